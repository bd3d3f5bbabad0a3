# The four kinds of target in this project. One line in a folder's CMakeLists.txt declares each.
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
include(ng_shaders)

# Whether files for particular x86-64 instruction sets are built; C asks __x86_64__.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  set(NG_X86 ON)
endif()

# ng_library(NAME SOURCES a.c b.cc ... [DEPS lib ...] [PRIVATE lib ...])
# A static library whose headers are included as "folder/header.h" from engine/ (or "lightformer/...").
function(ng_library name)
  cmake_parse_arguments(A "" "" "SOURCES;DEPS;PRIVATE" ${ARGN})
  add_library(${name} STATIC ${A_SOURCES})
  target_include_directories(${name} PUBLIC ${CMAKE_SOURCE_DIR}/engine ${CMAKE_SOURCE_DIR})
  target_link_libraries(${name} PUBLIC ${A_DEPS} PRIVATE ${A_PRIVATE} m)
endfunction()

# ng_kernels(OUT SOURCE): a file built once for each instruction set, with NG_KERNELS as "plain", "avx2" or "avx512" to name
# what it defines; OUT lists the objects. Which one runs is asked of base/cpu.h. The bytes are the same for all: nothing is fused.
# Infinities do not trap, so that branches become selects.
function(ng_kernels out source)
  set(avx2 -mavx2)
  set(avx512 -mavx512f -mavx512vl -mavx512dq -mavx512bw -mprefer-vector-width=512)
  set(sets plain)
  if(NG_X86)
    list(APPEND sets avx2 avx512)
  endif()
  set(objects)
  foreach(set IN LISTS sets)
    add_library(${out}_${set} OBJECT ${source})
    target_include_directories(${out}_${set} PRIVATE ${CMAKE_SOURCE_DIR}/engine ${CMAKE_SOURCE_DIR})
    target_compile_definitions(${out}_${set} PRIVATE NG_KERNELS=${set})
    target_compile_options(${out}_${set} PRIVATE -fopenmp-simd -fno-trapping-math ${${set}} ${NG_SCALAR})
    list(APPEND objects $<TARGET_OBJECTS:${out}_${set}>)
  endforeach()
  set(${out} ${objects} PARENT_SCOPE)
endfunction()

# So that LeakSanitizer can tell whose leak it is.
if(NG_SANITIZE MATCHES address)
  set(NG_SANITIZE_SOURCES ${CMAKE_SOURCE_DIR}/tests/keep_libraries.c)
endif()

# ng_program(NAME SOURCES ... DEPS ...): an executable in build/<preset>/bin.
function(ng_program name)
  cmake_parse_arguments(A "" "" "SOURCES;DEPS" ${ARGN})
  add_executable(${name} ${A_SOURCES} ${NG_SANITIZE_SOURCES})
  target_link_libraries(${name} PRIVATE ${A_DEPS} m)
endfunction()

# What `tools/test --tsan` builds: the tests of label `threads`.
add_custom_target(threads_tests)

# ng_test(NAME SOURCES ... DEPS ... [LABELS unit|gpu|image|...] [ARGS ...] [TIMEOUT s])
# A cmocka program run by CTest from the source directory, in a scratch directory of its own (NG_TEST_DIR).
function(ng_test name)
  cmake_parse_arguments(A "" "TIMEOUT" "SOURCES;DEPS;LABELS;ARGS" ${ARGN})
  if(NOT A_TIMEOUT)
    set(A_TIMEOUT 300)
  endif()
  add_executable(${name} ${A_SOURCES} ${NG_SANITIZE_SOURCES})
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR}/tests)
  target_link_libraries(${name} PRIVATE ${A_DEPS} PkgConfig::cmocka m)
  if("threads" IN_LIST A_LABELS)
    add_dependencies(threads_tests ${name})
  endif()
  add_test(NAME ${name} COMMAND ${name} ${A_ARGS} WORKING_DIRECTORY ${CMAKE_SOURCE_DIR})
  file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/scratch/${name})
  set_tests_properties(${name} PROPERTIES LABELS "${A_LABELS}" TIMEOUT ${A_TIMEOUT}
    ENVIRONMENT "NG_TEST_DIR=${CMAKE_BINARY_DIR}/scratch/${name};${NG_TEST_ENVIRONMENT}")
endfunction()

pkg_check_modules(cmocka REQUIRED IMPORTED_TARGET cmocka)

# LeakSanitizer: the driver and LLVM keep memory until the process ends; that is theirs.
set(NG_TEST_ENVIRONMENT
  "LSAN_OPTIONS=suppressions=${CMAKE_SOURCE_DIR}/tests/lsan.supp:print_suppressions=0"
  "ASAN_OPTIONS=detect_leaks=1:detect_stack_use_after_return=0"
  "UBSAN_OPTIONS=print_stacktrace=1"
  "TSAN_OPTIONS=suppressions=${CMAKE_SOURCE_DIR}/tests/tsan.supp:print_suppressions=0")

# Compilers, warnings, sanitizers: everything that holds for every target.
set(NG_SANITIZE "" CACHE STRING "Sanitizers to build with, as -fsanitize takes them: address,undefined or thread")

option(NG_FUZZER "Link the targets of tests/fuzz with libFuzzer, for tools/fuzz; needs clang" OFF)

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

set(CMAKE_C_STANDARD 17)
set(CMAKE_C_STANDARD_REQUIRED ON)
set(CMAKE_C_EXTENSIONS OFF)
set(CMAKE_CXX_STANDARD 17)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)

find_program(NG_CCACHE ccache)
if(NG_CCACHE)
  set(CMAKE_C_COMPILER_LAUNCHER ${NG_CCACHE})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${NG_CCACHE})
endif()

# -O3 for the loops that auto-vectorise; no -ffast-math: results must not depend on the compiler's mood.
set(CMAKE_C_FLAGS_RELEASE "-O3 -DNDEBUG")
set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG")
set(CMAKE_C_FLAGS_RELWITHDEBINFO "-O1 -g1")
set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O1 -g1")

# Our C is compiled with every warning as an error. C++ files are thin shims over C++ libraries.
add_compile_options(
  "$<$<COMPILE_LANGUAGE:C>:-Wall;-Wextra;-Wshadow;-Wconversion;-Wstrict-prototypes;-Wmissing-prototypes;-Wvla;-Werror>"
  "$<$<COMPILE_LANGUAGE:CXX>:-Wall;-Wextra;-Wshadow;-Werror>"
  -fno-math-errno -ffp-contract=off -fvisibility=hidden)
# The build directory must not leak into programs: the same sources give the same bytes.
add_compile_options(-ffile-prefix-map=${CMAKE_SOURCE_DIR}/=)
# cglm's types take the alignment of plain float arrays, so that they may point into public structs.
add_compile_definitions(CGLM_ALL_UNALIGNED)

# Sanitizers leave few loops that can be vectorised. Clang warns where one should have been: an option for such files.
if(NG_SANITIZE AND CMAKE_C_COMPILER_ID STREQUAL Clang)
  set(NG_SCALAR -Wno-pass-failed)
endif()
if(NG_SANITIZE)
  add_compile_options(-fsanitize=${NG_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${NG_SANITIZE})
endif()
if(NG_FUZZER)
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()

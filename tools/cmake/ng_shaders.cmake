# GLSL to SPIR-V at build, embedded: no file is read at run time.
#
# ng_shaders(TARGET a.vert b.frag c.comp ...)
#   Compiles each file of the current folder and makes "a.vert.spv.h" (which defines the words ng_spv_a_vert)
#   includable from TARGET's sources. Shaders include from engine/shaders and from their own folder
#   (GL_GOOGLE_include_directive); touching an included file recompiles what includes it.
find_program(NG_GLSLANG glslangValidator REQUIRED)

function(ng_shaders target)
  set(dir ${CMAKE_CURRENT_BINARY_DIR}/${target}_shaders)
  file(MAKE_DIRECTORY ${dir})
  set(headers)
  foreach(shader ${ARGN})
    get_filename_component(file ${shader} NAME)
    string(MAKE_C_IDENTIFIER ng_spv_${file} symbol)
    set(header ${dir}/${file}.spv.h)
    add_custom_command(
      OUTPUT ${header}
      COMMAND ${NG_GLSLANG} --quiet --target-env vulkan1.3 -I${CMAKE_SOURCE_DIR}/engine/shaders
              -I${CMAKE_CURRENT_SOURCE_DIR} --depfile ${header}.d --vn ${symbol} -o ${header}
              ${CMAKE_CURRENT_SOURCE_DIR}/${shader}
      DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${shader}
      DEPFILE ${header}.d
      COMMENT "glslang ${shader}"
      VERBATIM)
    list(APPEND headers ${header})
  endforeach()
  # One target for all of them: a build of just the shaders is what hot reload asks for.
  add_custom_target(${target}_spirv DEPENDS ${headers})
  add_dependencies(${target} ${target}_spirv)
  target_include_directories(${target} PRIVATE ${dir})
endfunction()

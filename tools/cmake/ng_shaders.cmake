# GLSL to SPIR-V at build, embedded: no file is read at run time.
#
# ng_shaders(TARGET a.vert b.frag c.comp ...)
#   Compiles each file of the current folder and makes "a.vert.spv.h" includable from TARGET's sources. It defines the words
#   ng_spv_a_vert, static, and their name ng_spv_a_vert_name. TARGET_spirv builds just the shaders. Shaders include from
#   engine/shaders and from their own folder (GL_GOOGLE_include_directive); touching an included file recompiles what includes it.
#
# engine/app/shader_reload.c calls the compiler in the same way while a program runs.
find_program(NG_GLSLANG glslangValidator REQUIRED)

function(ng_shaders target)
  set(dir ${CMAKE_CURRENT_BINARY_DIR}/${target}_shaders)
  set(outputs)
  foreach(shader ${ARGN})
    get_filename_component(file ${shader} NAME)
    string(MAKE_C_IDENTIFIER ng_spv_${file} symbol)
    set(words ${dir}/${file}.spv.inc)
    # The header is fixed; glslang writes the words that it includes.
    file(CONFIGURE OUTPUT ${dir}/${file}.spv.h @ONLY CONTENT
"// ${file} as SPIR-V for Vulkan 1.3. Generated.
#include <stdint.h>
#define ${symbol}_name \"${file}\"
static const uint32_t ${symbol}[] = {
#include \"${file}.spv.inc\"
};
")
    add_custom_command(
      OUTPUT ${words}
      COMMAND ${NG_GLSLANG} --quiet --target-env vulkan1.3 -I${CMAKE_SOURCE_DIR}/engine/shaders
              -I${CMAKE_CURRENT_SOURCE_DIR} --depfile ${words}.d -x -o ${words} ${CMAKE_CURRENT_SOURCE_DIR}/${shader}
      DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${shader}
      DEPFILE ${words}.d
      COMMENT "glslang ${shader}"
      VERBATIM)
    list(APPEND outputs ${words})
  endforeach()
  add_custom_target(${target}_spirv DEPENDS ${outputs})
  add_dependencies(${target} ${target}_spirv)
  target_include_directories(${target} PRIVATE ${dir})
endfunction()

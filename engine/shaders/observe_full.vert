#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_ARB_shader_viewport_layer_array : require
#define NG_TEXTURED
#define NG_FULL
#include "observe.vert.glsl"

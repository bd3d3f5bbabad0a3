#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#define NG_ENVIRONMENT
#include "direct.frag.glsl"

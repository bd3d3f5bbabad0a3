// Holes of an alpha mask let light through.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/scene.h"

layout(set = 0, binding = 2, scalar) readonly buffer Materials { ng_material_data materials[]; };
layout(set = 1, binding = 0) uniform sampler2D base_color_map;

layout(location = 0) in vec2 in_uv;
layout(location = 1) flat in uint in_material;

void main()
{
    ng_material_data m = materials[in_material];
    if (texture(base_color_map, in_uv).a * m.alpha < m.alpha_cutoff)
        discard;
}

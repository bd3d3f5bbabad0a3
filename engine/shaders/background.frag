// The environment, where no surface is: radiance of the map in the direction of the pixel.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/scene.h"

layout(set = 0, binding = 0, scalar) uniform View { ng_view_data view; };
layout(set = 0, binding = 1) uniform sampler2D map;

layout(push_constant, scalar) uniform Push {
    vec4 world_to_map[3]; // rotation
    vec3 radiance;        // factor on the map
} push;

layout(location = 0) in vec2 in_ndc;
layout(location = 0) out vec4 out_emission;

void main()
{
    vec3 d = view.forward;
    if (!(view.range > 0))
        d = normalize(d + in_ndc.x * view.right + in_ndc.y * view.down);
    vec3 m = vec3(dot(push.world_to_map[0].xyz, d), dot(push.world_to_map[1].xyz, d), dot(push.world_to_map[2].xyz, d));
    // Map centre looks along -Z, x grows to the right of it; row 0 is +Y.
    vec2 uv = vec2(0.5 + atan(m.x, -m.z) * 0.15915494, acos(clamp(m.y, -1.0, 1.0)) * 0.31830989);
    out_emission = vec4(min(textureLod(map, uv, 0).rgb * push.radiance, NG_RADIANCE_MAX), 0);
}

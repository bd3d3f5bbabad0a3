// The environment, where no surface is: radiance of the map in the direction of the pixel.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/scene.h"

layout(set = 0, binding = 0, scalar) uniform View { ng_view_data view; };
layout(set = 0, binding = 1) uniform sampler2D map;

#include "environment.glsl"

layout(location = 0) in vec2 in_ndc;
layout(location = 0) out vec4 out_emission;

void main()
{
    vec3 d = view.forward;
    if (!(view.range > 0))
        d = normalize(d + (in_ndc.x + view.shift.x) * view.right + (in_ndc.y + view.shift.y) * view.down);
    vec2 uv = environment_uv(environment_direction(d));
    out_emission = vec4(min(textureLod(map, uv, 0).rgb * push.radiance, NG_RADIANCE_MAX), 0);
}

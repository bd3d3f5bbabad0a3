// Radiance to a display's sRGB bytes, through the project's one tone map.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/scene.h"
#include "shared/tonemap.h"

layout(set = 0, binding = 0, scalar) uniform View { ng_view_data view; };
layout(set = 0, binding = 1) uniform sampler2D radiance_map;

layout(location = 0) in vec2 in_ndc;
layout(location = 0) out vec4 out_color;

void main()
{
    vec3 x = max(texelFetch(radiance_map, ivec2(gl_FragCoord.xy), 0).rgb * view.exposure, vec3(0));
    float peak = max(x.r, max(x.g, x.b));
    float toe = min(x.r, min(x.g, x.b));
    for (int i = 0; i < 3; i++)
        out_color[i] = ng_srgb_encode(ng_tonemap(x[i], peak, toe));
    out_color.a = 1;
}

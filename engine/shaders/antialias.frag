// The mean of a picture and of those before it, whose rays passed elsewhere in the pixels: of radiance, before
// exposure and tone map; and of which part of a pixel nothing is seen in, and in which part what is unlit.
#version 460
#extension GL_GOOGLE_include_directive : require

layout(set = 0, binding = 0) uniform sampler2D radiance_map;
layout(set = 0, binding = 1) uniform sampler2D position_map; // w: 0 where there is no surface, -1 where one is shown as it is
layout(set = 0, binding = 2) uniform sampler2D mean_map;     // of the pictures before; a black texel: there are none
layout(set = 0, binding = 3) uniform sampler2D shares_map;
layout(push_constant) uniform Push { float weight; }; // of this picture

layout(location = 0) in vec2 in_ndc;
layout(location = 0) out vec4 out_mean;
layout(location = 1) out vec2 out_shares; // nothing, unlit

vec4 fetch(sampler2D map)
{
    return texelFetch(map, min(ivec2(gl_FragCoord.xy), textureSize(map, 0) - 1), 0);
}

void main()
{
    const float surface = fetch(position_map).w;
    const vec2 shares = vec2(surface == 0 ? 1 : 0, surface < 0 ? 1 : 0);
    out_mean = mix(fetch(mean_map), fetch(radiance_map), weight);
    out_shares = mix(fetch(shares_map).xy, shares, weight);
}

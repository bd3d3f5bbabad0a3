// beauty = T_d + T_i + emission.
#version 460

// Single black texels where there is nothing.
layout(set = 0, binding = 0) uniform sampler2D direct_map;
layout(set = 0, binding = 1) uniform sampler2D indirect_map;
layout(set = 0, binding = 2) uniform sampler2D emission_map;

layout(location = 0) in vec2 in_ndc;
layout(location = 0) out vec4 out_radiance;

vec3 fetch(sampler2D map)
{
    return texelFetch(map, min(ivec2(gl_FragCoord.xy), textureSize(map, 0) - 1), 0).rgb;
}

void main()
{
    out_radiance = vec4(fetch(direct_map) + fetch(indirect_map) + fetch(emission_map), 1);
}

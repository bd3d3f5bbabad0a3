// beauty = T_d + T_i + emission.
#version 460

layout(set = 0, binding = 0) uniform sampler2D direct_map;
layout(set = 0, binding = 1) uniform sampler2D indirect_map; // 1x1 black where there is none
layout(set = 0, binding = 2) uniform sampler2D emission_map;

layout(location = 0) in vec2 in_ndc;
layout(location = 0) out vec4 out_radiance;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec3 indirect = texelFetch(indirect_map, min(at, textureSize(indirect_map, 0) - 1), 0).rgb;
    out_radiance = vec4(texelFetch(direct_map, at, 0).rgb + indirect + texelFetch(emission_map, at, 0).rgb, 1);
}

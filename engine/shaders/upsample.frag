// Light of fewer pixels at a pixel of the picture: of the four around it those that show the same surface, by its
// plane and its normal (joint bilateral upsampling, after Kopf et al. 2007), times what the surface reflects; and
// what it emits.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/upsample.h"

layout(set = 0, binding = 0) uniform sampler2D light_map; // of the light's pixels
layout(set = 0, binding = 1) uniform sampler2D light_position_map;
layout(set = 0, binding = 2) uniform sampler2D light_normal_map;
layout(set = 0, binding = 3) uniform sampler2D position_map; // of the picture's
layout(set = 0, binding = 4) uniform sampler2D normal_map;
layout(set = 0, binding = 5) uniform sampler2D diffuse_map;
layout(set = 0, binding = 6) uniform sampler2D specular_map;
layout(set = 0, binding = 7) uniform sampler2D emission_map;
layout(set = 0, binding = 8, scalar) readonly buffer Data { ng_upsample_data data; };

layout(location = 0) in vec2 in_ndc;
layout(location = 0) out vec4 out_radiance;

const float LEAST = 1e-4; // weight of another surface: it counts where there is nothing better

void main()
{
    const ivec2 pixel = ivec2(gl_FragCoord.xy), last = textureSize(light_map, 0) - 1;
    const vec4 position = texelFetch(position_map, pixel, 0);
    const vec3 normal = texelFetch(normal_map, pixel, 0).xyz;
    const vec3 reflectance = max(texelFetch(diffuse_map, pixel, 0).rgb + texelFetch(specular_map, pixel, 0).rgb, 0.02);
    const float size = data.pixel_at_eye + data.pixel * distance(position.xyz, data.eye);
    const vec2 at = gl_FragCoord.xy * data.scale - 0.5;
    const ivec2 corner = ivec2(floor(at));
    const vec2 part = at - vec2(corner);
    vec3 sum = vec3(0);
    float weights = 0;
    for (int i = 0; i < 4; i++) {
        const ivec2 step = ivec2(i & 1, i >> 1), place = clamp(corner + step, ivec2(0), last);
        const vec4 from = texelFetch(light_position_map, place, 0);
        const vec2 near = mix(1 - part, part, vec2(step));
        const float off = dot(from.xyz - position.xyz, normal) / size;
        const float facing = max(dot(texelFetch(light_normal_map, place, 0).xyz, normal), 0.0), facing2 = facing * facing;
        const float same = facing2 * facing2 / (1 + 4 * off * off * off * off);
        const float weight = from.w > 0 ? (near.x * near.y + 1e-3) * (same + LEAST) : 0;
        sum += weight * texelFetch(light_map, place, 0).rgb;
        weights += weight;
    }
    const vec3 light = position.w > 0 && weights > 0 ? sum / weights * reflectance : vec3(0);
    out_radiance = vec4(light + texelFetch(emission_map, pixel, 0).rgb, 1);
}

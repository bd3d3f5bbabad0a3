// Counts the pixels of a picture by their brightness (shared/meter.h): first those of direct light and emission, then
// those of all light.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/meter.h"

layout(local_size_x = 16, local_size_y = 16) in;

// Single black texels where there is nothing.
layout(set = 0, binding = 0) uniform sampler2D direct_map;
layout(set = 0, binding = 1) uniform sampler2D emission_map;
layout(set = 0, binding = 2) buffer Counts { uint counts[2 * NG_METER_BINS]; };
layout(set = 0, binding = 3) uniform sampler2D indirect_map;

shared uint own[2 * NG_METER_BINS];

vec3 fetch(sampler2D map)
{
    return texelFetch(map, min(ivec2(gl_GlobalInvocationID.xy), textureSize(map, 0) - 1), 0).rgb;
}

void count(uint first, vec3 radiance)
{
    float luminance = ng_meter_luminance(radiance.r, radiance.g, radiance.b);
    if (luminance > 0)
        atomicAdd(own[first + uint(ng_meter_bin(luminance))], 1u);
}

void main()
{
    const uint threads = gl_WorkGroupSize.x * gl_WorkGroupSize.y;
    for (uint i = gl_LocalInvocationIndex; i < 2 * NG_METER_BINS; i += threads)
        own[i] = 0;
    barrier();
    if (all(lessThan(ivec2(gl_GlobalInvocationID.xy), textureSize(emission_map, 0)))) {
        vec3 radiance = fetch(direct_map) + fetch(emission_map);
        count(0, radiance);
        count(NG_METER_BINS, radiance + fetch(indirect_map));
    }
    barrier();
    for (uint i = gl_LocalInvocationIndex; i < 2 * NG_METER_BINS; i += threads)
        if (own[i] > 0)
            atomicAdd(counts[i], own[i]);
}

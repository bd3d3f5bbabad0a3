// Counts the pixels of a picture by their brightness, in three histograms (shared/meter.h).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/meter.h"

layout(local_size_x = 16, local_size_y = 16) in;

const uint COUNTS = NG_METER_COUNTS * NG_METER_BINS;

// Single black texels where there is nothing.
layout(set = 0, binding = 0) uniform sampler2D direct_map;
layout(set = 0, binding = 1) uniform sampler2D emission_map;
layout(set = 0, binding = 2) buffer Counts { uint counts[COUNTS]; };
layout(set = 0, binding = 3) uniform sampler2D indirect_map;
layout(set = 0, binding = 4) uniform sampler2D position_map; // w: 0 where there is no surface, -1 where one is unlit

shared uint own[COUNTS];

vec4 fetch(sampler2D map)
{
    return texelFetch(map, min(ivec2(gl_GlobalInvocationID.xy), textureSize(map, 0) - 1), 0);
}

void count(uint which, vec3 radiance)
{
    float luminance = ng_meter_luminance(radiance.r, radiance.g, radiance.b);
    if (luminance > 0)
        atomicAdd(own[which * NG_METER_BINS + uint(ng_meter_bin(luminance))], 1u);
}

void count_pixel()
{
    const float surface = fetch(position_map).w;
    const vec3 radiance = fetch(direct_map).rgb + fetch(emission_map).rgb;
    if (surface > 0) {
        count(NG_METER_DIRECT, radiance);
        count(NG_METER_WHOLE, radiance + fetch(indirect_map).rgb);
    } else if (surface == 0) {
        count(NG_METER_SKY, radiance);
    }
}

void main()
{
    const uint threads = gl_WorkGroupSize.x * gl_WorkGroupSize.y;
    for (uint i = gl_LocalInvocationIndex; i < COUNTS; i += threads)
        own[i] = 0;
    barrier();
    if (all(lessThan(ivec2(gl_GlobalInvocationID.xy), textureSize(emission_map, 0))))
        count_pixel();
    barrier();
    for (uint i = gl_LocalInvocationIndex; i < COUNTS; i += threads)
        if (own[i] > 0)
            atomicAdd(counts[i], own[i]);
}

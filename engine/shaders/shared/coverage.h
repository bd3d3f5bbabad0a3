// What a surface covers where it covers a part only: of a pixel, a texel of a light's map, or a ray. One
// surface is drawn or not, so that any order gives the same, and nothing is sorted: it is drawn where its
// alpha is above a threshold, which is above a in a share a of all places. GLSL and C include this text, so
// that all methods see the same surface in a pixel.
//
// The thresholds of a surface over a picture are those of Roberts's additive sequences ("The unreasonable
// effectiveness of quasirandom sequences", 2018): spread evenly over any few pixels. They are plane waves, in
// whole numbers so that every processor has the same; two surfaces have two waves, or what is behind one of
// them would be hidden by the other always or never.
#ifndef NG_SHADERS_SHARED_COVERAGE_H
#define NG_SHADERS_SHARED_COVERAGE_H

#include "glsl_compat.h"

#define NG_COVERAGE_STEP (1.0f / 16777216.0f)

// A hash of 32 bits (Wellons's lowbias32).
NG_SHADER_FN ng_uint ng_coverage_hash(ng_uint x)
{
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ (x >> 16);
}

// In [0, 1), of a surface in a place of a picture. `surface`: index of the entity and which side. `number`:
// of the picture, where several are averaged; any few in a row lie evenly (the golden ratio's sequence).
NG_SHADER_FN float ng_coverage_threshold(ng_uint x, ng_uint y, ng_uint surface, ng_uint number)
{
    ng_uint hash = ng_coverage_hash(surface);
    // Steps along a row and from row to row, of 2^32: powers of the plastic number, and others like them, of
    // which no two near pixels are nearly alike, so that there are no streaks; in either order and direction.
    const ng_uint steps[12] = {2447445414u, 3242174889u, 3335039061u, 1512128488u, 2285118017u, 1390991958u,
                               1708529502u, 1092920818u, 1858888744u, 1380107002u, 2787050158u, 2298887297u};
    ng_uint wave = (hash >> 2) % 6u * 2u;
    ng_uint a = steps[wave + (hash & 1u)], b = steps[wave + 1u - (hash & 1u)];
    b = (hash & 2u) != 0u ? 0u - b : b;
    ng_uint t = a * x + b * y + hash + number * 2654435769u;
    return ng_float(t >> 8) * NG_COVERAGE_STEP;
}

#endif

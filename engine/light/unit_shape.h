// How the unit shapes of uniform lights (enum ng_light_shape) are sampled by u in [0, 1)^2, evenly by area:
// in a header, without branches, so that whoever samples many lights at once (lightformer/reference) does as
// the lights themselves do.
#ifndef NG_LIGHT_UNIT_SHAPE_H
#define NG_LIGHT_UNIT_SHAPE_H

#include "base/turn.h"

#include <math.h>

// The square of side 1 around the origin. Texture coordinates run against both axes.
static inline void ng_light_on_square(float u, float v, float *x, float *y)
{
    *x = 0.5f - u;
    *y = 0.5f - v;
}

// The disk of radius 1, keeping areas and neighbours (Shirley and Chiu 1997).
static inline void ng_light_on_disk(float u, float v, float *x, float *y)
{
    float a = 2 * u - 1, b = 2 * v - 1, cosine, sine;
    int wide = fabsf(a) > fabsf(b);
    float radius = wide ? a : b, other = wide ? b : a;
    float eighths = other / (radius != 0 ? radius : 1); // of a turn
    ng_turn(wide ? 0.125f * eighths : 0.25f - 0.125f * eighths, &cosine, &sine);
    *x = radius * cosine;
    *y = radius * sine;
}

// The sphere of radius 1.
static inline void ng_light_on_sphere(float u, float v, float *x, float *y, float *z)
{
    float cosine, sine, ring = 2 * sqrtf(v * (1 - v));
    ng_turn(u, &cosine, &sine);
    *x = ring * cosine;
    *y = ring * sine;
    *z = 1 - 2 * v;
}

#endif

// Where the rays of pictures pass that are averaged into an antialiased one: a fixed sequence, so that so
// many of them are the same picture everywhere.
#ifndef NG_RENDER_SUBPIXEL_H
#define NG_RENDER_SUBPIXEL_H

#include "base/extern_c.h"

#include <math.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

// A point of the tent of radius 1 around 0 from a number in 0..1: the filter of all methods.
static inline float ng_subpixel_tent(float u)
{
    return u < 0.5f ? sqrtf(2 * u) - 1 : 1 - sqrtf(2 - 2 * u);
}

// Of the picture `number`: how far from the middle of its pixel a ray passes, pixels to the right and down.
// 0: through the middle. The others are pairs on both sides of it, so that odd numbers of pictures have their
// mean in the middle. Any first few lie evenly in the filter (Roberts, "The unreasonable effectiveness of
// quasirandom sequences", 2018), whose weight is in how densely they lie: so all weigh the same.
static inline void ng_subpixel_shift(uint32_t number, float out[2])
{
    const uint32_t steps[2] = {3242174889u, 2447445414u}; // powers of the plastic number, of 2^32
    const uint32_t pair = (number + 1) / 2;
    for (int i = 0; i < 2; i++) {
        float u = (float)((0x80000000u + pair * steps[i]) >> 8) * (1.0f / 16777216.0f);
        out[i] = number % 2 ? ng_subpixel_tent(u) : -ng_subpixel_tent(u);
    }
}

NG_EXTERN_C_END

#endif

// Rotations and weights, as loading and saving make them of length, or sum, 1. What is already stays as it
// is, to the last bit: so what was saved is loaded as it was.
#ifndef NG_ASSET_GLTF_UNIT_H
#define NG_ASSET_GLTF_UNIT_H

#include <math.h>
#include <stdbool.h>

// False if there is no length.
static inline bool ng_gltf_normalize_rotation(float q[4])
{
    float length = sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(length > 1e-6f) || !isfinite(length))
        return false;
    for (int i = 0; i < 4 && fabsf(length - 1) > 1e-6f; i++)
        q[i] /= length;
    return true;
}

// Whether weights that have been divided by their sum have this one.
static inline bool ng_gltf_is_sum_one(float sum)
{
    return fabsf(sum - 1) < 4e-7f;
}

#endif

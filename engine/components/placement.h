// Where an entity is in the world: derived from the transforms of itself and its ancestors.
#ifndef NG_COMPONENTS_PLACEMENT_H
#define NG_COMPONENTS_PLACEMENT_H

#include "scene/component.h"

// How far from the origin things are along an axis, in metres, and how much larger than themselves. Squares
// of areas are finite in a float up to here, and two places may lie 64 m apart without one between them.
#define NG_PLACEMENT_MAX 1e9f

// An element of a matrix, kept to -most .. most; of what is no number 0: things without a place have no size.
static inline float ng_keep_within(float x, float most)
{
    if (x > most)
        return most;
    return x >= -most ? x : x < -most ? -most : 0;
}

// Column-major, local to world; within NG_PLACEMENT_MAX, whatever the transforms say. Changes (its tick) only
// when the matrix does.
struct ng_placement {
    float matrix[16];
};

#endif

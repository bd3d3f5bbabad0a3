// Where an entity is in the world: derived from the transforms of itself and its ancestors.
#ifndef NG_COMPONENTS_PLACEMENT_H
#define NG_COMPONENTS_PLACEMENT_H

#include "scene/component.h"

// Column-major, local to world. Changes (its tick) only when the matrix does.
struct ng_placement {
    float matrix[16];
};

#endif

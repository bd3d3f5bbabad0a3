// Where an entity is, relative to its parent in the hierarchy.
#ifndef NG_COMPONENTS_TRANSFORM_H
#define NG_COMPONENTS_TRANSFORM_H

#include "scene/component.h"

// Of translation and scale, either way: the matrix of two of them is still finite.
#define NG_TRANSFORM_MAX 1e18f

// local = translate * rotate * scale. Metres; right-handed, Y up.
struct ng_transform {
    float translation[3];
    float rotation[4]; // unit quaternion x y z w
    float scale[3];
};

#endif

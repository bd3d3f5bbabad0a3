// How much of each morph target of its geometry a mesh shows (glTF 2.0, 3.7.2.2): position = base + the sum
// of weight * delta, normals and tangents alike, before joints move them.
#ifndef NG_COMPONENTS_MORPH_H
#define NG_COMPONENTS_MORPH_H

#include "scene/component.h"

#define NG_MORPH_TARGETS 128 // of one mesh

// Fields are named after the first of four targets each: weights_0, weights_4, ...
struct ng_morph {
    float weights[NG_MORPH_TARGETS];
};

#endif

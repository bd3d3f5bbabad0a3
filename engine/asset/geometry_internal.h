// Parts of ng_geometry_complete.
#ifndef NG_ASSET_GEOMETRY_INTERNAL_H
#define NG_ASSET_GEOMETRY_INTERNAL_H

#include "asset/geometry.h"

// The unit normal of a triangle's front.
void ng_flat_normal(const float a[3], const float b[3], const float c[3], float out[3]);
// Before vertices are split into three a triangle, in the order of the indices: has the morph targets follow.
// False when out of memory.
bool ng_geometry_split_targets(struct ng_geometry *g);

#endif

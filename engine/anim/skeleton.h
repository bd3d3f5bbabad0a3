// Joints of a skin. glTF 2.0, 3.7.3.
#ifndef NG_ANIM_SKELETON_H
#define NG_ANIM_SKELETON_H

#include "scene/entity.h"

// Never changes: another skeleton is another asset.
struct ng_skeleton {
    uint32_t joint_count;
    ng_entity *joints;   // entities whose placements move the skin
    float *inverse_bind; // [joint_count][16], column-major
};

#endif

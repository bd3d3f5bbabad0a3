// A clip that plays. One entity a clip; clips that drive the same field are blended by weight.
#ifndef NG_COMPONENTS_ANIMATION_H
#define NG_COMPONENTS_ANIMATION_H

#include "scene/component.h"

// Clip time = (scene time * speed + offset), wrapped to the clip's length if `loop`, else clamped to it.
struct ng_animation {
    ng_asset clip; // struct ng_clip
    float weight;  // relative to the other clips that drive the same field; 0: the clip is off
    float speed;
    float offset; // seconds
    bool loop;
    bool playing; // false: as if the weight were 0
};

#endif

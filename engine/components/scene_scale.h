// The scene's size, fixed when the scene is made: the unit of lengths that reach a network, the reach of
// directional and environment lights. Never different from frame to frame. One entity of a world has it.
#ifndef NG_COMPONENTS_SCENE_SCALE_H
#define NG_COMPONENTS_SCENE_SCALE_H

#include "scene/component.h"

struct ng_scene_scale {
    float center[3];
    float radius; // of the bounding sphere when loaded, metres
};

#endif

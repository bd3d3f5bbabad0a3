// Light from a point, the same in all directions (KHR_lights_punctual). At the entity's origin.
#ifndef NG_COMPONENTS_LIGHT_POINT_H
#define NG_COMPONENTS_LIGHT_POINT_H

#include "scene/component.h"

struct ng_light_point {
    bool on;
    float color[3];  // linear
    float intensity; // W/sr, times colour
};

#endif

// Light from a point into a cone along the entity's -Z (KHR_lights_punctual).
#ifndef NG_COMPONENTS_LIGHT_SPOT_H
#define NG_COMPONENTS_LIGHT_SPOT_H

#include "scene/component.h"

struct ng_light_spot {
    bool on;
    float color[3];    // linear
    float intensity;   // W/sr on the axis, times colour
    float inner_angle; // half angles, radians: full inside the inner, none outside the outer
    float outer_angle;
};

#endif

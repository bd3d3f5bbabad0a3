// Light from infinitely far, travelling along the entity's -Z (KHR_lights_punctual).
#ifndef NG_COMPONENTS_LIGHT_DIRECTIONAL_H
#define NG_COMPONENTS_LIGHT_DIRECTIONAL_H

#include "scene/component.h"

struct ng_light_directional {
    bool on;
    float color[3];   // linear
    float irradiance; // W/m2 on a surface that faces it, times colour
};

#endif

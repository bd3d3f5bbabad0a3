// Light from all around: a latitude-longitude map in linear radiance, turned by the entity's rotation.
// Map centre looks along -Z, up is +Y; without a map the colour is the radiance everywhere.
#ifndef NG_COMPONENTS_LIGHT_ENVIRONMENT_H
#define NG_COMPONENTS_LIGHT_ENVIRONMENT_H

#include "scene/component.h"

struct ng_light_environment {
    bool on;
    float color[3];  // linear
    float intensity; // on the map's radiance, W/(sr m2)
    ng_asset map;    // struct ng_image, float
};

#endif

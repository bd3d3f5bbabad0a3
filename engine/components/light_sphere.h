// A sphere that emits outwards. The placement's scale must be uniform; its largest axis counts.
#ifndef NG_COMPONENTS_LIGHT_SPHERE_H
#define NG_COMPONENTS_LIGHT_SPHERE_H

#include "scene/component.h"

struct ng_light_sphere {
    bool on;
    float color[3]; // linear
    float radiance; // W/(sr m2), times colour
    float radius;   // metres, before the placement's scale
    float albedo[3];
};

#endif

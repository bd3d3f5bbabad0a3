// A disk in the entity's XY plane that emits along -Z, one-sided, with a cosine profile.
#ifndef NG_COMPONENTS_LIGHT_DISK_H
#define NG_COMPONENTS_LIGHT_DISK_H

#include "scene/component.h"

struct ng_light_disk {
    bool on;
    float color[3]; // linear
    float radiance; // W/(sr m2), times colour
    float radius;   // metres, before the placement's scale
    float albedo[3];
};

#endif

// A rectangle in the entity's XY plane that emits along -Z, one-sided, with a cosine (Lambertian) profile.
#ifndef NG_COMPONENTS_LIGHT_RECTANGLE_H
#define NG_COMPONENTS_LIGHT_RECTANGLE_H

#include "scene/component.h"

struct ng_light_rectangle {
    bool on;
    float color[3];   // linear
    float radiance;   // W/(sr m2), times colour, times texture
    float size[2];    // full width and height, metres, before the placement's scale
    ng_asset texture; // struct ng_image, linear or sRGB; none: white
    float albedo[3];  // an emitter also reflects
};

#endif

// What may vary: one entity a variation. A data set draws every sample of a scene from these
// (lightformer/dataset); pictures of the scene itself do not follow them.
//
// A field is drawn by `kind`, each channel on its own; what a kind does not use is ignored.
//     range     uniform in [min, max]; whole numbers and choices both ends included, a bool from 0 to 1
//     log_range min^(1-u) max^u with one u for all channels: for strengths; min above 0
//     offset    the present value plus a range
//     turn      transform.rotation, turned about its own Y, then X, then Z by angles in [min, max], radians
//     choices   one of choice_0 .. choice_(choice_count - 1)
// Two kinds have no field:
//     time      the sample's time in [min[0], max[0]], seconds; no target
//     camera    the target's transform: an eye in the box [min, max] that looks at a point in [look_min,
//               look_max], never inside of things, always at something. World space; no
//               transform above it
#ifndef NG_COMPONENTS_VARIATION_H
#define NG_COMPONENTS_VARIATION_H

#include "scene/component.h"

enum ng_variation_kind {
    NG_VARIATION_RANGE,
    NG_VARIATION_LOG_RANGE,
    NG_VARIATION_OFFSET,
    NG_VARIATION_TURN,
    NG_VARIATION_CHOICES,
    NG_VARIATION_TIME,
    NG_VARIATION_CAMERA,
};

#define NG_VARIATION_CHOICE_MAX 6

struct ng_variation {
    char field[NG_TEXT_SIZE]; // "light_rectangle.radiance"
    ng_entity target;         // whose field
    uint32_t kind;            // enum ng_variation_kind
    uint32_t choice_count;    // 1 to NG_VARIATION_CHOICE_MAX
    float min[4], max[4];     // as many as the field has channels
    float look_min[3], look_max[3];
    float choice_0[4], choice_1[4], choice_2[4], choice_3[4], choice_4[4], choice_5[4];
};

#endif

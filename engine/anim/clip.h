// Animation clips: keyframes for fields of components. glTF 2.0, 3.11 and appendix C.
#ifndef NG_ANIM_CLIP_H
#define NG_ANIM_CLIP_H

#include "scene/component.h"

enum ng_interpolation { NG_INTERPOLATION_STEP, NG_INTERPOLATION_LINEAR, NG_INTERPOLATION_CUBIC };

// Drives one field of one entity.
struct ng_channel {
    ng_entity target;
    ng_component component;
    uint32_t field_offset; // bytes into the component
    uint32_t width;        // floats: 1 to 4
    bool rotation;         // a quaternion: spherical interpolation, shortest way, normalised
    enum ng_interpolation interpolation;
    uint32_t key_count;
    float *times;  // [key_count], strictly increasing, seconds
    float *values; // [key_count][width]; cubic: [key_count][3][width] = in-tangent, value, out-tangent
};

struct ng_clip {
    uint32_t channel_count;
    struct ng_channel *channels;
    float duration;    // the last key of any channel
    uint64_t revision; // the asset store's: another number whenever anything in the clip is different
};

#endif

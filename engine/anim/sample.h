// Sampling and blending of clips: keyframes -> values at a moment.
//
// Pure functions over plain data; thread-safe.
#ifndef NG_ANIM_SAMPLE_H
#define NG_ANIM_SAMPLE_H

#include "anim/clip.h"
#include "base/extern_c.h"
#include "components/animation.h"

NG_EXTERN_C_BEGIN

// Where an animation is in its clip at scene time `time`, seconds. Loops wrap into [0, duration); others
// clamp to [0, duration]. A clip of no duration is at 0.
float ng_clip_time(const struct ng_animation *a, float duration, double time);

// The channel's value at clip time `t`: `width` floats. Before the first key the first value, after the last
// key the last one. glTF 2.0, appendix C: step, linear (quaternions: spherical, shortest way), cubic spline.
void ng_channel_sample(const struct ng_channel *c, float t, float out[4]);

// Blends values of one field by weights that are normalised by their sum. Quaternions are brought to the
// hemisphere of the first, averaged and normalised. Zero it before the first value. Weights not above 0 are
// ignored.
struct ng_blend {
    float first[4], sum[4];
    float weight;
    bool several;
};
void ng_blend_add(struct ng_blend *b, const float value[4], uint32_t width, bool rotation, float weight);
// False (out untouched) if nothing was added. A single value comes out bit for bit.
bool ng_blend_result(const struct ng_blend *b, uint32_t width, bool rotation, float out[4]);

NG_EXTERN_C_END

#endif

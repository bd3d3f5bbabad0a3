// Directions that the BRDF chooses: the same few numbers at all pixels, so that there is no noise.
#ifndef LF_CLUES_BRDF_SAMPLES_H
#define LF_CLUES_BRDF_SAMPLES_H

#include "base/extern_c.h"
#include "lightformer/trace/vec.h"
#include "shaders/shared/brdf.h"

#include <math.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

#define LF_LEAST_COSINE 1e-4f // of the viewer
#define LF_BRDF_SAMPLES 16

// Cosine and sine of 2 pi u1, and u2, for ng_brdf_half.
extern const float lf_brdf_samples[LF_BRDF_SAMPLES][3];

// As many such samples as are wanted, the same on every machine.
void lf_brdf_spiral(uint32_t count, float out[][3]);

// A surface as its viewer sees it; vectors are unit.
struct lf_shading_point {
    float normal[3]; // shading
    float flat[3];   // geometric
    float view[3];   // to the viewer
    float roughness;
};

static inline float lf_shading_cosine(const struct lf_shading_point *at)
{
    return fmaxf(lf_dot(at->normal, at->view), LF_LEAST_COSINE);
}

static inline void lf_local_to_world(const struct lf_frame *frame, const struct ng_local_direction *l,
                                     float out[3])
{
    const float local[3] = {l->x, l->y, l->z};
    lf_frame_to_world(frame, local, out);
    lf_normalize(out);
}

// The viewer in a frame around the normal.
static inline struct ng_local_direction lf_shading_view(const struct lf_shading_point *at,
                                                        const struct lf_frame *frame)
{
    const struct ng_local_direction view = {lf_dot(frame->tangent, at->view),
                                            lf_dot(frame->bitangent, at->view), lf_shading_cosine(at)};
    return view;
}

// Direction `u` (lf_brdf_samples), unit; may lead below the surface.
static inline void lf_brdf_direction(const struct lf_shading_point *at, const float u[3], float out[3])
{
    const struct lf_frame frame = lf_frame_toward(at->normal, at->view);
    struct ng_local_direction v = lf_shading_view(at, &frame);
    struct ng_local_direction l = ng_brdf_reflect(v, ng_brdf_half(v, at->roughness, u[0], u[1], u[2]));
    lf_local_to_world(&frame, &l, out);
}

NG_EXTERN_C_END

#endif

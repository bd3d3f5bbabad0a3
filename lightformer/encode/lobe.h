// Directions that the BRDF chooses: the same few numbers at all pixels, so that there is no noise.
#ifndef LF_ENCODE_LOBE_H
#define LF_ENCODE_LOBE_H

#include "lightformer/trace/vec.h"
#include "shaders/shared/brdf.h"

#include <math.h>

#define LF_LEAST_COSINE 1e-4f // of the viewer

// A surface as its viewer sees it; vectors are unit.
struct lf_lobe {
    float normal[3]; // shading
    float flat[3];   // geometric
    float view[3];   // to the viewer
    float roughness;
};

static inline float lf_lobe_cosine(const struct lf_lobe *at)
{
    return fmaxf(lf_dot(at->normal, at->view), LF_LEAST_COSINE);
}

// A frame around a unit normal (Duff et al. 2017).
static inline void lf_lobe_frame(const float n[3], float tangent[3], float bitangent[3])
{
    float sign = copysignf(1.0f, n[2]), a = -1.0f / (sign + n[2]), b = n[0] * n[1] * a;
    tangent[0] = 1 + sign * n[0] * n[0] * a;
    tangent[1] = sign * b;
    tangent[2] = -sign * n[0];
    bitangent[0] = b;
    bitangent[1] = sign + n[1] * n[1] * a;
    bitangent[2] = -n[1];
}

static inline void lf_lobe_to_world(const float n[3], const struct ng_local_direction *l, float out[3])
{
    float tangent[3], bitangent[3];
    lf_lobe_frame(n, tangent, bitangent);
    lf_scale(n, l->z, out);
    lf_mad(out, tangent, l->x, out);
    lf_mad(out, bitangent, l->y, out);
    lf_normalize(out);
}

// Direction `u` (lf_lobe_samples), unit; may lead below the surface.
static inline void lf_lobe_direction(const struct lf_lobe *at, const float u[3], float out[3])
{
    float tangent[3], bitangent[3];
    lf_lobe_frame(at->normal, tangent, bitangent);
    struct ng_local_direction v = {lf_dot(tangent, at->view), lf_dot(bitangent, at->view),
                                   lf_lobe_cosine(at)};
    struct ng_local_direction l = ng_brdf_reflect(v, ng_brdf_half(v, at->roughness, u[0], u[1], u[2]));
    lf_lobe_to_world(at->normal, &l, out);
}

#endif

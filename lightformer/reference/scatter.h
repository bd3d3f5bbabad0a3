// How a surface scatters light: the shared BRDF (shaders/shared/brdf.h) in world directions, with a density
// to choose directions by. Specular directions follow the visible normals, diffuse ones the cosine.
//
// Light passes only between directions above both the shading and the geometric normal. Where the shading
// normal turns away from the viewer, the viewer counts as grazing (cosine 1e-4), as in the raster method.
#ifndef LF_REFERENCE_SCATTER_H
#define LF_REFERENCE_SCATTER_H

#include "lightformer/trace/surface.h"

struct lf_scatter {
    const struct lf_surface *surface; // borrowed
    float tangent[3], bitangent[3];
    float view[3];        // towards the viewer in the frame (tangent, bitangent, normal)
    float specular_share; // probability of the specular lobe
};

// What passes in one direction.
struct lf_scatter_value {
    float value[3]; // BRDF times the cosine, by channel
    float pdf;      // density with which the direction is chosen, by solid angle
};

// `toward`: unit, to the viewer. `surface` must outlive the scatter.
void lf_scatter_at(const struct lf_surface *surface, const float toward[3], struct lf_scatter *out);
// False, and `out` in any state, if nothing passes.
bool lf_scatter_eval(const struct lf_scatter *s, const float direction[3], struct lf_scatter_value *out);
// Chooses a direction by u in [0, 1)^2. False, and the path ends, if nothing passes there.
bool lf_scatter_sample(const struct lf_scatter *s, const float u[2], float direction[3],
                       struct lf_scatter_value *out);

#endif

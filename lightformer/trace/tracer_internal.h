// What the files of this folder share.
#ifndef LF_TRACE_TRACER_INTERNAL_H
#define LF_TRACE_TRACER_INTERNAL_H

#include "lightformer/trace/surface.h"
#include "lightformer/trace/texture.h"
#include "lightformer/trace/tracer.h"
#include "render/snapshot.h"

enum lf_shape { LF_SHAPE_TRIANGLES, LF_SHAPE_DISK, LF_SHAPE_SPHERE };

// How a surface reflects and shines.
struct lf_look {
    float albedo[3], f0[3], emission[3], roughness;
};

// What a hit needs of an instance, in one place; made by every update, so that a hit computes little.
struct lf_instance {
    const struct ng_snapshot_mesh *mesh;
    const struct ng_snapshot_material *material;
    enum lf_shape shape;
    uint32_t flags, light;
    uint32_t place;         // of the light (snapshot.h), or NG_NONE
    bool textured;          // its material has an image, or its vertices have colours
    float normal_matrix[9]; // row-major, to world; not of unit scale
    struct lf_look plain;   // without textures
};

const struct lf_instance *lf_tracer_instance(const struct lf_tracer *tracer, uint32_t instance);
const struct lf_srgb *lf_tracer_srgb(const struct lf_tracer *tracer);

// Fills in all but the shape.
void lf_instance_read(const struct ng_snapshot *snapshot, uint32_t index, struct lf_instance *out);

// Alpha at a point of a triangle: of the texture, and what multiplies it.
struct lf_alpha {
    float texel, factor;
    float level; // that the texel is of
};
// No more of the hit than instance, triangle and barycentric coordinates counts. `footprint`: as in
// lf_surface_unsettled.
struct lf_alpha lf_surface_alpha(const struct lf_tracer *tracer, const struct lf_hit *hit,
                                 const struct lf_footprint *footprint);

#endif

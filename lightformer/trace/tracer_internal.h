// What the files of this folder share.
#ifndef LF_TRACE_TRACER_INTERNAL_H
#define LF_TRACE_TRACER_INTERNAL_H

#include "lightformer/trace/texture.h"
#include "lightformer/trace/tracer.h"
#include "render/snapshot.h"

enum lf_shape { LF_SHAPE_TRIANGLES, LF_SHAPE_DISK, LF_SHAPE_SPHERE };

enum lf_shape lf_tracer_shape(const struct lf_tracer *tracer, uint32_t instance);
const struct lf_srgb *lf_tracer_srgb(const struct lf_tracer *tracer);

// Whether an alpha mask leaves nothing at a point of a triangle.
bool lf_surface_is_cut(const struct lf_tracer *tracer, uint32_t instance, uint32_t triangle,
                       const float barycentric[2]);

#endif

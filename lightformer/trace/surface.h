// The surface at a hit, with its material: what engine/shaders/surface.frag.glsl makes of a fragment.
#ifndef LF_TRACE_SURFACE_H
#define LF_TRACE_SURFACE_H

#include "base/extern_c.h"
#include "lightformer/trace/tracer.h"

NG_EXTERN_C_BEGIN

struct lf_surface {
    float position[3];
    float flat_normal[3]; // geometric, towards the side that was met
    float normal[3];      // shading normal of that side, with the normal map
    float albedo[3], f0[3];
    float roughness; // at least 0.045
    // Radiance that the surface shows without being a light's emitter; zero behind one-sided ones.
    float emission[3];
    uint32_t light; // whose emitter this is, or NG_NONE: ng_light_seen_at says what it emits
    bool front, double_sided;
};

void lf_surface_at(const struct lf_tracer *tracer, const struct lf_hit *hit, struct lf_surface *out);
// False if the surface there is no light's emitter and shows no radiance of its own, so that whoever only
// wants to know that need not ask for all of it.
bool lf_surface_may_shine(const struct lf_tracer *tracer, const struct lf_hit *hit);
// Where the point of a hit was in the frame before, world (snapshot.h: previous matrices and positions).
void lf_surface_previous(const struct lf_tracer *tracer, const struct lf_hit *hit, float out[3]);
// Asks memory for what lf_surface_at will read, for callers with something to do in between: stage 0 for what
// tells where the rest is, stage 1 for the rest.
void lf_surface_prefetch(const struct lf_tracer *tracer, const struct lf_hit *hit, int stage);
// Whether it is met from the back and has none: black.
static inline bool lf_surface_is_black(const struct lf_surface *s)
{
    return !s->front && !s->double_sided;
}

NG_EXTERN_C_END

#endif

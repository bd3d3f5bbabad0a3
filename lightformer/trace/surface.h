// The surface at a hit, with its material: what engine/shaders/surface.frag.glsl makes of a fragment.
#ifndef LF_TRACE_SURFACE_H
#define LF_TRACE_SURFACE_H

#include "base/extern_c.h"
#include "lightformer/trace/tracer.h"
#include "render/snapshot.h"

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
    bool unlit; // reflects nothing, and its emission is for cameras alone
};

void lf_surface_at(const struct lf_tracer *tracer, const struct lf_hit *hit, struct lf_surface *out);
// The same as whoever looks along `direction` sees it: reflections lead out of the surface (ng_brdf_lift).
void lf_surface_seen_at(const struct lf_tracer *tracer, const struct lf_hit *hit, const float direction[3],
                        struct lf_surface *out);

// A step to the neighbours of a pixel to the right and below, on the triangle that it shows: by how much
// barycentric coordinates change.
struct lf_footprint {
    float right[2], down[2];
};
// From these steps in the world, which are in the plane of the triangle or near it (lf_view_steps). Of
// triangles alone: lf_surface_is_textured.
void lf_footprint_find(const struct lf_tracer *tracer, const struct lf_hit *hit, const float right[3],
                       const float down[3], struct lf_footprint *out);
bool lf_surface_is_textured(const struct lf_tracer *tracer, const struct lf_hit *hit);
// What a pixel shows there, as the G-buffer has it: textures are filtered over the footprint (null: level 0),
// and emission is the material's on surfaces of lights, too. Normals are of the front, the shading normal of
// any length: whoever asks for many settles, turns and lifts them at once, as lf_surface_seen_at does.
void lf_surface_unsettled(const struct lf_tracer *tracer, const struct lf_hit *hit,
                          const struct lf_footprint *footprint, struct lf_surface *out);
// False if the surface there is no light's emitter and shows no radiance of its own, so that whoever only
// wants to know that need not ask for all of it.
bool lf_surface_may_shine(const struct lf_tracer *tracer, const struct lf_hit *hit);
// Where the point of a hit was in the frame before, world (snapshot.h: previous matrices and positions).
void lf_surface_previous(const struct lf_tracer *tracer, const struct lf_hit *hit, float out[3]);
// Where an emitter's light was met, in the terms of that light; the rest of `out` is the caller's.
static inline void lf_hit_on_light(const struct ng_snapshot *snapshot, const struct lf_hit *hit,
                                   struct ng_light_hit *out)
{
    const struct ng_snapshot_instance *in = &snapshot->instances[hit->instance];
    // Of a light of several meshes those that are mirrored are turned around: corners 1 and 2 have changed
    // places.
    bool turned = (in->flags & NG_INSTANCE_MIRRORED) && !snapshot->lights[in->light].source.mirrored &&
                  snapshot->lights[in->light].source.type->emissive_mesh;
    out->triangle = in->light_triangle + hit->triangle;
    out->barycentric[0] = hit->barycentric[turned];
    out->barycentric[1] = hit->barycentric[!turned];
}
// Asks memory for what lf_surface_at will read, for callers with something to do in between: stage 0 for what
// tells where the rest is, stage 1 for the rest.
void lf_surface_prefetch(const struct lf_tracer *tracer, const struct lf_hit *hit, int stage);
// Whether it is met from the back and has none: it does not even shine.
static inline bool lf_surface_is_backless(const struct lf_surface *s)
{
    return !s->front && !s->double_sided;
}
// Whether it reflects nothing.
static inline bool lf_surface_is_black(const struct lf_surface *s)
{
    return s->unlit || lf_surface_is_backless(s);
}

NG_EXTERN_C_END

#endif

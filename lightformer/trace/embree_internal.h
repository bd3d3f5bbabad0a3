// Embree's side of a tracer: what building, meetings and rays share.
#ifndef LF_TRACE_EMBREE_INTERNAL_H
#define LF_TRACE_EMBREE_INTERNAL_H

#include "lightformer/trace/tracer_internal.h"
#include "lightformer/trace/vec.h"

#include <embree3/rtcore.h>
#include <string.h>

#define LF_MAX_BOXES 8

// One instance. Stays where it is while Embree knows it.
struct lf_slot {
    struct lf_tracer *tracer;
    RTCGeometry geometry;
    uint32_t instance;
    struct lf_instance seen; // by rays
    ng_entity entity;
    uint64_t mesh_key, mesh_revision, version;
    float matrix[12];
    float *vertices;         // Embree's, world space
    const uint32_t *indices; // the mesh's, while Embree uses them
    uint32_t *own_indices;   // Embree's instead, once a triangle had to be left out
};

// Around an emitter.
struct lf_box {
    float low[3], high[3];
};

struct lf_tracer {
    RTCDevice device;
    RTCScene scene, emitters;
    struct lf_box boxes[LF_MAX_BOXES];
    uint32_t box_count; // more than LF_MAX_BOXES: not all are kept, and Embree decides
    bool others_shine;  // some surface has emission without being a light's
    struct lf_slot *slots;
    uint32_t slot_count;
    const struct ng_snapshot *snapshot;
    struct lf_srgb srgb;
    struct lf_tracer_stats stats;
    bool failed; // Embree, since the last update began
};

// A coordinate that Embree takes, whatever it was.
static inline float lf_within_reach(float x)
{
    return lf_min(lf_max(x, -LF_TRACE_FARTHEST), LF_TRACE_FARTHEST);
}

// ---- shape.c ---------------------------------------------------------------------------------------------
// Unit normal of a disk or sphere at a place of it; moves the place exactly onto a sphere.
void lf_shape_normal(const struct lf_slot *slot, float position[3], float normal[3]);
// Gives a new geometry of Embree's kind "user", whose user data is a slot, the slot's shape.
void lf_shape_set(RTCGeometry geometry);

// ---- meeting.c -------------------------------------------------------------------------------------------
// What a ray looks for; Embree hands the context to every callback.
struct lf_query {
    struct RTCIntersectContext context;
    enum lf_ray_kind kind;
    uint32_t passes;   // a place of lights whose emitters are not there; NG_NONE: none
    lf_trace_fn visit; // every meeting is visited, none ends the ray
    void *user;
};

// Whether the query takes this meeting as its hit.
bool lf_accepts(const struct lf_query *query, const struct lf_slot *slot, const struct RTCRay *ray,
                const struct RTCHit *hit);
// Filters for Embree: of a query, and of the alpha mask of the geometry's slot.
void lf_filter_query(const struct RTCFilterFunctionNArguments *arguments);
void lf_filter_mask(const struct RTCFilterFunctionNArguments *arguments);

// Unit normal of the front. Embree's normal of a triangle follows the order of its vertices.
static inline void lf_triangle_normal(const struct lf_slot *s, const struct RTCHit *h, float normal[3])
{
    float sign = s->seen.flags & NG_INSTANCE_MIRRORED ? -1.0f : 1.0f;
    normal[0] = sign * h->Ng_x;
    normal[1] = sign * h->Ng_y;
    normal[2] = sign * h->Ng_z;
    lf_normalize(normal);
}

// The whole hit from what Embree tells of it. Nothing of the triangle is read: that would wait for memory.
static inline void lf_describe(const struct lf_slot *s, const struct RTCRay *ray, const struct RTCHit *h,
                               struct lf_hit *out)
{
    const float origin[3] = {ray->org_x, ray->org_y, ray->org_z};
    const float direction[3] = {ray->dir_x, ray->dir_y, ray->dir_z};
    out->instance = s->instance;
    out->triangle = h->primID;
    out->barycentric[0] = h->u;
    out->barycentric[1] = h->v;
    out->distance = ray->tfar;
    lf_mad(origin, direction, ray->tfar, out->position);
    if (s->seen.shape == LF_SHAPE_TRIANGLES)
        lf_triangle_normal(s, h, out->normal);
    else
        lf_shape_normal(s, out->position, out->normal);
    out->front = lf_dot(out->normal, direction) < 0;
}

// ---- packets ---------------------------------------------------------------------------------------------
// Callbacks see a packet of N rays, in which each member of struct RTCRay (or RTCHit), all of four bytes and
// in the same order, has become N of them. Alone, a ray is a packet of one.
static inline void lf_take_lane(void *one, size_t size, const void *packet, unsigned int n, unsigned int i)
{
    for (size_t k = 0; k < size / 4; k++)
        memcpy((char *)one + 4 * k, (const char *)packet + 4 * (k * n + i), 4);
}

static inline void lf_put_lane(void *packet, const void *one, size_t size, unsigned int n, unsigned int i)
{
    for (size_t k = 0; k < size / 4; k++)
        memcpy((char *)packet + 4 * (k * n + i), (const char *)one + 4 * k, 4);
}

static inline struct RTCRay lf_ray_of(const void *packet, unsigned int n, unsigned int i)
{
    struct RTCRay ray;
    lf_take_lane(&ray, sizeof ray, packet, n, i);
    return ray;
}

static inline struct RTCHit lf_hit_of(const void *packet, unsigned int n, unsigned int i)
{
    struct RTCHit hit;
    lf_take_lane(&hit, sizeof hit, packet, n, i);
    return hit;
}

#endif

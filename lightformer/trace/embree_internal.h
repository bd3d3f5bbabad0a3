// Embree's side of a tracer: what building, meetings and rays share.
#ifndef LF_TRACE_EMBREE_INTERNAL_H
#define LF_TRACE_EMBREE_INTERNAL_H

#include "base/array.h"
#include "lightformer/trace/tracer_internal.h"
#include "lightformer/trace/vec.h"
#include "render/copies.h"

#include <embree3/rtcore.h>
#include <string.h>

#define LF_MAX_BOXES 8

// Before these ids come geometries that nothing meets, one of each kind (tracer.c).
#define LF_TRACE_FIRST_ID 3u

// A geometry of triangles.
struct lf_triangles {
    RTCGeometry geometry;
    float *vertices;         // Embree's
    const uint32_t *indices; // the mesh's, while Embree uses them
    uint32_t *own_indices;   // Embree's instead, once a triangle had to be left out
    bool at_rest;            // the vertices are those of the mesh at rest, until its structure is built
    float turn[12];          // with which it was built
};

// A mesh that several instances show, where it is not flattened (sharing.c).
struct lf_shared {
    RTCScene scene; // null: not made yet
    struct lf_triangles triangles;
    bool masked; // for some instance
    bool used;   // by the snapshot of this update
};

// One instance. Stays where it is while Embree knows it.
struct lf_trace_slot {
    RTCGeometry geometry;
    uint32_t id; // of the geometry in the tracer's scenes
    uint32_t instance;
    struct lf_instance seen; // by rays
    ng_entity entity;
    uint64_t mesh_key, mesh_revision, version;
    uint32_t vertex_count, index_count;
    float matrix[12];
    struct lf_triangles triangles; // flattened into world space; `geometry` is theirs
    struct lf_shared *shared;      // or placed by Embree; null: not
    bool hidden;                   // by another one: without geometry
    bool may_share, emits, attached;
    bool shown; // by the snapshot of this update
};

// Around an emitter.
struct lf_box {
    float low[3], high[3];
};

struct lf_tracer {
    RTCDevice device;
    RTCScene scene, emitters;
    struct lf_box boxes[LF_MAX_BOXES];
    uint32_t box_count;                      // more than LF_MAX_BOXES: not all are kept, and Embree decides
    bool lamps;                              // some surface is one
    bool others_shine;                       // some surface has emission without being a light's
    NG_ARRAY(struct lf_trace_slot *) by_id;  // null: no geometry has this id
    NG_ARRAY(struct lf_trace_slot *) shown;  // beside the snapshot's instances
    NG_ARRAY(struct lf_trace_slot *) before; // those of the last update, while one runs
    NG_ARRAY(uint32_t) ids;                  // of the instances of this update
    NG_ARRAY(uint8_t) surfaces;              // of the entity with this index, listed so far
    NG_ARRAY(uint32_t) places;               // of the entity in the order of ids, from 1; 0: none
    struct ng_copies copies;                 // those that are hidden meet no ray
    NG_ARRAY(struct lf_shared *) shared;
    NG_ARRAY(struct lf_shared *) by_mesh; // of the snapshot's meshes, while an update runs; null: flattened
    uint64_t memory_limit, most_bytes, bytes; // asked for, of this update, and taken by Embree
    const struct ng_snapshot *snapshot;
    struct lf_srgb srgb;
    struct lf_tracer_stats stats;
    bool failed; // Embree, since the last update began
};

// A coordinate that Embree takes, whatever it was. It computes without denormal numbers: what is nearest to
// zero is zero, so that no two coordinates differ by one.
#define LF_TRACE_NEAREST 1e-30f
static inline float lf_within_reach(float x)
{
    float near = lf_min(lf_max(x, -LF_TRACE_FARTHEST), LF_TRACE_FARTHEST);
    return fabsf(near) < LF_TRACE_NEAREST ? 0 : near;
}

// ---- triangles.c -----------------------------------------------------------------------------------------
// A structure is built around the mesh at rest, then refitted (README.md): made, moved, committed with its
// scene, and settled.
NG_NODISCARD ng_result lf_triangles_make(RTCDevice device, const struct ng_snapshot_mesh *mesh,
                                         struct lf_triangles *out);
// To where a matrix (null: none) puts the mesh's positions; the caller commits. `*built`: the structure will
// be built, and if `at_rest` is set it has to be settled after that.
NG_NODISCARD ng_result lf_triangles_move(struct lf_triangles *triangles, const float matrix[12],
                                         const struct ng_snapshot_mesh *mesh, bool *built);
void lf_triangles_settle(struct lf_triangles *triangles, const float matrix[12],
                         const struct ng_snapshot_mesh *mesh);
void lf_triangles_mask(struct lf_triangles *triangles, bool masked);

// ---- slots.c ---------------------------------------------------------------------------------------------
// Finds the slots of a snapshot's instances: sets `shown`, null where one has to be made, and drops the slots
// of what is gone. `*changed`: what may be shared is to be chosen again.
NG_NODISCARD ng_result lf_slots_find(struct lf_tracer *tracer, const struct ng_snapshot *snapshot,
                                     bool *changed);
// Drops those that are shared and should not be, or the other way round.
void lf_slots_drop_otherwise_shared(struct lf_tracer *tracer, const struct ng_snapshot *snapshot);
// Makes what is missing, and brings the others to where the snapshot has them; the caller commits the scenes.
NG_NODISCARD ng_result lf_slots_follow(struct lf_tracer *tracer, const struct ng_snapshot *snapshot);
// Moves structures that were built around meshes at rest to where these are; the scenes have been committed,
// and have to be again. False: there were none.
bool lf_slots_settle(struct lf_tracer *tracer, const struct ng_snapshot *snapshot);
void lf_slots_forget(struct lf_tracer *tracer);

// ---- sharing.c -------------------------------------------------------------------------------------------
// Decides which of a snapshot's meshes instances share: sets `by_mesh`. Error, logged: NG_ERROR_MEMORY.
NG_NODISCARD ng_result lf_sharing_choose(struct lf_tracer *tracer, const struct ng_snapshot *snapshot);
// Frees the meshes that are shared no longer; no slot has them.
void lf_sharing_tidy(struct lf_tracer *tracer);
void lf_sharing_forget(struct lf_tracer *tracer);
// Whether an instance's mesh may be one of them.
bool lf_may_share(const struct lf_tracer *tracer, const struct ng_snapshot *snapshot, uint32_t instance);
// Makes a slot's geometry an instance of a mesh, which is made if it is not yet; the caller places and
// commits the geometry.
NG_NODISCARD ng_result lf_sharing_attach(struct lf_tracer *tracer, struct lf_shared *shared,
                                         const struct ng_snapshot_mesh *mesh, struct lf_trace_slot *slot);
// Follows the slot's matrix and mask.
void lf_sharing_place(struct lf_trace_slot *slot);

// ---- shape.c ---------------------------------------------------------------------------------------------
// Unit normal of a disk or sphere at a place of it; moves the place exactly onto a sphere.
void lf_shape_normal(const struct lf_trace_slot *slot, float position[3], float normal[3]);
// Gives a new geometry of Embree's kind "user" a slot's shape.
void lf_shape_set(RTCGeometry geometry, struct lf_trace_slot *slot);

// ---- meeting.c -------------------------------------------------------------------------------------------
// What a ray looks for; Embree hands the context to every callback.
struct lf_query {
    struct RTCIntersectContext context;
    const struct lf_tracer *tracer;
    enum lf_ray_kind kind;
    const uint32_t *pixel; // whose camera ray it is; null: no pixel's
    // Of rays of a view's pixels, which ids of rays number; or null. What they meet is lamps alone, or all
    // else.
    const struct lf_view *view;
    bool lamps;
    // Emitters in its place, and lamps beside it, are not there; or null.
    const struct ng_snapshot_light *light;
    lf_trace_fn visit; // every meeting is visited, none ends the ray
    void *user;
};

// Whether the query takes this meeting as its hit.
bool lf_accepts(const struct lf_query *query, const struct lf_trace_slot *slot, const struct RTCRay *ray,
                const struct RTCHit *hit);
// Filters for Embree: of a query, and of alpha masks.
void lf_filter_query(const struct RTCFilterFunctionNArguments *arguments);
void lf_filter_mask(const struct RTCFilterFunctionNArguments *arguments);

// Whether a query of a view takes a hit.
static inline bool lf_view_shows(const struct lf_query *q, const struct lf_trace_slot *s, bool front)
{
    bool lamp = s->seen.flags & NG_INSTANCE_LAMP;
    return lamp == q->lamps && (front || s->seen.flags & NG_INSTANCE_DOUBLE_SIDED);
}

// Whether Embree takes it: beyond these limits its assertions, which packages of it have on, end the process.
static inline bool lf_is_ray(const float origin[3], const float direction[3], float near, float far)
{
    bool inside = true;
    for (int k = 0; k < 3; k++)
        inside &= (fabsf(origin[k]) <= LF_TRACE_FARTHEST) & (fabsf(direction[k]) <= LF_TRACE_FARTHEST);
    return inside & (near >= 0) & (near <= far); // false of what is no number
}

// Whose geometry was met.
static inline const struct lf_trace_slot *lf_trace_slot_met(const struct lf_tracer *t, const struct RTCHit *h)
{
    return t->by_id.items[h->instID[0] == RTC_INVALID_GEOMETRY_ID ? h->geomID : h->instID[0]];
}

// Unit normal of the front. Embree's normal of a triangle follows the order of its vertices, in the mesh's
// own space if it is shared.
static inline void lf_triangle_normal(const struct lf_trace_slot *s, const struct RTCHit *h, float normal[3])
{
    if (s->shared) {
        const float own[3] = {h->Ng_x, h->Ng_y, h->Ng_z}, *to_world = s->seen.normal_matrix;
        for (int i = 0; i < 3; i++)
            normal[i] = lf_dot(to_world + (size_t)i * 3, own);
        lf_normalize(normal);
        return;
    }
    float sign = s->seen.flags & NG_INSTANCE_MIRRORED ? -1.0f : 1.0f;
    normal[0] = sign * h->Ng_x;
    normal[1] = sign * h->Ng_y;
    normal[2] = sign * h->Ng_z;
    lf_normalize(normal);
}

// The whole hit from what Embree tells of it. Nothing of the triangle is read: that would wait for memory.
static inline void lf_describe(const struct lf_trace_slot *s, const struct RTCRay *ray,
                               const struct RTCHit *h, struct lf_hit *out)
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

// Rays, one by one and in packets: from the tracer's terms to Embree's and back.
#include "light/light.h"
#include "lightformer/trace/embree_internal.h"
#include "lightformer/trace/vec.h"

#define MOST_COINCIDING 16    // emitters that are told apart
#define LEAST_SLANT     0.05f // cosine under which what coincides is no longer told apart from what lies behind

// In place: what is written member by member and then copied as a whole waits for the stores.
static void aim(const struct lf_ray *ray, struct RTCRay *out)
{
    out->org_x = ray->origin[0];
    out->org_y = ray->origin[1];
    out->org_z = ray->origin[2];
    out->tnear = ray->near;
    out->dir_x = ray->direction[0];
    out->dir_y = ray->direction[1];
    out->dir_z = ray->direction[2];
    out->time = 0;
    out->tfar = ray->far;
    out->mask = UINT32_MAX;
    out->id = ray->sample;
    out->flags = 0;
}

static void begin_query(const struct lf_tracer *t, enum lf_ray_kind kind, lf_trace_fn visit, void *user,
                        struct lf_query *out)
{
    rtcInitIntersectContext(&out->context);
    out->tracer = t;
    out->kind = kind;
    out->light = NULL;
    out->pixel = NULL;
    out->view = NULL;
    out->visit = visit;
    out->user = user;
    if (visit || kind == LF_RAY_CAMERA || (kind == LF_RAY_PAST_LAMPS && t->lamps))
        out->context.filter = lf_filter_query;
}

// Of LF_RAY_ALL. `light`: whose emitter is passed, and lamps beside it, or NG_NONE.
static void begin_passing(const struct lf_tracer *t, uint32_t light, struct lf_query *out)
{
    begin_query(t, LF_RAY_ALL, NULL, NULL, out);
    if (light == NG_NONE)
        return;
    out->light = &t->snapshot->lights[light];
    out->context.filter = lf_filter_query;
}

static bool intersect(RTCScene scene, const struct lf_ray *ray, struct lf_query *q, struct RTCRayHit *out)
{
    if (!lf_is_ray(ray->origin, ray->direction, ray->near, ray->far))
        return false;
    aim(ray, &out->ray);
    out->hit.geomID = RTC_INVALID_GEOMETRY_ID;
    out->hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene, &q->context, out);
    return out->hit.geomID != RTC_INVALID_GEOMETRY_ID;
}

bool lf_trace_closest(const struct lf_tracer *t, const struct lf_ray *ray, enum lf_ray_kind kind,
                      struct lf_hit *out)
{
    return lf_trace_pixel(t, ray, kind, NULL, out);
}

bool lf_trace_pixel(const struct lf_tracer *t, const struct lf_ray *ray, enum lf_ray_kind kind,
                    const uint32_t pixel[2], struct lf_hit *out)
{
    struct lf_query q;
    struct RTCRayHit rayhit;
    begin_query(t, kind, NULL, NULL, &q);
    q.pixel = pixel;
    if (!intersect(t->scene, ray, &q, &rayhit))
        return false;
    lf_describe(lf_trace_slot_met(t, &rayhit.hit), &rayhit.ray, &rayhit.hit, out);
    return true;
}

bool lf_trace_shadowed(const struct lf_tracer *t, const struct lf_ray *ray, uint32_t light)
{
    struct lf_query q;
    struct RTCRay r;
    if (!lf_is_ray(ray->origin, ray->direction, ray->near, ray->far))
        return false;
    begin_passing(t, light, &q);
    aim(ray, &r);
    rtcOccluded1(t->scene, &q.context, &r);
    return r.tfar < 0;
}

bool lf_trace_occluded(const struct lf_tracer *t, const struct lf_ray *ray)
{
    return lf_trace_shadowed(t, ray, NG_NONE);
}

// As Embree wants them; what is no ray is not valid, and harmless besides: kernels narrower than a packet
// take rays that end before they begin for none, whatever `valid` says. Lane by lane and axis by axis, so
// that it vectorizes.
static void aim_side_by_side(const struct lf_tracer *t, const struct lf_packet *p, struct lf_query *q,
                             int valid[LF_PACKET], struct RTCRayHit16 *out)
{
    begin_passing(t, p->passes, q);
    *out = (struct RTCRayHit16){0};
    for (int i = 0; i < LF_PACKET; i++) {
        const float origin[3] = {p->origin[0][i], p->origin[1][i], p->origin[2][i]};
        const float direction[3] = {p->direction[0][i], p->direction[1][i], p->direction[2][i]};
        bool ray = lf_is_ray(origin, direction, 0, p->far[i]) & (p->far[i] > 0);
        valid[i] = -(int)ray;
        out->ray.org_x[i] = ray ? origin[0] : 0;
        out->ray.org_y[i] = ray ? origin[1] : 0;
        out->ray.org_z[i] = ray ? origin[2] : 0;
        out->ray.dir_x[i] = ray ? direction[0] : 0;
        out->ray.dir_y[i] = ray ? direction[1] : 0;
        out->ray.dir_z[i] = ray ? direction[2] : 1;
        out->ray.tfar[i] = ray ? p->far[i] : -INFINITY;
        out->ray.mask[i] = UINT32_MAX;
        out->hit.geomID[i] = out->hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
}

void lf_trace_packet_occluded(const struct lf_tracer *t, struct lf_packet *p)
{
    struct lf_query q;
    struct RTCRayHit16 r;
    _Alignas(64) int valid[LF_PACKET];
    aim_side_by_side(t, p, &q, valid, &r);
    rtcOccluded16(valid, t->scene, &q.context, &r.ray);
    for (int i = 0; i < LF_PACKET; i++)
        p->met[i] = valid[i] && r.ray.tfar[i] < 0;
}

void lf_trace_packet(const struct lf_tracer *t, struct lf_packet *p, struct lf_hit *hits)
{
    struct lf_query q;
    struct RTCRayHit16 r;
    _Alignas(64) int valid[LF_PACKET];
    aim_side_by_side(t, p, &q, valid, &r);
    // Embree does not come back from some coherent packets among instances. Packets that ask for anything in
    // the way are faster without (bench_encode: visibility, shadow_distance).
    if (!t->shared.count)
        q.context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect16(valid, t->scene, &q.context, &r);
    for (unsigned int i = 0; i < LF_PACKET; i++) {
        p->met[i] = valid[i] && r.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
        if (p->met[i])
            p->far[i] = r.ray.tfar[i];
        if (p->met[i] && hits) {
            struct RTCRay ray = lf_ray_of(&r.ray, LF_PACKET, i);
            struct RTCHit hit = lf_hit_of(&r.hit, LF_PACKET, i);
            lf_describe(lf_trace_slot_met(t, &hit), &ray, &hit, &hits[i]);
        }
    }
}

// Up to LF_PACKET rays; lanes without a ray, or with what is none, are not valid.
static void aim_packet(const struct lf_ray *rays, uint32_t count, int valid[LF_PACKET], struct RTCRay16 *out)
{
    for (uint32_t i = 0; i < LF_PACKET; i++) {
        static const struct lf_ray none = {.direction = {0, 0, 1}, .near = 0, .far = -INFINITY};
        const struct lf_ray *ray = &rays[i < count ? i : 0];
        valid[i] = -(int)((i < count) & lf_is_ray(ray->origin, ray->direction, ray->near, ray->far));
        ray = valid[i] ? ray : &none;
        out->org_x[i] = ray->origin[0];
        out->org_y[i] = ray->origin[1];
        out->org_z[i] = ray->origin[2];
        out->tnear[i] = ray->near;
        out->dir_x[i] = ray->direction[0];
        out->dir_y[i] = ray->direction[1];
        out->dir_z[i] = ray->direction[2];
        out->time[i] = 0;
        out->tfar[i] = ray->far;
        out->mask[i] = UINT32_MAX;
        out->id[i] = ray->sample;
        out->flags[i] = 0;
    }
}

void lf_trace_closest_many(const struct lf_tracer *t, const struct lf_ray *rays, uint32_t count, bool *met,
                           struct lf_hit *hits)
{
    struct lf_query q;
    struct RTCRayHit16 r;
    _Alignas(64) int valid[LF_PACKET];
    begin_query(t, LF_RAY_ALL, NULL, NULL, &q);
    for (uint32_t begin = 0; begin < count; begin += LF_PACKET) {
        uint32_t lanes = count - begin < LF_PACKET ? count - begin : LF_PACKET;
        aim_packet(rays + begin, lanes, valid, &r.ray);
        for (uint32_t i = 0; i < LF_PACKET; i++)
            r.hit.geomID[i] = r.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect16(valid, t->scene, &q.context, &r);
        for (unsigned int i = 0; i < lanes; i++) {
            met[begin + i] = valid[i] && r.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
            if (!met[begin + i])
                continue;
            struct RTCRay ray = lf_ray_of(&r.ray, LF_PACKET, i);
            struct RTCHit hit = lf_hit_of(&r.hit, LF_PACKET, i);
            lf_describe(lf_trace_slot_met(t, &hit), &ray, &hit, &hits[begin + i]);
        }
    }
}

void lf_trace_occluded_many(const struct lf_tracer *t, const struct lf_ray *rays, uint32_t count, bool *met)
{
    struct lf_query q;
    struct RTCRay16 r;
    _Alignas(64) int valid[LF_PACKET];
    begin_query(t, LF_RAY_ALL, NULL, NULL, &q);
    for (uint32_t begin = 0; begin < count; begin += LF_PACKET) {
        uint32_t lanes = count - begin < LF_PACKET ? count - begin : LF_PACKET;
        aim_packet(rays + begin, lanes, valid, &r);
        rtcOccluded16(valid, t->scene, &q.context, &r);
        for (uint32_t i = 0; i < lanes; i++)
            met[begin + i] = valid[i] && r.tfar[i] < 0;
    }
}

static bool passes(const struct lf_ray *ray, const struct lf_box *b)
{
    float near = ray->near, far = ray->far;
    for (int k = 0; k < 3; k++) {
        float inverse = 1 / ray->direction[k];
        float a = (b->low[k] - ray->origin[k]) * inverse, c = (b->high[k] - ray->origin[k]) * inverse;
        // In the plane of a face one of them is not a number; then either answer is right.
        near = lf_max(lf_min(a, c), near);
        far = lf_min(lf_max(a, c), far);
    }
    return near <= far;
}

static bool passes_emitters(const struct lf_tracer *t, const struct lf_ray *ray)
{
    bool near = t->box_count > LF_MAX_BOXES;
    for (uint32_t i = 0; !near && i < t->box_count; i++)
        near = passes(ray, &t->boxes[i]);
    return near;
}

bool lf_trace_may_shine(const struct lf_tracer *t, const struct lf_ray *ray)
{
    return t->others_shine || passes_emitters(t, ray);
}

bool lf_trace_emitters(const struct lf_tracer *t, const struct lf_ray *ray, lf_trace_fn visit, void *user)
{
    if (!passes_emitters(t, ray))
        return false;
    struct lf_query q;
    struct RTCRayHit rayhit;
    begin_query(t, LF_RAY_ALL, visit, user, &q);
    intersect(t->emitters, ray, &q, &rayhit);
    return true;
}

static bool is_at_emitter(const struct lf_tracer *t, const float position[3], float reach)
{
    bool inside = t->box_count > LF_MAX_BOXES;
    for (uint32_t i = 0; !inside && i < t->box_count; i++) {
        const struct lf_box *b = &t->boxes[i];
        inside = true;
        for (int k = 0; k < 3; k++)
            inside &= (position[k] >= b->low[k] - reach) & (position[k] <= b->high[k] + reach);
    }
    return inside;
}

// A ray along an edge meets both triangles of one emitter.
struct coinciding {
    lf_trace_fn visit;
    void *user;
    uint32_t seen[MOST_COINCIDING], count;
};

static void visit_once(void *user, const struct lf_hit *hit)
{
    struct coinciding *c = user;
    for (uint32_t i = 0; i < c->count; i++)
        if (c->seen[i] == hit->instance)
            return;
    if (c->count < MOST_COINCIDING)
        c->seen[c->count++] = hit->instance;
    c->visit(c->user, hit);
}

void lf_trace_coinciding(const struct lf_tracer *t, const struct lf_ray *ray, const struct lf_hit *hit,
                         lf_trace_fn visit, void *user)
{
    float slant = lf_max(fabsf(lf_dot(hit->normal, ray->direction)), LEAST_SLANT);
    const struct ng_snapshot *s = t->snapshot;
    const float *p = hit->position;
    float reach = (ng_light_skin(s->scene_radius, p[0], p[1], p[2]) + s->place_size) / slant;
    if (!is_at_emitter(t, p, reach))
        return;
    struct lf_ray around = *ray;
    around.near = lf_max(hit->distance - reach, 0);
    around.far = hit->distance + reach;
    struct coinciding once = {.visit = visit, .user = user};
    lf_trace_emitters(t, &around, visit_once, &once);
}

uint32_t lf_trace_bare(const struct lf_tracer *t, const struct lf_ray *rays, uint32_t count)
{
    uint32_t met = 0;
    for (uint32_t i = 0; i < count; i++) {
        struct lf_query q;
        struct RTCRayHit rayhit;
        begin_query(t, LF_RAY_ALL, NULL, NULL, &q);
        met += intersect(t->scene, &rays[i], &q, &rayhit);
    }
    return met;
}

void lf_trace_origin(const struct lf_tracer *t, const float position[3], const float normal[3],
                     const float direction[3], float out[3])
{
    float off = lf_trace_offset(t->snapshot->scene_radius, position[0], position[1], position[2]);
    lf_mad(position, normal, copysignf(off, lf_dot(normal, direction)), out);
}

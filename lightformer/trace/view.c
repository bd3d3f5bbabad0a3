// Tiles of a camera's rays.
//
// Most first meetings count: a filter, which Embree asks for every triangle that is met, would cost more than
// all the rest. So a packet is traced without one, and once more with it where some of its rays met what does
// not count. All of its rays then go again, as they do where a lamp stands in front of one of them: of two
// triangles that meet in an edge a packet finds one or the other by how its rays lie together, and what is
// seen behind a lamp must not depend on the lamp.
#include "lightformer/trace/view.h"

#include "lightformer/trace/embree_internal.h"
#include "lightformer/trace/surface.h"
#include "render/camera.h"
#include "render/subpixel.h"

// Where in a pixel its ray passes: a hair beside the middle. Through the very middle of pixels lie edges of
// rooms that stand as their camera does, and which of two surfaces that meet in an edge is met depends on the
// structure of the scene, so on lamps that are not even seen.
#define ACROSS 1.3e-6f // in halves of the picture: some steps of the numbers there
#define DOWN   -1.1e-6f

struct lf_view lf_view_of(const struct ng_snapshot_camera *camera, uint32_t width, uint32_t height)
{
    const struct ng_camera_rays rays = ng_camera_rays_of(camera, (float)width / (float)height);
    struct lf_view v = {
        .near_plane = camera->near_plane, .parallel = camera->orthographic, .width = width, .height = height};
    ng_subpixel_shift(camera->subpixel, v.shift);
    v.subpixel = camera->subpixel;
    v.shift[0] = 2 * v.shift[0] / (float)width + ACROSS;
    v.shift[1] = 2 * v.shift[1] / (float)height + DOWN;
    memcpy(v.position, camera->position, sizeof v.position);
    memcpy(v.right, rays.right, sizeof v.right);
    memcpy(v.down, rays.down, sizeof v.down);
    memcpy(v.forward, rays.forward, sizeof v.forward);
    return v;
}

struct lf_ray lf_view_ray(const struct lf_view *v, uint32_t x, uint32_t y)
{
    struct lf_ray ray = {.far = INFINITY};
    float right = 2 * ((float)x + 0.5f) / (float)v->width - 1 + v->shift[0],
          down = 2 * ((float)y + 0.5f) / (float)v->height - 1 + v->shift[1];
    memcpy(ray.origin, v->position, sizeof ray.origin);
    memcpy(ray.direction, v->forward, sizeof ray.direction);
    float *moved = v->parallel ? ray.origin : ray.direction;
    lf_mad(moved, v->right, right, moved);
    lf_mad(moved, v->down, down, moved);
    lf_normalize(ray.direction);
    ray.near = v->near_plane / lf_dot(ray.direction, v->forward);
    return ray;
}

// A step of the ray moves the point along it, too, so that it stays in the plane.
static void step(const struct lf_view *v, const float to_point[3], const float normal[3], const float axis[3],
                 float pixels, float out[3])
{
    float distance = v->parallel ? 1 : lf_dot(to_point, v->forward);
    lf_scale(axis, 2 / pixels * distance, out);
    float slant = lf_dot(normal, to_point), along = slant != 0 ? -lf_dot(normal, out) / slant : 0;
    lf_mad(out, to_point, along, out);
}

void lf_view_steps(const struct lf_view *v, const float position[3], const float normal[3], float right[3],
                   float down[3])
{
    float to_point[3];
    if (v->parallel)
        memcpy(to_point, v->forward, sizeof to_point);
    else
        lf_mad(position, v->position, -1, to_point);
    step(v, to_point, normal, v->right, (float)v->width, right);
    step(v, to_point, normal, v->down, (float)v->height, down);
}

// ---- tiles -----------------------------------------------------------------------------------------------

struct packet {
    _Alignas(64) int valid[LF_PACKET];
    struct RTCRayHit16 rays;
};

// The rays of lf_view_ray, in loops over lanes that vectorize.
static void aim(const struct lf_view *v, uint32_t x, uint32_t y, struct lf_tile *tile, float near[LF_PACKET])
{
    float right[LF_PACKET], down[LF_PACKET],
        (*moved)[LF_PACKET] = v->parallel ? tile->origin : tile->direction;
    for (uint32_t i = 0; i < LF_PACKET; i++) {
        uint32_t column = x + i % LF_TILE, row = y + i / LF_TILE;
        right[i] = 2 * ((float)column + 0.5f) / (float)v->width - 1 + v->shift[0];
        down[i] = 2 * ((float)row + 0.5f) / (float)v->height - 1 + v->shift[1];
    }
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < LF_PACKET; i++) {
            tile->origin[k][i] = v->position[k];
            tile->direction[k][i] = v->forward[k];
            moved[k][i] += v->right[k] * right[i] + v->down[k] * down[i];
        }
    float *dx = tile->direction[0], *dy = tile->direction[1], *dz = tile->direction[2];
    for (int i = 0; i < LF_PACKET; i++) {
        float scale = 1 / sqrtf(dx[i] * dx[i] + dy[i] * dy[i] + dz[i] * dz[i]);
        dx[i] *= scale;
        dy[i] *= scale;
        dz[i] *= scale;
        near[i] = v->near_plane / (dx[i] * v->forward[0] + dy[i] * v->forward[1] + dz[i] * v->forward[2]);
    }
}

// What is no ray is not valid, and ends before it begins besides, as in rays.c.
static void load(const struct lf_view *v, uint32_t x, uint32_t y, const struct lf_tile *tile,
                 const float near[LF_PACKET], struct packet *out)
{
    for (uint32_t i = 0; i < LF_PACKET; i++) {
        uint32_t px = x + i % LF_TILE, py = y + i / LF_TILE;
        const float origin[3] = {tile->origin[0][i], tile->origin[1][i], tile->origin[2][i]};
        const float direction[3] = {tile->direction[0][i], tile->direction[1][i], tile->direction[2][i]};
        bool ray = (px < v->width) & (py < v->height) & lf_is_ray(origin, direction, near[i], INFINITY);
        out->valid[i] = -(int)ray;
        out->rays.ray.org_x[i] = ray ? origin[0] : 0;
        out->rays.ray.org_y[i] = ray ? origin[1] : 0;
        out->rays.ray.org_z[i] = ray ? origin[2] : 0;
        out->rays.ray.tnear[i] = ray ? near[i] : 0;
        out->rays.ray.dir_x[i] = ray ? direction[0] : 0;
        out->rays.ray.dir_y[i] = ray ? direction[1] : 0;
        out->rays.ray.dir_z[i] = ray ? direction[2] : 1;
        out->rays.ray.time[i] = 0;
        out->rays.ray.mask[i] = UINT32_MAX;
        out->rays.ray.id[i] = py * v->width + px; // meeting.c finds the pixel by it
        out->rays.ray.flags[i] = 0;
    }
}

static void forget_hits(struct packet *p)
{
    for (int i = 0; i < LF_PACKET; i++) {
        p->rays.ray.tfar[i] = p->valid[i] ? INFINITY : -INFINITY;
        p->rays.hit.geomID[i] = p->rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
}

// Not as a coherent packet, though that takes a fifth less time: what its rays meet in an edge would depend
// on how they lie together. Among instances it does so in any packet.
static void trace(const struct lf_tracer *t, RTCScene scene, struct lf_query *q, struct packet *p)
{
    forget_hits(p);
    if (!t->shared.count) {
        rtcIntersect16(p->valid, scene, &q->context, &p->rays);
        return;
    }
    for (unsigned int i = 0; i < LF_PACKET; i++) {
        struct RTCRayHit one = {.ray = lf_ray_of(&p->rays.ray, LF_PACKET, i),
                                .hit = lf_hit_of(&p->rays.hit, LF_PACKET, i)};
        if (!p->valid[i])
            continue;
        rtcIntersect1(scene, &q->context, &one);
        lf_put_lane(&p->rays.ray, &one.ray, sizeof one.ray, LF_PACKET, i);
        lf_put_lane(&p->rays.hit, &one.hit, sizeof one.hit, LF_PACKET, i);
    }
}

// False if a ray met what does not count.
static bool describe(const struct lf_query *q, const struct packet *p, struct lf_tile *out)
{
    const struct RTCHit16 *h = &p->rays.hit;
    bool all = true;
    for (unsigned int i = 0; i < LF_PACKET; i++) {
        out->met[i] = p->valid[i] && h->geomID[i] != RTC_INVALID_GEOMETRY_ID;
        if (!out->met[i])
            continue;
        const struct RTCRay ray = {.org_x = out->origin[0][i],
                                   .org_y = out->origin[1][i],
                                   .org_z = out->origin[2][i],
                                   .dir_x = out->direction[0][i],
                                   .dir_y = out->direction[1][i],
                                   .dir_z = out->direction[2][i],
                                   .tfar = p->rays.ray.tfar[i]};
        const struct RTCHit hit = {.Ng_x = h->Ng_x[i],
                                   .Ng_y = h->Ng_y[i],
                                   .Ng_z = h->Ng_z[i],
                                   .u = h->u[i],
                                   .v = h->v[i],
                                   .primID = h->primID[i],
                                   .geomID = h->geomID[i],
                                   .instID = {h->instID[0][i]}};
        const struct lf_trace_slot *slot = lf_trace_slot_met(q->tracer, &hit);
        lf_describe(slot, &ray, &hit, &out->hits[i]);
        all &= lf_view_shows(q, slot, out->hits[i].front);
    }
    return all;
}

void lf_trace_tile(const struct lf_tracer *t, const struct lf_view *view, uint32_t x, uint32_t y, bool lamps,
                   struct lf_tile *out)
{
    struct lf_query q = {.tracer = t, .kind = LF_RAY_CAMERA, .view = view, .lamps = lamps};
    struct packet p;
    float near[LF_PACKET];
    RTCScene scene = lamps ? t->emitters : t->scene;
    rtcInitIntersectContext(&q.context);
    aim(view, x, y, out, near);
    load(view, x, y, out, near, &p);
    // Where rays go one by one there is nothing to gain by a first round.
    if (!lamps && !t->shared.count) {
        trace(t, scene, &q, &p);
        if (describe(&q, &p, out))
            return;
    }
    q.context.filter = lf_filter_query;
    trace(t, scene, &q, &p);
    (void)describe(&q, &p, out);
}

// Tile by tile: rays in packets, then memory asked for, then each pixel's surface. Halfs are made of a whole
// tile at once.
#include "lightformer/raycast/picture.h"

#include "base/jobs.h"
#include "lightformer/raycast/pack.h"
#include "lightformer/trace/surface.h"
#include "lightformer/trace/vec.h"
#include "lightformer/trace/view.h"
#include "render/snapshot.h"
#include "shaders/shared/scene.h"

#include <string.h>

// A lamp that lies in a surface is seen: distances that differ by less than rounding are the same.
#define SAME_DISTANCE 1e-6f

struct drawing {
    const struct lf_raycast_job *job;
    const struct ng_snapshot *snapshot;
    const struct lf_pack_kernels *kernels;
    struct lf_view view;
    float pixels[2];           // half the picture's, for each length of `right` and `down`
    uint32_t first[2], end[2]; // pixels that are drawn: x, y
    bool lamps;
};

// What is written of a tile.
struct texels {
    float normal[LF_PACKET][4], diffuse[LF_PACKET][4], specular[LF_PACKET][4];
};

// ---- A pixel ---------------------------------------------------------------------------------------------

// Meyer et al. 2010; engine/shaders/geometry.glsl reads it.
static void set_octahedral(const float n[3], float *x, float *y)
{
    float scale = 1 / (fabsf(n[0]) + fabsf(n[1]) + fabsf(n[2]));
    float u = n[0] * scale, v = n[1] * scale;
    *x = n[2] >= 0 ? u : copysignf(1 - fabsf(v), u);
    *y = n[2] >= 0 ? v : copysignf(1 - fabsf(u), v);
}

static bool moves(const struct ng_snapshot *s, const struct ng_snapshot_instance *in)
{
    return s->meshes[in->mesh].dynamic || memcmp(in->matrix, in->previous_matrix, sizeof in->matrix) != 0;
}

// In pixels, from where the camera of the frame before saw the point.
static void find_motion(const struct drawing *d, const struct lf_hit *hit, const float position[3],
                        const uint32_t pixel[2], float out[2])
{
    const float *view = d->snapshot->camera.previous_view;
    float before[3], eye[3];
    memcpy(before, position, sizeof before);
    if (moves(d->snapshot, &d->snapshot->instances[hit->instance]))
        lf_surface_previous(d->job->tracer, hit, before);
    for (int i = 0; i < 3; i++)
        eye[i] = view[i] * before[0] + view[4 + i] * before[1] + view[8 + i] * before[2] + view[12 + i];
    float ahead = d->view.parallel ? 1 : -eye[2];
    out[0] = (float)pixel[0] + 0.5f - (0.5f * (float)d->view.width + eye[0] / ahead * d->pixels[0]);
    out[1] = (float)pixel[1] + 0.5f - (0.5f * (float)d->view.height - eye[1] / ahead * d->pixels[1]);
}

static void find_surface(const struct drawing *d, const struct lf_hit *hit, const float direction[3],
                         struct lf_surface *out)
{
    const struct lf_tracer *tracer = d->job->tracer;
    struct lf_footprint footprint;
    float right[3], down[3];
    bool textured = lf_surface_is_textured(tracer, hit);
    if (textured) {
        lf_view_steps(&d->view, hit->position, hit->normal, right, down);
        lf_footprint_find(tracer, hit, right, down, &footprint);
    }
    lf_surface_at_pixel(tracer, hit, direction, textured ? &footprint : NULL, out);
}

// Member by member, four at a time.
static void put(float to[4], const float xyz[3], float w)
{
    to[0] = xyz[0];
    to[1] = xyz[1];
    to[2] = xyz[2];
    to[3] = w;
}

static void draw_surface(const struct drawing *d, const struct lf_tile *tile, const uint32_t pixel[2],
                         int lane, struct texels *texels)
{
    const struct lf_raycast_picture *p = &d->job->picture;
    const struct lf_hit *hit = &tile->hits[lane];
    const float direction[3] = {tile->direction[0][lane], tile->direction[1][lane], tile->direction[2][lane]};
    size_t at = (size_t)pixel[1] * p->width + pixel[0];
    struct lf_surface s;
    float x, y;
    find_surface(d, hit, direction, &s);
    set_octahedral(s.flat_normal, &x, &y);
    put(texels->normal[lane], s.normal, s.roughness);
    put(texels->diffuse[lane], s.albedo, x);
    put(texels->specular[lane], s.f0, y);
    for (int c = 0; c < 3; c++)
        s.emission[c] = lf_min(s.emission[c], NG_RADIANCE_MAX);
    put(p->position + 4 * at, s.position, s.unlit ? -1 : 1);
    put(p->emission + 4 * at, s.emission, d->lamps ? 1 : 0);
    find_motion(d, hit, s.position, pixel, p->motion + 2 * at);
    p->entity[at] = ng_entity_index(d->snapshot->instances[hit->instance].entity);
}

// Where is no surface.
static void draw_background(const struct drawing *d, const struct lf_tile *tile, const uint32_t pixel[2],
                            int lane, struct texels *texels)
{
    static const float none[3];
    const struct lf_raycast_picture *p = &d->job->picture;
    size_t at = (size_t)pixel[1] * p->width + pixel[0];
    float sky[3] = {0, 0, 0};
    if (d->snapshot->environment != NG_NONE) {
        struct ng_light_hit hit = {.distance = INFINITY};
        for (int k = 0; k < 3; k++)
            hit.direction[k] = tile->direction[k][lane];
        ng_light_seen_at(&d->snapshot->lights[d->snapshot->environment].source, &hit, sky);
    }
    for (int c = 0; c < 3; c++)
        sky[c] = lf_min(sky[c], NG_RADIANCE_MAX);
    put(texels->normal[lane], none, 0);
    put(texels->diffuse[lane], none, 0);
    put(texels->specular[lane], none, 0);
    put(p->position + 4 * at, none, 0);
    put(p->emission + 4 * at, sky, 0);
    p->motion[2 * at] = p->motion[2 * at + 1] = 0;
    p->entity[at] = 0;
}

// ---- Tiles -----------------------------------------------------------------------------------------------

// What is drawn already, along the ray of a lane; where is none, farther than anything.
static float drawn_distance(const struct drawing *d, const struct lf_tile *tile, int lane,
                            const uint32_t pixel[2])
{
    const float *position = d->job->picture.position + 4 * ((size_t)pixel[1] * d->view.width + pixel[0]);
    float along = 0;
    for (int k = 0; k < 3; k++)
        along += (position[k] - tile->origin[k][lane]) * tile->direction[k][lane];
    return position[3] > 0 || position[3] < 0 ? along : INFINITY;
}

// Whether a pixel of the tile is written.
static bool is_written(const struct drawing *d, const struct lf_tile *tile, int lane, const uint32_t pixel[2])
{
    if (pixel[0] >= d->end[0] || pixel[1] >= d->end[1])
        return false;
    return !d->lamps || (tile->met[lane] && tile->hits[lane].distance <=
                                                drawn_distance(d, tile, lane, pixel) * (1 + SAME_DISTANCE));
}

static void prefetch(const struct lf_tracer *tracer, const struct lf_tile *tile)
{
    for (int stage = 0; stage < 2; stage++)
        for (int i = 0; i < LF_PACKET; i++)
            if (tile->met[i])
                lf_surface_prefetch(tracer, &tile->hits[i], stage);
}

static void write_halfs(const struct drawing *d, const struct texels *texels, const bool written[LF_PACKET],
                        uint32_t x, uint32_t y)
{
    const struct lf_raycast_picture *p = &d->job->picture;
    const float *const from[] = {texels->normal[0], texels->diffuse[0], texels->specular[0]};
    uint16_t *const to[] = {p->normal, p->diffuse, p->specular};
    for (size_t k = 0; k < NG_COUNT(from); k++) {
        uint16_t halfs[4 * LF_PACKET];
        d->kernels->to_halfs(from[k], halfs);
        for (uint32_t i = 0; i < LF_PACKET; i++) {
            size_t at = (size_t)(y + i / LF_TILE) * p->width + x + i % LF_TILE;
            if (written[i])
                memcpy(to[k] + 4 * at, halfs + (size_t)4 * i, 4 * sizeof *halfs);
        }
    }
}

static void draw_tile(const struct drawing *d, uint32_t x, uint32_t y)
{
    struct lf_tile tile;
    struct texels texels = {0};
    bool written[LF_PACKET], any = false;
    lf_trace_tile(d->job->tracer, &d->view, x, y, d->lamps, &tile);
    prefetch(d->job->tracer, &tile);
    for (int i = 0; i < LF_PACKET; i++) {
        const uint32_t pixel[2] = {x + (uint32_t)i % LF_TILE, y + (uint32_t)i / LF_TILE};
        any |= written[i] = is_written(d, &tile, i, pixel);
        if (written[i] && tile.met[i])
            draw_surface(d, &tile, pixel, i, &texels);
        else if (written[i])
            draw_background(d, &tile, pixel, i, &texels);
    }
    if (any)
        write_halfs(d, &texels, written, x, y);
}

static void draw_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct drawing *d = user;
    for (uint32_t row = begin; row < end; row++)
        for (uint32_t x = d->first[0]; x < d->end[0]; x += LF_TILE)
            draw_tile(d, x, d->first[1] + row * LF_TILE);
}

// ---- The picture -----------------------------------------------------------------------------------------

static struct drawing begin(const struct lf_raycast_job *job, bool lamps)
{
    const struct lf_raycast_picture *p = &job->picture;
    struct drawing d = {.job = job,
                        .snapshot = lf_tracer_snapshot(job->tracer),
                        .kernels = lf_pack_kernels_of(0),
                        .end = {p->width, p->height},
                        .lamps = lamps};
    d.view = lf_view_of(&d.snapshot->camera, p->width, p->height);
    d.pixels[0] = 0.5f * (float)p->width / sqrtf(lf_dot(d.view.right, d.view.right));
    d.pixels[1] = 0.5f * (float)p->height / sqrtf(lf_dot(d.view.down, d.view.down));
    return d;
}

static void draw(struct drawing *d)
{
    if (d->first[0] < d->end[0] && d->first[1] < d->end[1])
        ng_jobs_for(d->job->jobs, (d->end[1] - d->first[1] + LF_TILE - 1) / LF_TILE, 1, draw_rows, d);
}

void lf_raycast_draw(const struct lf_raycast_job *job)
{
    struct drawing d = begin(job, false);
    draw(&d);
}

// The part of the picture, in pixels, in which corners of a box may be seen; all of it where some are behind.
static void add_box(const struct lf_view *v, const float low[3], const float high[3], float first[2],
                    float end[2])
{
    for (int corner = 0; corner < 8; corner++) {
        float way[3];
        for (int k = 0; k < 3; k++)
            way[k] = (corner >> k & 1 ? high[k] : low[k]) - v->position[k];
        float ahead = v->parallel ? 1 : lf_dot(way, v->forward);
        bool seen = ahead > 0;
        const float *axes[2] = {v->right, v->down};
        for (int k = 0; k < 2; k++) {
            float size = (float)(k ? v->height : v->width);
            float at = lf_dot(way, axes[k]) / (lf_dot(axes[k], axes[k]) * ahead);
            first[k] = seen ? lf_min(first[k], (at * 0.5f + 0.5f) * size - 1) : 0;
            end[k] = seen ? lf_max(end[k], (at * 0.5f + 0.5f) * size + 2) : size;
        }
        if (!seen)
            return;
    }
}

void lf_raycast_draw_lamps(const struct lf_raycast_job *job)
{
    struct drawing d = begin(job, true);
    float size[2] = {(float)d.view.width, (float)d.view.height}, first[2] = {size[0], size[1]},
          end[2] = {0, 0};
    for (uint32_t i = 0; i < d.snapshot->instance_count; i++) {
        const struct ng_snapshot_instance *in = &d.snapshot->instances[i];
        if (in->flags & NG_INSTANCE_LAMP)
            add_box(&d.view, in->bounds_min, in->bounds_max, first, end);
    }
    for (int k = 0; k < 2; k++) {
        d.first[k] = (uint32_t)lf_min(lf_max(first[k], 0), size[k]) / LF_TILE * LF_TILE;
        d.end[k] = (uint32_t)lf_min(lf_max(end[k], 0), size[k]);
    }
    draw(&d);
}

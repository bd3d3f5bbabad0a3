// Tile by tile: rays in packets, then what waits for memory, pixel by pixel, then the arithmetic of all
// pixels at once (finish.h).
#include "lightformer/raycast/picture.h"

#include "base/jobs.h"
#include "lightformer/raycast/finish.h"
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
    const struct lf_finish_kernels *kernels;
    struct lf_view view;
    float pixels[2];           // half the picture's, for each length of `right` and `down`
    uint32_t first[2], end[2]; // pixels that are drawn: x, y
    bool lamps;
};

// ---- A pixel ---------------------------------------------------------------------------------------------

static bool moves(const struct ng_snapshot *s, const struct ng_snapshot_instance *in)
{
    bool moved = s->meshes[in->mesh].dynamic;
    for (size_t i = 0; i < NG_COUNT(in->matrix); i++)
        moved |= in->matrix[i] != in->previous_matrix[i];
    return moved;
}

static void find_before(const struct drawing *d, const struct lf_hit *hit, int lane, struct lf_finish *out)
{
    float before[3] = {hit->position[0], hit->position[1], hit->position[2]};
    if (moves(d->snapshot, &d->snapshot->instances[hit->instance]))
        lf_surface_previous(d->job->tracer, hit, before);
    for (int k = 0; k < 3; k++)
        out->before[k][lane] = before[k];
}

static void find_surface(const struct drawing *d, const struct lf_hit *hit, struct lf_surface *out)
{
    const struct lf_tracer *tracer = d->job->tracer;
    struct lf_footprint footprint;
    float right[3], down[3];
    bool textured = lf_surface_is_textured(tracer, hit);
    if (textured) {
        lf_view_steps(&d->view, hit->position, hit->normal, right, down);
        lf_footprint_find(tracer, hit, right, down, &footprint);
    }
    lf_surface_unsettled(tracer, hit, textured ? &footprint : NULL, out);
}

static void put(float to[4], const float xyz[3], float w)
{
    to[0] = xyz[0];
    to[1] = xyz[1];
    to[2] = xyz[2];
    to[3] = w;
}

static void draw_surface(const struct drawing *d, const struct lf_hit *hit, size_t at, int lane,
                         struct lf_finish *out)
{
    const struct lf_raycast_picture *p = &d->job->picture;
    struct lf_surface s;
    find_surface(d, hit, &s);
    find_before(d, hit, lane, out);
    out->shown[lane] = 1;
    out->side[lane] = s.front ? 1 : -1;
    out->roughness[lane] = s.roughness;
    for (int k = 0; k < 3; k++) {
        out->normal[k][lane] = s.normal[k];
        out->flat[k][lane] = s.flat_normal[k];
        out->albedo[k][lane] = s.albedo[k];
        out->f0[k][lane] = s.f0[k];
        s.emission[k] = lf_min(s.emission[k], NG_RADIANCE_MAX);
    }
    put(p->position + 4 * at, s.position, s.unlit ? -1 : 1);
    put(p->emission + 4 * at, s.emission, d->lamps ? 1 : 0);
    p->entity[at] = ng_entity_index(d->snapshot->instances[hit->instance].entity);
}

// Where is no surface.
static void draw_background(const struct drawing *d, const struct lf_tile *tile, size_t at, int lane)
{
    static const float none[3];
    const struct lf_raycast_picture *p = &d->job->picture;
    float sky[3] = {0, 0, 0};
    if (d->snapshot->environment != NG_NONE) {
        struct ng_light_hit hit = {.distance = INFINITY};
        for (int k = 0; k < 3; k++)
            hit.direction[k] = tile->direction[k][lane];
        ng_light_seen_at(&d->snapshot->lights[d->snapshot->environment].source, &hit, sky);
    }
    for (int k = 0; k < 3; k++)
        sky[k] = lf_min(sky[k], NG_RADIANCE_MAX);
    put(p->position + 4 * at, none, 0);
    put(p->emission + 4 * at, sky, 0);
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

static struct lf_finish_view finish_view(const struct drawing *d, uint32_t x, uint32_t y)
{
    const struct lf_view *v = &d->view;
    struct lf_finish_view out = {.parallel = v->parallel,
                                 .pixels = {d->pixels[0], d->pixels[1]},
                                 .middle = {0.5f * (float)v->width * (1 - v->shift[0]) - ((float)x + 0.5f),
                                            0.5f * (float)v->height * (1 - v->shift[1]) - ((float)y + 0.5f)}};
    memcpy(out.previous, d->snapshot->camera.previous_view, sizeof out.previous);
    return out;
}

// The pixels of a tile.
struct place {
    size_t at[LF_PACKET];
    bool written[LF_PACKET], any, surfaces; // surfaces: all are written, and show one
};

static struct place find_place(const struct drawing *d, const struct lf_tile *tile, uint32_t x, uint32_t y)
{
    struct place place = {.surfaces = true};
    for (int i = 0; i < LF_PACKET; i++) {
        const uint32_t pixel[2] = {x + (uint32_t)i % LF_TILE, y + (uint32_t)i / LF_TILE};
        place.at[i] = (size_t)pixel[1] * d->view.width + pixel[0];
        place.written[i] = is_written(d, tile, i, pixel);
        place.any |= place.written[i];
        place.surfaces &= place.written[i] & tile->met[i];
    }
    return place;
}

static void store(const struct lf_raycast_picture *p, const struct place *place,
                  const struct lf_finished *done)
{
    for (int i = 0; i < LF_PACKET; i++) {
        size_t at = place->at[i];
        if (!place->written[i])
            continue;
        memcpy(p->normal + 4 * at, &done->normal[i], sizeof done->normal[i]);
        memcpy(p->diffuse + 4 * at, &done->diffuse[i], sizeof done->diffuse[i]);
        memcpy(p->specular + 4 * at, &done->specular[i], sizeof done->specular[i]);
        p->motion[2 * at] = done->motion[0][i];
        p->motion[2 * at + 1] = done->motion[1][i];
    }
}

static void draw_tile(const struct drawing *d, uint32_t x, uint32_t y)
{
    struct lf_tile tile;
    struct lf_finish surfaces;
    struct lf_finished done;
    lf_trace_tile(d->job->tracer, &d->view, x, y, d->lamps, &tile);
    const struct place place = find_place(d, &tile, x, y);
    if (!place.any)
        return;
    if (!place.surfaces) // seldom: zeroing is not for nothing
        memset(&surfaces, 0, sizeof surfaces);
    for (int i = 0; i < LF_PACKET; i++) {
        if (place.written[i] && tile.met[i])
            draw_surface(d, &tile.hits[i], place.at[i], i, &surfaces);
        else if (place.written[i])
            draw_background(d, &tile, place.at[i], i);
    }
    const struct lf_finish_view view = finish_view(d, x, y);
    d->kernels->finish(&surfaces, tile.direction, &view, &done);
    store(&d->job->picture, &place, &done);
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
                        .kernels = lf_finish_kernels_of(0),
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
            first[k] = seen ? lf_min(first[k], (at * 0.5f + 0.5f) * size - 2) : 0;
            end[k] = seen ? lf_max(end[k], (at * 0.5f + 0.5f) * size + 3) : size;
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

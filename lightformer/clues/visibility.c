// How much of the light a pixel sees: a ray to one of sixteen direct VPLs from each pixel, another one for
// each pixel of a block (interleaved sampling), weighed by what that VPL would bring; and where neighbours
// found different things, in penumbrae, a ray to another one, so that a block has 32. Rays of pixels with the
// same VPL run side by side.
#include "lightformer/clues/clues_internal.h"

#include <string.h>

#define SAMPLES (LF_INTERLEAVE * LF_INTERLEAVE)
#define ROUNDS  2                      // of rays
#define SIDE    4                      // rays of a packet each way
#define TILE    (SIDE * LF_INTERLEAVE) // pixels each way

struct search {
    const struct lf_clues_scene *scene;
    const struct lf_pixel_clues *pixels;
    const struct lf_light_clues *light;
    const struct lf_interleaved *rays;
};

static const struct ng_light_sample *vpl_of(const struct search *s, uint32_t sample, uint32_t round)
{
    return &s->light->vpls.items[(lf_interleave_order[sample] + round * SAMPLES) % s->light->vpl_count];
}

// TILE x TILE pixels, and which of them ask.
struct tile {
    uint32_t x, y;
    bool asks[TILE * TILE];
};

static bool is_in_doubt(const struct search *s, uint32_t x, uint32_t y)
{
    return lf_interleaved_found(s->pixels, s->rays, x, y) == (LF_FOUND_LIT | LF_FOUND_HIDDEN);
}

// In the first round all pixels ask, later those where steps would show. False if none does.
static bool find_asking(const struct search *s, uint32_t x, uint32_t y, uint32_t round, struct tile *out)
{
    const struct lf_pixel_clues *p = s->pixels;
    bool any = false;
    out->x = x;
    out->y = y;
    for (uint32_t i = 0; i < TILE * TILE; i++) {
        uint32_t column = x + i % TILE, row = y + i / TILE;
        bool inside = column < p->width && row < p->height && p->mask[(size_t)row * p->width + column] > 0;
        out->asks[i] = inside && (!round || is_in_doubt(s, column, row));
        any = any || out->asks[i];
    }
    return any;
}

// To the mean of a pixel's rays so far.
static void add_answer(const struct search *s, size_t pixel, float weight, bool lit)
{
    float before = s->rays->part[pixel] * s->rays->weight[pixel];
    s->rays->weight[pixel] += weight;
    s->rays->part[pixel] = (before + (lit ? weight : 0)) / s->rays->weight[pixel];
}

// The pixels of a tile that sample the same VPL, by lane; others are nowhere.
struct questions {
    size_t pixels[LF_PACKET];
    bool asks[LF_PACKET];
    struct lf_shading_points points;
};

static bool find_questions(const struct search *s, const struct tile *tile, uint32_t sample,
                           struct questions *out)
{
    const struct lf_pixel_clues *p = s->pixels;
    bool any = false;
    for (uint32_t i = 0; i < LF_PACKET; i++) {
        uint32_t x = i % SIDE * LF_INTERLEAVE + sample % LF_INTERLEAVE,
                 y = i / SIDE * LF_INTERLEAVE + sample / LF_INTERLEAVE;
        bool asks = out->asks[i] = tile->asks[y * TILE + x];
        size_t pixel = out->pixels[i] = asks ? (size_t)(tile->y + y) * p->width + tile->x + x : 0;
        for (int c = 0; c < 3; c++) {
            out->points.position[c][i] = asks ? p->position[c][pixel] : 0;
            out->points.normal[c][i] = asks ? p->normal[c][pixel] : 0;
            out->points.flat[c][i] = asks ? p->flat[c][pixel] : 0;
        }
        any = any || asks;
    }
    return any;
}

// As the kernels take it.
static struct lf_light_sample sample_of(const struct search *s, const struct ng_light_sample *vpl)
{
    struct lf_light_sample out = {.density = 0};
    if (!s->light->unit.type->infinite)
        lf_to_scene(&s->pixels->space, vpl->position, out.position);
    memcpy(out.normal, vpl->normal, sizeof out.normal);
    for (int c = 0; c < 3 && vpl->pdf > 0; c++)
        out.weight[c] = vpl->radiance[c] / vpl->pdf;
    return out;
}

// From where the light comes, so that rays have one origin; or, if that is infinitely far, one direction.
static void set_ray(const struct search *s, const struct questions *q, const struct ng_light_sample *vpl,
                    const struct lf_aim *aim, uint32_t lane, struct lf_packet *packet)
{
    const struct lf_space *space = &s->pixels->space;
    bool infinite = s->light->unit.type->infinite;
    float direction[3], origin[3];
    for (int c = 0; c < 3; c++)
        direction[c] = aim->direction[c][lane];
    float skin = lf_skin_along(s->light, vpl, direction);
    if (infinite) {
        float at[3], flat[3], position[3];
        for (int c = 0; c < 3; c++) {
            at[c] = q->points.position[c][lane];
            flat[c] = q->points.flat[c][lane];
        }
        lf_to_world(space, at, position);
        lf_trace_origin(s->scene->tracer, position, flat, direction, origin);
    } else {
        lf_mad(vpl->position, direction, -skin, origin);
    }
    for (int c = 0; c < 3; c++) {
        packet->origin[c][lane] = origin[c];
        packet->direction[c][lane] = infinite ? direction[c] : -direction[c];
    }
    packet->far[lane] = infinite ? INFINITY : aim->distance[lane] * space->radius * LF_SHADOW_RAY_PART - skin;
}

static void trace_sample(const struct search *s, const struct tile *tile, uint32_t sample, uint32_t round)
{
    const struct ng_light_sample *vpl = vpl_of(s, sample, round);
    const struct lf_light_sample source = sample_of(s, vpl);
    struct questions q;
    struct lf_aim aim;
    struct lf_packet packet = {.passes = s->light->light};
    bool any = false;
    if (!find_questions(s, tile, sample, &q))
        return;
    lf_kernels_of(0)->arrive(&source, s->light->unit.type->infinite, &q.points, &aim);
    for (uint32_t i = 0; i < LF_PACKET; i++) {
        q.asks[i] = q.asks[i] && aim.weight[i] > 0 && isfinite(aim.weight[i]); // the VPL brings something
        if (q.asks[i])
            set_ray(s, &q, vpl, &aim, i, &packet);
        any = any || q.asks[i];
    }
    if (!any)
        return;
    lf_count_packet(s->scene, &packet);
    lf_trace_packet_occluded(s->scene->tracer, &packet);
    for (uint32_t i = 0; i < LF_PACKET; i++)
        if (q.asks[i])
            add_answer(s, q.pixels[i], aim.weight[i], !packet.met[i]);
}

static void trace_tile(const struct search *s, const struct tile *tile, uint32_t round)
{
    for (uint32_t sample = 0; sample < SAMPLES; sample++)
        trace_sample(s, tile, sample, round);
}

static void trace_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct search *s = user;
    const struct lf_pixel_clues *p = s->pixels;
    size_t first = (size_t)begin * TILE * p->width, last = (size_t)end * TILE * p->width;
    last = last < (size_t)p->height * p->width ? last : (size_t)p->height * p->width;
    memset(s->rays->part + first, 0, (last - first) * sizeof(float));
    memset(s->rays->weight + first, 0, (last - first) * sizeof(float));
    struct tile tile;
    for (uint32_t row = begin; row < end; row++)
        for (uint32_t x = 0; x < p->width; x += TILE)
            if (find_asking(s, x, row * TILE, 0, &tile))
                trace_tile(s, &tile, 0);
}

// A pixel that asked more often counts no more among its neighbours.
static void even_out(const struct search *s, const struct tile *tile)
{
    for (uint32_t i = 0; i < TILE * TILE; i++)
        if (tile->asks[i])
            s->rays->weight[(size_t)(tile->y + i / TILE) * s->pixels->width + tile->x + i % TILE] /= ROUNDS;
}

static void refine_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct search *s = user;
    struct tile tile;
    for (uint32_t row = begin; row < end; row++)
        for (uint32_t x = 0; x < s->pixels->width; x += TILE) {
            if (!find_asking(s, x, row * TILE, 1, &tile))
                continue;
            for (uint32_t round = 1; round < ROUNDS; round++)
                trace_tile(s, &tile, round);
            even_out(s, &tile);
        }
}

void lf_visibility_find(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                        const struct lf_light_clues *light, float *const shadow[5],
                        const struct lf_interleaved *rays, float *visibility)
{
    struct search s = {scene, pixels, light, rays};
    size_t count = (size_t)pixels->width * pixels->height;
    if (light->unit.type->delta) { // is seen from one sample, or one direction
        for (size_t i = 0; i < count; i++)
            visibility[i] = pixels->mask[i] > 0 && !(shadow[4][i] < shadow[3][i]) ? 1 : 0;
        return;
    }
    uint32_t rows = (pixels->height + TILE - 1) / TILE;
    ng_jobs_for(scene->jobs, rows, 1, trace_rows, &s);
    lf_interleaved_collect(scene, pixels, rays);
    ng_jobs_for(scene->jobs, rows, 1, refine_rows, &s);
    lf_interleaved_filter(scene, pixels, rays, false, visibility);
}

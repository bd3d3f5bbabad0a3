// How much of the light a pixel sees: a ray to one of sixteen direct VPLs, another one for each pixel of a
// block (interleaved sampling), weighed by what that VPL would bring. Of one or two lights all pixels ask;
// where neighbours found different things, in penumbrae, they do once more, other VPLs, so that a block
// has 32. Of more lights a quarter asks, and those at edges. There few neighbours are alike, so pixels in
// doubt ask more, and listen to themselves first. Rays of pixels with the same VPL run side by side.
#include "lightformer/clues/clues_internal.h"

#include <string.h>

#define SAMPLES ((uint32_t)(LF_INTERLEAVE * LF_INTERLEAVE))
#define ROWS    16  // of pixels, a job
#define COLUMNS 256 // of pixels whose questions are collected

struct search {
    const struct lf_clues_scene *scene;
    const struct lf_pixel_clues *pixels;
    const struct lf_light_clues *light;
    const struct lf_interleaved *rays;
    enum lf_questions questions;
};

enum round { FIRST, OTHERS, AGAIN, AT_EDGES, ROUNDS = AT_EDGES + LF_EDGE_RAYS };

static bool is_at_edge(const struct search *s, uint32_t x, uint32_t y)
{
    return s->pixels->relief.items[(size_t)y * s->pixels->width + x] & LF_EDGE;
}

static bool is_in_doubt(const struct search *s, uint32_t x, uint32_t y)
{
    return lf_interleaved_found(s->pixels, s->rays, x, y) == (LF_FOUND_LIT | LF_FOUND_HIDDEN);
}

// After the first round those ask where steps would show.
static bool asks(const struct search *s, uint32_t x, uint32_t y, uint32_t round)
{
    const struct lf_pixel_clues *p = s->pixels;
    if (!(p->mask[(size_t)y * p->width + x] > 0))
        return false;
    if (round == FIRST)
        return s->questions == LF_ASK_ALL || lf_interleaved_asks_first(p, x, y);
    bool again =
        round >= AT_EDGES ? is_at_edge(s, x, y) : round == AGAIN || !lf_interleaved_asks_first(p, x, y);
    return again && is_in_doubt(s, x, y);
}

// Pixels that sample the same VPL.
struct questions {
    size_t pixels[ROWS * COLUMNS / (LF_INTERLEAVE * LF_INTERLEAVE)];
    uint32_t count;
};

static void collect(const struct search *s, uint32_t x, uint32_t y, uint32_t round,
                    struct questions of_samples[])
{
    const struct lf_pixel_clues *p = s->pixels;
    uint32_t right = p->width - x < COLUMNS ? p->width : x + COLUMNS,
             below = p->height - y < ROWS ? p->height : y + ROWS;
    for (uint32_t sample = 0; sample < SAMPLES; sample++)
        of_samples[sample].count = 0;
    for (uint32_t row = y; row < below; row++)
        for (uint32_t column = x; column < right; column++)
            if (asks(s, column, row, round)) {
                struct questions *q = &of_samples[lf_interleave_index(column, row)];
                q->pixels[q->count++] = (size_t)row * p->width + column;
            }
}

// Once more, another sixteen; at edges those of the first that lie in other quarters of the light.
static const struct ng_light_sample *vpl_of(const struct search *s, uint32_t sample, uint32_t round)
{
    uint32_t index = lf_interleave_order[sample];
    if (round == AGAIN)
        index += SAMPLES;
    else if (round >= AT_EDGES)
        index ^= round - AT_EDGES + 1;
    return &s->light->vpls.items[index % s->light->vpl_count];
}

// Rays that a pixel has cast before a round.
static float count_before(uint32_t round)
{
    return round < AGAIN ? 0 : (float)(1 + round - AGAIN);
}

// To the mean of a pixel's rays so far. A pixel that asked more than once counts no more among its
// neighbours.
static void add_answer(const struct search *s, size_t pixel, float weight, bool lit, uint32_t round)
{
    float *mean = &s->rays->weight[pixel], *part = &s->rays->part[pixel];
    float count = count_before(round), before = count * *mean, all = before + weight;
    *part = (*part * before + (lit ? weight : 0)) / all;
    *mean = before > 0 ? all / (count + 1) : all;
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
static void set_ray(const struct search *s, const struct lf_shading_points *points,
                    const struct ng_light_sample *vpl, const struct lf_aim *aim, uint32_t lane,
                    struct lf_packet *packet)
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
            at[c] = points->position[c][lane];
            flat[c] = points->flat[c][lane];
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

static void set_points(const struct lf_pixel_clues *p, const size_t *pixels, uint32_t count,
                       struct lf_shading_points *out)
{
    for (int c = 0; c < 3; c++)
        for (uint32_t i = 0; i < LF_PACKET; i++) {
            size_t pixel = pixels[i < count ? i : 0];
            out->position[c][i] = p->position[c][pixel];
            out->normal[c][i] = p->normal[c][pixel];
            out->flat[c][i] = p->flat[c][pixel];
        }
}

static void ask(const struct search *s, const size_t *pixels, uint32_t count,
                const struct ng_light_sample *vpl, uint32_t round)
{
    const struct lf_light_sample source = sample_of(s, vpl);
    struct lf_shading_points points;
    struct lf_aim aim;
    struct lf_packet packet = {.passes = s->light->light};
    bool asked[LF_PACKET] = {false}, any = false;
    set_points(s->pixels, pixels, count, &points);
    lf_kernels_of(0)->arrive(&source, s->light->unit.type->infinite, &points, &aim);
    for (uint32_t i = 0; i < count; i++) {
        asked[i] = aim.weight[i] > 0 && isfinite(aim.weight[i]); // the VPL brings something
        if (asked[i])
            set_ray(s, &points, vpl, &aim, i, &packet);
        any = any || asked[i];
    }
    if (!any)
        return;
    lf_count_packet(s->scene, &packet);
    lf_trace_packet_occluded(s->scene->tracer, &packet);
    for (uint32_t i = 0; i < count; i++)
        if (asked[i])
            add_answer(s, pixels[i], aim.weight[i], !packet.met[i], round);
}

static void ask_rows(const struct search *s, uint32_t y, uint32_t round)
{
    struct questions of_samples[SAMPLES];
    for (uint32_t x = 0; x < s->pixels->width; x += COLUMNS) {
        collect(s, x, y, round, of_samples);
        for (uint32_t sample = 0; sample < SAMPLES; sample++) {
            const struct questions *q = &of_samples[sample];
            for (uint32_t i = 0; i < q->count; i += LF_PACKET)
                ask(s, q->pixels + i, q->count - i < LF_PACKET ? q->count - i : LF_PACKET,
                    vpl_of(s, sample, round), round);
        }
    }
}

static void ask_first(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct search *s = user;
    const struct lf_pixel_clues *p = s->pixels;
    size_t first = (size_t)begin * ROWS * p->width, last = (size_t)end * ROWS * p->width;
    last = last < (size_t)p->height * p->width ? last : (size_t)p->height * p->width;
    memset(s->rays->part + first, 0, (last - first) * sizeof(float));
    memset(s->rays->weight + first, 0, (last - first) * sizeof(float));
    for (uint32_t row = begin; row < end; row++)
        ask_rows(s, row * ROWS, FIRST);
}

static void ask_in_doubt(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct search *s = user;
    bool all = s->questions == LF_ASK_ALL;
    uint32_t last = all && !s->light->unit.type->infinite ? ROUNDS : AT_EDGES;
    for (uint32_t row = begin; row < end; row++)
        for (uint32_t round = all ? AGAIN : OTHERS; round < (all ? last : AGAIN); round++)
            ask_rows(s, row * ROWS, round);
}

void lf_visibility_find(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                        const struct lf_light_clues *light, float *const shadow[5],
                        const struct lf_interleaved *rays, float *visibility)
{
    struct search s = {scene, pixels, light, rays,
                       lf_questions_of(lf_tracer_snapshot(scene->tracer)->light_count)};
    size_t count = (size_t)pixels->width * pixels->height;
    if (light->unit.type->delta) { // is seen from one sample, or one direction
        for (size_t i = 0; i < count; i++)
            visibility[i] = pixels->mask[i] > 0 && !(shadow[4][i] < shadow[3][i]) ? 1 : 0;
        return;
    }
    uint32_t rows = (pixels->height + ROWS - 1) / ROWS;
    ng_jobs_for(scene->jobs, rows, 1, ask_first, &s);
    if (s.questions != LF_ASK_FEW) {
        lf_interleaved_collect(scene, pixels, rays);
        ng_jobs_for(scene->jobs, rows, 1, ask_in_doubt, &s);
    }
    lf_interleaved_filter(scene, pixels, rays, false, visibility);
    if (!light->unit.type->infinite)
        lf_interleaved_own_at_edges(scene, pixels, rays,
                                    s.questions == LF_ASK_ALL ? LF_OWN_PART : LF_OWN_PART_ONCE, visibility);
}

// Whether highlights are in shadow. How much of a light a pixel sees (visibility.c) is one thing; a
// highlight of a smooth surface shows one small part of the light, and where that part is hidden the
// highlight is gone, however bright it would have been. So where glossy light counts, rays go to the parts of
// the light that directions of the BRDF come nearest to: a quarter of sixteen, another one in each of four
// neighbours; and where neighbours found different things, which are few, all sixteen. Of many lights a
// quarter of the pixels asks first, and in doubt all ask a quarter. In doubt at edges pixels ask all
// quarters, and listen to themselves first.
#include "lightformer/clues/clues_internal.h"

#include <string.h>

#define ROWS         4 // of pixels, a job
#define QUARTERS     4 // of the directions
#define RAYS         (LF_BRDF_SAMPLES / QUARTERS)
#define LEAST_GLOSSY 0.01f // in units of the radiance that the light's power spread evenly would have

struct search {
    const struct lf_clues_scene *scene;
    const struct lf_pixel_clues *pixels;
    const struct lf_light_clues *light;
    float *const *glossy;
    const float *visibility;
    const struct lf_interleaved *rays;
    float *out;
    enum lf_questions questions;
};

static bool asks_first(const struct search *s, uint32_t x, uint32_t y)
{
    return s->questions == LF_ASK_ALL || lf_interleaved_asks_first(s->pixels, x, y);
}

static uint32_t quarter_of(uint32_t x, uint32_t y)
{
    return lf_interleave_order[lf_interleave_index(x, y)] / (LF_INTERLEAVE * LF_INTERLEAVE / QUARTERS);
}

// Rays of several pixels, answered together.
_Static_assert(LF_LANES == LF_PACKET, "a ray a lane");
struct asking {
    const struct search *search;
    struct lf_shading_points points;
    float u[3][LF_LANES];
    size_t pixels[LF_LANES];
    uint32_t count;
};

static void set_ray(const struct search *s, const struct lf_shading_points *points, const struct lf_aim *aim,
                    uint32_t lane, struct lf_packet *packet)
{
    float at[3], flat[3], direction[3], position[3], origin[3];
    for (int c = 0; c < 3; c++) {
        at[c] = points->position[c][lane];
        flat[c] = points->flat[c][lane];
        direction[c] = aim->direction[c][lane];
    }
    lf_to_world(&s->pixels->space, at, position);
    lf_trace_origin(s->scene->tracer, position, flat, direction, origin);
    for (int c = 0; c < 3; c++) {
        packet->origin[c][lane] = origin[c];
        packet->direction[c][lane] = direction[c];
    }
    packet->far[lane] = aim->distance[lane] * s->pixels->space.radius * LF_LIGHT_RAY_PART;
}

// Adds to the weights of the pixels, and what is lit of them to their parts.
static void answer(struct asking *a)
{
    const struct search *s = a->search;
    struct lf_packet packet = {.passes = s->light->light};
    struct lf_aim aim;
    bool any = false;
    if (!a->count)
        return;
    lf_kernels_of(0)->aim(&s->light->emitter, &a->points, a->u, &aim);
    for (uint32_t i = 0; i < a->count; i++) {
        if (!(aim.weight[i] > 0))
            continue;
        set_ray(s, &a->points, &aim, i, &packet);
        any = true;
    }
    if (any) {
        lf_count_packet(s->scene, &packet);
        lf_trace_packet_occluded(s->scene->tracer, &packet);
    }
    for (uint32_t i = 0; i < a->count; i++) {
        if (!(aim.weight[i] > 0))
            continue;
        s->rays->weight[a->pixels[i]] += aim.weight[i];
        s->rays->part[a->pixels[i]] += packet.met[i] ? 0 : aim.weight[i];
    }
    a->count = 0;
}

// Every fourth direction, from the lobe's middle outward.
static void ask_quarter(struct asking *a, size_t pixel, uint32_t quarter)
{
    for (uint32_t k = 0; k < RAYS; k++) {
        const float *u = lf_brdf_samples[k * QUARTERS + quarter];
        lf_shading_points_set_pixel(a->search->pixels, pixel, (int)a->count, &a->points);
        for (int c = 0; c < 3; c++)
            a->u[c][a->count] = u[c];
        a->pixels[a->count++] = pixel;
        if (a->count == LF_LANES)
            answer(a);
    }
}

static bool counts(const struct search *s, size_t pixel)
{
    const struct lf_pixel_clues *p = s->pixels;
    float glossy = (s->glossy[0][pixel] + s->glossy[1][pixel] + s->glossy[2][pixel]) / 3;
    return p->roughness[pixel] < LF_SMOOTH && glossy > LEAST_GLOSSY && !s->light->unit.type->delta &&
           s->visibility[pixel] > 0; // or no part of the light is seen from around here
}

// Four pixels have all of the directions.
static void find_row(const struct search *s, uint32_t y)
{
    size_t first = (size_t)y * s->pixels->width;
    struct asking asking = {.search = s};
    for (uint32_t x = 0; x < s->pixels->width; x++) {
        s->rays->part[first + x] = s->rays->weight[first + x] = 0;
        if (counts(s, first + x) && asks_first(s, x, y))
            ask_quarter(&asking, first + x, quarter_of(x, y));
    }
    answer(&asking);
    for (size_t i = first; i < first + s->pixels->width; i++)
        if (s->rays->weight[i] > 0)
            s->rays->part[i] /= s->rays->weight[i];
}

static void find_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    for (uint32_t y = begin; y < end; y++)
        find_row(user, y);
}

static bool is_doubtful(const struct search *s, uint32_t x, uint32_t y)
{
    return lf_interleaved_found(s->pixels, s->rays, x, y) == (LF_FOUND_LIT | LF_FOUND_HIDDEN) &&
           counts(s, (size_t)y * s->pixels->width + x);
}

// Of what is all around one direction says little of another, and at edges one pixel of another.
static bool asks_all(const struct search *s, size_t pixel)
{
    return s->light->unit.type->infinite ||
           (s->questions == LF_ASK_ALL && s->pixels->relief.items[pixel] & LF_EDGE);
}

// In doubt a pixel that has not asked does.
static void ask_more(const struct search *s, struct asking *asking, uint32_t x, uint32_t y)
{
    size_t pixel = (size_t)y * s->pixels->width + x;
    bool asked = asks_first(s, x, y), all = asks_all(s, pixel);
    for (uint32_t quarter = 0; quarter < QUARTERS; quarter++) {
        bool own = quarter == quarter_of(x, y);
        if (own ? !asked : all)
            ask_quarter(asking, pixel, quarter);
    }
}

static void refine_row(const struct search *s, uint32_t y)
{
    size_t first = (size_t)y * s->pixels->width;
    float *part = s->rays->part + first, *weight = s->rays->weight + first;
    struct asking asking = {.search = s};
    for (uint32_t x = 0; x < s->pixels->width; x++)
        if (is_doubtful(s, x, y)) {
            part[x] *= weight[x];
            ask_more(s, &asking, x, y);
        }
    answer(&asking);
    for (uint32_t x = 0; x < s->pixels->width; x++)
        if (weight[x] > 0 && is_doubtful(s, x, y)) {
            part[x] /= weight[x];
            weight[x] /= asks_all(s, first + x) ? QUARTERS : 1; // counts no more among its neighbours
        }
}

static void refine_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    for (uint32_t y = begin; y < end; y++)
        refine_row(user, y);
}

// Who did not ask takes what those around found, alike or not: at the rim of a doubt.
static float mean_around(const struct search *s, uint32_t x, uint32_t y)
{
    const struct lf_pixel_clues *p = s->pixels;
    const uint32_t half = LF_INTERLEAVE_HALF;
    float sum = 0, all = 0;
    for (uint32_t row = y > half ? y - half : 0; row < p->height && row <= y + half; row++)
        for (uint32_t column = x > half ? x - half : 0; column < p->width && column <= x + half; column++) {
            size_t other = (size_t)row * p->width + column;
            sum += s->rays->weight[other] * s->rays->part[other];
            all += s->rays->weight[other];
        }
    return all > 0 ? sum / all : s->visibility[(size_t)y * p->width + x];
}

// Elsewhere, and where no direction came near the light, the visibility of the whole light stands in.
static void fill_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct search *s = user;
    for (uint32_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < s->pixels->width; x++) {
            size_t i = (size_t)y * s->pixels->width + x;
            if (s->rays->weight[i] > 0)
                continue;
            unsigned found = counts(s, i) ? lf_interleaved_found(s->pixels, s->rays, x, y) : 0;
            if (!found)
                s->out[i] = s->visibility[i];
            else if (found == (LF_FOUND_LIT | LF_FOUND_HIDDEN))
                s->out[i] = mean_around(s, x, y);
        }
}

void lf_specular_visibility_find(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                                 const struct lf_light_clues *light, float *const glossy[3],
                                 const float *visibility, const struct lf_interleaved *rays, float *out)
{
    struct search s = {
        scene,      pixels, light, glossy,
        visibility, rays,   out,   lf_questions_of(lf_tracer_snapshot(scene->tracer)->light_count)};
    ng_jobs_for(scene->jobs, pixels->height, ROWS, find_rows, &s);
    lf_interleaved_collect(scene, pixels, rays);
    if (s.questions != LF_ASK_FEW)
        ng_jobs_for(scene->jobs, pixels->height, ROWS, refine_rows, &s);
    lf_interleaved_filter(scene, pixels, rays, true, out);
    if (!light->unit.type->infinite)
        lf_interleaved_own_at_edges(scene, pixels, rays,
                                    s.questions == LF_ASK_ALL ? LF_OWN_PART : LF_OWN_PART_ONCE, out);
    ng_jobs_for(scene->jobs, pixels->height, ROWS, fill_rows, &s);
}

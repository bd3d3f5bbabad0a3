// Whether highlights are in shadow. How much of a light reaches a pixel (reach.c) is one thing; a highlight
// of a smooth surface shows one small part of the light, and where that part is hidden the highlight is gone,
// however bright it would have been. So where glossy light counts, rays go to the parts of the light that
// directions of the BRDF come nearest to: a quarter of sixteen, another one in each of four neighbours; and
// where neighbours found different things, which are few, all sixteen.
#include "lightformer/encode/clues_internal.h"

#include <string.h>

#define ROWS         4 // of pixels, a job
#define QUARTERS     4 // of the directions
#define RAYS         (LF_LOBE_SAMPLES / QUARTERS)
#define INSIDE       0.98f // of an emitter's extent
#define LEAST_GLOSSY 0.01f // in units of the radiance that the light's power spread evenly would have

struct search {
    const struct lf_encode_scene *scene;
    const struct lf_pixel_clues *pixels;
    const struct lf_light_clues *light;
    float *const *glossy;
    const float *reached;
    const struct lf_block_rays *rays;
    float *out;
};

// A pixel as numbers; lengths as in the planes.
struct place {
    float position[3];
    struct lf_lobe lobe;
};

static void read_place(const struct lf_pixel_clues *p, size_t pixel, struct place *out)
{
    lf_pixel_position(p, pixel, out->position);
    lf_pixel_lobe(p, pixel, &out->lobe);
}

// The point of a flat emitter that a direction comes nearest to: where it meets the plane, drawn in to the
// edge.
static void nearest_of_plane(const struct lf_light_shape *s, const struct place *at, const float direction[3],
                             float out[3])
{
    float way[3], met[3], cosine = -lf_dot(direction, s->normal);
    lf_mad(s->center, at->position, -1, way);
    float t = -lf_dot(way, s->normal) / fmaxf(cosine, 1e-3f);
    lf_mad(at->position, direction, t > 0 ? t : 0, met);
    lf_mad(met, s->center, -1, way);
    float a = lf_dot(way, s->u), b = lf_dot(way, s->v);
    float extent = s->emitter == LF_EMITTER_DISK ? sqrtf(a * a + b * b) : fmaxf(fabsf(a), fabsf(b));
    float part = extent > INSIDE ? INSIDE / extent : 1; // toward the centre
    lf_mad(way, s->normal, -lf_dot(way, s->normal), way);
    lf_mad(s->center, way, part, out);
}

static void nearest_of_sphere(const struct lf_light_shape *s, const struct place *at,
                              const float direction[3], float out[3])
{
    float way[3], side[3];
    lf_mad(s->center, at->position, -1, way);
    lf_mad(at->position, direction, fmaxf(lf_dot(way, direction), 0), side);
    lf_mad(side, s->center, -1, side);
    float distance = sqrtf(lf_dot(side, side)), part = INSIDE * s->radius / fmaxf(distance, 1e-12f);
    lf_mad(s->center, side, part < 1 ? part : 1, out); // on the disk that is seen
}

// Among samples, the one whose direction is nearest.
static void nearest_of_samples(const struct lf_light_shape *s, const struct place *at,
                               const float direction[3], float out[3])
{
    float best = -2;
    for (uint32_t i = 0; i < s->sample_count; i++) {
        const struct lf_light_sample *l = &s->samples[i];
        float way[3];
        lf_mad(l->position, at->position, -1, way);
        if (s->emitter == LF_EMITTER_DIRECTION)
            lf_scale(l->normal, -1, way);
        if (!lf_normalize(way) || (s->emitter == LF_EMITTER_SURFACE && lf_dot(way, l->normal) >= 0))
            continue;
        float cosine = lf_dot(way, direction);
        if (cosine > best) {
            best = cosine;
            lf_mad(at->position, way, s->emitter == LF_EMITTER_DIRECTION ? 4 : 0, out);
            if (s->emitter != LF_EMITTER_DIRECTION)
                memcpy(out, l->position, sizeof l->position);
        }
    }
}

static void nearest(const struct lf_light_shape *s, const struct place *at, const float direction[3],
                    float out[3])
{
    memcpy(out, s->center, sizeof s->center);
    if (s->emitter == LF_EMITTER_SPHERE)
        nearest_of_sphere(s, at, direction, out);
    else if (s->emitter == LF_EMITTER_RECTANGLE || s->emitter == LF_EMITTER_DISK)
        nearest_of_plane(s, at, direction, out);
    else
        nearest_of_samples(s, at, direction, out);
}

static uint32_t quarter_of(uint32_t x, uint32_t y)
{
    return lf_block_order[lf_block_place(x, y)] / (LF_BLOCK * LF_BLOCK / QUARTERS);
}

// What the BRDF makes of light from a unit direction; 0 from below the surface.
static float weight_of(const struct place *at, const float direction[3])
{
    const struct lf_lobe *lobe = &at->lobe;
    float half[3], nl = lf_dot(lobe->normal, direction);
    lf_mad(direction, lobe->view, 1, half);
    if (!(nl > 0) || !(lf_dot(lobe->flat, direction) > 0) || !lf_normalize(half))
        return 0;
    float nh = ng_clamp(lf_dot(lobe->normal, half), 0.0f, 1.0f);
    return ng_brdf_lobe(nl, lf_lobe_cosine(lobe), nh, lobe->roughness) * nl;
}

static bool is_lit(const struct search *s, const struct place *at, const float direction[3], float distance)
{
    struct lf_ray ray = {.near = 0, .far = distance * s->pixels->space.radius * LF_SHADOW_REACH};
    float position[3];
    memcpy(ray.direction, direction, sizeof ray.direction);
    lf_to_world(&s->pixels->space, at->position, position);
    lf_trace_origin(s->scene->tracer, position, at->lobe.flat, direction, ray.origin);
    return !lf_trace_occluded(s->scene->tracer, &ray);
}

// Of a pixel's directions, weighed: how many, and how many of them are lit.
struct share {
    float lit, sum;
};

// Every fourth direction, from the lobe's middle outward.
static void add_quarter(const struct search *s, const struct place *at, uint32_t quarter, struct share *share)
{
    for (uint32_t k = 0; k < RAYS; k++) {
        float direction[3], target[3];
        lf_lobe_direction(&at->lobe, lf_lobe_samples[k * QUARTERS + quarter], direction);
        nearest(&s->light->shape, at, direction, target);
        lf_mad(target, at->position, -1, direction);
        float distance = sqrtf(lf_dot(direction, direction));
        float weight = lf_normalize(direction) ? weight_of(at, direction) : 0;
        share->sum += weight;
        share->lit += weight > 0 && is_lit(s, at, direction, distance) ? weight : 0;
    }
}

static void set_share(const struct search *s, size_t pixel, const struct share *share, uint32_t quarters)
{
    s->rays->part[pixel] = share->sum > 0 ? share->lit / share->sum : 0;
    s->rays->weight[pixel] = share->sum / (float)quarters;
}

// Four pixels have all of the directions.
static void find_pixel(const struct search *s, uint32_t x, uint32_t y)
{
    size_t pixel = (size_t)y * s->pixels->width + x;
    struct place at;
    struct share share = {0};
    read_place(s->pixels, pixel, &at);
    add_quarter(s, &at, quarter_of(x, y), &share);
    set_share(s, pixel, &share, 1);
}

static void refine_pixel(const struct search *s, uint32_t x, uint32_t y)
{
    size_t pixel = (size_t)y * s->pixels->width + x;
    struct place at;
    struct share share = {.sum = s->rays->weight[pixel]};
    share.lit = share.sum * s->rays->part[pixel];
    read_place(s->pixels, pixel, &at);
    for (uint32_t quarter = 0; quarter < QUARTERS; quarter++)
        if (quarter != quarter_of(x, y))
            add_quarter(s, &at, quarter, &share);
    set_share(s, pixel, &share, QUARTERS);
}

static bool counts(const struct search *s, size_t pixel)
{
    const struct lf_pixel_clues *p = s->pixels;
    float glossy = (s->glossy[0][pixel] + s->glossy[1][pixel] + s->glossy[2][pixel]) / 3;
    return p->roughness[pixel] < LF_SMOOTH && glossy > LEAST_GLOSSY && !s->light->unit.type->delta;
}

static void find_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct search *s = user;
    for (uint32_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < s->pixels->width; x++) {
            size_t i = (size_t)y * s->pixels->width + x;
            s->rays->part[i] = s->rays->weight[i] = 0;
            if (counts(s, i))
                find_pixel(s, x, y);
        }
}

static void refine_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct search *s = user;
    for (uint32_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < s->pixels->width; x++) {
            bool asked = s->rays->weight[(size_t)y * s->pixels->width + x] > 0;
            if (asked && lf_block_opinions(s->pixels, s->rays, x, y) == (LF_BLOCK_LIT | LF_BLOCK_HIDDEN))
                refine_pixel(s, x, y);
        }
}

// Elsewhere, and where no direction came near the light, what reaches the pixel is all the same.
static void fill_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct search *s = user;
    for (size_t i = (size_t)begin * s->pixels->width; i < (size_t)end * s->pixels->width; i++)
        if (!(s->rays->weight[i] > 0))
            s->out[i] = s->reached[i];
}

void lf_highlights_find(const struct lf_encode_scene *scene, const struct lf_pixel_clues *pixels,
                        const struct lf_light_clues *light, float *const glossy[3], const float *reached,
                        const struct lf_block_rays *rays, float *out)
{
    struct search s = {scene, pixels, light, glossy, reached, rays, out};
    ng_jobs_for(scene->jobs, pixels->height, ROWS, find_rows, &s);
    lf_block_ask(scene, pixels, rays);
    ng_jobs_for(scene->jobs, pixels->height, ROWS, refine_rows, &s);
    lf_block_average(scene, pixels, rays, true, out);
    ng_jobs_for(scene->jobs, pixels->height, ROWS, fill_rows, &s);
}

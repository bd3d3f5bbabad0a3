// A wide lobe sees much, and the rays of one block are few for it: what a pixel reflects is averaged once
// more, over nine pixels a block apart, as far as they see the same. With weights of 1, 2, 1 each way all
// rays of the blocks around count the same, wherever the pixel is between them: no pattern shows.
#include "lightformer/clues/clues_internal.h"

#include <string.h>

#define LANES       12 // LF_REFLECTION_FILTER_TAPS, rounded up
#define MIDDLE      (LF_REFLECTION_FILTER_TAPS / 2)
#define LEAST_SHARE (1 / 64.f) // of a pixel's weights; less is left out

// Of a pixel's neighbours by place, relative to it: what they see in the middle of their lobes.
struct sights {
    float from[3][LANES], direction[3][LANES], distance[LANES];
    float weight[LANES]; // by place; 0: no neighbour
};

// Of its own or of others, that met something or nothing.
static bool has_rays(const struct lf_pixel_clues *p, size_t pixel)
{
    return p->reflection_nearness[pixel] > 0 || p->reflection_missed[pixel] > 0;
}

static uint32_t step_of(const struct lf_pixel_clues *p, size_t pixel)
{
    return LF_INTERLEAVE * p->reflections.lattices[p->reflections.kinds.items[pixel]].spacing;
}

static void find_sights(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    struct lf_pixel_clues *p = user;
    for (uint32_t i = begin; i < end; i++) {
        uint32_t pixel = p->reflections.taps.items[i].pixel;
        struct lf_sight *out = &p->reflections.sights.items[pixel];
        float normal[3], view[3];
        for (int c = 0; c < 3; c++) {
            normal[c] = p->normal[c][pixel];
            view[c] = p->view[c][pixel];
        }
        lf_mirror_direction(view, normal, out->direction);
        out->distance = (1 / lf_max(p->reflection_nearness[pixel], 1e-6f) - 1) * p->distance[pixel];
    }
}

static bool sees_alike(const struct lf_pixel_clues *p, size_t pixel, size_t other)
{
    const unsigned char *kinds = p->reflections.kinds.items;
    return kinds[pixel] == kinds[other] && has_rays(p, other);
}

// Place of tap k around a pixel. False if it is outside.
static bool neighbour(const struct lf_pixel_clues *p, uint32_t pixel, uint32_t k, size_t *out)
{
    uint32_t step = step_of(p, pixel); // what is left or above of the picture wraps
    uint32_t column = pixel % p->width + k % 3 * step - step, row = pixel / p->width + k / 3 * step - step;
    *out = (size_t)row * p->width + column;
    return column < p->width && row < p->height;
}

static void gather(const struct lf_pixel_clues *p, uint32_t pixel, struct sights *out)
{
    for (uint32_t k = 0; k < LF_REFLECTION_FILTER_TAPS; k++) {
        size_t other;
        out->weight[k] = 0;
        if (!neighbour(p, pixel, k, &other) || !sees_alike(p, pixel, other))
            continue;
        const struct lf_sight *seen = &p->reflections.sights.items[other];
        for (int c = 0; c < 3; c++) {
            out->from[c][k] = p->position[c][other] - p->position[c][pixel];
            out->direction[c][k] = seen->direction[c];
        }
        out->distance[k] = seen->distance;
        out->weight[k] = (k % 3 == 1 ? 2.0f : 1.0f) * (k / 3 == 1 ? 2.0f : 1.0f);
    }
}

// How much of what others see is in a pixel's lobe: GGX of the half vector between, the peak being 1.
static void liken(struct sights *s, const float direction[3], float roughness)
{
    float alpha = ng_brdf_alpha(roughness), sharpness = 1 / (alpha * alpha);
    for (int i = 0; i < LANES; i++) {
        float x = s->from[0][i] + s->direction[0][i] * s->distance[i];
        float y = s->from[1][i] + s->direction[1][i] * s->distance[i];
        float z = s->from[2][i] + s->direction[2][i] * s->distance[i];
        float along = x * direction[0] + y * direction[1] + z * direction[2];
        float length = sqrtf(x * x + y * y + z * z);
        float tangent =
            (length - along) / lf_max(length + along, 1e-6f * length + 1e-20f); // of half the angle, squared
        float spread = 1 + tangent * sharpness;
        s->weight[i] /= spread * spread;
    }
}

static void weigh(const struct lf_pixel_clues *p, struct sights *s, struct lf_reflection_filter_taps *out)
{
    float sum = 0, kept = 0;
    gather(p, out->pixel, s);
    liken(s, p->reflections.sights.items[out->pixel].direction, p->roughness[out->pixel]);
    s->weight[MIDDLE] = 4; // also where what it sees is no number
    for (int k = 0; k < LF_REFLECTION_FILTER_TAPS; k++)
        sum += s->weight[k] > 0 ? s->weight[k] : 0;
    for (int k = 0; k < LF_REFLECTION_FILTER_TAPS; k++)
        kept += s->weight[k] = s->weight[k] >= LEAST_SHARE * sum ? s->weight[k] : 0;
    for (int k = 0; k < LF_REFLECTION_FILTER_TAPS; k++)
        out->weight[k] = s->weight[k] / kept;
}

static void weigh_all(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    struct lf_pixel_clues *p = user;
    struct sights sights = {.weight = {0}}; // places without a neighbour hold any numbers, but numbers
    for (uint32_t i = begin; i < end; i++)
        weigh(p, &sights, &p->reflections.filtered.items[i]);
}

// Pixels that took of any ray.
static void list_pixels(struct lf_pixel_clues *p)
{
    struct lf_reflections *m = &p->reflections;
    m->filtered.count = 0;
    for (size_t i = 0; i < m->taps.count; i++)
        if (has_rays(p, m->taps.items[i].pixel))
            m->filtered.items[m->filtered.count++].pixel = m->taps.items[i].pixel;
}

// Those that take anything of others.
static void keep_filtered(struct lf_reflections *m)
{
    size_t count = m->filtered.count;
    m->filtered.count = 0;
    for (size_t i = 0; i < count; i++)
        if (m->filtered.items[i].weight[MIDDLE] < 1)
            m->filtered.items[m->filtered.count++] = m->filtered.items[i];
}

ng_result lf_reflection_filter_find(const struct lf_clues_scene *scene, struct lf_pixel_clues *p)
{
    struct lf_reflections *m = &p->reflections;
    struct lf_memory *memory = &p->memory[LF_PIXEL_REFLECTIONS];
    if (!lf_take(memory, &m->filtered, m->taps.count) || !lf_take(memory, &m->sights, m->kinds.count))
        return ng_out_of_memory("the reflections of a picture");
    list_pixels(p);
    ng_jobs_for(scene->jobs, (uint32_t)m->taps.count, 1024, find_sights, p);
    ng_jobs_for(scene->jobs, (uint32_t)m->filtered.count, 256, weigh_all, p);
    keep_filtered(m);
    return NG_OK;
}

struct averaging {
    const struct lf_pixel_clues *pixels;
    float *const *planes;
    uint32_t channels;
    float *mean; // [pixels that are averaged][channels]
};

static void average(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct averaging *job = user;
    const struct lf_pixel_clues *p = job->pixels;
    for (uint32_t i = begin; i < end; i++) {
        const struct lf_reflection_filter_taps *t = &p->reflections.filtered.items[i];
        float *out = job->mean + (size_t)i * job->channels;
        memset(out, 0, job->channels * sizeof *out);
        for (uint32_t k = 0; k < LF_REFLECTION_FILTER_TAPS; k++) {
            size_t other;
            if (!(t->weight[k] > 0) || !neighbour(p, t->pixel, k, &other))
                continue;
            for (uint32_t c = 0; c < job->channels; c++)
                out[c] += t->weight[k] * job->planes[c][other];
        }
    }
}

static void store(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct averaging *job = user;
    for (uint32_t i = begin; i < end; i++) {
        uint32_t pixel = job->pixels->reflections.filtered.items[i].pixel;
        for (uint32_t c = 0; c < job->channels; c++)
            job->planes[c][pixel] = job->mean[(size_t)i * job->channels + c];
    }
}

void lf_reflection_filter_apply(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                                uint32_t channels, float *scratch, float *const planes[])
{
    struct averaging job = {pixels, planes, channels, scratch};
    uint32_t count = (uint32_t)pixels->reflections.filtered.count;
    ng_jobs_for(scene->jobs, count, 1024, average, &job);
    ng_jobs_for(scene->jobs, count, 1024, store, &job);
}

// What arrives at pixels along rays, of all lights together, and the unit of radiance, in which it is said.
// Each light has said what every hit shows of it (secondary_hit.c). Their sum, and what hits emit themselves,
// goes to the pixels once a picture, however many lights there are.
#include "base/system.h"
#include "lightformer/clues/clues_internal.h"

#include <string.h>

enum rays { REFLECTIONS, HEMISPHERE };

struct sum {
    const struct lf_pixel_clues *pixels;
    struct lf_light_clues *const *lights;
    uint32_t light_count;
    enum rays rays;
    const struct lf_secondary_hit *hits;
    float *out; // [hits][LF_HIT_CHANNELS], W/(sr m2)
};

static void add_light(const struct sum *s, const struct lf_light_clues *light, size_t begin, size_t end)
{
    const float *shown = s->rays == REFLECTIONS ? light->reflected.items : light->hemisphere.items;
    float power = lf_mean(light->power);
    for (size_t i = begin * LF_HIT_CHANNELS; i < end * LF_HIT_CHANNELS; i++)
        s->out[i] += power * shown[i];
}

static void sum_hits(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct sum *s = user;
    for (size_t i = begin; i < end; i++) {
        float *out = s->out + i * LF_HIT_CHANNELS;
        memcpy(out, s->hits[i].emission, 3 * sizeof *out);
        out[3] = 0;
    }
    for (uint32_t k = 0; k < s->light_count; k++)
        add_light(s, s->lights[k], begin, end);
}

static void sum_all(const struct lf_clues_scene *scene, struct sum *s, enum rays rays, size_t count)
{
    const struct lf_pixel_clues *p = s->pixels;
    s->rays = rays;
    s->hits = rays == REFLECTIONS ? p->reflections.hits.items : p->hemisphere.hits.items;
    ng_jobs_for(scene->jobs, (uint32_t)count, 4096, sum_hits, s);
}

struct room {
    LF_PART(float) planes, hits, scratch;
};

// ---- the unit --------------------------------------------------------------------------------------------

struct scaling {
    float *planes, factor;
};

static void scale_run(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct scaling *s = user;
    for (size_t i = begin; i < end; i++)
        s->planes[i] = lf_finite(s->planes[i] * s->factor);
}

static void scale_planes(const struct lf_clues_scene *scene, const struct lf_pixel_clues *p, float *planes)
{
    struct scaling s = {.planes = planes, .factor = p->radiance > 0 ? 1 / p->radiance : 0};
    ng_jobs_for(scene->jobs, 3 * p->width * p->height, 1u << 16, scale_run, &s);
}

// Row by row, so that the sum is the same for any number of threads.
struct adding {
    float *const *planes;
    const float *seen;
    size_t width;
    float *rows;
};

static void add_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct adding *a = user;
    for (size_t y = begin; y < end; y++) {
        float sum = 0;
        for (size_t i = y * a->width; i < (y + 1) * a->width; i++)
            sum += (a->planes[0][i] + a->planes[1][i] + a->planes[2][i]) * (a->seen ? a->seen[i] : 1);
        a->rows[y] = sum / 3;
    }
}

float lf_mean_shown(const struct lf_clues_scene *scene, const struct lf_pixel_clues *p,
                    float *const planes[3], const float *seen, float *rows)
{
    struct adding a = {planes, seen, p->width, rows};
    double sum = 0;
    ng_jobs_for(scene->jobs, p->height, 16, add_rows, &a);
    for (uint32_t y = 0; y < p->height; y++)
        sum += (double)rows[y];
    return p->surfaces ? lf_finite((float)(sum / p->surfaces)) : 0;
}

// Of lights that nobody asked what of them reaches, the power stands in.
static float mean_direct(struct lf_light_clues *const *lights, uint32_t light_count)
{
    double sum = 0;
    for (uint32_t i = 0; i < light_count; i++)
        sum +=
            (double)lf_mean(lights[i]->power) * (lights[i]->reaching < 0 ? 1 : (double)lights[i]->reaching);
    return (float)sum;
}

static size_t larger(size_t a, size_t b)
{
    return a > b ? a : b;
}

// Of both kinds of rays in turn. lf_clues_bytes knows the most of it.
static ng_result take_room(struct lf_pixel_clues *p, struct room *out)
{
    struct lf_memory *memory = &p->memory[LF_PIXEL_ARRIVING];
    size_t hits = larger(p->reflections.hits.count, p->hemisphere.hits.count);
    size_t scratch = larger(3 * p->reflections.filtered.count, larger(9 * lf_grid_points(p), p->height));
    NG_TRY(lf_memory_begin(memory,
                           lf_clues_bytes(p->width, p->height, p->reflection_rays).pixels[LF_PIXEL_ARRIVING],
                           "the inputs of a picture"));
    bool ok = lf_take(memory, &out->planes, 6 * ((size_t)p->width * p->height + LF_PLANE_GAP)) &&
              lf_take(memory, &out->hits, LF_HIT_CHANNELS * hits) && lf_take(memory, &out->scratch, scratch);
    return ok ? NG_OK : ng_out_of_memory("the inputs of a picture");
}

static void take_planes(const struct lf_pixel_clues *p, const struct room *room, int first, float *out[3])
{
    size_t count = (size_t)p->width * p->height;
    for (size_t c = 0; c < 3; c++)
        out[c] = room->planes.items + ((size_t)first + c) * count + (first ? LF_PLANE_GAP : 0);
}

ng_result lf_clues_arriving(const struct lf_clues_scene *scene, struct lf_pixel_clues *p,
                            struct lf_light_clues *const *lights, uint32_t light_count)
{
    uint64_t begin = ng_clock_ns();
    struct sum sum = {.pixels = p, .lights = lights, .light_count = light_count};
    struct room room;
    float *reflected[3], *gathered[3], unit = mean_direct(lights, light_count);
    NG_TRY(take_room(p, &room));
    sum.out = room.hits.items;
    take_planes(p, &room, 0, reflected);
    take_planes(p, &room, 3, gathered);
    p->values.of[LF_INPUT_PIXEL_REFLECTED] = p->values.of[LF_INPUT_PIXEL_GATHERED] = NULL;
    if (lf_clues_wants(scene, LF_INPUT_PIXEL_REFLECTED)) {
        sum_all(scene, &sum, REFLECTIONS, p->reflections.hits.count);
        lf_reflections_spread(scene, p, sum.out, room.scratch.items, reflected);
        p->values.of[LF_INPUT_PIXEL_REFLECTED] = reflected[0];
    }
    if (lf_clues_wants(scene, LF_INPUT_PIXEL_GATHERED)) {
        sum_all(scene, &sum, HEMISPHERE, p->hemisphere.hits.count);
        lf_hemisphere_spread(scene, p, sum.out, room.scratch.items, gathered);
        unit += lf_mean_shown(scene, p, gathered, NULL, room.scratch.items);
        p->values.of[LF_INPUT_PIXEL_GATHERED] = gathered[0];
    }
    lf_clues_set_unit(p, unit, lights, light_count);
    if (p->values.of[LF_INPUT_PIXEL_REFLECTED])
        scale_planes(scene, p, reflected[0]);
    if (p->values.of[LF_INPUT_PIXEL_GATHERED])
        scale_planes(scene, p, gathered[0]);
    p->ms[LF_CLUES_ARRIVING] = lf_clues_lap(&begin);
    return NG_OK;
}

// What arrives at pixels along rays, of all lights together. Each light has said what every hit shows of it
// (secondary_hit.c). Their sum, and what hits emit themselves, goes to the pixels once a picture, however
// many lights there are.
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
    float *out; // [hits][LF_HIT_CHANNELS], in frame.radiance
};

static void add_light(const struct sum *s, const struct lf_light_clues *light, size_t begin, size_t end)
{
    const float *shown = s->rays == REFLECTIONS ? light->reflected.items : light->hemisphere.items;
    for (size_t i = begin * LF_HIT_CHANNELS; i < end * LF_HIT_CHANNELS; i++)
        s->out[i] += light->share * shown[i];
}

static void sum_hits(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct sum *s = user;
    float unit = s->pixels->radiance > 0 ? 1 / s->pixels->radiance : 0;
    for (size_t i = begin; i < end; i++) {
        float *out = s->out + i * LF_HIT_CHANNELS;
        lf_scale(s->hits[i].emission, unit, out);
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

static size_t larger(size_t a, size_t b)
{
    return a > b ? a : b;
}

// Of both kinds of rays in turn. lf_clues_bytes knows the most of it.
static ng_result take_room(struct lf_pixel_clues *p, struct room *out)
{
    struct lf_memory *memory = &p->memory[LF_PIXEL_ARRIVING];
    size_t hits = larger(p->reflections.hits.count, p->hemisphere.hits.count);
    size_t scratch = larger(3 * p->reflections.filtered.count, 6 * lf_grid_points(p));
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
    float *planes[3];
    NG_TRY(take_room(p, &room));
    sum.out = room.hits.items;
    p->values.of[LF_INPUT_PIXEL_REFLECTED] = p->values.of[LF_INPUT_PIXEL_GATHERED] = NULL;
    if (lf_clues_wants(scene, LF_INPUT_PIXEL_REFLECTED)) {
        take_planes(p, &room, 0, planes);
        sum_all(scene, &sum, REFLECTIONS, p->reflections.hits.count);
        lf_reflections_spread(scene, p, sum.out, room.scratch.items, planes);
        p->values.of[LF_INPUT_PIXEL_REFLECTED] = planes[0];
    }
    if (lf_clues_wants(scene, LF_INPUT_PIXEL_GATHERED)) {
        take_planes(p, &room, 3, planes);
        sum_all(scene, &sum, HEMISPHERE, p->hemisphere.hits.count);
        lf_hemisphere_spread(scene, p, sum.out, room.scratch.items, planes);
        p->values.of[LF_INPUT_PIXEL_GATHERED] = planes[0];
    }
    p->ms[LF_CLUES_ARRIVING] = lf_clues_lap(&begin);
    return NG_OK;
}

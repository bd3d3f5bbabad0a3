// How much of the light reaches a pixel: a ray to one of sixteen direct VPLs from each pixel, another one for
// each place of a block, weighed by what that VPL would bring. Rays of pixels with the same VPL run side by
// side.
#include "lightformer/encode/clues_internal.h"

#include <string.h>

#define PLACES (LF_BLOCK * LF_BLOCK)
#define SIDE   4                 // rays of a packet each way
#define TILE   (SIDE * LF_BLOCK) // pixels each way

struct search {
    const struct lf_encode_scene *scene;
    const struct lf_pixel_clues *pixels;
    const struct lf_light_clues *light;
    const struct lf_block_rays *rays;
};

// Sets a ray from the VPL to a pixel. False if it brings nothing there.
static bool set_ray(const struct search *s, size_t pixel, const struct ng_light_sample *vpl, uint32_t lane,
                    struct lf_packet *packet)
{
    const struct lf_pixel_clues *p = s->pixels;
    struct lf_lobe at;
    struct ng_light_incident in;
    float position[3], origin[3], scaled[3];
    lf_pixel_position(p, pixel, scaled);
    lf_pixel_lobe(p, pixel, &at);
    lf_to_world(&p->space, scaled, position);
    ng_light_incident_at(&s->light->unit, vpl, position, &in);
    float cosine = lf_dot(at.normal, in.direction), weight = ng_light_mean(in.irradiance) * cosine;
    if (!(cosine > 0) || !(weight > 0) || !isfinite(weight) || !(lf_dot(at.flat, in.direction) > 0))
        return false;
    // From where the light comes, so that rays have one origin; or, if that is infinitely far, one direction.
    bool infinite = !isfinite(in.distance);
    if (infinite)
        lf_trace_origin(s->scene->tracer, position, at.flat, in.direction, origin);
    else
        memcpy(origin, vpl->position, sizeof origin);
    for (int c = 0; c < 3; c++) {
        packet->origin[c][lane] = origin[c];
        packet->direction[c][lane] = infinite ? in.direction[c] : -in.direction[c];
    }
    packet->far[lane] = infinite ? INFINITY : in.distance * LF_SHADOW_REACH;
    s->rays->weight[pixel] = weight;
    return true;
}

// The pixels of a tile that have one place in their blocks.
static void trace_place(const struct search *s, uint32_t x0, uint32_t y0, uint32_t place)
{
    const struct lf_pixel_clues *p = s->pixels;
    const struct ng_light_sample *vpl = &s->light->vpls.items[lf_block_order[place] % s->light->vpl_count];
    struct lf_packet packet = {.passes = s->light->light};
    size_t at[LF_PACKET];
    uint32_t rays = 0;
    for (uint32_t i = 0; i < LF_PACKET; i++) {
        uint32_t x = x0 + i % SIDE * LF_BLOCK + place % LF_BLOCK,
                 y = y0 + i / SIDE * LF_BLOCK + place / LF_BLOCK;
        at[i] = SIZE_MAX;
        packet.far[i] = 0;
        if (x >= p->width || y >= p->height)
            continue;
        at[i] = (size_t)y * p->width + x;
        s->rays->weight[at[i]] = s->rays->part[at[i]] = 0;
        rays += p->mask[at[i]] > 0 && set_ray(s, at[i], vpl, i, &packet);
    }
    if (!rays)
        return;
    lf_trace_packet_occluded(s->scene->tracer, &packet);
    for (uint32_t i = 0; i < LF_PACKET; i++)
        if (at[i] != SIZE_MAX && s->rays->weight[at[i]] > 0)
            s->rays->part[at[i]] = packet.met[i] ? 0 : 1;
}

static void trace_tiles(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct search *s = user;
    for (uint32_t row = begin; row < end; row++)
        for (uint32_t x = 0; x < s->pixels->width; x += TILE)
            for (uint32_t place = 0; place < PLACES; place++)
                trace_place(s, x, row * TILE, place);
}

void lf_reach_find(const struct lf_encode_scene *scene, const struct lf_pixel_clues *pixels,
                   const struct lf_light_clues *light, float *const way[5], const struct lf_block_rays *rays,
                   float *reached)
{
    struct search s = {scene, pixels, light, rays};
    size_t count = (size_t)pixels->width * pixels->height;
    if (light->unit.type->delta) { // is seen from one place, or one direction
        for (size_t i = 0; i < count; i++)
            reached[i] = pixels->mask[i] > 0 && !(way[4][i] < way[3][i]) ? 1 : 0;
        return;
    }
    ng_jobs_for(scene->jobs, (pixels->height + TILE - 1) / TILE, 1, trace_tiles, &s);
    lf_block_average(scene, pixels, rays, false, reached);
}

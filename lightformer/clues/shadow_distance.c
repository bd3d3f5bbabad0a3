// Equation 2's distances. A ray from the proxy to each pixel says exactly what a depth map says by the texel.
#include "lightformer/clues/clues_internal.h"

#include "lightformer/trace/vec.h"

#include <string.h>

#define TILE 4 // pixels a side of a packet

struct search {
    const struct lf_clues_scene *scene;
    const struct lf_pixel_clues *pixels;
    const struct lf_light_clues *light;
    float *const *out;
};

// From the light to a pixel, in metres; directions are unit.
struct shadow_ray {
    float origin[3], direction[3];
    float distance; // d_f
    bool lit;       // the light sends something in this direction
};

static bool sends(const struct lf_light_clues *light, const float direction[3])
{
    if (light->data.vpl_kind == NG_VPL_POINT)
        return lf_dot(light->data.look, direction) * light->data.cone_scale + light->data.cone_offset > 0;
    for (size_t i = 0; i < light->intensity.count; i++)
        if (lf_dot(light->intensity.items[i].normal, direction) > 0)
            return true;
    return false;
}

static struct shadow_ray find_shadow_ray(const struct search *s, size_t pixel)
{
    const struct ng_light_data *data = &s->light->data;
    struct shadow_ray ray = {.distance = 0};
    float scaled[3], position[3];
    lf_pixel_position(s->pixels, pixel, scaled);
    lf_to_world(&s->pixels->space, scaled, position);
    lf_mad(position, data->proxy, -1, ray.direction);
    memcpy(ray.origin, data->proxy, sizeof ray.origin);
    if (data->vpl_kind == NG_VPL_DIRECTIONAL) { // from where the light enters the scene's sphere
        ray.distance = lf_dot(ray.direction, data->look);
        memcpy(ray.direction, data->look, sizeof ray.direction);
        lf_mad(position, data->look, -ray.distance, ray.origin);
        ray.lit = ray.distance > 0;
        return ray;
    }
    ray.distance = sqrtf(lf_dot(ray.direction, ray.direction));
    if (lf_normalize(ray.direction))
        ray.lit = sends(s->light, ray.direction);
    else
        memcpy(ray.direction, data->look, sizeof ray.direction);
    return ray;
}

static void write_pixel(const struct search *s, size_t pixel, const struct shadow_ray *ray,
                        float shadow_distance)
{
    float scale = 1 / s->pixels->space.radius;
    for (int c = 0; c < 3; c++)
        s->out[c][pixel] = -ray->direction[c];
    s->out[3][pixel] = ray->distance * scale;
    s->out[4][pixel] = shadow_distance * scale;
}

static void look_up(const struct search *s, size_t pixel, const struct shadow_ray *ray)
{
    const struct lf_captured_light *maps = s->light->maps;
    struct lf_depth_map map = {&maps->data, maps->depth, maps->depth_views, maps->face_size};
    float position[3];
    lf_mad(ray->origin, ray->direction, ray->distance, position);
    struct lf_shadow_distance shadow = lf_shadow_lookup(&map, position);
    write_pixel(s, pixel, ray,
                shadow.occluder < LF_SHADOW_RAY_PART * ray->distance ? shadow.occluder : ray->distance);
}

static void find_tile(const struct search *s, uint32_t x0, uint32_t y0)
{
    const struct lf_pixel_clues *p = s->pixels;
    struct lf_packet packet = {.passes = s->light->light};
    struct shadow_ray shadow_rays[LF_PACKET];
    size_t at[LF_PACKET];
    uint32_t rays = 0;
    for (uint32_t i = 0; i < LF_PACKET; i++) {
        uint32_t x = x0 + i % TILE, y = y0 + i / TILE;
        at[i] = SIZE_MAX;
        packet.far[i] = 0;
        if (x >= p->width || y >= p->height)
            continue;
        at[i] = (size_t)y * p->width + x;
        if (!(p->mask[at[i]] > 0)) {
            write_pixel(s, at[i], &(struct shadow_ray){.distance = 0}, 0);
            continue;
        }
        shadow_rays[i] = find_shadow_ray(s, at[i]);
        if (s->light->maps) {
            look_up(s, at[i], &shadow_rays[i]);
            continue;
        }
        write_pixel(s, at[i], &shadow_rays[i], shadow_rays[i].distance);
        for (int c = 0; c < 3; c++) {
            packet.origin[c][i] = shadow_rays[i].origin[c];
            packet.direction[c][i] = shadow_rays[i].direction[c];
        }
        packet.far[i] = shadow_rays[i].lit ? shadow_rays[i].distance * LF_SHADOW_RAY_PART : 0;
        rays += packet.far[i] > 0;
    }
    if (!rays)
        return;
    lf_count_packet(s->scene, &packet);
    lf_trace_packet(s->scene->tracer, &packet, NULL);
    for (uint32_t i = 0; i < LF_PACKET; i++)
        if (packet.met[i])
            write_pixel(s, at[i], &shadow_rays[i], packet.far[i]);
}

static void find_tiles(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct search *s = user;
    for (uint32_t row = begin; row < end; row++)
        for (uint32_t x = 0; x < s->pixels->width; x += TILE)
            find_tile(s, x, row * TILE);
}

void lf_shadow_distance_find(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                             const struct lf_light_clues *light, float *const out[5])
{
    struct search search = {.scene = scene, .pixels = pixels, .light = light, .out = out};
    ng_jobs_for(scene->jobs, (pixels->height + TILE - 1) / TILE, 1, find_tiles, &search);
}

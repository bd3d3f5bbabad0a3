#include "picture.h"

#include "base/half.h"
#include "base/hash.h"
#include "components/light_point.h"
#include "components/light_rectangle.h"
#include "lightformer/trace/surface.h"
#include "lightformer/trace/vec.h"

#include <math.h>

static const struct lf_net_input_info infos[] = {
#define LF_INPUT(id, name, domain, channels, when) {name, LF_DOMAIN_##domain, channels, false},
#include "lightformer/net/inputs.inc"
#undef LF_INPUT
};

static void camera_ray(const struct ng_snapshot_camera *c, float x, float y, float aspect, struct lf_ray *out)
{
    float t = tanf(c->fov_y / 2);
    *out = (struct lf_ray){.far = INFINITY};
    memcpy(out->origin, c->position, sizeof out->origin);
    for (int i = 0; i < 3; i++)
        out->direction[i] = c->view[i * 4] * x * t * aspect - c->view[i * 4 + 1] * y * t - c->view[i * 4 + 2];
    lf_normalize(out->direction);
}

static void octahedral(const float n[3], float out[2])
{
    float sum = fabsf(n[0]) + fabsf(n[1]) + fabsf(n[2]);
    out[0] = n[0] / sum;
    out[1] = n[1] / sum;
    if (n[2] < 0) {
        float x = (1 - fabsf(out[1])) * (out[0] >= 0 ? 1.0f : -1.0f);
        out[1] = (1 - fabsf(out[0])) * (out[1] >= 0 ? 1.0f : -1.0f);
        out[0] = x;
    }
}

static void put(uint16_t *to, const float rgb[3], float w)
{
    for (int c = 0; c < 3; c++)
        to[c] = ng_half_from_float(rgb[c]);
    to[3] = ng_half_from_float(w);
}

static void draw(struct picture *p, const struct scene *s)
{
    for (uint32_t i = 0; i < p->width * p->height; i++) {
        uint32_t column = i % p->width, line = i / p->width;
        float x = ((float)column + 0.5f) / (float)p->width * 2 - 1,
              y = ((float)line + 0.5f) / (float)p->height * 2 - 1, flat[2];
        struct lf_ray ray;
        struct lf_hit hit;
        struct lf_surface at;
        camera_ray(&s->snapshot->camera, x, y, (float)p->width / (float)p->height, &ray);
        if (!lf_trace_closest(s->tracer, &ray, LF_RAY_CAMERA, &hit))
            continue;
        lf_surface_seen_at(s->tracer, &hit, ray.direction, &at);
        memcpy(p->position + 4 * i, at.position, sizeof at.position);
        p->position[4 * i + 3] = 1;
        octahedral(at.flat_normal, flat);
        put(p->normal + 4 * i, at.normal, at.roughness);
        put(p->diffuse + 4 * i, at.albedo, flat[0]);
        put(p->specular + 4 * i, at.f0, flat[1]);
        memcpy(p->emission + 4 * i, at.emission, sizeof at.emission);
    }
}

static void resize(struct picture *p, uint32_t width, uint32_t height)
{
    size_t count = (size_t)width * height * 4;
    uint16_t **halfs[] = {&p->normal, &p->diffuse, &p->specular};
    p->width = width;
    p->height = height;
    free(p->position);
    p->position = calloc(count, sizeof *p->position);
    free(p->emission);
    p->emission = calloc(count, sizeof *p->emission);
    for (size_t i = 0; i < NG_COUNT(halfs); i++) {
        free(*halfs[i]);
        *halfs[i] = calloc(count, sizeof **halfs[i]);
    }
}

void picture_encode_with(struct picture *p, const struct scene *s, uint32_t width, uint32_t height,
                         uint64_t reads, const struct lf_clues_light_params *params)
{
    struct lf_clues_scene scene = {.tracer = s->tracer, .jobs = s->jobs, .reads = reads};
    if (!p->pixels)
        OK(lf_pixel_clues_create(&p->pixels));
    resize(p, width, height);
    draw(p, s);
    OK(lf_clues_pixels(&scene,
                       &(struct lf_clues_pixels_params){
                           .gbuffer = {p->position, p->normal, p->diffuse, p->specular, p->emission},
                           .width = width,
                           .height = height},
                       p->pixels));
    p->lights = s->snapshot->light_count;
    assert_true(p->lights <= NG_COUNT(p->light));
    for (uint32_t i = 0; i < p->lights; i++) {
        if (!p->light[i])
            OK(lf_light_clues_create(&p->light[i]));
        OK(lf_clues_light(&scene, i, params, p->light[i]));
        OK(lf_clues_view(&scene, p->pixels, p->light[i]));
    }
    lf_clues_set_powers(s->snapshot, p->pixels, p->light, p->lights);
    OK(lf_clues_arriving(&scene, p->pixels, p->light, p->lights));
}

void picture_encode(struct picture *p, const struct scene *s, uint32_t width, uint32_t height)
{
    picture_encode_with(p, s, width, height, 0, NULL);
}

void picture_close(struct picture *p)
{
    for (size_t i = 0; i < NG_COUNT(p->light); i++)
        lf_light_clues_destroy(&p->light[i]);
    lf_pixel_clues_destroy(&p->pixels);
    free(p->position);
    free(p->normal);
    free(p->diffuse);
    free(p->specular);
    free(p->emission);
}

const float *picture_pixels(const struct picture *p, enum lf_net_input input, uint32_t channel)
{
    return lf_pixel_clues_values(p->pixels)->of[input] + (size_t)channel * p->width * p->height;
}

const float *picture_view(const struct picture *p, uint32_t light, enum lf_net_input input, uint32_t channel)
{
    return lf_light_clues_values(p->light[light])->of[input] + (size_t)channel * p->width * p->height;
}

float picture_unit(const struct picture *p, uint32_t light)
{
    return *lf_light_clues_values(p->light[light])->of[LF_INPUT_LIGHT_SHARE] *
           *lf_pixel_clues_values(p->pixels)->of[LF_INPUT_FRAME_RADIANCE];
}

static uint64_t hash_values(const struct picture *p, const struct lf_net_values *values, uint32_t vpls,
                            uint32_t texels, bool apart_from_power, uint64_t hash)
{
    const size_t counts[] = {1, 1, vpls, texels, (size_t)p->width * p->height, (size_t)p->width * p->height};
    for (int i = 0; i < LF_INPUT_COUNT; i++) {
        size_t count = counts[infos[i].domain] * infos[i].channels;
        bool of_power = infos[i].domain == LF_DOMAIN_FRAME || i == LF_INPUT_LIGHT_SHARE ||
                        i == LF_INPUT_LIGHT_POWER || i == LF_INPUT_PIXEL_REFLECTED ||
                        i == LF_INPUT_PIXEL_GATHERED;
        if (!values->of[i] || (apart_from_power && of_power))
            continue;
        for (size_t k = 0; k < count; k++)
            if (!isfinite(values->of[i][k]))
                fail_msg("%s: number %zu is not finite", infos[i].name, k);
        hash = ng_hash_bytes(hash, values->of[i], count * sizeof(float));
    }
    return hash;
}

uint64_t picture_hash(const struct picture *p, bool apart_from_power)
{
    uint64_t hash = hash_values(p, lf_pixel_clues_values(p->pixels), 0, 0, apart_from_power, 0);
    for (uint32_t i = 0; i < p->lights; i++)
        hash = hash_values(p, lf_light_clues_values(p->light[i]), lf_light_clues_vpls(p->light[i]),
                           lf_light_clues_texels(p->light[i]), apart_from_power, hash);
    return hash;
}

// ---- scenes -----------------------------------------------------------------------------------------------

ng_entity picture_point(struct scene *s, float intensity, const float position[3])
{
    struct ng_light_point light = {.on = true, .color = {1, 0.5f, 0.25f}, .intensity = intensity};
    return scene_light(s, NG_LIGHT_POINT, &light, position, NULL);
}

ng_entity picture_panel(struct scene *s, float radiance, const float position[3])
{
    struct ng_light_rectangle light = {
        .on = true, .color = {1, 1, 1}, .radiance = radiance, .size = {0.6f, 0.4f}};
    return scene_light(s, NG_LIGHT_RECTANGLE, &light, position, scene_down);
}

void picture_dark_room(struct scene *s, uint32_t threads)
{
    scene_open(s, threads);
    ng_entity smooth = scene_material(s, (const float[3]){0.5f, 0.5f, 0.5f}, 0, 0.15f),
              rough = scene_material(s, (const float[3]){1, 1, 1}, 0, 0.9f);
    scene_quad(s, (const float[3]){-3, -1, 3}, (const float[3]){6, 0, 0}, (const float[3]){0, 0, -6}, smooth);
    scene_quad(s, (const float[3]){-3, -1, -2}, (const float[3]){6, 0, 0}, (const float[3]){0, 4, 0}, rough);
    scene_sphere(s, (const float[3]){0.2f, -0.4f, 0}, 0.6f, false, rough);
}

void picture_room(struct scene *s, uint32_t threads)
{
    picture_dark_room(s, threads);
    picture_point(s, 2, (const float[3]){-1, 1, 1});
    picture_panel(s, 3, (const float[3]){0.7f, 1.4f, 0});
}

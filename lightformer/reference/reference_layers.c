// Layers: light from the sums; what the camera meets by tracing the rays through the pixels' centres again.
#include "base/log.h"
#include "lightformer/reference/reference_internal.h"
#include "lightformer/trace/vec.h"

#include <stdlib.h>
#include <string.h>

enum layer {
    LAYER_BEAUTY,
    LAYER_DIRECT,
    LAYER_UNSHADOWED,
    LAYER_SHADOW,
    LAYER_INDIRECT,
    LAYER_EMISSION,
    LAYER_VARIANCE,
    LAYER_SAMPLES,
    LAYER_ALBEDO, // from here on: of the surface at the pixel's centre
    LAYER_SPECULAR,
    LAYER_POSITION,
    LAYER_NORMAL,
    LAYER_ROUGHNESS,
    LAYER_MOTION,
    LAYER_DEPTH,
    LAYER_ENTITY,
    LAYER_COUNT,
};

// Wherever the engine has the same layer, the words are the engine's (engine/render/layers.c).
static const struct lf_layer_info infos[LAYER_COUNT] = {
    [LAYER_BEAUTY] = {"beauty", {"R", "G", "B"}, false, "radiance: direct + indirect + emission, W/(sr m2)"},
    [LAYER_DIRECT] = {"direct", {"R", "G", "B"}, false, "T_d: direct light with shadows"},
    [LAYER_UNSHADOWED] = {"unshadowed",
                          {"R", "G", "B"},
                          false,
                          "T_l: direct light as if nothing were in its way"},
    [LAYER_SHADOW] = {"shadow", {"R", "G", "B"}, false, "T_ls = T_d / T_l; 1 where T_l is 0"},
    [LAYER_INDIRECT] = {"indirect", {"R", "G", "B"}, false, "T_i: everything after the first bounce"},
    [LAYER_EMISSION] = {"emission", {"R", "G", "B"}, false, "what surfaces and the environment emit"},
    [LAYER_VARIANCE] = {"variance", {"R", "G", "B"}, false, "estimated variance of beauty"},
    [LAYER_SAMPLES] = {"samples", {"Y"}, false, "paths a pixel"},
    [LAYER_ALBEDO] = {"albedo", {"R", "G", "B"}, false, "diffuse albedo"},
    [LAYER_SPECULAR] = {"specular", {"R", "G", "B"}, false, "specular reflectance at normal incidence, F0"},
    [LAYER_POSITION] = {"position", {"X", "Y", "Z"}, false, "world position, m; 0 where there is no surface"},
    [LAYER_NORMAL] = {"normal", {"X", "Y", "Z"}, false, "shading normal, world"},
    [LAYER_ROUGHNESS] = {"roughness", {"Y"}, false, "perceptual roughness; alpha is its square"},
    [LAYER_MOTION] = {"motion", {"X", "Y"}, false, "pixels, now - before, x right, y down"},
    [LAYER_DEPTH] = {"depth", {"Z"}, false, "distance along the view axis, m; 0 where there is no surface"},
    [LAYER_ENTITY] = {"entity", {"id"}, true, "index half of the entity's id; 0 where there is none"},
};

const struct lf_layer_info *lf_reference_layer_info(uint32_t index)
{
    return index < LAYER_COUNT ? &infos[index] : NULL;
}

const struct lf_layer_info *lf_reference_find_layer(const char *name)
{
    for (uint32_t i = 0; i < LAYER_COUNT; i++)
        if (strcmp(infos[i].name, name) == 0)
            return &infos[i];
    return NULL;
}

static void mean_of(const double sum[3], uint32_t samples, float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = samples ? (float)(sum[i] / samples) : 0;
}

static void find_light(const struct lf_sums *s, uint32_t samples, enum layer layer, float out[3])
{
    float direct[3], unshadowed[3], indirect[3], emission[3];
    mean_of(s->direct, samples, direct);
    mean_of(s->unshadowed, samples, unshadowed);
    mean_of(s->indirect, samples, indirect);
    mean_of(s->emission, samples, emission);
    double n = samples;
    for (int i = 0; i < 3; i++) {
        double mean = n > 0 ? (s->direct[i] + s->indirect[i] + s->emission[i]) / n : 0;
        double variance = n > 1 ? (s->square[i] / n - mean * mean) / (n - 1) : 0;
        const float values[] = {
            [LAYER_BEAUTY] = direct[i] + indirect[i] + emission[i],
            [LAYER_DIRECT] = direct[i],
            [LAYER_UNSHADOWED] = unshadowed[i],
            [LAYER_SHADOW] = unshadowed[i] > 0 ? direct[i] / unshadowed[i] : 1,
            [LAYER_INDIRECT] = indirect[i],
            [LAYER_EMISSION] = emission[i],
            [LAYER_VARIANCE] = variance > 0 ? (float)variance : 0,
            [LAYER_SAMPLES] = (float)samples,
        };
        out[i] = values[layer];
    }
}

// From the pixel in which the camera of the frame before saw the point, to the middle of this one, where the
// ray goes through.
static void find_motion(const struct lf_reference *r, const struct lf_primary *p, float out[2])
{
    const struct ng_snapshot_camera *camera = &lf_tracer_snapshot(r->tracer)->camera;
    const float *view = camera->previous_view, *now = p->ray.direction;
    float before[3], eye[3], ahead = lf_dot(now, r->camera.forward);
    lf_surface_previous(r->tracer, &p->hit, before);
    for (int i = 0; i < 3; i++)
        eye[i] = view[i] * before[0] + view[4 + i] * before[1] + view[8 + i] * before[2] + view[12 + i];
    // Both on the plane at distance 1, where the picture is 2 x 2 lengths of right and down.
    float width = (float)r->params.width, height = (float)r->params.height;
    float right = sqrtf(lf_dot(r->camera.right, r->camera.right));
    float down = sqrtf(lf_dot(r->camera.down, r->camera.down));
    if (camera->orthographic) { // both in metres across
        float from[3];
        lf_mad(p->ray.origin, camera->position, -1, from);
        out[0] = (lf_dot(from, r->camera.right) / right - eye[0]) / right * width * 0.5f;
        out[1] = (lf_dot(from, r->camera.down) / down + eye[1]) / down * height * 0.5f;
        return;
    }
    float x = lf_dot(now, r->camera.right) / (right * ahead),
          y = lf_dot(now, r->camera.down) / (down * ahead);
    out[0] = (x + eye[0] / eye[2]) / right * width * 0.5f;
    out[1] = (y - eye[1] / eye[2]) / down * height * 0.5f;
}

static void find_surface(const struct lf_reference *r, const struct lf_primary *p, enum layer layer,
                         float out[3])
{
    const struct lf_surface *s = &p->surface;
    memset(out, 0, 3 * sizeof(float));
    if (!p->met)
        return;
    const float *value = layer == LAYER_ALBEDO     ? s->albedo
                         : layer == LAYER_SPECULAR ? s->f0
                         : layer == LAYER_POSITION ? s->position
                                                   : s->normal;
    if (layer == LAYER_ROUGHNESS)
        out[0] = s->roughness;
    else if (layer == LAYER_MOTION)
        find_motion(r, p, out);
    else if (layer == LAYER_DEPTH)
        out[0] = p->hit.distance * lf_dot(p->ray.direction, r->camera.forward);
    else
        memcpy(out, value, 3 * sizeof(float));
}

static uint32_t entity_of(const struct lf_reference *r, const struct lf_primary *p)
{
    return p->met ? ng_entity_index(lf_tracer_snapshot(r->tracer)->instances[p->hit.instance].entity) : 0;
}

static void fill(const struct lf_reference *r, enum layer layer, struct lf_layer *out)
{
    const struct lf_region *region = &r->params.region;
    struct lf_path_stats stats = {0};
    struct lf_path_scene scene = lf_reference_scene(r, &stats);
    float *pixel = out->pixels;
    uint32_t *id = out->pixels;
    for (uint32_t y = 0; y < region->height; y++)
        for (uint32_t x = 0; x < region->width; x++) {
            float value[3];
            if (layer < LAYER_ALBEDO) {
                find_light(&r->sums[(size_t)y * region->width + x], r->samples, layer, value);
            } else {
                struct lf_primary primary;
                struct lf_ray ray =
                    lf_reference_ray(r, (float)(region->x + x) + 0.5f, (float)(region->y + y) + 0.5f);
                const uint32_t at[2] = {region->x + x, region->y + y};
                lf_path_begin(&scene, &ray, at, &primary);
                if (layer == LAYER_ENTITY) {
                    *id++ = entity_of(r, &primary);
                    continue;
                }
                find_surface(r, &primary, layer, value);
            }
            memcpy(pixel, value, out->channels * sizeof *pixel);
            pixel += out->channels;
        }
}

ng_result lf_reference_layer(const struct lf_reference *r, const char *name, struct lf_layer *out)
{
    NG_REQUIRE(r->tracer, "lf_reference_begin comes first");
    const struct lf_layer_info *info = lf_reference_find_layer(name);
    *out = (struct lf_layer){0};
    if (!info) {
        ng_log_error("reference: there is no layer \"%s\"", name);
        return NG_ERROR_NOT_FOUND;
    }
    *out = (struct lf_layer){
        .info = info, .width = r->params.region.width, .height = r->params.region.height, .channels = 1};
    while (out->channels < 4 && info->channels[out->channels])
        out->channels++;
    out->pixels = calloc(lf_pixel_count(r), out->channels * sizeof(float));
    if (!out->pixels)
        return ng_out_of_memory(name);
    fill(r, (enum layer)(info - infos), out);
    return NG_OK;
}

#include "scene.h"

#include "asset/geometry.h"
#include "asset/gltf.h"
#include "base/jobs.h"
#include "components/camera.h"
#include "components/light_environment.h"
#include "components/light_point.h"
#include "components/material.h"
#include "components/mesh.h"
#include "components/name.h"
#include "components/scene_scale.h"
#include "components/transform.h"
#include "render/extract.h"
#include "render/scene_systems.h"
#include "scene/system.h"
#include "scene/world.h"

#include <math.h>

#define PI 3.14159265358979

static void open_parts(struct scene *s, uint32_t threads)
{
    *s = (struct scene){0};
    OK(ng_world_create(NULL, &s->world));
    OK(ng_components_register(s->world));
    OK(ng_assets_create(&s->assets));
    OK(ng_jobs_create(&(struct ng_jobs_params){.threads = threads}, &s->jobs));
    OK(ng_scene_systems_add(s->world, s->assets, s->jobs));
    OK(ng_extractor_create(&s->extractor));
    OK(lf_tracer_create(&s->tracer));
}

void scene_open(struct scene *s, uint32_t threads)
{
    open_parts(s, threads);
    s->scale = ng_entity_create(s->world);
    OK(ng_world_add(s->world, s->scale, NG_SCENE_SCALE, &(struct ng_scene_scale){.radius = 3}));
    s->camera = scene_entity(s, "camera", (const float[3]){0, 0, 5}, NULL);
    OK(ng_world_add(s->world, s->camera, NG_CAMERA, NULL));
}

void scene_load(struct scene *s, uint32_t threads, const char *path)
{
    struct ng_gltf_scene loaded;
    open_parts(s, threads);
    OK(ng_gltf_load(path, s->world, s->assets, NULL, &loaded));
    s->camera = loaded.camera;
}

void scene_close(struct scene *s)
{
    lf_light_choice_finish(&s->lights);
    lf_tracer_destroy(&s->tracer);
    ng_extractor_destroy(&s->extractor);
    ng_world_destroy(&s->world);
    ng_assets_destroy(&s->assets);
    ng_jobs_destroy(&s->jobs);
}

void scene_frame(struct scene *s, double time)
{
    OK(ng_world_run(s->world, time));
    struct ng_extract_params p = {.world = s->world, .assets = s->assets, .jobs = s->jobs, .time = time};
    OK(ng_extract(s->extractor, &p, &s->snapshot));
    OK(lf_tracer_update(s->tracer, s->snapshot));
    OK(lf_light_choice_update(&s->lights, s->snapshot));
}

void scene_frame_warned(struct scene *s, double time)
{
    struct test_log log;
    test_log_begin(&log);
    scene_frame(s, time);
    test_log_end(&log);
    assert_int_equal(log.warnings, 1);
}

ng_entity scene_entity(struct scene *s, const char *name, const float position[3], const float rotation[4])
{
    ng_entity e = ng_entity_create(s->world);
    struct ng_transform t = {.rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}};
    struct ng_name text = {{0}};
    memcpy(t.translation, position, sizeof t.translation);
    if (rotation)
        memcpy(t.rotation, rotation, sizeof t.rotation);
    snprintf(text.text, sizeof text.text, "%s", name);
    OK(ng_world_add(s->world, e, NG_NAME, &text));
    OK(ng_world_add(s->world, e, NG_TRANSFORM, &t));
    return e;
}

ng_entity scene_material(struct scene *s, const float base[3], float metallic, float roughness)
{
    ng_entity e = ng_entity_create(s->world);
    OK(ng_world_add(s->world, e, NG_MATERIAL, NULL));
    struct ng_material *m = ng_world_edit(s->world, e, NG_MATERIAL);
    memcpy(m->base_color, base, sizeof m->base_color);
    m->metallic = metallic;
    m->roughness = roughness;
    return e;
}

ng_entity scene_glow(struct scene *s, const float radiance[3])
{
    ng_entity e = scene_material(s, (const float[3]){0, 0, 0}, 0, 1);
    struct ng_material *m = ng_world_edit(s->world, e, NG_MATERIAL);
    memcpy(m->emissive, radiance, sizeof m->emissive);
    m->emissive_strength = 1;
    return e;
}

static ng_entity add_mesh(struct scene *s, struct ng_geometry *g, const float position[3], ng_entity material)
{
    ng_asset id;
    OK(ng_geometry_complete(g));
    OK(ng_assets_take_geometry(s->assets, "test", g, &id));
    ng_entity e = scene_entity(s, "mesh", position, NULL);
    OK(ng_world_add(s->world, e, NG_MESH,
                    &(struct ng_mesh){.geometry = id, .material = material, .visible = true}));
    return e;
}

static struct ng_geometry allocate(uint32_t vertices, uint32_t indices)
{
    struct ng_geometry g = {.vertex_count = vertices, .index_count = indices};
    g.positions = calloc(vertices, 3 * sizeof(float));
    g.normals = calloc(vertices, 3 * sizeof(float));
    g.uvs = calloc(vertices, 2 * sizeof(float));
    g.indices = calloc(indices, sizeof(uint32_t));
    assert_true(g.positions && g.normals && g.uvs && g.indices);
    return g;
}

ng_entity scene_quad(struct scene *s, const float corner[3], const float u[3], const float v[3],
                     ng_entity material)
{
    static const uint32_t indices[6] = {0, 1, 2, 2, 1, 3};
    struct ng_geometry g = allocate(4, 6);
    float n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (size_t i = 0; i < 4; i++) {
        for (size_t c = 0; c < 3; c++) {
            g.positions[i * 3 + c] = (i & 1 ? u[c] : 0) + (i & 2 ? v[c] : 0);
            g.normals[i * 3 + c] = n[c] / length;
        }
        g.uvs[i * 2] = i & 1 ? 1.0f : 0.0f;
        g.uvs[i * 2 + 1] = i & 2 ? 1.0f : 0.0f;
    }
    memcpy(g.indices, indices, sizeof indices);
    return add_mesh(s, &g, corner, material);
}

ng_entity scene_sphere(struct scene *s, const float center[3], float radius, bool inside, ng_entity material)
{
    enum { AROUND = 192, DOWN = 96, ROW = AROUND + 1 };
    struct ng_geometry g = allocate(ROW * (DOWN + 1), AROUND * DOWN * 6);
    for (size_t j = 0; j <= DOWN; j++)
        for (size_t i = 0; i <= AROUND; i++) {
            double phi = 2 * PI * (double)i / AROUND, theta = PI * (double)j / DOWN;
            const double n[3] = {sin(theta) * cos(phi), cos(theta), -sin(theta) * sin(phi)};
            for (size_t c = 0; c < 3; c++) {
                g.positions[(j * ROW + i) * 3 + c] = (float)(n[c] * (double)radius);
                g.normals[(j * ROW + i) * 3 + c] = (float)(inside ? -n[c] : n[c]);
            }
        }
    size_t at = 0;
    for (uint32_t j = 0; j < DOWN; j++)
        for (uint32_t i = 0; i < AROUND; i++) {
            uint32_t a = j * ROW + i, b = a + ROW;
            const uint32_t out[6] = {a, b, a + 1, a + 1, b, b + 1};
            for (size_t k = 0; k < 6; k++)
                g.indices[at++] = out[inside ? 5 - k : k];
        }
    return add_mesh(s, &g, center, material);
}

ng_entity scene_light(struct scene *s, ng_component type, const void *light, const float position[3],
                      const float rotation[4])
{
    ng_entity e = scene_entity(s, "light", position, rotation);
    OK(ng_world_add(s->world, e, type, light));
    return e;
}

const float scene_down[4] = {-0.70710678f, 0, 0, 0.70710678f};

ng_entity scene_point(struct scene *s, float intensity, const float position[3])
{
    const struct ng_light_point light = {.on = true, .color = {1, 1, 1}, .intensity = intensity};
    return scene_light(s, NG_LIGHT_POINT, &light, position, NULL);
}

ng_entity scene_sky(struct scene *s)
{
    const struct ng_light_environment light = {.on = true, .color = {1, 1, 1}, .intensity = 1};
    return scene_light(s, NG_LIGHT_ENVIRONMENT, &light, (const float[3]){0, 0, 0}, NULL);
}

// ---- estimates -------------------------------------------------------------------------------------------
struct estimate scene_estimate(const struct scene *s, const struct lf_primary *primary, uint32_t samples,
                               uint32_t depth, enum lf_sampler_kind kind, uint64_t seed, size_t part)
{
    struct lf_path_stats stats = {0};
    struct lf_path_scene scene = {.tracer = s->tracer, .lights = &s->lights, .depth = depth, .stats = &stats};
    double sum = 0, square = 0;
    struct lf_path paths[LF_PATHS];
    for (uint32_t i = 0, count; i < samples; i += count) {
        for (count = 0; count < LF_PATHS && i + count < samples; count++)
            paths[count] = (struct lf_path){.primary = primary,
                                            .sampler = lf_sampler_start(kind, seed, 0, 0, i + count)};
        lf_paths_trace(&scene, paths, count);
        for (uint32_t k = 0; k < count; k++) {
            float rgb[3];
            memcpy(rgb, (const char *)&paths[k].radiance + part, sizeof rgb);
            double x = ((double)rgb[0] + (double)rgb[1] + (double)rgb[2]) / 3;
            sum += x;
            square += x * x;
        }
    }
    double mean = sum / samples, variance = fmax(square / samples - mean * mean, 0);
    return (struct estimate){mean, sqrt(variance / samples)};
}

struct lf_primary scene_receiver(const float position[3], const float normal[3])
{
    struct lf_primary p = {.met = true, .surface = {.roughness = 1, .front = true, .light = NG_NONE}};
    for (int i = 0; i < 3; i++) {
        p.surface.position[i] = position[i];
        p.surface.normal[i] = p.surface.flat_normal[i] = normal[i];
        p.surface.albedo[i] = 1;
        p.ray.direction[i] = -normal[i];
    }
    return p;
}

struct estimate scene_irradiance_(const struct scene *s, const float position[3], const float normal[3],
                                  uint32_t samples, size_t part)
{
    struct lf_primary p = scene_receiver(position, normal);
    struct estimate e = scene_estimate(s, &p, samples, 2, LF_SAMPLER_INDEPENDENT, 1, part);
    return (struct estimate){PI * e.mean, PI * e.error};
}

struct lf_reference *scene_render(const struct scene *s, const struct lf_reference_params *params,
                                  uint32_t samples)
{
    struct lf_reference *r;
    OK(lf_reference_create(params, &r));
    OK(lf_reference_begin(r, s->tracer));
    OK(lf_reference_run(r, &(struct lf_reference_run_params){.samples = samples}));
    return r;
}

float *scene_layer(const struct lf_reference *reference, const char *name)
{
    struct lf_layer layer;
    OK(lf_reference_layer(reference, name, &layer));
    return layer.pixels;
}

float *scene_render_layer(const struct scene *s, const struct lf_reference_params *params, uint32_t samples,
                          const char *name)
{
    struct lf_reference *r = scene_render(s, params, samples);
    float *layer = scene_layer(r, name);
    lf_reference_destroy(&r);
    return layer;
}

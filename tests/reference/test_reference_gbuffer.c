// The reference and the rasterizer agree on what a pixel shows: position, normal, materials, emission,
// entity.
#include "scene.h"

#include "app/stage.h"
#include "components/camera.h"
#include "components/material.h"
#include "components/transform.h"
#include "render/renderer.h"
#include "scene/world.h"

#include <math.h>

static const char *const names[] = {"entity",   "position",  "normal",   "albedo",
                                    "specular", "roughness", "emission", "depth"};

// Pixels whose neighbours show the same thing: there, edges and filters do not matter.
static bool is_inside(const uint32_t *ids, int side, int x, int y)
{
    if (x < 1 || y < 1 || x >= side - 1 || y >= side - 1)
        return false;
    for (int j = -1; j <= 1; j++)
        for (int i = -1; i <= 1; i++)
            if (ids[(y + j) * side + x + i] != ids[y * side + x])
                return false;
    return true;
}

// Mean difference over the pixels inside of things, relative to the layer's mean.
static double difference(const float *a, const float *b, const uint32_t *ids, uint32_t channels, int side)
{
    double sum = 0, size = 0;
    for (int y = 0; y < side; y++)
        for (int x = 0; x < side; x++)
            for (uint32_t c = 0; is_inside(ids, side, x, y) && c < channels; c++) {
                size_t at = ((size_t)y * (size_t)side + (size_t)x) * channels + c;
                sum += fabs((double)a[at] - (double)b[at]);
                size += fabs((double)b[at]);
            }
    return size > 0 ? sum / size : sum;
}

// Turns what has a normal map into its mirror image.
static void mirror_normal_maps(struct ng_stage *stage)
{
    OK(ng_stage_seek(stage, 0, NULL));
    const struct ng_snapshot *s = stage->snapshot;
    for (uint32_t i = 0; i < s->instance_count; i++)
        if (s->materials[s->instances[i].material].textures[NG_TEXTURE_NORMAL].image != NG_NONE)
            ((struct ng_transform *)ng_world_edit(stage->world, s->instances[i].entity, NG_TRANSFORM))
                ->scale[0] = -1;
}

// Normals that contradict their triangles everywhere.
static void turn_normals(struct ng_stage *stage)
{
    OK(ng_stage_seek(stage, 0, NULL));
    const struct ng_snapshot *s = stage->snapshot;
    for (uint32_t i = 0; i < s->mesh_count; i++)
        for (size_t k = 0; k < (size_t)s->meshes[i].vertex_count * 3; k++)
            ((float *)s->meshes[i].normals)[k] *= -1;
}

// The camera behind every mirror that there is: its own scale, and a parent that also shears.
static void scale_camera(struct ng_stage *stage, float x, float y, float z)
{
    OK(ng_stage_seek(stage, 0, NULL));
    float *scale =
        ((struct ng_transform *)ng_world_edit(stage->world, stage->scene.camera, NG_TRANSFORM))->scale;
    scale[0] = x, scale[1] = y, scale[2] = z;
}

static void mirror_camera(struct ng_stage *stage)
{
    scale_camera(stage, -1, 1, 1);
}

static void mirror_camera_upwards(struct ng_stage *stage)
{
    scale_camera(stage, 1, -3, 1);
}

static void turn_camera(struct ng_stage *stage)
{
    scale_camera(stage, -0.5f, -2, 1);
}

static void mirror_parent_of_camera(struct ng_stage *stage)
{
    OK(ng_stage_seek(stage, 0, NULL));
    ng_entity parent = ng_entity_create(stage->world);
    OK(ng_world_add(
        stage->world, parent, NG_TRANSFORM,
        &(struct ng_transform){.rotation = {0, 0, 0.3826834f, 0.9238795f}, .scale = {-1, 1.3f, 1}}));
    OK(ng_world_set_parent(stage->world, stage->scene.camera, parent, (ng_entity){0}));
}

// Every light and every material that emits, so many times as bright. A light without a colour is a mesh's,
// which has its material's.
static double brightness;

static void brighten(struct ng_stage *stage)
{
    OK(ng_stage_seek(stage, 0, NULL));
    const struct ng_snapshot *s = stage->snapshot;
    for (uint32_t i = 0; i < s->light_count; i++) {
        ng_component component = s->lights[i].source.type->component;
        const struct ng_field *color =
            ng_component_field(ng_world_component(stage->world, component), "color");
        char *light = ng_world_edit(stage->world, s->lights[i].entity, component);
        for (int c = 0; light && color && c < 3; c++)
            ((float *)(void *)(light + color->offset))[c] *= (float)brightness;
    }
    for (uint32_t i = 0; i < s->material_count; i++) {
        struct ng_material *m = ng_world_edit(stage->world, s->materials[i].entity, NG_MATERIAL);
        if (m) // not the one that stands for none
            m->emissive_strength *= (float)brightness;
    }
}

// `change` may be null: the scene as it is.
static void compare(const char *path, int side, void (*change)(struct ng_stage *))
{
    struct ng_stage *stage;
    OK(ng_stage_create(&(struct ng_stage_params){.scene = path, .threads = 2}, &stage));
    struct ng_stage_frame frame = {.width = (uint32_t)side,
                                   .height = (uint32_t)side,
                                   .layers = names,
                                   .layer_count = NG_COUNT(names),
                                   .time = 0.4};
    if (change)
        change(stage);
    OK(ng_stage_draw(stage, &frame));
    struct lf_tracer *tracer;
    struct lf_reference *reference;
    OK(lf_tracer_create(&tracer));
    OK(lf_tracer_update(tracer, stage->snapshot));
    OK(lf_reference_create(
        &(struct lf_reference_params){.width = (uint32_t)side, .height = (uint32_t)side, .jobs = stage->jobs},
        &reference));
    OK(lf_reference_begin(reference, tracer));
    OK(lf_reference_run(reference, &(struct lf_reference_run_params){.samples = 1}));
    uint32_t *ids = NULL;
    for (size_t i = 0; i < NG_COUNT(names); i++) {
        struct ng_layer drawn;
        OK(ng_renderer_layer(stage->renderer, names[i], &drawn));
        void *traced = scene_layer(reference, names[i]);
        if (drawn.info->uint) {
            int differ = 0;
            ids = traced;
            for (int p = 0; p < side * side; p++)
                differ += ids[p] != drawn.ids[p];
            if (differ > side * side / 200)
                fail_msg("%s: %d of %d pixels show another entity", path, differ, side * side);
            continue;
        }
        double d = difference(traced, drawn.pixels, ids, drawn.channels, side);
        // Half floats (not of emission) and 8-bit filter weights in the one, mip levels in the other.
        if (d > 0.01)
            fail_msg("%s: layer %s differs by %g", path, names[i], d);
        free(traced);
    }
    free(ids);
    lf_reference_destroy(&reference);
    lf_tracer_destroy(&tracer);
    ng_stage_destroy(&stage);
}

static void look_in_parallel(struct ng_stage *stage)
{
    struct ng_camera *camera = ng_world_edit(stage->world, stage->scene.camera, NG_CAMERA);
    camera->projection = NG_PROJECTION_ORTHOGRAPHIC;
    camera->height = 3;
}

static void compare_cameras(const char *path)
{
    static void (*const changes[])(struct ng_stage *) = {mirror_camera, mirror_camera_upwards, turn_camera,
                                                         mirror_parent_of_camera};
    for (size_t i = 0; i < NG_COUNT(changes); i++)
        compare(path, 96, changes[i]);
}

static void test_layers_equal_the_rasterizers(void **state)
{
    (void)state;
    // Textures need texels that are not smaller than pixels: mip levels blur those, and the reference does
    // not.
    static const struct {
        const char *name;
        int side;
    } scenes[] = {{"materials", 96},    {"mirrored", 96},   {"double_sided", 96},      {"hierarchy", 96},
                  {"alpha_mask", 256},  {"light_spot", 96}, {"character", 96},         {"subdivision", 96},
                  {"light_sphere", 96}, {"light_disk", 96}, {"light_environment", 96}, {"normal_map", 384}};
    for (size_t i = 0; i < NG_COUNT(scenes); i++) {
        char path[128];
        snprintf(path, sizeof path, "content/unit/%s.glb", scenes[i].name);
        compare(path, scenes[i].side, NULL);
    }
    // The same texels, and of what blends the same surface, in each pixel.
    static const char *const looks[] = {"magnified", "filter_nearest", "blend_30", "unlit", "metal"};
    for (size_t i = 0; i < NG_COUNT(looks); i++) {
        char path[128];
        snprintf(path, sizeof path, "tests/files/materials/%s.gltf", looks[i]);
        compare(path, 384, NULL);
    }
    compare("content/unit/normal_map.glb", 384, mirror_normal_maps);
    compare("content/unit/light_point.glb", 96, turn_normals);
    static const char *const shining[] = {"light_rectangle", "light_disk", "light_sphere", "materials",
                                          "light_environment"};
    for (brightness = 1e-9; brightness < 1e10; brightness *= 1e9)
        for (size_t i = 0; i < NG_COUNT(shining); i++) {
            char path[128];
            snprintf(path, sizeof path, "content/unit/%s.glb", shining[i]);
            compare(path, 96, brighten);
        }
    compare("tests/files/geometry/figure.gltf", 384,
            NULL); // colours, second UVs, morph targets, joints, a mask
    compare_cameras("content/unit/double_sided.glb");
    compare_cameras("content/unit/mirrored.glb");
    compare_cameras("tests/files/geometry/orthographic.gltf");
    compare("content/unit/materials.glb", 96, look_in_parallel);
    compare("content/unit/light_environment.glb", 96, look_in_parallel);
}

// Pixels that a thing crosses between two frames, as both methods see it.
static void check_motion(const char *name, bool moves, void (*change)(struct ng_stage *))
{
    enum { SIDE = 96 };
    static const char *const layers[] = {"entity", "motion"};
    char path[128];
    struct ng_stage *stage;
    struct ng_layer drawn, ids;
    struct lf_tracer *tracer;
    struct lf_reference *reference;
    snprintf(path, sizeof path, "content/unit/%s.glb", name);
    OK(ng_stage_create(&(struct ng_stage_params){.scene = path, .threads = 2}, &stage));
    if (change)
        change(stage);
    struct ng_stage_frame frame = {
        .width = SIDE, .height = SIDE, .layers = layers, .layer_count = NG_COUNT(layers), .time = 0.4};
    OK(ng_stage_draw(stage, &frame));
    frame.time += 1 / 30.0;
    OK(ng_stage_draw(stage, &frame));
    OK(lf_tracer_create(&tracer));
    OK(lf_tracer_update(tracer, stage->snapshot));
    OK(lf_reference_create(&(struct lf_reference_params){.width = SIDE, .height = SIDE}, &reference));
    OK(lf_reference_begin(reference, tracer));
    OK(ng_renderer_layer(stage->renderer, "motion", &drawn));
    OK(ng_renderer_layer(stage->renderer, "entity", &ids));
    float *traced = scene_layer(reference, "motion"), most = 0;
    for (int i = 0; i < SIDE * SIDE; i++)
        for (int c = 0; is_inside(ids.ids, SIDE, i % SIDE, i / SIDE) && ids.ids[i] && c < 2; c++) {
            NEAR(traced[i * 2 + c], drawn.pixels[i * 2 + c], 0.02f);
            most = fmaxf(most, fabsf(traced[i * 2 + c]));
        }
    assert_int_equal(most > 0.1f, moves);
    free(traced);
    lf_reference_destroy(&reference);
    lf_tracer_destroy(&tracer);
    ng_stage_destroy(&stage);
}

static void test_motion_equals_the_rasterizers(void **state)
{
    (void)state;
    check_motion("character", true, NULL);
    check_motion("character", true, look_in_parallel);
    check_motion("hierarchy", true, NULL);
    check_motion("light_sphere", false, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_layers_equal_the_rasterizers),
                                       cmocka_unit_test(test_motion_equals_the_rasterizers)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// The reference and the rasterizer agree on what a pixel shows: position, normal, materials, emission,
// entity.
#include "views.h"

#include "app/stage.h"
#include "components/material.h"
#include "render/renderer.h"
#include "scene/world.h"

#include <math.h>

static const char *const names[] = {"entity",   "position",  "normal",   "albedo",
                                    "specular", "roughness", "emission", "depth"};

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
        double d = view_difference(traced, drawn.pixels, ids, drawn.channels, side, side);
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

static void compare_cameras(const char *path)
{
    for (size_t i = 0; i < VIEW_CAMERAS; i++)
        compare(path, 96, view_cameras[i]);
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
    compare("content/unit/normal_map.glb", 384, view_mirror_normal_maps);
    compare("content/unit/light_point.glb", 96, view_turn_normals);
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
    compare("content/unit/materials.glb", 96, view_look_in_parallel);
    compare("content/unit/light_environment.glb", 96, view_look_in_parallel);
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
        for (int c = 0; view_is_inside(ids.ids, SIDE, SIDE, i % SIDE, i / SIDE) && ids.ids[i] && c < 2; c++) {
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
    check_motion("character", true, view_look_in_parallel);
    check_motion("hierarchy", true, NULL);
    check_motion("light_sphere", false, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_layers_equal_the_rasterizers),
                                       cmocka_unit_test(test_motion_equals_the_rasterizers)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// The live reference: slices add up to what lf_reference makes, byte for byte, and it begins anew when, and
// only when, something changes.
#include "reference/scene.h"

#include "gpu/gpu_test.h"

#include "components/light_sphere.h"
#include "components/material.h"
#include "components/transform.h"
#include "lightformer/progressive/progressive.h"
#include "render/renderer.h"
#include "scene/world.h"

enum { WIDTH = 100, HEIGHT = 70, SAMPLES = 3 }; // four regions, three of them cut off

static const char *const names[] = {"unshadowed", "direct", "indirect"};

struct rig {
    struct scene scene;
    struct ng_gpu *gpu;
    struct ng_renderer *renderer;
    struct lf_progressive *progressive;
    struct ng_render_params frame;
};

static int begin(void **state)
{
    static struct rig r;
    r = (struct rig){.gpu = gpu_test_begin()};
    scene_load(&r.scene, 2, "content/unit/light_sphere.glb");
    scene_frame(&r.scene, 0);
    OK(ng_renderer_create(&(struct ng_renderer_params){.gpu = r.gpu, .jobs = r.scene.jobs}, &r.renderer));
    // Slices end at once, so that every one is a single region.
    struct lf_progressive_params params = {.jobs = r.scene.jobs, .samples = SAMPLES, .slice = 1e-9};
    OK(lf_progressive_create(&params, &r.progressive));
    OK(lf_progressive_join(r.progressive, ng_renderer_composer(r.renderer)));
    r.frame = (struct ng_render_params){.width = WIDTH,
                                        .height = HEIGHT,
                                        .method = "reference",
                                        .layers = names,
                                        .layer_count = NG_COUNT(names)};
    *state = &r;
    return 0;
}

static int end(void **state)
{
    struct rig *r = *state;
    lf_progressive_destroy(&r->progressive);
    ng_renderer_destroy(&r->renderer);
    gpu_test_end(r->gpu);
    scene_close(&r->scene);
    return 0;
}

// A frame of the world as it is now; as in a program, the snapshot is made anew for each.
static struct lf_progressive_stats draw(struct rig *r)
{
    struct ng_cmd *cmd;
    scene_frame(&r->scene, 0);
    r->frame.snapshot = r->scene.snapshot;
    OK(ng_frame_begin(r->gpu, &cmd));
    OK(ng_renderer_frame(r->renderer, &cmd, &r->frame));
    OK(ng_frame_end(r->gpu, &cmd));
    return lf_progressive_stats_of(r->progressive);
}

static void draw_to_the_end(struct rig *r)
{
    int frames = 0;
    while (!draw(r).resting)
        assert_true(++frames < 1000);
    assert_int_equal(lf_progressive_stats_of(r->progressive).samples, SAMPLES);
}

static void assert_is_the_reference(struct rig *r)
{
    struct lf_reference *reference;
    struct lf_reference_params params = {
        .width = r->frame.width, .height = r->frame.height, .jobs = r->scene.jobs};
    OK(lf_reference_create(&params, &reference));
    OK(lf_reference_begin(reference, r->scene.tracer));
    OK(lf_reference_run(reference, &(struct lf_reference_run_params){.samples = SAMPLES}));
    for (size_t i = 0; i < NG_COUNT(names); i++) {
        struct ng_layer got;
        struct lf_layer want;
        OK(ng_renderer_layer(r->renderer, names[i], &got));
        OK(lf_reference_layer(reference, names[i], &want));
        assert_memory_equal(got.pixels, want.pixels, (size_t)want.width * want.height * 3 * sizeof(float));
        free(want.pixels);
    }
    lf_reference_destroy(&reference);
}

static void slices_add_up_to_the_reference(void **state)
{
    struct rig *r = *state;
    assert_int_equal(draw(r).samples, 0);
    draw_to_the_end(r);
    assert_is_the_reference(r);
    // Four regions, three times each, and the preview's own rays.
    struct lf_progressive_stats stats = lf_progressive_stats_of(r->progressive);
    assert_true(stats.rays > (uint64_t)WIDTH * HEIGHT * SAMPLES);
    assert_int_equal(draw(r).rays, stats.rays); // it rests
}

static void a_preview_comes_first(void **state)
{
    struct rig *r = *state;
    struct ng_layer layer;
    draw(r);
    OK(ng_renderer_layer(r->renderer, "direct", &layer));
    int lit = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        lit += layer.pixels[i * 3] > 0;
    assert_true(lit > WIDTH * HEIGHT / 4);
}

// A material that someone gave to a thing; a light's surface has one of its own making.
static ng_entity some_material(struct rig *r)
{
    const struct ng_snapshot *s = r->scene.snapshot;
    for (uint32_t i = 0; i < s->material_count; i++)
        if (ng_world_get(r->scene.world, s->materials[i].entity, NG_MATERIAL))
            return s->materials[i].entity;
    fail_msg("no material in the scene");
    return (ng_entity){0};
}

static void move(struct rig *r, ng_entity e, int axis)
{
    struct ng_world *world = r->scene.world;
    struct ng_transform place = *(const struct ng_transform *)ng_world_get(world, e, NG_TRANSFORM);
    place.translation[axis] += 0.1f;
    OK(ng_world_set(world, e, NG_TRANSFORM, &place));
}

// The picture begins anew in the next frame, and ends as the reference of what there is now.
static void assert_begins_anew(struct rig *r)
{
    assert_int_equal(draw(r).samples, 0);
    draw_to_the_end(r);
    assert_is_the_reference(r);
}

static void what_changes_begins_anew(void **state)
{
    struct rig *r = *state;
    struct ng_world *world = r->scene.world;
    draw_to_the_end(r);

    ng_entity lamp = r->scene.snapshot->lights[0].entity;
    struct ng_light_sphere light =
        *(const struct ng_light_sphere *)ng_world_get(world, lamp, NG_LIGHT_SPHERE);
    light.radiance *= 2;
    OK(ng_world_set(world, lamp, NG_LIGHT_SPHERE, &light));
    assert_begins_anew(r);

    move(r, r->scene.snapshot->instances[0].entity, 1);
    assert_begins_anew(r);
    move(r, r->scene.snapshot->camera.entity, 0);
    assert_begins_anew(r);

    ng_entity surface = some_material(r);
    struct ng_material material = *(const struct ng_material *)ng_world_get(world, surface, NG_MATERIAL);
    material.emissive_strength = 1;
    material.emissive[0] += 1; // which no instance's version tells
    OK(ng_world_set(world, surface, NG_MATERIAL, &material));
    assert_begins_anew(r);

    r->frame.width = 65;
    r->frame.height = 1;
    assert_begins_anew(r);
}

static void another_method_in_between_loses_nothing(void **state)
{
    struct rig *r = *state;
    draw_to_the_end(r);
    uint64_t rays = lf_progressive_stats_of(r->progressive).rays;
    r->frame.method = "raster";
    r->frame.layer_count = 2; // it has no indirect light
    draw(r);
    r->frame.method = "reference";
    r->frame.layer_count = NG_COUNT(names);
    assert_int_equal(draw(r).rays, rays);
    assert_is_the_reference(r);
}

static void two_methods_share_a_frame(void **state)
{
    struct rig *r = *state;
    r->frame.shown =
        (struct ng_shown){.comparison = NG_COMPARE_SPLIT, .other_method = "raster", .divider = 0.5f};
    draw_to_the_end(r);
    assert_is_the_reference(r); // layers are of the frame's own method
    assert_true(ng_renderer_shows(r->renderer, 0) && ng_renderer_shows(r->renderer, 1));
    r->frame.shown.other_layer = "indirect";
    draw(r);
    assert_true(ng_renderer_shows(r->renderer, 0) && !ng_renderer_shows(r->renderer, 1));
}

// How much of a difference is seen: the mean of its bytes.
static double seen(struct rig *r, uint32_t cell)
{
    static const char *const display[] = {"display"};
    const uint8_t *rgba;
    uint32_t width, height;
    double sum = 0;
    r->frame.shown.cell = cell;
    r->frame.layers = display;
    r->frame.layer_count = 1;
    draw(r);
    OK(ng_renderer_display(r->renderer, &rgba, &width, &height));
    for (uint32_t i = 0; i < width * height * 4; i++)
        sum += i % 4 < 3 ? rgba[i] : 0;
    return sum / (3.0 * width * height);
}

// Noise vanishes from a difference of means; what differs stays. Cells are cut off at the picture's edges.
static void a_difference_of_means_has_less_noise(void **state)
{
    struct rig *r = *state;
    r->frame.shown = (struct ng_shown){
        .layer = "unshadowed", .comparison = NG_COMPARE_DIFFERENCE, .other_method = "raster"};
    draw_to_the_end(r);
    double pixels = seen(r, 1), means = seen(r, 16);
    print_message("difference seen: %.2f of pixels, %.2f of means\n", pixels, means);
    assert_true(means < 0.6 * pixels);
    assert_true(seen(r, 0) == pixels && seen(r, 1000) < means);
    r->frame.shown.other_layer = "emission"; // black
    assert_true(seen(r, 16) > 2 * means);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(slices_add_up_to_the_reference, begin, end),
        cmocka_unit_test_setup_teardown(a_preview_comes_first, begin, end),
        cmocka_unit_test_setup_teardown(what_changes_begins_anew, begin, end),
        cmocka_unit_test_setup_teardown(another_method_in_between_loses_nothing, begin, end),
        cmocka_unit_test_setup_teardown(two_methods_share_a_frame, begin, end),
        cmocka_unit_test_setup_teardown(a_difference_of_means_has_less_noise, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

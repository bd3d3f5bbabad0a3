// Variations: what they draw, what they refuse, and that a sample leaves no trace.
#include "test.h"

#include "asset/assets.h"
#include "asset/gltf.h"
#include "components/camera.h"
#include "components/components.h"
#include "components/light_point.h"
#include "components/light_rectangle.h"
#include "components/material.h"
#include "components/name.h"
#include "components/transform.h"
#include "components/variation.h"
#include "lightformer/dataset/sampler.h"
#include "lightformer/dataset/variations.h"
#include "lightformer/trace/tracer.h"
#include "render/scene_systems.h"
#include "render/snapshot.h"
#include "scene/history.h"
#include "scene/system.h"
#include "scene/world.h"

#include <math.h>

#define OK(call) assert_int_equal((call), NG_OK)

struct scene {
    struct ng_world *world;
    struct ng_assets *assets;
    ng_entity lamp, camera;
};

static ng_entity add_entity(struct ng_world *world, const char *name)
{
    struct ng_name text = {{0}};
    ng_entity e = ng_entity_create(world);
    snprintf(text.text, sizeof text.text, "%s", name);
    OK(ng_world_add(world, e, NG_NAME, &text));
    OK(ng_world_add(world, e, NG_TRANSFORM, NULL));
    return e;
}

static int begin(void **state)
{
    struct scene *s = calloc(1, sizeof *s);
    assert_non_null(s);
    OK(ng_world_create(NULL, &s->world));
    OK(ng_components_register(s->world));
    OK(ng_assets_create(&s->assets));
    OK(ng_scene_systems_add(s->world, s->assets, NULL));
    s->lamp = add_entity(s->world, "lamp");
    OK(ng_world_add(s->world, s->lamp, NG_LIGHT_RECTANGLE, NULL));
    s->camera = add_entity(s->world, "view");
    OK(ng_world_add(s->world, s->camera, NG_CAMERA, NULL));
    OK(ng_world_run(s->world, 0));
    *state = s;
    return 0;
}

static int end(void **state)
{
    struct scene *s = *state;
    ng_world_destroy(&s->world);
    ng_assets_destroy(&s->assets);
    free(s);
    return 0;
}

static ng_entity vary(struct scene *s, const char *field, uint32_t kind, ng_entity target, float min,
                      float max)
{
    ng_entity e = add_entity(s->world, "it");
    struct ng_variation v = {.kind = kind, .target = target};
    snprintf(v.field, sizeof v.field, "%s", field);
    for (int i = 0; i < 4; i++) {
        v.min[i] = min;
        v.max[i] = max;
    }
    OK(ng_world_add(s->world, e, NG_VARIATION, &v));
    return e;
}

static struct lf_variations *open(struct scene *s)
{
    struct lf_variations *v;
    OK(lf_variations_create(s->world, &v));
    return v;
}

static double apply(struct lf_variations *v, uint64_t seed)
{
    double time;
    OK(lf_variations_apply(v, &(struct lf_variations_apply_params){.seed = seed, .time = 3}, &time));
    return time;
}

// All values of a world, one after another.
static unsigned char *freeze(const struct ng_world *world, size_t *size)
{
    unsigned char *bytes = NULL;
    *size = 0;
    for (uint32_t index = 0; index < 4096; index++) {
        ng_entity e = ng_world_entity_at(world, index);
        for (ng_component c = 0; !ng_entity_is_null(e) && c < ng_world_component_count(world); c++) {
            const void *value = ng_world_get(world, e, c);
            size_t n = ng_world_component(world, c)->size;
            if (!value || !n)
                continue;
            bytes = realloc(bytes, *size + n);
            assert_non_null(bytes);
            memcpy(bytes + *size, value, n);
            *size += n;
        }
    }
    return bytes;
}

static void values_stay_in_their_range(void **state)
{
    struct scene *s = *state;
    vary(s, "light_rectangle.size", NG_VARIATION_RANGE, s->lamp, 0.5f, 2);
    vary(s, "light_rectangle.radiance", NG_VARIATION_LOG_RANGE, s->lamp, 1, 100);
    vary(s, "transform.translation", NG_VARIATION_OFFSET, s->lamp, -1, 1);
    vary(s, "light_rectangle.on", NG_VARIATION_RANGE, s->lamp, 0, 1);
    vary(s, "transform.rotation", NG_VARIATION_TURN, s->lamp, -3, 3);
    vary(s, "", NG_VARIATION_TIME, s->lamp, 2, 4);
    *(struct ng_transform *)ng_world_edit(s->world, s->lamp, NG_TRANSFORM) =
        (struct ng_transform){.translation = {10, 20, 30}, .rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}};
    struct lf_variations *v = open(s);
    assert_int_equal(lf_variations_count(v), 6);
    double logs = 0, times = 0;
    int on = 0, different = 0;
    float last = 0;
    enum { SAMPLES = 400 };
    for (uint64_t seed = 0; seed < SAMPLES; seed++) {
        double time = apply(v, seed);
        const struct ng_light_rectangle *l = ng_world_get(s->world, s->lamp, NG_LIGHT_RECTANGLE);
        const struct ng_transform *t = ng_world_get(s->world, s->lamp, NG_TRANSFORM);
        assert_true(l->size[0] >= 0.5f && l->size[0] <= 2 && l->size[1] >= 0.5f && l->size[1] <= 2);
        assert_true(l->radiance >= 1 && l->radiance <= 100 && time >= 2 && time <= 4);
        for (int k = 0; k < 3; k++)
            assert_true(fabsf(t->translation[k] - 10 * (float)(k + 1)) <= 1);
        const float *q = t->rotation;
        assert_true(fabsf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1) < 1e-5f);
        logs += log((double)l->radiance) / SAMPLES;
        times += time / SAMPLES;
        on += l->on;
        different += l->size[0] != last;
        last = l->size[0];
        OK(ng_world_undo(s->world));
    }
    assert_true(fabs(logs - log(10)) < 0.3); // the logarithm is uniform
    assert_true(fabs(times - 3) < 0.12);
    assert_in_range(on, SAMPLES * 2 / 5, SAMPLES * 3 / 5);
    assert_int_equal(different, SAMPLES);
    lf_variations_destroy(&v);
}

static void choices_are_all_taken(void **state)
{
    struct scene *s = *state;
    ng_entity e = vary(s, "light_rectangle.color", NG_VARIATION_CHOICES, s->lamp, 0, 0);
    struct ng_variation *edit = ng_world_edit(s->world, e, NG_VARIATION);
    edit->choice_count = 3;
    edit->choice_0[0] = 1;
    edit->choice_1[1] = 1;
    edit->choice_2[2] = 1;
    struct lf_variations *v = open(s);
    int taken[3] = {0};
    for (uint64_t seed = 0; seed < 60; seed++) {
        apply(v, seed);
        const struct ng_light_rectangle *l = ng_world_get(s->world, s->lamp, NG_LIGHT_RECTANGLE);
        assert_true(l->color[0] + l->color[1] + l->color[2] == 1);
        for (int k = 0; k < 3; k++)
            taken[k] += l->color[k] == 1;
        OK(ng_world_undo(s->world));
    }
    for (int k = 0; k < 3; k++)
        assert_in_range(taken[k], 8, 40);
    lf_variations_destroy(&v);
}

// A quarter turn about Y takes +X to -Z, whatever the rotation before.
static void a_turn_is_about_the_entitys_own_axes(void **state)
{
    struct scene *s = *state;
    ng_entity e = vary(s, "transform.rotation", NG_VARIATION_TURN, s->lamp, 0, 0);
    struct ng_variation *edit = ng_world_edit(s->world, e, NG_VARIATION);
    edit->min[1] = edit->max[1] = 1.57079632679f;
    const float half = sqrtf(0.5f);
    struct ng_transform *t = ng_world_edit(s->world, s->lamp, NG_TRANSFORM);
    memcpy(t->rotation, (const float[]){half, 0, 0, half}, sizeof t->rotation); // a quarter about X
    struct lf_variations *v = open(s);
    apply(v, 1);
    const float *q = ((const struct ng_transform *)ng_world_get(s->world, s->lamp, NG_TRANSFORM))->rotation;
    const float expected[4] = {0.5f, 0.5f, 0.5f, 0.5f}; // qx * qy
    for (int k = 0; k < 4; k++)
        assert_true(fabsf(q[k] - expected[k]) < 1e-6f);
    lf_variations_destroy(&v);
}

static ng_result refuse_all(void *user, double time, uint32_t candidate, const float eye[3],
                            const float forward[3], bool *good)
{
    NG_UNUSED(time);
    NG_UNUSED(candidate);
    NG_UNUSED(eye);
    assert_true(fabsf(forward[0] * forward[0] + forward[1] * forward[1] + forward[2] * forward[2] - 1) <
                1e-5f);
    *good = false;
    ++*(int *)user;
    return NG_OK;
}

static void cameras_look_from_box_to_box(void **state)
{
    struct scene *s = *state;
    ng_entity e = vary(s, "", NG_VARIATION_CAMERA, s->camera, 4, 5);
    struct ng_variation *edit = ng_world_edit(s->world, e, NG_VARIATION);
    memcpy(edit->look_max, (const float[]){0.5f, 0, 0.5f}, sizeof edit->look_max);
    struct lf_variations *v = open(s);
    for (uint64_t seed = 0; seed < 50; seed++) {
        apply(v, seed);
        const struct ng_transform *t = ng_world_get(s->world, s->camera, NG_TRANSFORM);
        const float *q = t->rotation, *p = t->translation;
        // Where the ray along -Z meets the plane y = 0.
        float z[3] = {-2 * (q[0] * q[2] + q[1] * q[3]), -2 * (q[1] * q[2] - q[0] * q[3]),
                      -1 + 2 * (q[0] * q[0] + q[1] * q[1])};
        float right_y = 2 * (q[0] * q[1] + q[2] * q[3]), at = -p[1] / z[1];
        assert_true(fabsf(right_y) < 1e-5f); // the picture is upright
        for (int k = 0; k < 3; k++)
            assert_true(p[k] >= 4 && p[k] <= 5);
        assert_true(at > 0 && p[0] + at * z[0] > -1e-4f && p[0] + at * z[0] < 0.5001f);
        assert_true(p[2] + at * z[2] > -1e-4f && p[2] + at * z[2] < 0.5001f);
        OK(ng_world_undo(s->world));
    }
    size_t before_size, after_size;
    OK(ng_world_run(s->world, 0));
    unsigned char *before = freeze(s->world, &before_size);
    struct test_log log;
    int tries = 0;
    test_log_begin(&log);
    assert_int_equal(
        lf_variations_apply(
            v, &(struct lf_variations_apply_params){.seed = 7, .judge = refuse_all, .user = &tries}, NULL),
        NG_ERROR_NOT_FOUND);
    test_log_end(&log);
    assert_int_equal(log.errors, 1);
    assert_non_null(strstr(log.text, "seed 7"));
    assert_int_equal(tries, 256);
    unsigned char *after = freeze(s->world, &after_size);
    assert_int_equal(before_size, after_size);
    assert_memory_equal(before, after, before_size);
    free(before);
    free(after);
    lf_variations_destroy(&v);
}

// ---- mistakes --------------------------------------------------------------------------------------------

static void refused(struct scene *s, ng_entity e, ng_result expected, const char *text)
{
    struct lf_variations *v;
    struct test_log log;
    test_log_begin(&log);
    ng_result result = lf_variations_create(s->world, &v);
    test_log_end(&log);
    if (result != expected || log.errors != 1 || !strstr(log.text, text) || !strstr(log.text, "\"it\""))
        fail_msg("expected %d and \"%s\", not %d and \"%s\"", expected, text, result, log.text);
    assert_null(v);
    if (!ng_entity_is_null(e))
        OK(ng_entity_destroy(s->world, e));
}

static void mistakes_are_named(void **state)
{
    struct scene *s = *state;
    const ng_entity none = {0};
    const uint32_t range = NG_VARIATION_RANGE;
    refused(s, vary(s, "light_rectangle.brightness", range, s->lamp, 0, 1), NG_ERROR_NOT_FOUND, "is unknown");
    refused(s, vary(s, "radiance", range, s->lamp, 0, 1), NG_ERROR_NOT_FOUND, "is unknown");
    refused(s, vary(s, "light_rectangle.radiance", range, s->lamp, 2, 1), NG_ERROR_FORMAT, "empty");
    refused(s, vary(s, "light_rectangle.radiance", range, s->lamp, -1, 1), NG_ERROR_FORMAT, "outside");
    refused(s, vary(s, "light_rectangle.radiance", NG_VARIATION_LOG_RANGE, s->lamp, 0, 1), NG_ERROR_FORMAT,
            "above 0");
    refused(s, vary(s, "light_rectangle.radiance", range, none, 0, 1), NG_ERROR_NOT_FOUND, "not set");
    refused(s, vary(s, "light_rectangle.radiance", range, s->camera, 0, 1), NG_ERROR_NOT_FOUND,
            "no component light_rectangle");
    refused(s, vary(s, "light_rectangle.texture", range, s->lamp, 0, 1), NG_ERROR_FORMAT, "cannot vary");
    refused(s, vary(s, "placement.matrix", range, s->lamp, 0, 1), NG_ERROR_FORMAT, "computed");
    refused(s, vary(s, "transform.rotation", range, s->lamp, 0, 1), NG_ERROR_FORMAT, "use \"turn\"");
    refused(s, vary(s, "transform.scale", NG_VARIATION_TURN, s->lamp, 0, 1), NG_ERROR_FORMAT, "turn");
    refused(s, vary(s, "light_rectangle.on", range, s->lamp, 0, 2), NG_ERROR_FORMAT, "whole numbers");
    refused(s, vary(s, "light_rectangle.color", NG_VARIATION_CHOICES, s->lamp, 0, 1), NG_ERROR_FORMAT,
            "no choices");
    refused(s, vary(s, "", NG_VARIATION_CAMERA, s->lamp, 0, 1), NG_ERROR_NOT_FOUND, "no component camera");
    refused(s, vary(s, "", NG_VARIATION_TIME, none, 1, 0), NG_ERROR_FORMAT, "empty");
    ng_entity first = vary(s, "light_rectangle.size", range, s->lamp, 1, 2);
    refused(s, vary(s, "light_rectangle.size", range, s->lamp, 1, 3), NG_ERROR_FORMAT, "already");
    OK(ng_entity_destroy(s->world, first));
    *(struct ng_transform *)ng_world_edit(s->world, s->lamp, NG_TRANSFORM) =
        (struct ng_transform){.translation = {1, 0, 0}, .rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}};
    OK(ng_world_set_parent(s->world, s->camera, s->lamp, none));
    refused(s, vary(s, "", NG_VARIATION_CAMERA, s->camera, 0, 1), NG_ERROR_FORMAT, "hangs on \"lamp\"");
    vary(s, "light_rectangle.size", NG_VARIATION_OFFSET, s->lamp, -9, -8);
    struct lf_variations *v = open(s);
    struct test_log log;
    test_log_begin(&log);
    assert_int_equal(lf_variations_apply(v, &(struct lf_variations_apply_params){.seed = 1}, NULL),
                     NG_ERROR_FORMAT);
    test_log_end(&log);
    assert_int_equal(log.errors, 1);
    assert_false(ng_world_in_transaction(s->world));
    lf_variations_destroy(&v);
}

// ---- the chess scene -------------------------------------------------------------------------------------

static void open_chess(struct scene *s)
{
    struct ng_gltf_scene scene;
    *s = (struct scene){0};
    OK(ng_world_create(NULL, &s->world));
    OK(ng_components_register(s->world));
    OK(ng_assets_create(&s->assets));
    OK(ng_scene_systems_add(s->world, s->assets, NULL));
    OK(ng_gltf_load("content/chess/chess.glb", s->world, s->assets, NULL, &scene));
}

static void close_chess(struct scene *s)
{
    ng_world_destroy(&s->world);
    ng_assets_destroy(&s->assets);
}

// Whatever was drawn before it, a sample is the same; and then the world is as it was.
static void a_seed_is_a_sample(void **state)
{
    NG_UNUSED(state);
    struct scene a, b;
    size_t size[4];
    unsigned char *frozen[4];
    double time[2];
    open_chess(&a);
    open_chess(&b);
    struct lf_variations *va = open(&a), *vb = open(&b);
    OK(ng_world_run(a.world, 0));
    frozen[0] = freeze(a.world, &size[0]);
    for (uint64_t seed = 0; seed < 5; seed++) {
        apply(va, seed);
        OK(ng_world_undo(a.world));
        OK(ng_world_run(a.world, 0));
    }
    frozen[1] = freeze(a.world, &size[1]);
    assert_int_equal(size[0], size[1]);
    assert_memory_equal(frozen[0], frozen[1], size[0]);
    time[0] = apply(va, 42);
    time[1] = apply(vb, 42);
    frozen[2] = freeze(a.world, &size[2]);
    frozen[3] = freeze(b.world, &size[3]);
    assert_true(time[0] == time[1]);
    assert_int_equal(size[2], size[3]);
    assert_memory_equal(frozen[2], frozen[3], size[2]);
    assert_memory_not_equal(frozen[0], frozen[2], size[0]);
    for (int i = 0; i < 4; i++)
        free(frozen[i]);
    lf_variations_destroy(&va);
    lf_variations_destroy(&vb);
    close_chess(&a);
    close_chess(&b);
}

static void what_a_clip_drives_cannot_vary(void **state)
{
    NG_UNUSED(state);
    struct scene s;
    struct test_log log;
    open_chess(&s);
    for (uint32_t i = 0; i < 4096; i++) {
        ng_entity e = ng_world_entity_at(s.world, i);
        if (ng_world_has(s.world, e, NG_LIGHT_RECTANGLE)) {
            vary(&s, "transform.translation", NG_VARIATION_RANGE, e, 0, 1);
            break;
        }
    }
    struct lf_variations *v = open(&s);
    test_log_begin(&log);
    assert_int_equal(lf_variations_apply(v, &(struct lf_variations_apply_params){.seed = 1}, NULL),
                     NG_ERROR_FORMAT);
    test_log_end(&log);
    assert_int_equal(log.errors, 1);
    assert_non_null(strstr(log.text, "animated"));
    lf_variations_destroy(&v);
    close_chess(&s);
}

// Every eye is in the room and outside of the pieces: what it sees all around are fronts, not too near.
static void cameras_are_never_inside_of_things(void **state)
{
    NG_UNUSED(state);
    struct scene s;
    struct lf_scene_sampler *sampler;
    open_chess(&s);
    OK(lf_scene_sampler_create(&(struct lf_scene_sampler_params){.world = s.world, .assets = s.assets},
                               &sampler));
    for (uint64_t seed = 100; seed < 112; seed++) {
        struct lf_sample sample;
        OK(lf_scene_sampler_begin(sampler, seed, &sample));
        const struct ng_snapshot_camera *camera = &sample.snapshot->camera;
        for (int i = 0; i < 200; i++) {
            float z = 1 - 2 * ((float)i + 0.5f) / 200, r = sqrtf(1 - z * z), angle = 2.39996f * (float)i;
            struct lf_ray ray = {.direction = {r * cosf(angle), r * sinf(angle), z}, .far = INFINITY};
            struct lf_hit hit;
            memcpy(ray.origin, camera->position, sizeof ray.origin);
            assert_true(lf_trace_closest(sample.tracer, &ray, LF_RAY_ALL, &hit)); // the room is closed
            bool lamp =
                sample.snapshot->instances[hit.instance].light != NG_NONE; // which are seen from behind
            assert_true(hit.front || lamp);
        }
        OK(lf_scene_sampler_end(sampler));
    }
    lf_scene_sampler_destroy(&sampler);
    close_chess(&s);
}

static void scenes_that_give_no_samples(void **state)
{
    struct scene *s = *state;
    struct lf_scene_sampler *sampler;
    struct lf_sample sample;
    struct test_log log;
    const struct lf_scene_sampler_params params = {.world = s->world, .assets = s->assets};
    test_log_begin(&log);
    assert_int_equal(lf_scene_sampler_create(&params, &sampler), NG_ERROR_NOT_FOUND);
    assert_non_null(strstr(log.text, "nothing varies"));
    vary(s, "transform.translation", NG_VARIATION_RANGE, s->camera, 0, 1);
    OK(ng_world_set_field(s->world, s->lamp, "light_rectangle.on", NG_FIELD_BOOL, &(bool){false}));
    OK(lf_scene_sampler_create(&params, &sampler));
    assert_int_equal(lf_scene_sampler_begin(sampler, 5, &sample), NG_ERROR_FORMAT);
    assert_non_null(strstr(log.text, "nothing gives light"));
    OK(ng_world_set_field(s->world, s->lamp, "light_rectangle.on", NG_FIELD_BOOL, &(bool){true}));
    ((struct ng_transform *)ng_world_edit(s->world, s->lamp, NG_TRANSFORM))->scale[0] = 0;
    assert_int_equal(lf_scene_sampler_begin(sampler, 5, &sample), NG_ERROR_FORMAT);
    assert_non_null(strstr(log.text, "\"lamp\" has no area"));
    lf_scene_sampler_destroy(&sampler);
    OK(ng_world_remove(s->world, s->camera, NG_CAMERA));
    assert_int_equal(lf_scene_sampler_create(&params, &sampler), NG_ERROR_NOT_FOUND);
    assert_non_null(strstr(log.text, "no camera"));
    test_log_end(&log);
    assert_int_equal(log.errors, 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(values_stay_in_their_range, begin, end),
        cmocka_unit_test_setup_teardown(choices_are_all_taken, begin, end),
        cmocka_unit_test_setup_teardown(a_turn_is_about_the_entitys_own_axes, begin, end),
        cmocka_unit_test_setup_teardown(cameras_look_from_box_to_box, begin, end),
        cmocka_unit_test_setup_teardown(mistakes_are_named, begin, end),
        cmocka_unit_test(a_seed_is_a_sample),
        cmocka_unit_test(what_a_clip_drives_cannot_vary),
        cmocka_unit_test(cameras_are_never_inside_of_things),
        cmocka_unit_test_setup_teardown(scenes_that_give_no_samples, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

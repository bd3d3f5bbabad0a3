// What a scene may throw at the method: no light and many, lights in walls, sizes, values that are no
// numbers; and what physics asks of the picture.
#include "neural_test.h"

#include "base/rng.h"
#include "components/light_point.h"
#include "components/material.h"
#include "components/transform.h"
#include "networks.h"
#include "scene/world.h"

#include <math.h>

static const char *const parts[PARTS] = {"unshadowed", "direct", "indirect"};

// Every value is a number and none is below zero.
static double check_layer(const struct room *r, struct method *m, const char *name)
{
    float *pixels = room_layer(r, m, name);
    double sum = 0;
    for (size_t i = 0; i < (size_t)r->width * r->height * 3; i++) {
        if (!isfinite(pixels[i]) || pixels[i] < 0)
            fail_msg("%s at (%zu, %zu) is %g", name, i / 3 % r->width, i / 3 / r->width, (double)pixels[i]);
        sum += (double)pixels[i];
    }
    free(pixels);
    return sum;
}

static double draw_and_check(struct room *r, struct method *m)
{
    double sum = 0;
    room_draw(r, m);
    for (int p = 0; p < PARTS; p++)
        sum += check_layer(r, m, parts[p]);
    return sum;
}

static void no_light_gives_black(void **state)
{
    NG_UNUSED(state);
    struct room r;
    struct method m;
    room_open(&r, 0);
    method_open(&r, NULL, &m);
    assert_true(draw_and_check(&r, &m) == 0);
    method_close(&m);
    room_close(&r);
}

// A network says something everywhere; where is no surface that is no light.
static void there_is_no_light_in_the_sky(void **state)
{
    NG_UNUSED(state);
    struct room r;
    struct method m;
    room_open(&r, PANEL | POINT);
    room_move(&r, r.scene.camera, 0, 0, 8);
    method_open(&r, NULL, &m);
    room_draw(&r, &m);
    for (int p = 0; p < PARTS; p++) {
        float *pixels = room_layer(&r, &m, parts[p]),
              *middle = pixels + (size_t)3 * (r.width * r.height + r.width) / 2;
        for (uint32_t i = 0; i < 3 * r.width; i++)
            assert_true(pixels[i] == 0);
        assert_true(middle[0] + middle[1] + middle[2] > 0);
        free(pixels);
    }
    method_close(&m);
    room_close(&r);
}

static void many_lights_are_drawn(void **state)
{
    NG_UNUSED(state);
    struct room r;
    struct method m;
    struct ng_rng rng = ng_rng_make(1, 1);
    room_open(&r, PANEL);
    r.width = r.height = 24;
    for (int i = 0; i < 199; i++)
        room_add_point(&r,
                       (const float[3]){ng_rng_range(&rng, -1.9f, 1.9f), ng_rng_range(&rng, -1.9f, 1.9f),
                                        ng_rng_range(&rng, -1.9f, 1.9f)},
                       0.1f);
    method_open(&r, NULL, &m);
    assert_true(draw_and_check(&r, &m) > 0);
    method_close(&m);
    room_close(&r);
}

// Directly in the plane of a wall, inside of the ball, far outside: pictures, whatever they show.
static void lights_may_be_anywhere(void **state)
{
    NG_UNUSED(state);
    static const float places[][3] = {{0, -2, 0}, {0.7f, -1.2f, 0}, {900, 0, 0}, {0, 0, 5}};
    struct room r;
    struct method m;
    room_open(&r, 0);
    method_open(&r, NULL, &m);
    ng_entity light = room_add_point(&r, places[0], 5);
    for (size_t i = 0; i < NG_COUNT(places); i++) {
        struct ng_transform *t = ng_world_edit(r.scene.world, light, NG_TRANSFORM);
        memcpy(t->translation, places[i], sizeof t->translation);
        draw_and_check(&r, &m);
    }
    method_close(&m);
    room_close(&r);
}

static void sizes_may_be_odd(void **state)
{
    NG_UNUSED(state);
    static const uint32_t sizes[][2] = {{1, 1}, {17, 3}, {3, 17}, {2, 1}, {33, 31}};
    struct room r;
    struct method m;
    room_open(&r, POINT | PANEL);
    method_open(&r, NULL, &m);
    for (size_t i = 0; i < NG_COUNT(sizes); i++) {
        r.width = sizes[i][0];
        r.height = sizes[i][1];
        assert_true(draw_and_check(&r, &m) > 0);
    }
    method_close(&m);
    room_close(&r);
}

// Refused before anything is allocated, in one line, as often as it is tried.
static void what_does_not_fit_into_memory_is_refused(void **state)
{
    NG_UNUSED(state);
    struct room r;
    struct method m;
    struct test_log log;
    room_open(&r, POINT | PANEL);
    method_open(&r, &(struct lf_neural_params){.memory_limit = 8000000}, &m);
    r.width = 400, r.height = 320;
    scene_frame(&r.scene, 0);
    test_log_begin(&log);
    assert_int_equal(room_draw_again(&r, &m), NG_ERROR_MEMORY);
    assert_int_equal(room_draw_again(&r, &m), NG_ERROR_MEMORY);
    test_log_end(&log);
    assert_int_equal(log.errors, 1);
    assert_non_null(strstr(log.text, "400x320 pixels and 2 lights need"));
    r.width = r.height = 8; // and then goes on
    assert_true(draw_and_check(&r, &m) > 0);
    method_close(&m);
    room_close(&r);
}

static void materials_may_hold_anything(void **state)
{
    NG_UNUSED(state);
    struct room r;
    struct method m;
    room_open(&r, POINT | PANEL);
    method_open(&r, NULL, &m);
    const float bad[] = {NAN, INFINITY, 1e30f};
    for (size_t i = 0; i < NG_COUNT(bad); i++) {
        struct ng_material *material = ng_world_edit(r.scene.world, r.red, NG_MATERIAL);
        material->base_color[0] = material->roughness = bad[i];
        draw_and_check(&r, &m);
    }
    method_close(&m);
    room_close(&r);
}

// A processor without vector instructions draws the same picture.
static void plain_kernels_draw_the_same(void **state)
{
    NG_UNUSED(state);
    struct room r;
    struct method fast, plain;
    room_open(&r, POINT | PANEL);
    method_open(&r, NULL, &fast);
    method_open(&r, &(struct lf_neural_params){.kernel = LF_KERNEL_PLAIN}, &plain);
    room_draw(&r, &fast);
    OK(room_draw_again(&r, &plain));
    for (int p = 0; p < PARTS; p++) {
        float *a = room_layer(&r, &fast, parts[p]), *b = room_layer(&r, &plain, parts[p]);
        double error = 0, sum = 0;
        for (size_t i = 0; i < (size_t)r.width * r.height * 3; i++) {
            error += pow((double)a[i] - (double)b[i], 2);
            sum += pow((double)b[i], 2);
        }
        assert_true(error < 1e-4 * sum); // bf16 has three digits
        free(a);
        free(b);
    }
    method_close(&plain);
    method_close(&fast);
    room_close(&r);
}

static void weights_that_do_not_fit_are_refused(void **state)
{
    NG_UNUSED(state);
    struct lf_neural *neural;
    struct test_log log;
    test_log_begin(&log);
    assert_int_equal(
        lf_neural_create(&(struct lf_neural_params){.weights = "content/chess/chess.glb"}, &neural),
        NG_ERROR_FORMAT);
    assert_int_equal(lf_neural_create(&(struct lf_neural_params){.weights = "nowhere.safetensors"}, &neural),
                     NG_ERROR_NOT_FOUND);
    test_log_end(&log);
    assert_null(neural);
    assert_int_equal(log.errors, 2);
}

// Finite weights, products of which are not: light that is a number, and one line however often it is drawn.
static void weights_that_overflow_are_said(void **state)
{
    NG_UNUSED(state);
    struct room r;
    struct method m;
    struct test_log log;
    room_open(&r, POINT | PANEL);
    network_write_overflowing(r.weights);
    method_open(&r, NULL, &m);
    test_log_begin(&log);
    for (int i = 0; i < 2; i++) {
        draw_and_check(&r, &m);
        room_move(&r, r.scene.camera, 0.1f, 0, 0);
    }
    test_log_end(&log);
    assert_int_equal(log.warnings, 1);
    assert_non_null(strstr(log.text, "not finite"));
    assert_true(check_layer(&r, &m, "unshadowed") > 0); // not the network's
    method_close(&m);
    room_close(&r);
}

static void weights_are_found_beside_their_scene(void **state)
{
    NG_UNUSED(state);
    char scene[256], weights[256], found[256];
    test_path(scene, sizeof scene, "some.room.glb");
    test_path(weights, sizeof weights, "some.room.weights.safetensors");
    remove(weights);
    assert_false(lf_neural_find_weights(scene, found, sizeof found));
    network_write_physics(weights);
    assert_true(lf_neural_find_weights(scene, found, sizeof found));
    assert_string_equal(found, weights);
    assert_false(lf_neural_find_weights(scene, found, 10));
    remove(weights);
}

// ---- what physics asks -----------------------------------------------------------------------------------

struct pair {
    struct room room;
    struct method a, b;
};

static void pair_open(struct pair *p, unsigned lights)
{
    room_open(&p->room, lights);
    method_open(&p->room, NULL, &p->a);
    method_open(&p->room, NULL, &p->b);
    room_draw(&p->room, &p->a);
}

static void pair_close(struct pair *p)
{
    method_close(&p->a);
    method_close(&p->b);
    room_close(&p->room);
}

// Draws the scene anew: the picture is `scale` times the one before, to 1e-3.
static void expect_scaled(struct pair *p, double scale)
{
    room_draw(&p->room, &p->b);
    for (int i = 0; i < PARTS; i++) {
        float *a = room_layer(&p->room, &p->a, parts[i]), *b = room_layer(&p->room, &p->b, parts[i]);
        double error = 0, sum = 0;
        for (size_t k = 0; k < (size_t)p->room.width * p->room.height * 3; k++) {
            error += fabs((double)a[k] * scale - (double)b[k]);
            sum += (double)a[k] * scale;
        }
        assert_true(sum > 0);
        assert_true(error < 1e-3 * sum);
        free(a);
        free(b);
    }
}

static void scaling_all_lights_scales_the_picture(void **state)
{
    NG_UNUSED(state);
    struct pair p;
    pair_open(&p, POINT | PANEL);
    room_set(&p.room, p.room.point, "light_point.intensity", 6 * 7.5f);
    room_set(&p.room, p.room.panel, "light_rectangle.radiance", 9 * 7.5f);
    expect_scaled(&p, 7.5);
    pair_close(&p);
}

static void a_light_without_power_changes_nothing(void **state)
{
    NG_UNUSED(state);
    struct pair p;
    pair_open(&p, POINT | PANEL);
    room_add_point(&p.room, (const float[3]){1, 1, 1}, 0);
    expect_scaled(&p, 1);
    pair_close(&p);
}

static void two_halves_equal_one(void **state)
{
    NG_UNUSED(state);
    struct pair p;
    const float place[3] = {0.4f, 0.3f, 0.9f}; // of the room's own point light, whose power is 6
    pair_open(&p, POINT | PANEL);
    room_set(&p.room, p.room.point, "light_point.intensity", 3);
    room_add_point(&p.room, place, 3);
    expect_scaled(&p, 1);
    pair_close(&p);
}

// The order of lights is that of their entities: the first one comes back as the last.
static void the_order_of_lights_does_not_matter(void **state)
{
    NG_UNUSED(state);
    struct pair p;
    const float place[3] = {0.4f, 0.3f, 0.9f};
    pair_open(&p, POINT | PANEL);
    ng_entity again = room_add_point(&p.room, place, 6);
    OK(ng_entity_destroy(p.room.scene.world, p.room.point));
    p.room.point = again;
    expect_scaled(&p, 1);
    pair_close(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_light_gives_black),
        cmocka_unit_test(there_is_no_light_in_the_sky),
        cmocka_unit_test(many_lights_are_drawn),
        cmocka_unit_test(lights_may_be_anywhere),
        cmocka_unit_test(sizes_may_be_odd),
        cmocka_unit_test(what_does_not_fit_into_memory_is_refused),
        cmocka_unit_test(materials_may_hold_anything),
        cmocka_unit_test(plain_kernels_draw_the_same),
        cmocka_unit_test(weights_that_do_not_fit_are_refused),
        cmocka_unit_test(weights_that_overflow_are_said),
        cmocka_unit_test(weights_are_found_beside_their_scene),
        cmocka_unit_test(scaling_all_lights_scales_the_picture),
        cmocka_unit_test(a_light_without_power_changes_nothing),
        cmocka_unit_test(two_halves_equal_one),
        cmocka_unit_test(the_order_of_lights_does_not_matter),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

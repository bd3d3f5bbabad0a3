// What must not change what is encoded: threads, power, size; and what it must not break at.
#include "picture.h"

#include "components/light_point.h"
#include "components/light_rectangle.h"
#include "components/scene_scale.h"
#include "components/transform.h"
#include "scene/world.h"

#include <math.h>

static const float grey[3] = {0.5f, 0.5f, 0.5f};

static uint64_t room_hash(uint32_t threads)
{
    struct scene s;
    struct picture p = {0};
    picture_room(&s, threads);
    scene_frame(&s, 0);
    picture_encode(&p, &s, 70, 50);
    uint64_t hash = picture_hash(&p, false);
    picture_close(&p);
    scene_close(&s);
    return hash;
}

static void threads_do_not_matter(void **state)
{
    NG_UNUSED(state);
    assert_true(room_hash(1) == room_hash(3));
}

// Brightness, on and off change shares, and nothing else by a bit.
static void power_does_not_matter(void **state)
{
    NG_UNUSED(state);
    struct scene s;
    struct picture p = {0};
    scene_open(&s, 2);
    ng_entity material = scene_material(&s, grey, 0, 0.2f);
    scene_quad(&s, (const float[3]){-3, -1, 3}, (const float[3]){6, 0, 0}, (const float[3]){0, 0, -6},
               material);
    ng_entity lamps[] = {picture_point(&s, 2, (const float[3]){-1, 1, 1}),
                         picture_panel(&s, 3, (const float[3]){0.7f, 1.4f, 0})};
    scene_frame(&s, 0);
    picture_encode(&p, &s, 40, 30);
    uint64_t hash = picture_hash(&p, true), all = picture_hash(&p, false);
    float share[2] = {*lf_light_clues_values(p.light[0])->of[LF_INPUT_LIGHT_SHARE],
                      *lf_light_clues_values(p.light[1])->of[LF_INPUT_LIGHT_SHARE]};
    NEAR(share[0] + share[1], 1, 1e-6);
    ((struct ng_light_point *)ng_world_edit(s.world, lamps[0], NG_LIGHT_POINT))->intensity = 2 * 7.3f;
    scene_frame(&s, 1);
    picture_encode(&p, &s, 40, 30);
    assert_true(picture_hash(&p, true) == hash && picture_hash(&p, false) != all);
    NEAR(*lf_light_clues_values(p.light[0])->of[LF_INPUT_LIGHT_SHARE],
         7.3f * share[0] / (7.3f * share[0] + share[1]), 1e-5);
    ((struct ng_light_rectangle *)ng_world_edit(s.world, lamps[1], NG_LIGHT_RECTANGLE))->on = false;
    scene_frame(&s, 2);
    picture_encode(&p, &s, 40, 30);
    assert_true(picture_hash(&p, true) == hash);
    assert_true(*lf_light_clues_values(p.light[1])->of[LF_INPUT_LIGHT_SHARE] == 0);
    ((struct ng_light_point *)ng_world_edit(s.world, lamps[0], NG_LIGHT_POINT))->on = false;
    scene_frame(&s, 3);
    lf_encode_powers(s.snapshot, p.pixels, p.light, 2); // alone, without encoding again
    assert_true(picture_hash(&p, true) == hash);
    assert_true(*lf_pixel_clues_values(p.pixels)->of[LF_INPUT_FRAME_RADIANCE] == 0);
    assert_true(*lf_light_clues_values(p.light[0])->of[LF_INPUT_LIGHT_SHARE] == 0);
    picture_close(&p);
    scene_close(&s);
}

// The room as open_room has it, `scale` times as large.
static void encode_scaled(float scale, struct scene *s, struct picture *p)
{
    const float k = scale;
    scene_open(s, 2);
    ng_entity smooth = scene_material(s, grey, 0, 0.15f);
    ((struct ng_scene_scale *)ng_world_edit(s->world, s->scale, NG_SCENE_SCALE))->radius = 3 * k;
    scene_quad(s, (const float[3]){-3 * k, -k, 3 * k}, (const float[3]){6 * k, 0, 0},
               (const float[3]){0, 0, -6 * k}, smooth);
    scene_sphere(s, (const float[3]){0.2f * k, -0.4f * k, 0}, 0.6f * k, false, smooth);
    struct ng_light_rectangle light = {
        .on = true, .color = {1, 1, 1}, .radiance = 2, .size = {0.6f * k, 0.4f * k}};
    scene_light(s, NG_LIGHT_RECTANGLE, &light, (const float[3]){0.7f * k, 1.4f * k, 0}, scene_down);
    ((struct ng_transform *)ng_world_edit(s->world, s->camera, NG_TRANSFORM))->translation[2] = 5 * k;
    scene_frame(s, 0);
    picture_encode(p, s, 32, 32);
}

static void size_does_not_matter(void **state)
{
    NG_UNUSED(state);
    static const enum lf_net_input compared[] = {LF_INPUT_VIEW_DISTANCE, LF_INPUT_VIEW_DIFFUSE,
                                                 LF_INPUT_VIEW_GLOSSY, LF_INPUT_VIEW_BOUNCE,
                                                 LF_INPUT_VIEW_MIRROR};
    struct scene a, b;
    struct picture p = {0}, q = {0};
    encode_scaled(1, &a, &p);
    encode_scaled(8, &b, &q);
    float ratio = b.snapshot->scene_radius / a.snapshot->scene_radius;
    if (fabsf(ratio - 8) > 1e-3f)
        fail_msg("the scene is %g times as large", (double)ratio);
    for (size_t n = 0; n < NG_COUNT(compared); n++) {
        double difference = 0, size = 0;
        for (size_t i = 0; i < 32 * 32; i++) {
            double x = (double)picture_view(&p, 0, compared[n], 0)[i],
                   y = (double)picture_view(&q, 0, compared[n], 0)[i];
            difference += fabs(x - y);
            size += fabs(x);
        }
        assert_true(size > 0);
        if (!(difference < 1e-3 * size))
            fail_msg("input %d changes by %g", compared[n], difference / size);
    }
    picture_close(&p);
    picture_close(&q);
    scene_close(&a);
    scene_close(&b);
}

// What a program does not read is not there; what it reads is as always.
static void unread_inputs_are_left_out(void **state)
{
    NG_UNUSED(state);
    struct scene s;
    struct picture p = {0}, q = {0};
    picture_room(&s, 1);
    scene_frame(&s, 0);
    picture_encode(&p, &s, 20, 20);
    picture_encode_with(&q, &s, 20, 20,
                        UINT64_C(1) << LF_INPUT_VIEW_DIFFUSE | UINT64_C(1) << LF_INPUT_VIEW_BOUNCE, NULL);
    const struct lf_net_values *few = lf_light_clues_values(q.light[1]);
    assert_null(few->of[LF_INPUT_VIEW_OCCLUDER]);
    assert_null(few->of[LF_INPUT_VIEW_MIRROR]);
    assert_null(lf_pixel_clues_values(q.pixels)->of[LF_INPUT_PIXEL_MIRROR]);
    for (uint32_t c = 0; c < 3; c++) {
        assert_memory_equal(picture_view(&p, 1, LF_INPUT_VIEW_DIFFUSE, c),
                            picture_view(&q, 1, LF_INPUT_VIEW_DIFFUSE, c), 400 * sizeof(float));
        assert_memory_equal(picture_view(&p, 1, LF_INPUT_VIEW_BOUNCE, c),
                            picture_view(&q, 1, LF_INPUT_VIEW_BOUNCE, c), 400 * sizeof(float));
    }
    picture_close(&p);
    picture_close(&q);
    scene_close(&s);
}

// Odd sizes, no light, nothing to see, a light in a wall, a black light, absurd numbers: finite values
// throughout (picture_hash looks).
static void odd_pictures(void **state)
{
    NG_UNUSED(state);
    static const uint32_t sizes[][2] = {{1, 1}, {17, 3}, {3, 17}, {33, 1}};
    struct scene s;
    struct picture p = {0};
    picture_room(&s, 2);
    picture_panel(&s, 1, (const float[3]){0, 1, -2});       // in the wall
    picture_point(&s, 1, (const float[3]){0.2f, -0.4f, 0}); // in the ball
    picture_point(&s, 0, (const float[3]){0, 0, 1});        // of no power
    picture_point(&s, 1, (const float[3]){0, 0, 5});        // in the eye
    scene_frame(&s, 0);
    for (size_t i = 0; i < NG_COUNT(sizes); i++) {
        picture_encode(&p, &s, sizes[i][0], sizes[i][1]);
        picture_hash(&p, false);
    }
    picture_encode(&p, &s, 48, 48);
    picture_hash(&p, false);
    picture_close(&p);
    scene_close(&s);

    p = (struct picture){0};
    scene_open(&s, 1);
    scene_frame(&s, 0);
    picture_encode(&p, &s, 5, 4); // an empty world
    picture_hash(&p, false);
    assert_true(*lf_pixel_clues_values(p.pixels)->of[LF_INPUT_FRAME_RADIANCE] == 0);
    picture_point(&s, 1, (const float[3]){0, 0, 0});
    scene_frame(&s, 1);
    picture_encode(&p, &s, 5, 4); // a light and nothing that it falls on
    picture_hash(&p, false);
    assert_int_equal(lf_light_clues_texels(p.light[0]), 0);
    picture_close(&p);
    scene_close(&s);
}

// A G-buffer of numbers that are none.
static void bad_numbers_end_at_the_door(void **state)
{
    NG_UNUSED(state);
    enum { SIZE = 16 };
    static const uint16_t bad[] = {0x7e00, 0x7c00, 0xfc00};
    struct scene s;
    struct picture p = {0};
    picture_room(&s, 1);
    scene_frame(&s, 0);
    picture_encode(&p, &s, SIZE, SIZE);
    for (size_t i = 0; i < SIZE * SIZE; i++) {
        if (i % 5 == 0)
            p.position[4 * i + i % 3] = i % 2 ? NAN : INFINITY;
        uint16_t *halfs[] = {p.normal, p.diffuse, p.specular};
        halfs[i % 3][4 * i + i % 4] = bad[i % NG_COUNT(bad)];
    }
    struct lf_encode_scene scene = {.tracer = s.tracer, .jobs = s.jobs};
    OK(lf_encode_pixels(&scene,
                        &(struct lf_encode_pixels_params){
                            .gbuffer = {p.position, p.normal, p.diffuse, p.specular, p.emission},
                            .width = SIZE,
                            .height = SIZE},
                        p.pixels));
    for (uint32_t i = 0; i < p.lights; i++)
        OK(lf_encode_view(&scene, p.pixels, p.light[i]));
    picture_hash(&p, false);
    picture_close(&p);
    scene_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_do_not_matter), cmocka_unit_test(power_does_not_matter),
        cmocka_unit_test(size_does_not_matter),  cmocka_unit_test(unread_inputs_are_left_out),
        cmocka_unit_test(odd_pictures),          cmocka_unit_test(bad_numbers_end_at_the_door),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// What must not change what is encoded: threads, power, size; and what it must not break at.
#include "picture.h"

#include "components/light_point.h"
#include "components/light_rectangle.h"
#include "components/scene_scale.h"
#include "components/transform.h"
#include "scene/query.h"
#include "scene/world.h"

#include <cglm/cglm.h>
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
    assert_true(share[0] > 0 && share[1] > 0);
    ((struct ng_light_point *)ng_world_edit(s.world, lamps[0], NG_LIGHT_POINT))->intensity = 2 * 7.3f;
    scene_frame(&s, 1);
    picture_encode(&p, &s, 40, 30);
    assert_true(picture_hash(&p, true) == hash && picture_hash(&p, false) != all);
    NEAR(*lf_light_clues_values(p.light[0])->of[LF_INPUT_LIGHT_SHARE] /
             *lf_light_clues_values(p.light[1])->of[LF_INPUT_LIGHT_SHARE] * share[1] / share[0],
         7.3f, 1e-5);
    ((struct ng_light_rectangle *)ng_world_edit(s.world, lamps[1], NG_LIGHT_RECTANGLE))->on = false;
    scene_frame(&s, 2);
    picture_encode(&p, &s, 40, 30);
    assert_true(picture_hash(&p, true) == hash);
    assert_true(*lf_light_clues_values(p.light[1])->of[LF_INPUT_LIGHT_SHARE] == 0);
    ((struct ng_light_point *)ng_world_edit(s.world, lamps[0], NG_LIGHT_POINT))->on = false;
    scene_frame(&s, 3);
    lf_clues_set_powers(s.snapshot, p.pixels, p.light, 2); // alone, without encoding again
    OK(lf_clues_arriving(&(struct lf_clues_scene){.tracer = s.tracer, .jobs = s.jobs}, p.pixels, p.light, 2));
    assert_true(picture_hash(&p, true) == hash);
    assert_true(*lf_pixel_clues_values(p.pixels)->of[LF_INPUT_FRAME_RADIANCE] == 0);
    assert_true(*lf_light_clues_values(p.light[0])->of[LF_INPUT_LIGHT_SHARE] == 0);
    picture_close(&p);
    scene_close(&s);
}

// ---- where a scene lies, and how large it is -------------------------------------------------------------

// Scales the whole scene and moves it; what lights without extent send grows as what the others send.
static void place(struct scene *s, float scale, const float move[3])
{
    struct ng_query *query;
    const struct ng_query_desc desc = {.terms = {NG_WRITE(NG_TRANSFORM), NG_WRITE_OPTIONAL(NG_LIGHT_POINT)},
                                       .term_count = 2};
    OK(ng_query_create(s->world, &desc, &query));
    ng_query_each (it, query) {
        struct ng_transform *t = it.columns[0];
        struct ng_light_point *point = it.columns[1];
        for (uint32_t i = 0; i < it.count; i++) {
            for (int c = 0; c < 3; c++) {
                t[i].translation[c] = t[i].translation[c] * scale + move[c];
                t[i].scale[c] *= scale;
            }
            if (point)
                point[i].intensity *= scale * scale;
        }
        ng_query_mark_all(&it, 0);
    }
    ng_query_destroy(&query);
    struct ng_scene_scale *size = ng_world_edit(s->world, s->scale, NG_SCENE_SCALE);
    size->radius *= scale;
    memcpy(size->center, move, sizeof size->center);
}

enum { SIDE = 64 };

// Two pictures of a scene: as it is, and placed elsewhere.
struct pair {
    struct scene scene[2];
    struct picture picture[2];
};

static void pair_open(struct pair *p, void (*build)(struct scene *), float scale, const float move[3])
{
    struct test_log log;
    *p = (struct pair){0};
    for (int i = 0; i < 2; i++) {
        build(&p->scene[i]);
        if (i)
            place(&p->scene[i], scale, move);
        test_log_begin(&log); // may warn of what emits and is no light
        scene_frame(&p->scene[i], 0);
        test_log_end(&log);
        picture_encode(&p->picture[i], &p->scene[i], SIDE, SIDE);
    }
    float ratio = p->scene[1].snapshot->scene_radius / p->scene[0].snapshot->scene_radius;
    if (fabsf(ratio / scale - 1) > 1e-3f)
        fail_msg("the scene is %g times as large", (double)ratio);
}

static void pair_close(struct pair *p)
{
    for (int i = 0; i < 2; i++) {
        picture_close(&p->picture[i]);
        scene_close(&p->scene[i]);
    }
}

// Whether there is anything but zeros.
static bool expect_same(enum lf_net_input input, const float *a, const float *b, size_t count, double bound)
{
    double difference = 0, size = 0;
    for (size_t i = 0; i < count; i++) {
        difference += fabs((double)a[i] - (double)b[i]);
        size += fabs((double)a[i]);
    }
    if (!(difference <= bound * size))
        fail_msg("%s changes by %g", lf_net_inputs[input].name, difference / size);
    return size > 0;
}

// Bounds of `glossy`, and of all else.
struct bounds {
    double glossy, other;
};

// Returns the set of inputs that hold anything.
static uint64_t expect_same_values(const struct lf_net_values *a, const struct lf_net_values *b,
                                   const size_t counts[], const struct bounds *bounds)
{
    uint64_t set = 0;
    for (int i = 0; i < LF_INPUT_COUNT; i++) {
        size_t count = lf_net_inputs[i].channels * counts[lf_net_inputs[i].domain];
        double bound = i == LF_INPUT_VIEW_GLOSSY ? bounds->glossy : bounds->other;
        assert_true(!a->of[i] == !b->of[i]);
        set |= (uint64_t)(a->of[i] && expect_same((enum lf_net_input)i, a->of[i], b->of[i], count, bound))
               << i;
    }
    return set;
}

// A room with something to see for every input. No ray runs exactly along an edge: whether it meets the
// surface is for rounding to say.
static void build_room(struct scene *s)
{
    picture_dark_room(s, 2);
    scene_sphere(s, (const float[3]){-1, -0.5f, 0.3f}, 0.5f, false, scene_material(s, grey, 1, 0.2f));
    scene_quad(s, (const float[3]){-2, -1, -1}, (const float[3]){0.5f, 0, 0}, (const float[3]){0, 1, 0},
               scene_glow(s, (const float[3]){1, 2, 3}));
    picture_panel(s, 3, (const float[3]){0.71f, 1.42f, 0.03f});
    picture_point(s, 2, (const float[3]){-1.04f, 1.13f, 0.92f});
}

static void expect_same_pictures(const struct pair *p, const struct bounds *bounds)
{
    const struct picture *a = &p->picture[0], *b = &p->picture[1];
    size_t counts[] = {1, 1, 0, 0, SIDE * SIDE, SIDE * SIDE};
    uint64_t set = expect_same_values(lf_pixel_clues_values(a->pixels), lf_pixel_clues_values(b->pixels),
                                      counts, bounds);
    for (uint32_t i = 0; i < a->lights; i++) {
        counts[LF_DOMAIN_VPL] = lf_light_clues_vpls(a->light[i]);
        counts[LF_DOMAIN_TEXEL] = lf_light_clues_texels(a->light[i]);
        assert_int_equal(lf_light_clues_vpls(b->light[i]), counts[LF_DOMAIN_VPL]);
        assert_int_equal(lf_light_clues_texels(b->light[i]), counts[LF_DOMAIN_TEXEL]);
        set |= expect_same_values(lf_light_clues_values(a->light[i]), lf_light_clues_values(b->light[i]),
                                  counts, bounds);
    }
    assert_true(set == (UINT64_C(1) << LF_INPUT_COUNT) - 1); // there was something to compare
}

// Far from the origin of a small scene normals, which are halfs, round another way here and there, and a
// point light's highlights are sharp.
static void place_does_not_matter(void **state)
{
    NG_UNUSED(state);
    static const struct {
        float scale, move[3];
        struct bounds bounds;
    } places[] = {{3, {0}, {1e-3, 1e-3}},
                  {0.1f, {0}, {1e-3, 1e-3}},
                  {1, {10, 5, -20}, {1e-3, 1e-3}},
                  {0.25f, {10, 5, -20}, {4e-3, 1e-3}}};
    for (size_t i = 0; i < NG_COUNT(places); i++) {
        struct pair p;
        pair_open(&p, build_room, places[i].scale, places[i].move);
        expect_same_pictures(&p, &places[i].bounds);
        pair_close(&p);
    }
}

// A lamp close above a floor, and a metal that shows them.
static void build_low_lamp(struct scene *s)
{
    scene_open(s, 2);
    scene_quad(s, (const float[3]){-3, -1, 3}, (const float[3]){6, 0, 0}, (const float[3]){0, 0, -6},
               scene_material(s, grey, 0, 0.15f));
    scene_quad(s, (const float[3]){-2, -1, -1}, (const float[3]){4, 0, 0}, (const float[3]){0, 2, 0},
               scene_material(s, grey, 1, 0.1f));
    picture_panel(s, 3, (const float[3]){0.1f, -0.7f, 0.2f});
}

// A kilometre out, rays start so far off the floor that less than the way to the lamp is left; the lamp
// itself is not in their way.
static void a_far_lamp_does_not_shadow_itself(void **state)
{
    NG_UNUSED(state);
    static const enum lf_net_input inputs[] = {LF_INPUT_VIEW_VISIBILITY_DIFFUSE,
                                               LF_INPUT_VIEW_VISIBILITY_SPECULAR};
    static const enum lf_net_input sums[] = {LF_INPUT_PIXEL_REFLECTED, LF_INPUT_PIXEL_GATHERED};
    struct pair p;
    pair_open(&p, build_low_lamp, 1, (const float[3]){1000, 0, 0});
    for (size_t i = 0; i < NG_COUNT(inputs); i++)
        assert_true(expect_same(inputs[i], picture_view(&p.picture[0], 0, inputs[i], 0),
                                picture_view(&p.picture[1], 0, inputs[i], 0),
                                (size_t)SIDE * SIDE * lf_net_inputs[inputs[i]].channels, 0.01));
    for (size_t i = 0; i < NG_COUNT(sums); i++)
        assert_true(expect_same(sums[i], picture_pixels(&p.picture[0], sums[i], 0),
                                picture_pixels(&p.picture[1], sums[i], 0), (size_t)SIDE * SIDE * 3, 0.01));
    pair_close(&p);
}

// What the network of the family `lean` gets: radiances in the picture's unit, and distances in those to the
// eye.
static const enum lf_net_input lean_pixels[] = {
    LF_INPUT_FRAME_RADIANCE,          LF_INPUT_PIXEL_REFLECTION_NEARNESS, LF_INPUT_PIXEL_REFLECTION_MISSED,
    LF_INPUT_PIXEL_REFLECTION_ALBEDO, LF_INPUT_PIXEL_REFLECTED,           LF_INPUT_PIXEL_GATHERED,
    LF_INPUT_PIXEL_GATHERED_ALBEDO,   LF_INPUT_PIXEL_GATHERED_MISSED};
static const enum lf_net_input lean_radiances[] = {LF_INPUT_VIEW_DIFFUSE, LF_INPUT_VIEW_GLOSSY,
                                                   LF_INPUT_VIEW_IRRADIANCE_RSM};

// Sums over lights, as the gather takes them. `reached`: of a lobe, the part that the light reaches.
static void sum_lights(const struct picture *p, enum lf_net_input input, int reached, float *out)
{
    memset(out, 0, sizeof(float) * SIDE * SIDE);
    for (uint32_t l = 0; l < p->lights; l++) {
        float share = *lf_light_clues_values(p->light[l])->of[LF_INPUT_LIGHT_SHARE];
        const float *radiance = picture_view(p, l, input, 1),
                    *part = reached >= 0 ? picture_view(p, l, (enum lf_net_input)reached, 0) : NULL;
        for (int i = 0; i < SIDE * SIDE; i++)
            out[i] += share * radiance[i] * (part ? part[i] : 1);
    }
}

static void expect_same_to_lean(const struct picture *a, const struct picture *b, double pixels, double sums)
{
    static float of_a[SIDE * SIDE], of_b[SIDE * SIDE];
    for (size_t i = 0; i < NG_COUNT(lean_pixels); i++) {
        enum lf_net_input input = lean_pixels[i];
        size_t count =
            input == LF_INPUT_FRAME_RADIANCE ? 1 : lf_net_inputs[input].channels * (size_t)SIDE * SIDE;
        const float *first = lf_pixel_clues_values(a->pixels)->of[input],
                    *second = lf_pixel_clues_values(b->pixels)->of[input];
        assert_true(first && second && expect_same(input, first, second, count, pixels));
    }
    for (size_t i = 0; i < NG_COUNT(lean_radiances); i++) {
        static const int reached[] = {LF_INPUT_VIEW_VISIBILITY_DIFFUSE, LF_INPUT_VIEW_VISIBILITY_SPECULAR,
                                      -1};
        sum_lights(a, lean_radiances[i], reached[i], of_a);
        sum_lights(b, lean_radiances[i], reached[i], of_b);
        assert_true(expect_same(lean_radiances[i], of_a, of_b, SIDE * SIDE, sums));
    }
}

// The scene's sphere grows a hundredfold, as it does when something stands that far away: what the picture
// shows stays, and so does what it is told in.
static void what_is_far_away_does_not_matter(void **state)
{
    NG_UNUSED(state);
    struct scene s;
    struct picture near = {0}, far = {0};
    build_room(&s);
    struct test_log log;
    test_log_begin(&log); // warns of what emits and is no light
    scene_frame(&s, 0);
    picture_encode(&near, &s, SIDE, SIDE);
    ((struct ng_scene_scale *)ng_world_edit(s.world, s.scale, NG_SCENE_SCALE))->radius *= 100;
    scene_frame(&s, 1);
    test_log_end(&log);
    picture_encode(&far, &s, SIDE, SIDE);
    assert_true(s.snapshot->scene_radius > 200);
    expect_same_to_lean(&near, &far, 0.03, 0.01);
    picture_close(&near);
    picture_close(&far);
    scene_close(&s);
}

// Turns the whole scene, its camera too, about a slanted axis.
static void turn(struct scene *s)
{
    struct ng_query *query;
    const struct ng_query_desc desc = {.terms = {NG_WRITE(NG_TRANSFORM)}, .term_count = 1};
    versor by;
    glm_quat(by, 0.7f, 0.3f, 1, 0.2f);
    OK(ng_query_create(s->world, &desc, &query));
    ng_query_each (it, query) {
        struct ng_transform *t = it.columns[0];
        for (uint32_t i = 0; i < it.count; i++) {
            versor turned;
            glm_quat_rotatev(by, t[i].translation, t[i].translation);
            glm_quat_mul(by, t[i].rotation, turned);
            glm_vec4_copy(turned, t[i].rotation);
        }
        ng_query_mark_all(&it, 0);
    }
    ng_query_destroy(&query);
}

// No direction of a ray and no sample of a light follows the world's axes. Here and there a ray passes an
// edge on the other side, and texels of the RSM, which are drawn by place, are others.
static void turning_does_not_matter(void **state)
{
    NG_UNUSED(state);
    struct scene s[2];
    struct picture p[2] = {{0}};
    for (int i = 0; i < 2; i++) {
        picture_dark_room(&s[i], 2);
        scene_sphere(&s[i], (const float[3]){-1, -0.5f, 0.3f}, 0.5f, false,
                     scene_material(&s[i], grey, 1, 0.2f));
        picture_panel(&s[i], 3, (const float[3]){0.71f, 1.42f, 0.03f});
        if (i)
            turn(&s[i]);
        scene_frame(&s[i], 0);
        picture_encode(&p[i], &s[i], SIDE, SIDE);
    }
    expect_same_to_lean(&p[0], &p[1], 0.01, 0.01);
    for (int i = 0; i < 2; i++) {
        picture_close(&p[i]);
        scene_close(&s[i]);
    }
}

// A panel, or its two halves as lights of their own.
static void build_halves(struct scene *s, bool split)
{
    picture_dark_room(s, 2);
    for (int half = 0; half < (split ? 2 : 1); half++) {
        struct ng_light_rectangle light = {
            .on = true, .color = {1, 1, 1}, .radiance = 3, .size = {split ? 0.3f : 0.6f, 0.4f}};
        float at[3] = {split ? (half ? 0.85f : 0.55f) : 0.7f, 1.4f, 0};
        scene_light(s, NG_LIGHT_RECTANGLE, &light, at, scene_down);
    }
}

static void halves_of_a_light_are_the_light(void **state)
{
    NG_UNUSED(state);
    struct scene s[2];
    struct picture p[2] = {{0}};
    for (int i = 0; i < 2; i++) {
        build_halves(&s[i], i);
        scene_frame(&s[i], 0);
        picture_encode(&p[i], &s[i], SIDE, SIDE);
    }
    float whole = *lf_pixel_clues_values(p[0].pixels)->of[LF_INPUT_FRAME_RADIANCE],
          halves = *lf_pixel_clues_values(p[1].pixels)->of[LF_INPUT_FRAME_RADIANCE];
    NEAR(halves / whole, 1, 0.01);
    for (size_t i = 0; i < NG_COUNT(lean_radiances); i++) {
        static float of_whole[SIDE * SIDE], of_halves[SIDE * SIDE];
        sum_lights(&p[0], lean_radiances[i], -1, of_whole);
        sum_lights(&p[1], lean_radiances[i], -1, of_halves);
        assert_true(expect_same(lean_radiances[i], of_whole, of_halves, SIDE * SIDE, 0.08));
    }
    for (int i = 0; i < 2; i++) {
        picture_close(&p[i]);
        scene_close(&s[i]);
    }
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
                        UINT64_C(1) << LF_INPUT_VIEW_DIFFUSE | UINT64_C(1) << LF_INPUT_VIEW_IRRADIANCE_RSM,
                        NULL);
    const struct lf_net_values *few = lf_light_clues_values(q.light[1]);
    assert_null(few->of[LF_INPUT_VIEW_SHADOW_DISTANCE]);
    assert_null(lf_pixel_clues_values(q.pixels)->of[LF_INPUT_PIXEL_REFLECTED]);
    assert_null(lf_pixel_clues_values(q.pixels)->of[LF_INPUT_PIXEL_REFLECTION_NEARNESS]);
    for (uint32_t c = 0; c < 3; c++) {
        assert_memory_equal(picture_view(&p, 1, LF_INPUT_VIEW_DIFFUSE, c),
                            picture_view(&q, 1, LF_INPUT_VIEW_DIFFUSE, c), 400 * sizeof(float));
        assert_memory_equal(picture_view(&p, 1, LF_INPUT_VIEW_IRRADIANCE_RSM, c),
                            picture_view(&q, 1, LF_INPUT_VIEW_IRRADIANCE_RSM, c), 400 * sizeof(float));
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
    struct lf_clues_scene scene = {.tracer = s.tracer, .jobs = s.jobs};
    OK(lf_clues_pixels(
        &scene,
        &(struct lf_clues_pixels_params){.gbuffer = {p.position, p.normal, p.diffuse, p.specular, p.emission},
                                         .width = SIZE,
                                         .height = SIZE},
        p.pixels));
    for (uint32_t i = 0; i < p.lights; i++)
        OK(lf_clues_view(&scene, p.pixels, p.light[i]));
    picture_hash(&p, false);
    picture_close(&p);
    scene_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(power_does_not_matter),
        cmocka_unit_test(place_does_not_matter),
        cmocka_unit_test(what_is_far_away_does_not_matter),
        cmocka_unit_test(halves_of_a_light_are_the_light),
        cmocka_unit_test(turning_does_not_matter),
        cmocka_unit_test(a_far_lamp_does_not_shadow_itself),
        cmocka_unit_test(unread_inputs_are_left_out),
        cmocka_unit_test(odd_pictures),
        cmocka_unit_test(bad_numbers_end_at_the_door),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// What is encoded of small scenes, against closed forms.
#include "picture.h"

#include "components/light_directional.h"
#include "lightformer/clues/clues_internal.h"

#include <math.h>

#define PI 3.14159265f

static const float white[3] = {1, 1, 1}, grey[3] = {0.5f, 0.5f, 0.5f};

// ---- distances -------------------------------------------------------------------------------------------

// Whether the segment from `a` to `b` passes through the ball, and where it enters.
static bool enters(const float a[3], const float b[3], const float center[3], float radius, float *distance)
{
    float d[3], o[3], length = 0, m = 0, c = -radius * radius;
    for (int i = 0; i < 3; i++) {
        d[i] = b[i] - a[i];
        o[i] = a[i] - center[i];
        length += d[i] * d[i];
        c += o[i] * o[i];
    }
    length = sqrtf(length);
    for (int i = 0; i < 3; i++)
        m += o[i] * d[i] / length;
    *distance = -m - sqrtf(fmaxf(m * m - c, 0));
    return m * m > c && *distance > 0 && *distance < length;
}

// A ball over a floor: the floor's distances in closed form, d_f to the last bit where nothing is in between.
static void occluders_are_where_they_are(void **state)
{
    NG_UNUSED(state);
    static const float center[3] = {0, -0.2f, 0}, lamp[3] = {0.3f, 1.5f, 0.2f};
    enum { SIZE = 64 };
    struct scene s;
    struct picture p = {0};
    scene_open(&s, 2);
    ng_entity material = scene_material(&s, grey, 0, 0.9f);
    scene_quad(&s, (const float[3]){-3, -1, 3}, (const float[3]){6, 0, 0}, (const float[3]){0, 0, -6},
               material);
    scene_sphere(&s, center, 0.5f, false, material);
    picture_point(&s, 1, lamp);
    scene_frame(&s, 0);
    picture_encode(&p, &s, SIZE, SIZE);
    const float *far = picture_view(&p, 0, LF_INPUT_VIEW_DISTANCE, 0),
                *near = picture_view(&p, 0, LF_INPUT_VIEW_SHADOW_DISTANCE, 0);
    const float radius = s.snapshot->scene_radius;
    int lit = 0, dark = 0, odd = 0;
    for (size_t i = 0; i < SIZE * SIZE; i++) {
        const float *position = p.position + 4 * i;
        if (!(position[3] > 0) || position[1] > -0.999f)
            continue;
        float distance, square = 0;
        for (int c = 0; c < 3; c++)
            square += (position[c] - lamp[c]) * (position[c] - lamp[c]);
        NEAR(far[i] * radius, sqrtf(square), 1e-4);
        bool inside = enters(lamp, position, center, 0.49f, &distance),
             outside = !enters(lamp, position, center, 0.51f, &distance);
        if (inside) {
            enters(lamp, position, center, 0.5f, &distance);
            NEAR(near[i] * radius, distance, 3e-3);
            dark++;
        } else if (outside) {
            odd += near[i] != far[i];
            lit++;
        }
    }
    assert_true(lit > 500 && dark > 50);
    assert_int_equal(odd, 0);
    picture_close(&p);
    scene_close(&s);
}

// Parallel light comes from where it enters the scene's sphere.
static void parallel_light_begins_at_the_sphere(void **state)
{
    NG_UNUSED(state);
    struct scene s;
    struct picture p = {0};
    scene_open(&s, 1);
    ng_entity material = scene_material(&s, grey, 0, 0.9f);
    scene_quad(&s, (const float[3]){-3, -1, 3}, (const float[3]){6, 0, 0}, (const float[3]){0, 0, -6},
               material);
    scene_quad(&s, (const float[3]){-3, 1, 3}, (const float[3]){3, 0, 0}, (const float[3]){0, 0, -6},
               material);
    struct ng_light_directional sun = {.on = true, .color = {1, 1, 1}, .irradiance = 2};
    scene_light(&s, NG_LIGHT_DIRECTIONAL, &sun, (const float[3]){0, 0, 0}, scene_down);
    scene_frame(&s, 0);
    picture_encode(&p, &s, 32, 32);
    const float *far = picture_view(&p, 0, LF_INPUT_VIEW_DISTANCE, 0),
                *near = picture_view(&p, 0, LF_INPUT_VIEW_SHADOW_DISTANCE, 0);
    float radius = s.snapshot->scene_radius, top = s.snapshot->scene_center[1] + radius;
    int shaded = 0, open = 0;
    for (size_t i = 0; i < 32 * 32; i++) {
        const float *position = p.position + 4 * i;
        if (!(position[3] > 0) || position[1] > -0.99f)
            continue;
        NEAR(far[i] * radius, top - position[1], 1e-4);
        NEAR(picture_view(&p, 0, LF_INPUT_VIEW_DIRECTION, 1)[i], 1, 1e-5);
        bool under = position[0] < -0.05f;
        if (fabsf(position[0]) > 0.05f)
            NEAR(near[i] * radius, under ? top - 1 : top - position[1], 1e-3);
        shaded += under;
        open += !under;
    }
    assert_true(shaded > 50 && open > 50);
    picture_close(&p);
    scene_close(&s);
}

// ---- the second bounce -----------------------------------------------------------------------------------

// A lamp in the middle of a hollow ball: everything is lit alike, and sends the same to everywhere.
static void a_hollow_ball_is_lit_evenly(void **state)
{
    NG_UNUSED(state);
    enum { SIZE = 24 };
    struct scene s;
    struct picture p = {0};
    scene_open(&s, 2);
    scene_sphere(&s, (const float[3]){0, 0, 0}, 2, true, scene_material(&s, grey, 0, 1));
    picture_point(&s, 3, (const float[3]){0, 0, 0});
    scene_frame(&s, 0);
    picture_encode(&p, &s, SIZE, SIZE);
    const struct lf_net_values *v = lf_light_clues_values(p.light[0]);
    uint32_t rows = lf_light_clues_texels(p.light[0]);
    assert_true(rows > 6 * 64 * 64 - 100); // needles at the poles are black
    double mean[3] = {0};
    for (size_t c = 0; c < 3; c++)
        for (size_t i = 0; i < rows; i++)
            mean[c] += (double)v->of[LF_INPUT_TEXEL_FLUX][c * rows + i] / rows;
    // Half of the light, and what 4 % at normal incidence add; by channel as the lamp's colour.
    for (size_t c = 0; c < 3; c++) {
        double share = mean[c] / (double)v->of[LF_INPUT_LIGHT_COLOR][c];
        assert_true(share > 0.5 && share < 0.56);
    }
    // Irradiance E from the wall is its reflectance times the lamp's E, which is Phi / (4 pi r^2).
    double radius = (double)s.snapshot->scene_radius, error = 0;
    for (size_t c = 0; c < 3; c++) {
        double expected = mean[c] / (4 * (double)PI * 4) / (double)PI * radius * radius;
        for (size_t i = 0; i < SIZE * SIZE; i++)
            error =
                !(picture_pixels(&p, LF_INPUT_PIXEL_MASK, 0)[i] > 0)
                    ? error
                    : fmax(error,
                           fabs((double)picture_view(&p, 0, LF_INPUT_VIEW_IRRADIANCE_RSM, (uint32_t)c)[i] /
                                    expected -
                                1));
    }
    if (!(error < 0.05))
        fail_msg("%g from even", error);
    picture_close(&p);
    scene_close(&s);
}

// Sums at every fourth pixel, spread, against sums at every pixel.
static void spreading_is_close_to_summing(void **state)
{
    NG_UNUSED(state);
    enum { SIZE = 256 };
    struct scene s;
    struct picture p = {0};
    picture_room(&s, 2);
    scene_frame(&s, 0);
    picture_encode(&p, &s, SIZE, SIZE);
    double error = 0, size = 0;
    for (uint32_t l = 0; l < 2; l++)
        for (size_t i = 0; i < SIZE * SIZE; i++) {
            struct lf_shading_points points;
            float exact[3][LF_LANES];
            if (!(picture_pixels(&p, LF_INPUT_PIXEL_MASK, 0)[i] > 0))
                continue;
            for (int k = 0; k < LF_LANES; k++)
                lf_shading_points_set_pixel(p.pixels, i, k, &points);
            lf_kernels_of(0)->rsm_gather(p.light[l]->sources.items, (uint32_t)p.light[l]->sources.count,
                                         &points, exact);
            for (uint32_t c = 0; c < 3; c++) {
                double d = (double)(picture_view(&p, l, LF_INPUT_VIEW_IRRADIANCE_RSM, c)[i] - exact[c][0]);
                error += d * d;
                size += (double)exact[c][0] * (double)exact[c][0];
            }
        }
    print_message("relative error of spreading: %.2g\n", sqrt(error / size));
    assert_true(size > 0 && sqrt(error / size) < 0.03);
    picture_close(&p);
    scene_close(&s);
}

// ---- mirrors ---------------------------------------------------------------------------------------------

// What a wall that faces the camera reflects of a light's bounce, at a point on it.
static float bounce_of_wall(const struct picture *p, const float at[3])
{
    const struct lf_light_clues *light = p->light[0];
    struct lf_shading_points points = {0};
    float gathered[3][LF_LANES], place[3];
    lf_to_scene(&light->space, at, place);
    for (int i = 0; i < LF_LANES; i++) {
        for (int c = 0; c < 3; c++)
            points.position[c][i] = place[c];
        points.normal[2][i] = points.flat[2][i] = 1;
    }
    lf_kernels_of(0)->rsm_gather(light->sources_of_hits.items, (uint32_t)light->sources_of_hits.count,
                                 &points, gathered);
    return 0.52f * gathered[0][0]; // albedo, and F0 of a dielectric
}

// A mirror on the floor before a wall that glows on its left and is lit on its right; a lamp over the mirror.
static void mirrors_show_what_is_lit(void **state)
{
    NG_UNUSED(state);
    enum { SIZE = 256 };
    static const float lamp[3] = {1, 1, 2};
    struct scene s;
    struct picture p = {0};
    scene_open(&s, 2);
    ng_entity mirror = scene_material(&s, white, 1, 0.05f), wall = scene_material(&s, grey, 0, 1),
              glow = scene_glow(&s, (const float[3]){0, 5, 0});
    scene_quad(&s, (const float[3]){-2, -1, 2}, (const float[3]){4, 0, 0}, (const float[3]){0, 0, -3.9f},
               mirror);
    scene_quad(&s, (const float[3]){0, -1, -2}, (const float[3]){2, 0, 0}, (const float[3]){0, 4, 0}, wall);
    scene_quad(&s, (const float[3]){-2, -1, -2}, (const float[3]){2, 0, 0}, (const float[3]){0, 4, 0}, glow);
    picture_point(&s, 2, lamp);
    scene_frame_warned(&s, 0);
    picture_encode(&p, &s, SIZE, SIZE);
    float radius = s.snapshot->scene_radius,
          unit = *lf_pixel_clues_values(p.pixels)->of[LF_INPUT_FRAME_RADIANCE];
    const float *eye = s.snapshot->camera.position;
    int lit = 0, glowing = 0;
    for (size_t i = 0; i < SIZE * SIZE; i++) {
        const float *x = p.position + 4 * i;
        if (!(x[3] > 0) || x[1] > -0.99f)
            continue;
        float t = (x[2] + 2) / (eye[2] - x[2]); // the reflected ray goes on to z = -2
        float hit[3] = {x[0] + (x[0] - eye[0]) * t, -1 + (eye[1] + 1) * t, -2}, way = 0, square = 0, far = 0;
        for (int c = 0; c < 3; c++) {
            far += (eye[c] - x[c]) * (eye[c] - x[c]);
            way += (hit[c] - x[c]) * (hit[c] - x[c]);
            square += (lamp[c] - hit[c]) * (lamp[c] - hit[c]);
        }
        // At edges it takes from inside; at the wall's foot rays that are neighbours go ways of different
        // lengths.
        if (fabsf(hit[0]) < 0.1f || fabsf(hit[0]) > 1.9f || hit[1] > 2.5f || x[2] < -1.2f)
            continue;
        float nearness = picture_pixels(&p, LF_INPUT_PIXEL_REFLECTION_NEARNESS, 0)[i];
        NEAR(nearness, 1 / (1 + sqrtf(way / far)), 0.015);
        if (hit[0] < 0) {
            NEAR(picture_pixels(&p, LF_INPUT_PIXEL_REFLECTED, 1)[i] -
                     picture_pixels(&p, LF_INPUT_PIXEL_REFLECTED, 0)[i],
                 5 / unit, 1e-3 * 5 / (double)unit);
            glowing++;
            continue;
        }
        // Irradiance of the wall by the lamp: I cos / d^2; at unit power I = 1 / (4 pi) of each channel's
        // share.
        float cosine = (lamp[2] + 2) / sqrtf(square),
              expected = 0.5f / PI * cosine / square / (4 * PI) * radius * radius;
        float shown = picture_pixels(&p, LF_INPUT_PIXEL_REFLECTED, 0)[i] * unit / picture_unit(&p, 0);
        float seen = (shown - bounce_of_wall(&p, hit)) /
                     lf_light_clues_values(p.light[0])->of[LF_INPUT_LIGHT_COLOR][0];
        // Fresnel takes some of the diffuse light and gives some glossy.
        if (!(fabsf(seen / expected - 1) < 0.03f))
            fail_msg("%g instead of %g", (double)seen, (double)expected);
        lit++;
    }
    assert_true(lit > 5000 && glowing > 5000);
    picture_close(&p);
    scene_close(&s);
}

// With a wall between lamp and what is mirrored, the mirror shows nothing of the lamp.
static void what_mirrors_show_is_shadowed(void **state)
{
    NG_UNUSED(state);
    struct scene s;
    struct picture p = {0};
    scene_open(&s, 1);
    ng_entity mirror = scene_material(&s, white, 1, 0.05f), wall = scene_material(&s, grey, 0, 1);
    scene_quad(&s, (const float[3]){-2, -1, 2}, (const float[3]){4, 0, 0}, (const float[3]){0, 0, -3.9f},
               mirror);
    scene_quad(&s, (const float[3]){-2, -1, -2}, (const float[3]){4, 0, 0}, (const float[3]){0, 4, 0}, wall);
    scene_quad(&s, (const float[3]){-9, 1.5f, 3}, (const float[3]){0, 0, -9}, (const float[3]){18, 0, 0},
               wall);
    picture_point(&s, 2, (const float[3]){0, 4, 1});
    scene_frame(&s, 0);
    picture_encode(&p, &s, 48, 48);
    int mirrored = 0;
    for (size_t i = 0; i < 48 * 48; i++) {
        const float *x = p.position + 4 * i;
        if (!(x[3] > 0) || x[1] > -0.99f || x[2] > 1)
            continue;
        mirrored += picture_pixels(&p, LF_INPUT_PIXEL_REFLECTION_NEARNESS, 0)[i] > 0;
        assert_true(picture_pixels(&p, LF_INPUT_PIXEL_REFLECTED, 0)[i] == 0);
    }
    assert_true(mirrored > 50);
    picture_close(&p);
    scene_close(&s);
}

// A mirror before a wall that ends: rays meet it, or nothing, or, at its edge, both.
static void rays_that_meet_nothing_are_known(void **state)
{
    NG_UNUSED(state);
    enum { SIZE = 64 };
    struct scene s;
    struct picture p = {0};
    scene_open(&s, 1);
    ng_entity mirror = scene_material(&s, white, 1, 0.3f), wall = scene_material(&s, grey, 0, 1);
    scene_quad(&s, (const float[3]){-2, -1, 2}, (const float[3]){4, 0, 0}, (const float[3]){0, 0, -4},
               mirror);
    scene_quad(&s, (const float[3]){-2, -1, -2}, (const float[3]){2, 0, 0}, (const float[3]){0, 9, 0}, wall);
    picture_point(&s, 2, (const float[3]){0, 4, 1});
    scene_frame(&s, 0);
    picture_encode(&p, &s, SIZE, SIZE);
    int met = 0, missed = 0, both = 0;
    for (size_t i = 0; i < SIZE * SIZE; i++) {
        const float *x = p.position + 4 * i;
        float part = picture_pixels(&p, LF_INPUT_PIXEL_REFLECTION_MISSED, 0)[i],
              nearness = picture_pixels(&p, LF_INPUT_PIXEL_REFLECTION_NEARNESS, 0)[i];
        if (!(x[3] > 0) || x[1] > -0.9f)
            assert_true(part == 0 && nearness == 0);
        if (!(x[3] > 0) || x[1] > -0.99f || x[2] < -1.9f)
            continue;
        assert_true(part >= 0 && part < 1.0001f && (part > 0.9999f || nearness > 0));
        met += x[0] < -0.7f && part < 0.5f;
        missed += x[0] > 0.7f && part > 0.8f;
        both += fabsf(x[0]) < 0.2f && part > 0.2f && part < 0.8f;
    }
    print_message("rays met %d, missed %d, both %d\n", met, missed, both);
    assert_true(met > 50 && missed > 200 && both > 50);
    picture_close(&p);
    scene_close(&s);
}

// Nothing but what reflects, as far as rays go round: most of it metal, before a metal.
static void memory_is_what_was_said(void **state)
{
    NG_UNUSED(state);
    enum { SIZE = 160, STRIPES = 160 };
    struct scene s;
    struct picture p = {0};
    scene_open(&s, 2);
    ng_entity metal = scene_material(&s, white, 1, 0.3f), gloss = scene_material(&s, grey, 0, 0.3f);
    for (int i = 0; i < STRIPES; i++)
        scene_quad(&s, (const float[3]){-8 + 0.1f * (float)i, -8, 0}, (const float[3]){0.1f, 0, 0},
                   (const float[3]){0, 16, 0}, i % 7 < 2 ? gloss : metal);
    scene_quad(&s, (const float[3]){30, -30, 9}, (const float[3]){-60, 0, 0}, (const float[3]){0, 60, 0},
               metal);
    picture_point(&s, 2, (const float[3]){0, 1, 6});
    scene_frame(&s, 0);
    picture_encode(&p, &s, SIZE, SIZE);
    const struct lf_clues_bytes most = lf_clues_bytes(SIZE, SIZE, 0);
    uint64_t view = lf_clues_view_bytes(SIZE, SIZE), hits = lf_clues_hits_bytes(SIZE, SIZE, 0);
    size_t reflecting = p.pixels->reflections.taps.count;
    for (size_t i = 0; i < SIZE * SIZE; i++)
        reflecting += p.pixels->reflections.kinds.items[i] == LF_REFLECTION_BETWEEN;
    assert_int_equal(reflecting, SIZE * SIZE);
    assert_true(p.pixels->reflections.first < p.pixels->reflections.hits.count);
    for (int i = 0; i < LF_PIXEL_PARTS; i++)
        assert_in_range(p.pixels->memory[i].used, most.pixels[i] * 8 / 10, most.pixels[i]);
    assert_in_range(p.light[0]->memory[LF_LIGHT_VIEW].used, view * 9 / 10, view);
    assert_in_range(p.light[0]->memory[LF_LIGHT_HITS].used, hits * 5 / 10, hits);
    picture_close(&p);
    scene_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(occluders_are_where_they_are),
        cmocka_unit_test(parallel_light_begins_at_the_sphere),
        cmocka_unit_test(a_hollow_ball_is_lit_evenly),
        cmocka_unit_test(spreading_is_close_to_summing),
        cmocka_unit_test(mirrors_show_what_is_lit),
        cmocka_unit_test(what_mirrors_show_is_shadowed),
        cmocka_unit_test(rays_that_meet_nothing_are_known),
        cmocka_unit_test(memory_is_what_was_said),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// What is encoded of small scenes, against closed forms, and what must not change it.
#include "picture.h"

#include "base/half.h"
#include "components/light_directional.h"
#include "components/light_point.h"
#include "components/light_rectangle.h"
#include "components/scene_scale.h"
#include "components/transform.h"
#include "lightformer/encode/clues_internal.h"
#include "scene/world.h"

#include <math.h>

#define PI 3.14159265f

static const float white[3] = {1, 1, 1}, grey[3] = {0.5f, 0.5f, 0.5f};

static ng_entity add_point(struct scene *s, float intensity, const float position[3])
{
    struct ng_light_point light = {.on = true, .color = {1, 0.5f, 0.25f}, .intensity = intensity};
    return scene_light(s, NG_LIGHT_POINT, &light, position, NULL);
}

static ng_entity add_rectangle(struct scene *s, float radiance, const float position[3])
{
    struct ng_light_rectangle light = {
        .on = true, .color = {1, 1, 1}, .radiance = radiance, .size = {0.6f, 0.4f}};
    return scene_light(s, NG_LIGHT_RECTANGLE, &light, position, scene_down);
}

// A smooth floor, a ball, a wall behind; two lights.
static void open_room(struct scene *s, uint32_t threads)
{
    scene_open(s, threads);
    ng_entity smooth = scene_material(s, grey, 0, 0.15f), rough = scene_material(s, white, 0, 0.9f);
    scene_quad(s, (const float[3]){-3, -1, 3}, (const float[3]){6, 0, 0}, (const float[3]){0, 0, -6}, smooth);
    scene_quad(s, (const float[3]){-3, -1, -2}, (const float[3]){6, 0, 0}, (const float[3]){0, 4, 0}, rough);
    scene_sphere(s, (const float[3]){0.2f, -0.4f, 0}, 0.6f, false, rough);
    add_point(s, 2, (const float[3]){-1, 1, 1});
    add_rectangle(s, 3, (const float[3]){0.7f, 1.4f, 0});
}

// What the path tracer says of one layer of a square picture. free() it.
static float *trace_layer(const struct scene *s, uint32_t size, uint32_t depth, uint32_t samples,
                          const char *name)
{
    return scene_render_layer(
        s, &(struct lf_reference_params){.width = size, .height = size, .depth = depth, .jobs = s->jobs},
        samples, name);
}

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
    add_point(&s, 1, lamp);
    scene_frame(&s, 0);
    picture_encode(&p, &s, SIZE, SIZE);
    const float *far = picture_view(&p, 0, LF_INPUT_VIEW_DISTANCE, 0),
                *near = picture_view(&p, 0, LF_INPUT_VIEW_OCCLUDER, 0);
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
                *near = picture_view(&p, 0, LF_INPUT_VIEW_OCCLUDER, 0);
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
    add_point(&s, 3, (const float[3]){0, 0, 0});
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
            error = !(picture_pixels(&p, LF_INPUT_PIXEL_MASK, 0)[i] > 0)
                        ? error
                        : fmax(error, fabs((double)picture_view(&p, 0, LF_INPUT_VIEW_BOUNCE, (uint32_t)c)[i] /
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
    open_room(&s, 2);
    scene_frame(&s, 0);
    picture_encode(&p, &s, SIZE, SIZE);
    double error = 0, size = 0;
    for (uint32_t l = 0; l < 2; l++)
        for (size_t i = 0; i < SIZE * SIZE; i++) {
            struct lf_points points;
            float exact[3][LF_LANES];
            if (!(picture_pixels(&p, LF_INPUT_PIXEL_MASK, 0)[i] > 0))
                continue;
            for (int k = 0; k < LF_LANES; k++)
                lf_points_set_pixel(p.pixels, i, k, &points);
            lf_kernels_of(0)->bounce(p.light[l]->sources.items, (uint32_t)p.light[l]->sources.count, &points,
                                     exact);
            for (uint32_t c = 0; c < 3; c++) {
                double d = (double)(picture_view(&p, l, LF_INPUT_VIEW_BOUNCE, c)[i] - exact[c][0]);
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
    add_point(&s, 2, lamp);
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
        float hit[3] = {x[0] + (x[0] - eye[0]) * t, -1 + (eye[1] + 1) * t, -2}, way = 0, square = 0;
        for (int c = 0; c < 3; c++) {
            way += (hit[c] - x[c]) * (hit[c] - x[c]);
            square += (lamp[c] - hit[c]) * (lamp[c] - hit[c]);
        }
        // At edges it takes from inside; at the wall's foot rays that are neighbours go ways of different
        // lengths.
        if (fabsf(hit[0]) < 0.1f || fabsf(hit[0]) > 1.9f || hit[1] > 2.5f || x[2] < -1.2f)
            continue;
        float nearness = picture_pixels(&p, LF_INPUT_PIXEL_MIRROR, 0)[i];
        NEAR(nearness, 1 / (1 + sqrtf(way) / radius), 0.015);
        if (hit[0] < 0) {
            NEAR(picture_pixels(&p, LF_INPUT_PIXEL_MIRROR_EMISSION, 1)[i], 5 / unit, 1e-3 * 5 / (double)unit);
            assert_true(picture_pixels(&p, LF_INPUT_PIXEL_MIRROR_EMISSION, 0)[i] == 0);
            glowing++;
            continue;
        }
        // Irradiance of the wall by the lamp: I cos / d^2; at unit power I = 1 / (4 pi) of each channel's
        // share.
        float cosine = (lamp[2] + 2) / sqrtf(square),
              expected = 0.5f / PI * cosine / square / (4 * PI) * radius * radius;
        float seen = picture_view(&p, 0, LF_INPUT_VIEW_MIRROR, 0)[i] /
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
    add_point(&s, 2, (const float[3]){0, 4, 1});
    scene_frame(&s, 0);
    picture_encode(&p, &s, 48, 48);
    int mirrored = 0;
    for (size_t i = 0; i < 48 * 48; i++) {
        const float *x = p.position + 4 * i;
        if (!(x[3] > 0) || x[1] > -0.99f || x[2] > 1)
            continue;
        mirrored += picture_pixels(&p, LF_INPUT_PIXEL_MIRROR, 0)[i] > 0;
        assert_true(picture_view(&p, 0, LF_INPUT_VIEW_MIRROR, 0)[i] == 0);
    }
    assert_true(mirrored > 50);
    picture_close(&p);
    scene_close(&s);
}

// A metal floor shows a lamp, half of it behind a board: what rays leave of the highlight is what the path
// tracer leaves of it; without them it would shine through.
static void highlights_are_shadowed(void **state)
{
    NG_UNUSED(state);
    enum { SIZE = 128 };
    struct scene s;
    struct picture p = {0};
    scene_open(&s, 2);
    ng_entity metal = scene_material(&s, white, 1, 0.15f), board = scene_material(&s, grey, 0, 1);
    scene_quad(&s, (const float[3]){-3, -1, 3}, (const float[3]){6, 0, 0}, (const float[3]){0, 0, -6}, metal);
    scene_quad(&s, (const float[3]){-1, 0, -1.2f}, (const float[3]){1.05f, 0, 0}, (const float[3]){0, 0, -2},
               board);
    add_rectangle(&s, 3, (const float[3]){0, 0.2f, -2.5f});
    scene_frame(&s, 0);
    picture_encode(&p, &s, SIZE, SIZE);
    float *truth = trace_layer(&s, SIZE, 2, 150, "direct"),
          unit = *lf_pixel_clues_values(p.pixels)->of[LF_INPUT_FRAME_RADIANCE];
    double with = 0, without = 0, size = 0;
    for (size_t i = 0; i < SIZE * SIZE; i++) {
        const float *at = p.position + 4 * i;
        if (!(at[3] > 0) || at[1] > -0.99f)
            continue;
        double glossy = (double)(picture_view(&p, 0, LF_INPUT_VIEW_GLOSSY, 0)[i] * unit),
               b = (double)truth[3 * i];
        double ours = glossy * (double)picture_view(&p, 0, LF_INPUT_VIEW_GLOSSY_REACHED, 0)[i];
        with += (ours - b) * (ours - b);
        without += (glossy - b) * (glossy - b);
        size += b * b;
    }
    print_message("highlights: %.2g of the error without rays, %.2g of the light\n", with / without,
                  with / size);
    assert_true(size > 0 && with < 0.06 * without && with < 0.09 * size);
    free(truth);
    picture_close(&p);
    scene_close(&s);
}

// A small board over a floor, under a lamp: what rays of neighbours say of its penumbra is what the path
// tracer says. A ray to the middle of the lamp alone would see a hard edge.
static void penumbrae_are_soft(void **state)
{
    NG_UNUSED(state);
    enum { SIZE = 128 };
    struct scene s;
    struct picture p = {0};
    scene_open(&s, 2);
    ng_entity rough = scene_material(&s, grey, 0, 1);
    scene_quad(&s, (const float[3]){-2, -1, 2}, (const float[3]){4, 0, 0}, (const float[3]){0, 0, -4}, rough);
    scene_quad(&s, (const float[3]){-0.3f, 0.4f, 0.2f}, (const float[3]){0.5f, 0, 0},
               (const float[3]){0, 0, -0.5f}, rough);
    add_rectangle(&s, 3, (const float[3]){0, 1.5f, 0});
    scene_frame(&s, 0);
    picture_encode(&p, &s, SIZE, SIZE);
    float *truth = trace_layer(&s, SIZE, 2, 80, "direct"),
          unit = *lf_pixel_clues_values(p.pixels)->of[LF_INPUT_FRAME_RADIANCE];
    double soft = 0, hard = 0, size = 0;
    int partly = 0;
    for (size_t i = 0; i < SIZE * SIZE; i++) {
        const float *at = p.position + 4 * i;
        if (!(at[3] > 0) || at[1] > -0.99f)
            continue;
        double all = (double)((picture_view(&p, 0, LF_INPUT_VIEW_DIFFUSE, 0)[i] +
                               picture_view(&p, 0, LF_INPUT_VIEW_GLOSSY, 0)[i]) *
                              unit),
               b = (double)truth[3 * i];
        double reached = (double)picture_view(&p, 0, LF_INPUT_VIEW_DIFFUSE_REACHED, 0)[i];
        bool free = picture_view(&p, 0, LF_INPUT_VIEW_OCCLUDER, 0)[i] >=
                    picture_view(&p, 0, LF_INPUT_VIEW_DISTANCE, 0)[i];
        assert_true(reached >= 0 && reached <= 1);
        partly += reached > 0.1 && reached < 0.9;
        soft += (all * reached - b) * (all * reached - b);
        hard += (all * free - b) * (all * free - b);
        size += b * b;
    }
    print_message("penumbra: %.2g of the light, %.2g with one ray\n", soft / size, hard / size);
    assert_true(partly > 50 && soft < 0.2 * hard && soft < 0.01 * size);
    free(truth);
    picture_close(&p);
    scene_close(&s);
}

// A rough metal ball before lit walls of three colours, and a second one that shows the first: what its rays
// see, times F0, is what the path tracer finds after one reflection, or two.
static void metals_show_what_surrounds_them(void **state)
{
    NG_UNUSED(state);
    enum { SIZE = 128 };
    static const float red[3] = {0.8f, 0.1f, 0.1f}, blue[3] = {0.1f, 0.1f, 0.8f};
    struct scene s;
    struct picture p = {0};
    scene_open(&s, 2);
    ng_entity metal = scene_material(&s, white, 1, 0.3f), left = scene_material(&s, red, 0, 1),
              right = scene_material(&s, blue, 0, 1), floor = scene_material(&s, grey, 0, 1);
    scene_quad(&s, (const float[3]){-2, -1, 4}, (const float[3]){4, 0, 0}, (const float[3]){0, 0, -6}, floor);
    scene_quad(&s, (const float[3]){-2, -1, 4}, (const float[3]){0, 0, -6}, (const float[3]){0, 3, 0}, left);
    scene_quad(&s, (const float[3]){2, -1, -2}, (const float[3]){0, 0, 6}, (const float[3]){0, 3, 0}, right);
    scene_quad(&s, (const float[3]){-2, -1, -2}, (const float[3]){4, 0, 0}, (const float[3]){0, 3, 0}, floor);
    scene_sphere(&s, (const float[3]){-0.55f, -0.5f, 0}, 0.5f, false, metal);
    scene_sphere(&s, (const float[3]){0.55f, -0.5f, 0}, 0.5f, false, metal);
    add_point(&s, 4, (const float[3]){0, 1.2f, 2});
    scene_frame(&s, 0);
    picture_encode(&p, &s, SIZE, SIZE);
    float *truth = trace_layer(&s, SIZE, 4, 100, "indirect"),
          unit = *lf_pixel_clues_values(p.pixels)->of[LF_INPUT_FRAME_RADIANCE];
    double error = 0, mean = 0, expected = 0;
    int count = 0;
    for (size_t i = 0; i < SIZE * SIZE; i++)
        for (uint32_t c = 0; c < 3; c++) {
            if (!(picture_pixels(&p, LF_INPUT_PIXEL_SPECULAR, 0)[i] > 0.5f))
                continue;
            double seen = (double)((picture_view(&p, 0, LF_INPUT_VIEW_MIRROR, c)[i] +
                                    picture_view(&p, 0, LF_INPUT_VIEW_MIRROR_BOUNCE, c)[i]) *
                                   unit),
                   b = (double)truth[3 * i + c];
            error += (seen - b) * (seen - b) / (b * b + 1e-3);
            mean += seen;
            expected += b;
            count++;
        }
    print_message("metals: relative squared error %.2g, mean %.3f (of %.2g)\n", error / count,
                  mean / expected, expected / count);
    assert_true(count > 1000 && error < 0.1 * count && fabs(mean / expected - 1) < 0.1);
    free(truth);
    picture_close(&p);
    scene_close(&s);
}

// A table keeps off the floor what lit walls reflect: rays over the hemisphere know, light of RSM texels does
// not.
static void what_stands_in_the_way_counts(void **state)
{
    NG_UNUSED(state);
    enum { SIZE = 96 };
    struct scene s;
    struct picture p = {0};
    scene_open(&s, 2);
    ng_entity rough = scene_material(&s, grey, 0, 1);
    scene_quad(&s, (const float[3]){-2, -1, 2}, (const float[3]){4, 0, 0}, (const float[3]){0, 0, -4}, rough);
    scene_quad(&s, (const float[3]){-2, -1, -2}, (const float[3]){4, 0, 0}, (const float[3]){0, 3, 0}, rough);
    scene_quad(&s, (const float[3]){-2, -1, 2}, (const float[3]){0, 0, -4}, (const float[3]){0, 3, 0}, rough);
    scene_quad(&s, (const float[3]){2, -1, -2}, (const float[3]){0, 0, 4}, (const float[3]){0, 3, 0}, rough);
    scene_quad(&s, (const float[3]){-1, -0.5f, 0}, (const float[3]){2, 0, 0}, (const float[3]){0, 0, -1.8f},
               rough);
    scene_quad(&s, (const float[3]){-1, -0.5f, 0}, (const float[3]){0, 0, -1.8f}, (const float[3]){2, 0, 0},
               rough);
    add_point(&s, 2, (const float[3]){0, 1.5f, 0});
    scene_frame(&s, 0);
    picture_encode(&p, &s, SIZE, SIZE);
    float *truth = trace_layer(&s, SIZE, 4, 100, "indirect"),
          unit = *lf_pixel_clues_values(p.pixels)->of[LF_INPUT_FRAME_RADIANCE];
    double expected = 0, rays = 0, texels = 0;
    for (size_t i = 0; i < SIZE * SIZE; i++) {
        const float *at = p.position + 4 * i;
        if (!(at[3] > 0) || at[1] > -0.99f || fabsf(at[0]) > 0.8f || at[2] > -0.2f || at[2] < -1.6f)
            continue;
        expected += (double)truth[3 * i] / 0.48; // what Fresnel leaves of the albedo
        rays += (double)(picture_view(&p, 0, LF_INPUT_VIEW_GATHERED, 0)[i] * unit);
        texels += (double)(picture_view(&p, 0, LF_INPUT_VIEW_BOUNCE, 0)[i] * unit);
    }
    print_message("of the indirect light: rays %.2f, texels %.2f\n", rays / expected, texels / expected);
    assert_true(expected > 0 && texels > 1.5 * expected); // so that there is something in the way
    assert_true(fabs(rays - expected) < 0.5 * fabs(texels - expected));
    free(truth);
    picture_close(&p);
    scene_close(&s);
}

// ---- what must not matter --------------------------------------------------------------------------------

static uint64_t room_hash(uint32_t threads)
{
    struct scene s;
    struct picture p = {0};
    open_room(&s, threads);
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
    ng_entity lamps[] = {add_point(&s, 2, (const float[3]){-1, 1, 1}),
                         add_rectangle(&s, 3, (const float[3]){0.7f, 1.4f, 0})};
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
    open_room(&s, 1);
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
    open_room(&s, 2);
    add_rectangle(&s, 1, (const float[3]){0, 1, -2});   // in the wall
    add_point(&s, 1, (const float[3]){0.2f, -0.4f, 0}); // in the ball
    add_point(&s, 0, (const float[3]){0, 0, 1});        // of no power
    add_point(&s, 1, (const float[3]){0, 0, 5});        // in the eye
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
    add_point(&s, 1, (const float[3]){0, 0, 0});
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
    open_room(&s, 1);
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
        cmocka_unit_test(occluders_are_where_they_are),
        cmocka_unit_test(parallel_light_begins_at_the_sphere),
        cmocka_unit_test(a_hollow_ball_is_lit_evenly),
        cmocka_unit_test(spreading_is_close_to_summing),
        cmocka_unit_test(what_stands_in_the_way_counts),
        cmocka_unit_test(penumbrae_are_soft),
        cmocka_unit_test(metals_show_what_surrounds_them),
        cmocka_unit_test(mirrors_show_what_is_lit),
        cmocka_unit_test(what_mirrors_show_is_shadowed),
        cmocka_unit_test(highlights_are_shadowed),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(power_does_not_matter),
        cmocka_unit_test(size_does_not_matter),
        cmocka_unit_test(unread_inputs_are_left_out),
        cmocka_unit_test(odd_pictures),
        cmocka_unit_test(bad_numbers_end_at_the_door),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

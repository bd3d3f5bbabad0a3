// What rays find, against the path tracer: shadows, reflections, indirect light.
#include "picture.h"

#include "lightformer/clues/clues_internal.h"

#include <math.h>

static const float white[3] = {1, 1, 1}, grey[3] = {0.5f, 0.5f, 0.5f};

// What the path tracer says of one layer of a square picture. free() it.
static float *trace_layer(const struct scene *s, uint32_t size, uint32_t depth, uint32_t samples,
                          const char *name)
{
    return scene_render_layer(
        s, &(struct lf_reference_params){.width = size, .height = size, .depth = depth, .jobs = s->jobs},
        samples, name);
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
    picture_panel(&s, 3, (const float[3]){0, 0.2f, -2.5f});
    scene_frame(&s, 0);
    picture_encode(&p, &s, SIZE, SIZE);
    float *truth = trace_layer(&s, SIZE, 2, 150, "direct"), unit = picture_unit(&p, 0);
    double with = 0, without = 0, size = 0;
    for (size_t i = 0; i < SIZE * SIZE; i++) {
        const float *at = p.position + 4 * i;
        if (!(at[3] > 0) || at[1] > -0.99f)
            continue;
        double glossy = (double)(picture_view(&p, 0, LF_INPUT_VIEW_GLOSSY, 0)[i] * unit),
               b = (double)truth[3 * i];
        double ours = glossy * (double)picture_view(&p, 0, LF_INPUT_VIEW_VISIBILITY_SPECULAR, 0)[i];
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
    picture_panel(&s, 3, (const float[3]){0, 1.5f, 0});
    scene_frame(&s, 0);
    picture_encode(&p, &s, SIZE, SIZE);
    float *truth = trace_layer(&s, SIZE, 2, 80, "direct"), unit = picture_unit(&p, 0);
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
        double reached = (double)picture_view(&p, 0, LF_INPUT_VIEW_VISIBILITY_DIFFUSE, 0)[i];
        bool free = picture_view(&p, 0, LF_INPUT_VIEW_SHADOW_DISTANCE, 0)[i] >=
                    picture_view(&p, 0, LF_INPUT_VIEW_DISTANCE, 0)[i];
        assert_true(reached >= 0 && reached <= 1);
        partly += reached > 0.1 && reached < 0.9;
        soft += (all * reached - b) * (all * reached - b);
        hard += (all * free - b) * (all * free - b);
        size += b * b;
    }
    print_message("penumbra: %.2g of the light, %.2g with one ray\n", soft / size, hard / size);
    assert_true(partly > 50 && soft < 0.1 * hard && soft < 0.0035 * size);
    free(truth);
    picture_close(&p);
    scene_close(&s);
}

// Slats before a floor, each two pixels wide, half in the shadow of a board: few neighbours of a pixel are of
// its slat, so what it sees of the lamp it has to ask itself.
static void edges_know_their_shadows(void **state)
{
    NG_UNUSED(state);
    enum { SIZE = 128, SLATS = 24 };
    struct scene s;
    struct picture p = {0};
    scene_open(&s, 2);
    ng_entity rough = scene_material(&s, grey, 0, 1);
    for (int i = 0; i < SLATS; i++)
        scene_quad(&s, (const float[3]){-1.5f, -1 + 0.09f * (float)(i % 3), 1 - 0.1f * (float)i},
                   (const float[3]){3, 0, 0}, (const float[3]){0, 0, -0.05f}, rough);
    scene_quad(&s, (const float[3]){-0.3f, 0.4f, 0.4f}, (const float[3]){0.6f, 0, 0},
               (const float[3]){0, 0, -0.8f}, rough);
    picture_panel(&s, 3, (const float[3]){0, 1.5f, 0});
    scene_frame(&s, 0);
    picture_encode(&p, &s, SIZE, SIZE);
    float *truth = trace_layer(&s, SIZE, 2, 150, "direct"), unit = picture_unit(&p, 0);
    double error = 0, size = 0;
    int partly = 0;
    for (size_t i = 0; i < SIZE * SIZE; i++) {
        float reached = picture_view(&p, 0, LF_INPUT_VIEW_VISIBILITY_DIFFUSE, 0)[i];
        if (!(p.pixels->relief.items[i] & LF_EDGE) || !(p.position[4 * i + 3] > 0))
            continue;
        double ours = (double)((picture_view(&p, 0, LF_INPUT_VIEW_DIFFUSE, 0)[i] +
                                picture_view(&p, 0, LF_INPUT_VIEW_GLOSSY, 0)[i]) *
                               reached * unit),
               b = (double)truth[3 * i];
        partly += reached > 0.05f && reached < 0.95f;
        error += (ours - b) * (ours - b);
        size += b * b;
    }
    print_message("edges: %.2g of the light, %d of them in doubt\n", error / size, partly);
    assert_true(partly > 100 && error < 0.04 * size);
    free(truth);
    picture_close(&p);
    scene_close(&s);
}

struct likeness {
    double error, mean; // relative squared error; ratio of means
    int count;
};

// What rays of metals see, times F0, beside their indirect light by the path tracer.
static struct likeness compare_reflections(const struct picture *p, const float *truth, size_t pixels)
{
    float unit = *lf_pixel_clues_values(p->pixels)->of[LF_INPUT_FRAME_RADIANCE];
    double error = 0, mean = 0, expected = 0;
    int count = 0;
    for (size_t i = 0; i < pixels; i++)
        for (uint32_t c = 0; c < 3; c++) {
            if (!(picture_pixels(p, LF_INPUT_PIXEL_SPECULAR, 0)[i] > 0.5f))
                continue;
            double seen = (double)(picture_pixels(p, LF_INPUT_PIXEL_REFLECTED, c)[i] * unit),
                   b = (double)truth[3 * i + c];
            error += (seen - b) * (seen - b) / (b * b + 1e-3);
            mean += seen;
            expected += b;
            count++;
        }
    return (struct likeness){error / count, mean / expected, count};
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
    picture_point(&s, 4, (const float[3]){0, 1.2f, 2});
    scene_frame(&s, 0);
    picture_encode(&p, &s, SIZE, SIZE);
    float *truth = trace_layer(&s, SIZE, 4, 100, "indirect");
    struct likeness l = compare_reflections(&p, truth, SIZE * SIZE);
    print_message("metals: relative squared error %.2g, mean %.3f\n", l.error, l.mean);
    assert_true(l.count > 1000 && l.error < 0.1 && fabs(l.mean - 1) < 0.1);
    free(truth);
    picture_close(&p);
    scene_close(&s);
}

// A plate of rough metal before a fence of red and blue posts: a lobe sees many of them, a block of rays
// some.
static void wide_lobes_see_much(void **state)
{
    NG_UNUSED(state);
    enum { SIZE = 128, POSTS = 24 };
    static const float red[3] = {0.8f, 0.1f, 0.1f}, blue[3] = {0.1f, 0.1f, 0.8f};
    struct scene s;
    struct picture p = {0};
    scene_open(&s, 2);
    ng_entity metal = scene_material(&s, white, 1, 0.5f);
    ng_entity paint[2] = {scene_material(&s, red, 0, 1), scene_material(&s, blue, 0, 1)};
    scene_quad(&s, (const float[3]){-2, -1, 2}, (const float[3]){4, 0, 0}, (const float[3]){0, 0, -4}, metal);
    for (int i = 0; i < POSTS; i++)
        scene_quad(&s, (const float[3]){-2 + 4.0f / POSTS * (float)i, -1, -2},
                   (const float[3]){2.0f / POSTS, 0, 0}, (const float[3]){0, 2, 0}, paint[i % 2]);
    picture_point(&s, 4, (const float[3]){0, 1.2f, 2});
    scene_frame(&s, 0);
    picture_encode(&p, &s, SIZE, SIZE);
    float *truth = trace_layer(&s, SIZE, 4, 400, "indirect");
    struct likeness l = compare_reflections(&p, truth, SIZE * SIZE);
    print_message("a fence: relative squared error %.2g, mean %.3f\n", l.error, l.mean);
    assert_true(l.count > 1000 && l.error < 0.007 && fabs(l.mean - 1) < 0.25);
    free(truth);
    picture_close(&p);
    scene_close(&s);
}

static bool on_back_wall(const struct picture *p, size_t pixel)
{
    const float *at = p->position + 4 * pixel;
    return at[3] > 0 && at[2] < -1.99f;
}

// Of light from the hemisphere on the back wall: how far points are from the mean of those on both sides.
static double grain_of_wall(const struct picture *p, uint32_t size)
{
    double grain = 0, sum = 0;
    for (size_t y = 0; y < size; y++)
        for (size_t x = 4; x + 4 < size; x++) {
            size_t i = y * size + x;
            if (!on_back_wall(p, i) || !on_back_wall(p, i - 4) || !on_back_wall(p, i + 4))
                continue;
            const float *light = &picture_pixels(p, LF_INPUT_PIXEL_GATHERED, 0)[i];
            grain += fabs((double)light[0] - 0.5 * (double)(light[-4] + light[4]));
            sum += (double)light[0];
        }
    return grain / sum;
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
    picture_point(&s, 2, (const float[3]){0, 1.5f, 0});
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
        rays += (double)(picture_pixels(&p, LF_INPUT_PIXEL_GATHERED, 0)[i] * unit);
        texels += (double)(picture_view(&p, 0, LF_INPUT_VIEW_IRRADIANCE_RSM, 0)[i] * picture_unit(&p, 0));
    }
    double grain = grain_of_wall(&p, SIZE);
    print_message("of the indirect light: rays %.2f, texels %.2f; grain %.2g\n", rays / expected,
                  texels / expected, grain);
    assert_true(expected > 0 && texels > 1.5 * expected); // so that there is something in the way
    assert_true(grain < 0.02);
    assert_true(fabs(rays - expected) < 0.5 * fabs(texels - expected));
    free(truth);
    picture_close(&p);
    scene_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(highlights_are_shadowed),  cmocka_unit_test(penumbrae_are_soft),
        cmocka_unit_test(edges_know_their_shadows), cmocka_unit_test(metals_show_what_surrounds_them),
        cmocka_unit_test(wide_lobes_see_much),      cmocka_unit_test(what_stands_in_the_way_counts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// Rays against the renderer's maps, on the chess scene: the same RSM, the same distances but at edges.
#include "picture.h"

#include "app/stage.h"
#include "lightformer/dataset/capture.h"

#include <math.h>

enum { SIZE = 128 };

struct chess {
    struct ng_stage *stage;
    struct lf_capture *observer;
    struct lf_captured_frame seen;
    struct lf_tracer *tracer;
    struct lf_pixel_clues *pixels;
};

static void open_chess(struct chess *c)
{
    OK(ng_stage_create(&(struct ng_stage_params){.scene = "content/chess/chess.glb", .threads = 2},
                       &c->stage));
    OK(ng_stage_seek(c->stage, 1.3, NULL));
    OK(lf_capture_create(c->stage->gpu, c->stage->jobs, &c->observer));
    OK(lf_capture_frame(
        c->observer,
        &(struct lf_capture_params){.snapshot = c->stage->snapshot, .width = SIZE, .height = SIZE},
        &c->seen));
    OK(lf_tracer_create(&c->tracer));
    OK(lf_tracer_update(c->tracer, c->stage->snapshot));
    OK(lf_pixel_clues_create(&c->pixels));
    struct lf_clues_scene scene = {.tracer = c->tracer, .jobs = c->stage->jobs};
    OK(lf_clues_pixels(
        &scene, &(struct lf_clues_pixels_params){.gbuffer = c->seen.gbuffer, .width = SIZE, .height = SIZE},
        c->pixels));
}

static void close_chess(struct chess *c)
{
    lf_pixel_clues_destroy(&c->pixels);
    lf_tracer_destroy(&c->tracer);
    lf_capture_destroy(&c->observer);
    ng_stage_destroy(&c->stage);
}

static struct lf_light_clues *encode(const struct chess *c, const struct lf_captured_light *light,
                                     bool from_maps)
{
    struct lf_clues_scene scene = {.tracer = c->tracer, .jobs = c->stage->jobs};
    struct lf_clues_light_params params = {.maps = from_maps ? light : NULL};
    struct lf_light_clues *clues;
    OK(lf_light_clues_create(&clues));
    OK(lf_clues_light(&scene, light->light, &params, clues));
    OK(lf_clues_view(&scene, c->pixels, clues));
    return clues;
}

static double sum_of(const struct lf_light_clues *clues, enum lf_net_input input, size_t channel)
{
    double sum = 0;
    size_t rows = lf_light_clues_texels(clues);
    for (size_t i = 0; i < rows; i++)
        sum += (double)lf_light_clues_values(clues)->of[input][channel * rows + i] / (double)rows;
    return sum;
}

static void compare_texels(const struct lf_light_clues *a, const struct lf_light_clues *b)
{
    uint32_t rows[2] = {lf_light_clues_texels(a), lf_light_clues_texels(b)};
    assert_true(rows[0] > 8000 && fabs((double)rows[0] - (double)rows[1]) < 0.005 * rows[0]);
    for (size_t c = 0; c < 3; c++) {
        double flux = sum_of(a, LF_INPUT_TEXEL_FLUX, c); // the mean is the reflected share
        assert_true(flux > 0.05 && flux < 1);
        NEAR(sum_of(b, LF_INPUT_TEXEL_FLUX, c), flux, 0.005 * flux);
        NEAR(sum_of(b, LF_INPUT_TEXEL_POSITION, c), sum_of(a, LF_INPUT_TEXEL_POSITION, c), 0.005);
        NEAR(sum_of(b, LF_INPUT_TEXEL_OFFSET, c), sum_of(a, LF_INPUT_TEXEL_OFFSET, c), 0.005);
        NEAR(sum_of(b, LF_INPUT_TEXEL_NORMAL, c), sum_of(a, LF_INPUT_TEXEL_NORMAL, c), 0.005);
    }
}

// Of pixels toward which the light, a rectangle, sends something; to others no ray is cast.
static void compare_distances(const struct chess *c, const float look[3], const struct lf_light_clues *a,
                              const struct lf_light_clues *b)
{
    const float *far[2] = {lf_light_clues_values(a)->of[LF_INPUT_VIEW_DISTANCE],
                           lf_light_clues_values(b)->of[LF_INPUT_VIEW_DISTANCE]};
    const float *near[2] = {lf_light_clues_values(a)->of[LF_INPUT_VIEW_SHADOW_DISTANCE],
                            lf_light_clues_values(b)->of[LF_INPUT_VIEW_SHADOW_DISTANCE]};
    const float *mask = lf_pixel_clues_values(c->pixels)->of[LF_INPUT_PIXEL_MASK];
    int pixels = 0, same = 0, shaded = 0;
    for (size_t i = 0; i < SIZE * SIZE; i++) {
        float cosine = 0;
        for (size_t k = 0; k < 3; k++)
            cosine -= look[k] * lf_light_clues_values(a)->of[LF_INPUT_VIEW_DIRECTION][k * SIZE * SIZE + i];
        if (!(mask[i] > 0) || cosine < 0)
            continue;
        assert_true(far[0][i] == far[1][i] && near[0][i] <= far[0][i]);
        pixels++;
        shaded += near[0][i] < far[0][i];
        same += fabsf(near[0][i] - near[1][i]) < 0.02f * far[0][i];
    }
    print_message("%d of %d pixels, %d in shadow\n", same, pixels, shaded);
    assert_true(pixels > SIZE * SIZE / 2 && shaded > 500 && same > 0.98 * pixels);
}

static void rays_see_what_maps_show(void **state)
{
    NG_UNUSED(state);
    struct chess c = {0};
    open_chess(&c);
    assert_int_equal(c.seen.light_count, 2);
    for (uint32_t i = 0; i < c.seen.light_count; i++) {
        struct lf_light_clues *rays = encode(&c, &c.seen.lights[i], false),
                              *maps = encode(&c, &c.seen.lights[i], true);
        compare_texels(rays, maps);
        compare_distances(&c, c.seen.lights[i].data.look, rays, maps);
        lf_light_clues_destroy(&rays);
        lf_light_clues_destroy(&maps);
    }
    close_chess(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_see_what_maps_show),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

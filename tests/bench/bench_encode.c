// What the inputs of the network cost, stage by stage, and how far view.diffuse + view.glossy are from the
// path tracer's unshadowed light: bench_encode [SCENE [SIZE [ROUNDS [SPP [TIME]]]]]. Prints JSON:
// milliseconds are medians over rounds; errors relative to a reference of SPP samples (0: none).
#include "app/stage.h"
#include "base/system.h"
#include "lightformer/clues/clues.h"
#include "lightformer/dataset/capture.h"
#include "lightformer/reference/reference.h"
#include "lightformer/trace/tracer.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define LIGHTS 16
#define ROUNDS 64

struct bench {
    struct ng_stage *stage;
    struct lf_capture *observer;
    struct lf_captured_frame seen;
    struct lf_tracer *tracer;
    struct lf_pixel_clues *pixels;
    struct lf_light_clues *lights[LIGHTS];
    uint32_t light_count, size;
};

static ng_result open_bench(struct bench *b, const char *scene, double time)
{
    NG_TRY(ng_stage_create(&(struct ng_stage_params){.scene = scene}, &b->stage));
    NG_TRY(ng_stage_seek(b->stage, time, NULL));
    NG_TRY(lf_capture_create(b->stage->gpu, b->stage->jobs, &b->observer));
    NG_TRY(lf_capture_frame(
        b->observer,
        &(struct lf_capture_params){.snapshot = b->stage->snapshot, .width = b->size, .height = b->size},
        &b->seen));
    NG_TRY(lf_tracer_create(&b->tracer));
    NG_TRY(lf_tracer_update(b->tracer, b->stage->snapshot));
    NG_TRY(lf_pixel_clues_create(&b->pixels));
    b->light_count = b->stage->snapshot->light_count < LIGHTS ? b->stage->snapshot->light_count : LIGHTS;
    for (uint32_t i = 0; i < b->light_count; i++)
        NG_TRY(lf_light_clues_create(&b->lights[i]));
    return NG_OK;
}

static void close_bench(struct bench *b)
{
    for (uint32_t i = 0; i < b->light_count; i++)
        lf_light_clues_destroy(&b->lights[i]);
    lf_pixel_clues_destroy(&b->pixels);
    lf_tracer_destroy(&b->tracer);
    lf_capture_destroy(&b->observer);
    ng_stage_destroy(&b->stage);
}

static ng_result encode(struct bench *b)
{
    struct lf_clues_scene scene = {.tracer = b->tracer, .jobs = b->stage->jobs};
    struct lf_clues_pixels_params params = {.gbuffer = b->seen.gbuffer, .width = b->size, .height = b->size};
    NG_TRY(lf_clues_pixels(&scene, &params, b->pixels));
    for (uint32_t i = 0; i < b->light_count; i++) {
        NG_TRY(lf_clues_light(&scene, i, NULL, b->lights[i]));
        NG_TRY(lf_clues_view(&scene, b->pixels, b->lights[i]));
    }
    lf_clues_set_powers(b->stage->snapshot, b->pixels, b->lights, b->light_count);
    NG_TRY(lf_clues_arriving(&scene, b->pixels, b->lights, b->light_count));
    return NG_OK;
}

static int compare_numbers(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double stage_ms(const struct bench *b, enum lf_clues_stage stage)
{
    double ms = lf_pixel_clues_ms(b->pixels, stage);
    for (uint32_t i = 0; i < b->light_count; i++)
        ms += lf_light_clues_ms(b->lights[i], stage);
    return ms;
}

static ng_result measure_stages(struct bench *b, uint32_t rounds)
{
    static double ms[LF_CLUES_STAGES + 1][ROUNDS];
    for (uint32_t r = 0; r < rounds; r++) {
        uint64_t begin = ng_clock_ns();
        NG_TRY(encode(b));
        ms[LF_CLUES_STAGES][r] = (double)(ng_clock_ns() - begin) * 1e-6;
        for (int s = 0; s < LF_CLUES_STAGES; s++)
            ms[s][r] = stage_ms(b, (enum lf_clues_stage)s);
    }
    for (int s = 0; s <= LF_CLUES_STAGES; s++) {
        qsort(ms[s], rounds, sizeof **ms, compare_numbers);
        printf("\"%s_ms\": %.2f, ", s < LF_CLUES_STAGES ? lf_clues_stage_names[s] : "all", ms[s][rounds / 2]);
    }
    return NG_OK;
}

// T_l of the network's inputs, as the gather of `structured` without corrections would make it.
static void direct_at(const struct bench *b, size_t pixel, float out[3])
{
    size_t n = (size_t)b->size * b->size;
    float radiance = *lf_pixel_clues_values(b->pixels)->of[LF_INPUT_FRAME_RADIANCE];
    for (size_t c = 0; c < 3; c++) {
        out[c] = 0;
        for (uint32_t i = 0; i < b->light_count; i++) {
            const struct lf_net_values *v = lf_light_clues_values(b->lights[i]);
            out[c] +=
                (v->of[LF_INPUT_VIEW_DIFFUSE][c * n + pixel] + v->of[LF_INPUT_VIEW_GLOSSY][c * n + pixel]) *
                *v->of[LF_INPUT_LIGHT_SHARE] * radiance;
        }
    }
}

static ng_result measure_error(struct bench *b, uint32_t spp)
{
    struct lf_reference *reference;
    struct lf_layer layer;
    size_t n = (size_t)b->size * b->size;
    NG_TRY(lf_reference_create(
        &(struct lf_reference_params){
            .width = b->size, .height = b->size, .depth = 2, .jobs = b->stage->jobs},
        &reference));
    NG_TRY(lf_reference_begin(reference, b->tracer));
    NG_TRY(lf_reference_run(reference, &(struct lf_reference_run_params){.samples = spp}));
    NG_TRY(lf_reference_layer(reference, "unshadowed", &layer));
    const float *truth = layer.pixels,
                *rough = lf_pixel_clues_values(b->pixels)->of[LF_INPUT_PIXEL_ROUGHNESS];
    double mean = 0, error[2] = {0}, sum = 0;
    for (size_t i = 0; i < n * 3; i++)
        mean += (double)truth[i] / (double)(n * 3);
    for (size_t i = 0; i < n; i++) {
        float ours[3];
        direct_at(b, i, ours);
        for (size_t c = 0; c < 3; c++) {
            double x = (double)ours[c] / mean, y = (double)truth[i * 3 + c] / mean;
            error[rough[i] < 0.5f] += (x - y) * (x - y) / (y * y + 0.01) / (double)(n * 3);
            sum += (double)ours[c] / (double)(n * 3);
        }
    }
    printf("\"rse_rough\": %.5f, \"rse_smooth\": %.5f, \"ratio\": %.4f, ", error[0], error[1], sum / mean);
    free(layer.pixels);
    lf_reference_destroy(&reference);
    return NG_OK;
}

static ng_result measure(struct bench *b, uint32_t rounds, uint32_t spp)
{
    NG_TRY(encode(b)); // memory grows once
    printf("{\"size\": %u, \"lights\": %u, ", b->size, b->light_count);
    NG_TRY(measure_stages(b, rounds));
    if (spp)
        NG_TRY(measure_error(b, spp));
    printf("\"texels\": %u}\n", b->light_count ? lf_light_clues_texels(b->lights[0]) : 0);
    return NG_OK;
}

int main(int argc, char **argv)
{
    const char *scene = argc > 1 ? argv[1] : "content/chess/chess.glb";
    struct bench b = {.size = argc > 2 ? (uint32_t)atoi(argv[2]) : 512};
    uint32_t rounds = argc > 3 ? (uint32_t)atoi(argv[3]) : 9, spp = argc > 4 ? (uint32_t)atoi(argv[4]) : 0;
    rounds = rounds < 1 ? 1 : rounds > ROUNDS ? ROUNDS : rounds;
    ng_result result = open_bench(&b, scene, argc > 5 ? atof(argv[5]) : 0);
    if (result == NG_OK)
        result = measure(&b, rounds, spp);
    close_bench(&b);
    return result == NG_OK ? 0 : 1;
}

// How fast the path tracer traces, against a bare loop of closest hits of incoherent rays in the same scene
// on as many threads: bench_reference [SCENE [SIZE [SAMPLES]]]. Prints JSON: medians over rounds.
#include "asset/assets.h"
#include "asset/gltf.h"
#include "base/jobs.h"
#include "base/rng.h"
#include "base/system.h"
#include "components/components.h"
#include "lightformer/reference/reference.h"
#include "render/extract.h"
#include "render/scene_systems.h"
#include "scene/system.h"
#include "scene/world.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define RAYS   65536u
#define ROUNDS 5

struct bench {
    struct ng_jobs *jobs;
    struct ng_assets *assets;
    struct ng_world *world;
    struct ng_extractor *extractor;
    const struct ng_snapshot *snapshot;
    struct lf_tracer *tracer;
    struct lf_ray *rays;
};

static ng_result open_scene(struct bench *b, const char *path)
{
    struct ng_gltf_scene scene;
    NG_TRY(ng_jobs_create(&(struct ng_jobs_params){0}, &b->jobs));
    NG_TRY(ng_assets_create(&b->assets));
    NG_TRY(ng_world_create(NULL, &b->world));
    NG_TRY(ng_components_register(b->world));
    NG_TRY(ng_scene_systems_add(b->world, b->assets, b->jobs));
    NG_TRY(ng_gltf_load(path, b->world, b->assets, NULL, &scene));
    NG_TRY(ng_extractor_create(&b->extractor));
    return lf_tracer_create(&b->tracer);
}

static ng_result move_to(struct bench *b, double time)
{
    NG_TRY(ng_world_run(b->world, time));
    struct ng_extract_params p = {.world = b->world, .assets = b->assets, .jobs = b->jobs, .time = time};
    NG_TRY(ng_extract(b->extractor, &p, &b->snapshot));
    return lf_tracer_update(b->tracer, b->snapshot);
}

static void close_scene(struct bench *b)
{
    free(b->rays);
    lf_tracer_destroy(&b->tracer);
    ng_extractor_destroy(&b->extractor);
    ng_world_destroy(&b->world);
    ng_assets_destroy(&b->assets);
    ng_jobs_destroy(&b->jobs);
}

// Rays from random points of what the camera sees into random directions.
static ng_result make_rays(struct bench *b)
{
    const uint32_t size = 256;
    struct lf_reference *reference;
    struct lf_layer position, normal;
    b->rays = calloc(RAYS, sizeof *b->rays);
    if (!b->rays)
        return NG_ERROR_MEMORY;
    NG_TRY(lf_reference_create(&(struct lf_reference_params){.width = size, .height = size}, &reference));
    NG_TRY(lf_reference_begin(reference, b->tracer));
    NG_TRY(lf_reference_layer(reference, "position", &position));
    NG_TRY(lf_reference_layer(reference, "normal", &normal));
    struct ng_rng rng = ng_rng_make(1, 2);
    for (uint32_t i = 0; i < RAYS; i++) {
        struct lf_ray *ray = &b->rays[i];
        size_t pixel = ng_rng_below(&rng, size * size);
        const float *n = (const float *)normal.pixels + pixel * 3;
        float z = ng_rng_range(&rng, -1, 1), phi = ng_rng_range(&rng, 0, 6.2831853f), s = sqrtf(1 - z * z);
        const float d[3] = {s * cosf(phi), s * sinf(phi), z};
        float sign = n[0] * d[0] + n[1] * d[1] + n[2] * d[2] < 0 ? -1.0f : 1.0f;
        for (int c = 0; c < 3; c++)
            ray->direction[c] = sign * d[c];
        lf_trace_origin(b->tracer, (const float *)position.pixels + pixel * 3, n, ray->direction,
                        ray->origin);
        ray->far = INFINITY;
    }
    free(position.pixels);
    free(normal.pixels);
    lf_reference_destroy(&reference);
    return NG_OK;
}

static void trace_bare(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct bench *b = user;
    lf_trace_bare(b->tracer, b->rays + begin, end - begin);
}

static double bare_rays_a_second(struct bench *b)
{
    uint64_t begin = ng_clock_ns(), rays = 0;
    double seconds;
    do {
        ng_jobs_for(b->jobs, RAYS, 1024, trace_bare, b);
        rays += RAYS;
        seconds = (double)(ng_clock_ns() - begin) * 1e-9;
    } while (seconds < 0.25);
    return (double)rays / seconds;
}

static int compare_ratios(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static ng_result measure(struct bench *b, uint32_t size, uint32_t samples)
{
    NG_TRY(move_to(b, 0));
    struct lf_tracer_stats built = lf_tracer_stats_of(b->tracer);
    NG_TRY(make_rays(b));
    struct lf_reference *reference;
    struct lf_reference_params params = {.width = size, .height = size, .jobs = b->jobs};
    NG_TRY(lf_reference_create(&params, &reference));
    double bare[ROUNDS], traced[ROUNDS], ratios[ROUNDS];
    struct lf_reference_stats stats;
    for (int i = 0; i < ROUNDS; i++) { // in turns, so that both see the same machine
        bare[i] = bare_rays_a_second(b);
        NG_TRY(lf_reference_begin(reference, b->tracer));
        NG_TRY(lf_reference_run(reference, &(struct lf_reference_run_params){.samples = samples}));
        stats = lf_reference_stats_of(reference);
        traced[i] = (double)stats.rays / stats.seconds;
        ratios[i] = traced[i] / bare[i];
    }
    lf_reference_destroy(&reference);
    double pixels = (double)samples * size * size, rays_a_sample = (double)stats.rays / pixels;
    qsort(bare, ROUNDS, sizeof *bare, compare_ratios);
    qsort(traced, ROUNDS, sizeof *traced, compare_ratios);
    qsort(ratios, ROUNDS, sizeof *ratios, compare_ratios);
    NG_TRY(move_to(b, 1 / 30.0));
    NG_TRY(move_to(b, 2 / 30.0));
    struct lf_tracer_stats moved = lf_tracer_stats_of(b->tracer);
    printf("{\"triangles\": %llu, \"build_ms\": %.1f, \"refit_ms\": %.2f, \"refitted\": %u, "
           "\"bare_rays_s\": %.0f, \"reference_rays_s\": %.0f, \"samples_s\": %.0f, "
           "\"rays_a_sample\": %.2f, \"ratio\": %.3f}\n",
           (unsigned long long)built.triangles, built.update_ms, moved.update_ms, moved.updated,
           bare[ROUNDS / 2], traced[ROUNDS / 2], traced[ROUNDS / 2] / rays_a_sample, rays_a_sample,
           ratios[ROUNDS / 2]);
    return NG_OK;
}

int main(int argc, char **argv)
{
    struct bench b = {0};
    const char *path = argc > 1 ? argv[1] : "content/chess/chess.glb";
    uint32_t size = argc > 2 ? (uint32_t)atoi(argv[2]) : 128;
    uint32_t samples = argc > 3 ? (uint32_t)atoi(argv[3]) : 8;
    ng_result result = open_scene(&b, path);
    if (result == NG_OK)
        result = measure(&b, size, samples);
    close_scene(&b);
    return result == NG_OK ? 0 : 1;
}

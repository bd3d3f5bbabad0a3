// The path tracer and the bare loop take turns, round by round, so that both see the same machine; medians
// over the rounds. The bare loop starts at random points of what the camera sees, into random directions, as
// the second ray of a path does.
#include "bench_reference.h"

#include "json.h"
#include "opening.h"

#include "app/stage.h"
#include "base/file.h"
#include "base/jobs.h"
#include "base/log.h"
#include "base/printable.h"
#include "base/rng.h"
#include "base/system.h"
#include "lightformer/reference/reference.h"

#include <math.h>
#include <stdlib.h>

#define RAYS         65536u
#define ROUNDS       5
#define BARE_SECONDS 0.25 // of a round
#define RAY_PIXELS   256  // a side of the picture that the bare loop's rays start from

struct session {
    const struct bench_reference_params *params;
    struct ng_stage *stage;
    struct lf_tracer *tracer;
    struct lf_ray *rays;
};

struct figures {
    struct lf_tracer_stats built, moved; // by the first snapshot; by a frame of animation
    double bare, traced, ratio;          // rays a second; medians
    double samples;                      // a second; median
    struct lf_reference_stats last;
};

// ---- the scene -------------------------------------------------------------------------------------------
static ng_result move_to(struct session *s, double time)
{
    NG_TRY(ng_stage_seek(s->stage, time, NULL));
    return lf_tracer_update(s->tracer, s->stage->snapshot);
}

static ng_result open_session(struct session *s)
{
    struct ng_stage_params params = {
        .scene = s->params->scene, .threads = s->params->threads, .no_device = true};
    opening_apply(s->params->opening, &params);
    NG_TRY(ng_stage_create(&params, &s->stage));
    NG_TRY(lf_tracer_create(&s->tracer));
    return move_to(s, 0);
}

static void close_session(struct session *s)
{
    free(s->rays);
    lf_tracer_destroy(&s->tracer);
    ng_stage_destroy(&s->stage);
}

// ---- the bare loop ---------------------------------------------------------------------------------------
static void make_ray(const struct session *s, struct ng_rng *rng, const float position[3],
                     const float normal[3], struct lf_ray *out)
{
    float z = ng_rng_range(rng, -1, 1), phi = ng_rng_range(rng, 0, 6.2831853f), r = sqrtf(1 - z * z);
    const float d[3] = {r * cosf(phi), r * sinf(phi), z};
    float side = normal[0] * d[0] + normal[1] * d[1] + normal[2] * d[2] < 0 ? -1.0f : 1.0f;
    for (int i = 0; i < 3; i++)
        out->direction[i] = side * d[i];
    lf_trace_origin(s->tracer, position, normal, out->direction, out->origin);
    out->far = INFINITY;
}

static void make_rays(struct session *s, const struct lf_layer *position, const struct lf_layer *normal)
{
    struct ng_rng rng = ng_rng_make(1, 2);
    for (uint32_t i = 0; i < RAYS; i++) {
        size_t at = (size_t)ng_rng_below(&rng, RAY_PIXELS * RAY_PIXELS) * 3;
        make_ray(s, &rng, (const float *)position->pixels + at, (const float *)normal->pixels + at,
                 &s->rays[i]);
    }
}

static ng_result prepare_rays(struct session *s)
{
    struct lf_reference *picture;
    struct lf_layer position = {0}, normal = {0};
    s->rays = calloc(RAYS, sizeof *s->rays);
    if (!s->rays)
        return ng_out_of_memory("rays to measure");
    NG_TRY(lf_reference_create(&(struct lf_reference_params){.width = RAY_PIXELS, .height = RAY_PIXELS},
                               &picture));
    ng_result result = lf_reference_begin(picture, s->tracer);
    if (result == NG_OK)
        result = lf_reference_layer(picture, "position", &position);
    if (result == NG_OK)
        result = lf_reference_layer(picture, "normal", &normal);
    if (result == NG_OK)
        make_rays(s, &position, &normal);
    free(position.pixels);
    free(normal.pixels);
    lf_reference_destroy(&picture);
    return result;
}

static void trace_bare(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct session *s = user;
    lf_trace_bare(s->tracer, s->rays + begin, end - begin);
}

static double seconds_since(uint64_t ns)
{
    return (double)(ng_clock_ns() - ns) * 1e-9;
}

static double bare_rays_a_second(struct session *s)
{
    uint64_t begin = ng_clock_ns(), rays = 0;
    do {
        ng_jobs_for(s->stage->jobs, RAYS, 1024, trace_bare, s);
        rays += RAYS;
    } while (seconds_since(begin) < BARE_SECONDS);
    return (double)rays / seconds_since(begin);
}

// ---- rounds ----------------------------------------------------------------------------------------------
static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double values[ROUNDS])
{
    qsort(values, ROUNDS, sizeof *values, compare);
    return values[ROUNDS / 2];
}

static ng_result take_turns(struct session *s, struct lf_reference *picture, struct figures *out)
{
    double bare[ROUNDS], traced[ROUNDS], samples[ROUNDS], ratios[ROUNDS];
    double pixels = (double)s->params->size.width * s->params->size.height;
    for (int i = 0; i < ROUNDS; i++) {
        bare[i] = bare_rays_a_second(s);
        NG_TRY(lf_reference_begin(picture, s->tracer));
        NG_TRY(lf_reference_run(picture, &(struct lf_reference_run_params){.samples = s->params->samples}));
        out->last = lf_reference_stats_of(picture);
        traced[i] = (double)out->last.rays / out->last.seconds;
        samples[i] = pixels * s->params->samples / out->last.seconds;
        ratios[i] = traced[i] / bare[i];
    }
    out->bare = median(bare);
    out->traced = median(traced);
    out->samples = median(samples);
    out->ratio = median(ratios);
    return NG_OK;
}

static ng_result measure(struct session *s, struct figures *out)
{
    struct lf_reference *picture;
    struct lf_reference_params params = {.width = s->params->size.width,
                                         .height = s->params->size.height,
                                         .jobs = s->stage->jobs,
                                         .timed = true};
    out->built = lf_tracer_stats_of(s->tracer);
    NG_TRY(prepare_rays(s));
    NG_TRY(lf_reference_create(&params, &picture));
    ng_result result = take_turns(s, picture, out);
    lf_reference_destroy(&picture);
    NG_TRY(result);
    NG_TRY(move_to(s, 1 / 30.0));
    NG_TRY(move_to(s, 2 / 30.0));
    out->moved = lf_tracer_stats_of(s->tracer);
    return NG_OK;
}

// ---- printing --------------------------------------------------------------------------------------------
static double share(uint64_t part, uint64_t whole)
{
    return whole ? (double)part / (double)whole : 0;
}

static void print_figures(const struct session *s, const struct figures *f)
{
    const struct lf_path_stats *p = &f->last.paths;
    double paths = (double)s->params->size.width * s->params->size.height * s->params->samples;
    ng_print_line(stdout, "%s, %ux%u, %u samples a pixel, %u threads", ng_path_name(s->params->scene),
                  s->params->size.width, s->params->size.height, s->params->samples,
                  ng_jobs_threads(s->stage->jobs));
    printf("bare loop of closest hits  %8.2f million rays a second\n", f->bare * 1e-6);
    printf("path tracer                %8.2f million rays a second, ratio %.3f\n", f->traced * 1e-6,
           f->ratio);
    printf("                           %8.3f million samples a second\n", f->samples * 1e-6);
    printf("rays a sample              %8.2f: %.2f of paths, %.2f of shadows; besides, %.2f through emitters "
           "alone\n",
           (double)f->last.rays / paths, (double)p->path_rays / paths, (double)p->shadow_rays / paths,
           (double)p->emitter_rays / paths);
    printf("time                       %7.1f %% rays of paths, %.1f %% rays of shadows, %.1f %% shading\n",
           100 * share(p->path_ns, p->total_ns), 100 * share(p->shadow_ns, p->total_ns),
           100 * (1 - share(p->path_ns + p->shadow_ns, p->total_ns)));
    printf("%llu triangles: built in %.1f ms; a frame of animation moves %u of %u instances in %.2f ms\n",
           (unsigned long long)f->built.triangles, f->built.update_ms, f->moved.updated, f->moved.instances,
           f->moved.update_ms);
}

static void write_figures(const struct session *s, const struct figures *f)
{
    struct json j = {.out = stdout};
    const struct lf_path_stats *p = &f->last.paths;
    double paths = (double)s->params->size.width * s->params->size.height * s->params->samples;
    json_object(&j, NULL);
    json_text(&j, "scene", ng_path_name(s->params->scene));
    json_number(&j, "width", s->params->size.width);
    json_number(&j, "height", s->params->size.height);
    json_number(&j, "samples", s->params->samples);
    json_number(&j, "threads", ng_jobs_threads(s->stage->jobs));
    json_number(&j, "bare_rays_s", f->bare);
    json_number(&j, "reference_rays_s", f->traced);
    json_number(&j, "ratio", f->ratio);
    json_number(&j, "samples_s", f->samples);
    json_object(&j, "rays_a_sample");
    json_number(&j, "path", (double)p->path_rays / paths);
    json_number(&j, "shadow", (double)p->shadow_rays / paths);
    json_number(&j, "emitter", (double)p->emitter_rays / paths);
    json_end(&j);
    json_object(&j, "share_of_time");
    json_number(&j, "path_rays", share(p->path_ns, p->total_ns));
    json_number(&j, "shadow_rays", share(p->shadow_ns, p->total_ns));
    json_number(&j, "shading", 1 - share(p->path_ns + p->shadow_ns, p->total_ns));
    json_end(&j);
    json_number(&j, "triangles", (double)f->built.triangles);
    json_number(&j, "build_ms", f->built.update_ms);
    json_number(&j, "refit_ms", f->moved.update_ms);
    json_number(&j, "refitted", f->moved.updated);
    json_end(&j);
}

ng_result bench_reference(const struct bench_reference_params *params)
{
    struct session s = {.params = params};
    struct figures figures = {0};
    ng_result result = open_session(&s);
    if (result == NG_OK)
        result = measure(&s, &figures);
    if (result == NG_OK)
        (params->json ? write_figures : print_figures)(&s, &figures);
    close_session(&s);
    return result;
}

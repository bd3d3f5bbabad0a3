// Frames in which everything is redone, of the scene as it is and of others made from it: with more lights,
// with more things. What is compared is measured in turns within one process, so that what else the machine
// does touches it alike; peak memory and the first picture are those of processes of their own.
#define _DEFAULT_SOURCE // setenv, wait4
#include "bench_neural.h"

#include "bench_room.h"
#include "bench_scene.h"
#include "commands.h"
#include "opening.h"
#include "progress.h"

#include "app/stage.h"
#include "base/array.h"
#include "base/log.h"
#include "base/system.h"
#include "components/components.h"
#include "components/transform.h"
#include "lightformer/methods/methods.h"
#include "lightformer/neural/neural.h"
#include "lightformer/reference/reference.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#define WARM_UP       3
#define MAX_FRAMES    256u
#define MEMORY_LIGHTS 7u
#define NET_LIGHTS    2u
#define MEMORY_GOAL   700e6 // bytes
#define FIRST_GOAL    3.0   // seconds
#define TRACER_DEPTH  5u

// ---- A scene under measurement ---------------------------------------------------------------------------

struct subject {
    const struct bench_neural_params *params;
    struct ng_stage *stage;
    struct lf_method *neural;
    uint32_t frame;
    NG_ARRAY(uint64_t) runs; // of each pass, before the last frame
};

static void close_subject(struct subject *s)
{
    lf_method_destroy(&s->neural);
    ng_stage_destroy(&s->stage);
    ng_array_finish(&s->runs);
}

static ng_result join(struct subject *s)
{
    ng_graph_ignore_keys(ng_renderer_graph(s->stage->renderer), true); // everything, in every frame
    return lf_method_create(&(struct lf_method_params){.name = LF_NEURAL_METHOD,
                                                       .composer = ng_renderer_composer(s->stage->renderer),
                                                       .jobs = s->stage->jobs,
                                                       .scene = s->params->scene,
                                                       .weights = s->params->weights,
                                                       .gbuffer = (enum lf_raycast_use)s->params->gbuffer},
                            &s->neural);
}

static ng_result open_subject(const struct bench_neural_params *params, struct subject *s)
{
    *s = (struct subject){.params = params};
    struct ng_stage_params stage = {
        .scene = params->scene, .device = params->device, .threads = params->threads};
    opening_apply(params->opening, &stage);
    NG_TRY(ng_stage_create(&stage, &s->stage));
    ng_result result = join(s);
    if (result != NG_OK)
        close_subject(s);
    return result;
}

// Draws the next frame and waits for its picture.
static ng_result draw(struct subject *s, double *ms)
{
    static const char *const layers[] = {"display"};
    const struct ng_stage_frame frame = {.time = s->frame++ / CLI_FRAMES_A_SECOND,
                                         .width = s->params->width,
                                         .height = s->params->height,
                                         .method = LF_NEURAL_METHOD,
                                         .layers = layers,
                                         .layer_count = NG_COUNT(layers)};
    const uint8_t *rgba;
    uint32_t width, height;
    uint64_t start = ng_clock_ns();
    NG_TRY(ng_stage_draw(s->stage, &frame));
    NG_TRY(ng_renderer_display(s->stage->renderer, &rgba, &width, &height));
    *ms = (double)(ng_clock_ns() - start) * 1e-6;
    return NG_OK;
}

static ng_result warm_up(struct subject *s, uint32_t frames)
{
    double ms;
    for (uint32_t i = 0; i < frames; i++)
        NG_TRY(draw(s, &ms));
    return NG_OK;
}

// ---- Figures of a frame ----------------------------------------------------------------------------------

enum stage {
    SCENE,
    TRACE,
    RSM,
    GBUFFER,
    PIXELS,
    CLUES,
    LIGHT,
    UNET,
    GATHER,
    DISPLAY,
    STAGES,
};

static const struct {
    const char *name, *begins, *ends; // of the passes
    enum stage stage;
    bool gpu;
} pass_stages[] = {
    {"rays follow", "trace:update", "", TRACE, false},
    {"RSM", "encode:", "/rsm", RSM, false},
    {"G-buffer", "gbuffer", "", GBUFFER, true},
    {NULL, "background", "", GBUFFER, true},
    {"pixel clues", "clues:pixels", "", PIXELS, false},
    {"clues", "encode:", "/clues", CLUES, false},
    {"light encoding", "encode:", "/light", LIGHT, false},
    {"U-Net", "encode:", "/view", UNET, false},
    {"gather", "gather", "", GATHER, false},
    {NULL, "clues:normalization", "", GATHER, false},
    {"tone map", "tone map", "", DISPLAY, true},
    {NULL, "compose", "", DISPLAY, true},
};

static const char *stage_name(enum stage stage)
{
    for (size_t i = 0; i < NG_COUNT(pass_stages); i++)
        if (pass_stages[i].stage == stage && pass_stages[i].name)
            return pass_stages[i].name;
    return "scene";
}

static bool matches(const char *name, const char *begins, const char *ends)
{
    size_t length = strlen(name), end = strlen(ends);
    return strncmp(name, begins, strlen(begins)) == 0 && length >= end &&
           strcmp(name + length - end, ends) == 0;
}

static void add_pass(double ms[STAGES], const struct ng_pass_stats *pass)
{
    for (size_t k = 0; k < NG_COUNT(pass_stages); k++)
        if (matches(pass->name, pass_stages[k].begins, pass_stages[k].ends))
            // The G-buffer may be made on either side.
            ms[pass_stages[k].stage] += pass_stages[k].gpu && pass->gpu_ms > 0 ? pass->gpu_ms : pass->cpu_ms;
}

// Milliseconds of each stage in the last frame.
static ng_result read_stages(struct subject *s, double ms[STAGES])
{
    size_t count;
    const struct ng_pass_stats *stats = ng_graph_stats(ng_renderer_graph(s->stage->renderer), &count);
    if (!ng_array_resize(&s->runs, count))
        return ng_out_of_memory("measurements");
    memset(ms, 0, STAGES * sizeof *ms);
    ms[SCENE] = s->stage->world_ms + s->stage->extract_ms;
    for (size_t i = 0; i < count; i++) {
        if (stats[i].runs > s->runs.items[i]) // the others repeat their last figure
            add_pass(ms, &stats[i]);
        s->runs.items[i] = stats[i].runs;
    }
    return NG_OK;
}

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, uint32_t count)
{
    qsort(values, count, sizeof *values, compare_doubles);
    return count ? values[count / 2] : 0;
}

static uint32_t frames_of(const struct bench_neural_params *params)
{
    return params->frames < MAX_FRAMES ? params->frames : MAX_FRAMES;
}

// ---- The frame, and a sample of the path tracer ----------------------------------------------------------

struct rival {
    struct lf_tracer *tracer;
    struct lf_reference *reference;
};

static ng_result open_rival(const struct subject *s, struct rival *r)
{
    NG_TRY(lf_tracer_create(&r->tracer));
    const struct lf_reference_params params = {.width = s->params->width,
                                               .height = s->params->height,
                                               .depth = TRACER_DEPTH,
                                               .jobs = s->stage->jobs};
    return lf_reference_create(&params, &r->reference);
}

static void close_rival(struct rival *r)
{
    lf_reference_destroy(&r->reference);
    lf_tracer_destroy(&r->tracer);
}

// One sample a pixel of the scene as it is now; building and sorting are not counted.
static ng_result trace_sample(const struct subject *s, struct rival *r, double *ms)
{
    NG_TRY(lf_tracer_update(r->tracer, s->stage->snapshot));
    NG_TRY(lf_reference_begin(r->reference, r->tracer));
    uint64_t start = ng_clock_ns();
    NG_TRY(lf_reference_run(r->reference, &(struct lf_reference_run_params){.samples = 1}));
    *ms = (double)(ng_clock_ns() - start) * 1e-6;
    return NG_OK;
}

struct series {
    double stages[STAGES][MAX_FRAMES];
    double frame[MAX_FRAMES], sample[MAX_FRAMES], ratio[MAX_FRAMES];
    uint32_t count;
};

static ng_result measure_frames(struct subject *s, struct rival *r, struct series *series)
{
    struct progress progress;
    uint32_t frames = frames_of(s->params);
    ng_result result = warm_up(s, WARM_UP);
    progress_begin(&progress, "frame", frames);
    for (uint32_t i = 0; i < frames && result == NG_OK; i++) {
        double ms[STAGES] = {0};
        progress_update(&progress, i);
        result = draw(s, &series->frame[i]);
        if (result == NG_OK)
            result = read_stages(s, ms);
        for (int k = 0; k < STAGES; k++)
            series->stages[k][i] = ms[k];
        if (result == NG_OK)
            result = trace_sample(s, r, &series->sample[i]);
        series->ratio[i] = series->frame[i] / series->sample[i];
    }
    progress_end(&progress);
    series->count = frames;
    return result;
}

static void summarize(struct series *series, struct bench_neural *out)
{
    double sum = 0;
    out->frame_ms = median(series->frame, series->count);
    out->sample_ms = median(series->sample, series->count);
    out->frame_ratio = median(series->ratio, series->count);
    for (int k = 0; k < STAGES; k++) {
        double ms = median(series->stages[k], series->count);
        out->budget[out->stage_count].name = stage_name((enum stage)k);
        out->budget[out->stage_count++].ms = ms;
        sum += ms;
    }
    out->budget[out->stage_count].name = "copies, waiting, other";
    // The GPU's figures come a few frames late (ng_graph_stats), so that over few frames the stages may sum
    // up to more than a frame.
    out->budget[out->stage_count++].ms = fmax(out->frame_ms - sum, 0);
}

static ng_result measure_budget(const struct bench_neural_params *params, struct bench_neural *out)
{
    struct subject s;
    struct rival rival = {0};
    struct series *series = calloc(1, sizeof *series);
    if (!series)
        return ng_out_of_memory("measurements");
    ng_result result = open_subject(params, &s);
    if (result == NG_OK) {
        result = open_rival(&s, &rival);
        if (result == NG_OK)
            result = measure_frames(&s, &rival, series);
        summarize(series, out);
        close_rival(&rival);
        close_subject(&s);
    }
    free(series);
    return result;
}

// ---- More lights, more things ----------------------------------------------------------------------------

#define MAX_ROUNDS 64u

struct growth {
    double encode[MAX_ROUNDS], gather[MAX_ROUNDS], network[MAX_ROUNDS];
};

// Adds `share` of what a frame takes; the one before it has the new number of lights already, or memory would
// grow in this one.
static ng_result measure_round(struct subject *s, uint32_t round, double share, struct growth *out)
{
    double frame_ms, ms[STAGES];
    NG_TRY(warm_up(s, 1));
    NG_TRY(read_stages(s, ms));
    NG_TRY(draw(s, &frame_ms));
    NG_TRY(read_stages(s, ms));
    out->encode[round] += share * (ms[RSM] + ms[CLUES] + ms[LIGHT] + ms[UNET]);
    out->gather[round] += share * ms[GATHER];
    out->network[round] += share * (ms[LIGHT] + ms[UNET] + ms[GATHER]);
    return NG_OK;
}

static void take_medians(struct growth *g, uint32_t rounds, struct bench_neural_step *out)
{
    out->encode_ms = median(g->encode, rounds);
    out->gather_ms = median(g->gather, rounds);
    out->network_ms = median(g->network, rounds);
}

static uint32_t rounds_of(const struct bench_neural_params *params)
{
    uint32_t rounds = params->frames / 4 + 1;
    return rounds < MAX_ROUNDS ? rounds : MAX_ROUNDS;
}

#define MOST_LIGHTS (1u << (BENCH_STEPS - 1))

struct many_lights {
    ng_entity all[MOST_LIGHTS];
    uint32_t kinds; // the scene's own; then come copies of them in turn
};

// A scene's lights differ in what they cost: where a number does not hold equally many of each kind, every
// kind comes first once.
static ng_result measure_lights_round(struct subject *s, const struct many_lights *lights, uint32_t count,
                                      uint32_t round, struct growth *out)
{
    uint32_t turns = lights->kinds && count % lights->kinds ? lights->kinds : 1;
    for (uint32_t first = 0; first < turns; first++) {
        NG_TRY(bench_scene_switch_lights(s->stage->world, lights->all, MOST_LIGHTS, first, count));
        NG_TRY(measure_round(s, round, 1.0 / turns, out));
    }
    return NG_OK;
}

// All lights are there; the numbers take turns in how many of them shine.
static ng_result measure_light_rounds(struct subject *s, struct bench_neural_step steps[BENCH_STEPS])
{
    struct growth growth[BENCH_STEPS] = {0};
    struct many_lights lights;
    struct progress progress;
    uint32_t rounds = rounds_of(s->params);
    ng_result result = bench_scene_set_lights(s->stage->world, MOST_LIGHTS, lights.all, &lights.kinds);
    if (result == NG_OK)
        result = warm_up(s, WARM_UP);
    progress_begin(&progress, "lights", (uint64_t)rounds * BENCH_STEPS);
    for (uint32_t i = 0; i < rounds * BENCH_STEPS && result == NG_OK; i++) {
        uint32_t step = i % BENCH_STEPS;
        progress_update(&progress, i);
        steps[step].count = 1u << step;
        result = measure_lights_round(s, &lights, steps[step].count, i / BENCH_STEPS, &growth[step]);
    }
    progress_end(&progress);
    for (uint32_t i = 0; i < BENCH_STEPS && result == NG_OK; i++)
        take_medians(&growth[i], rounds, &steps[i]);
    return result;
}

static ng_result measure_lights(const struct bench_neural_params *params, struct bench_neural *out)
{
    struct subject s;
    NG_TRY(open_subject(params, &s));
    ng_result result = measure_light_rounds(&s, out->lights);
    close_subject(&s);
    return result;
}

// Both scenes are open, and take turns.
static ng_result measure_piece_rounds(struct subject s[2], struct bench_neural_step steps[2])
{
    struct growth growth[2] = {0};
    struct progress progress;
    uint32_t rounds = rounds_of(s[0].params);
    ng_result result = NG_OK;
    for (int i = 0; i < 2 && result == NG_OK; i++) {
        result = bench_scene_set_copies(s[i].stage->world, i ? 100 : 1, &steps[i].count);
        if (result == NG_OK)
            result = warm_up(&s[i], WARM_UP);
    }
    progress_begin(&progress, "pieces", (uint64_t)rounds * 2);
    for (uint32_t i = 0; i < rounds * 2 && result == NG_OK; i++) {
        progress_update(&progress, i);
        result = measure_round(&s[i % 2], i / 2, 1, &growth[i % 2]);
    }
    progress_end(&progress);
    for (int i = 0; i < 2 && result == NG_OK; i++)
        take_medians(&growth[i], rounds, &steps[i]);
    return result;
}

static ng_result measure_pieces(const struct bench_neural_params *params, struct bench_neural *out)
{
    struct subject s[2];
    NG_TRY(open_subject(params, &s[0]));
    ng_result result = open_subject(params, &s[1]);
    if (result == NG_OK) {
        result = measure_piece_rounds(s, out->pieces);
        close_subject(&s[1]);
    }
    close_subject(&s[0]);
    return result;
}

// ---- One lamp of seven is dragged ------------------------------------------------------------------------

static ng_result move_lamp(struct subject *s, ng_entity lamp, uint32_t round)
{
    struct ng_transform *t = ng_world_edit(s->stage->world, lamp, NG_TRANSFORM);
    NG_REQUIRE(t, "a lamp has a place");
    t->translation[0] += round % 2 ? -0.05f : 0.05f;
    return NG_OK;
}

// The two kinds of frame take turns.
static ng_result measure_drag_rounds(struct subject *s, ng_entity lamp, struct bench_neural *out)
{
    double drag[MAX_ROUNDS] = {0}, redo[MAX_ROUNDS] = {0}, ratio[MAX_ROUNDS];
    struct progress progress;
    uint32_t rounds = rounds_of(s->params);
    ng_result result = warm_up(s, WARM_UP);
    progress_begin(&progress, "dragged lamp", rounds);
    for (uint32_t i = 0; i < rounds && result == NG_OK; i++) {
        progress_update(&progress, i);
        ng_graph_ignore_keys(ng_renderer_graph(s->stage->renderer), false);
        result = move_lamp(s, lamp, i);
        if (result == NG_OK)
            result = draw(s, &drag[i]);
        ng_graph_ignore_keys(ng_renderer_graph(s->stage->renderer), true);
        if (result == NG_OK)
            result = draw(s, &redo[i]);
        ratio[i] = drag[i] / redo[i];
    }
    progress_end(&progress);
    if (result != NG_OK)
        return result;
    out->drag_ms = median(drag, rounds);
    out->redo_ms = median(redo, rounds);
    out->drag_ratio = median(ratio, rounds);
    return NG_OK;
}

// The stage's own scene makes room.
static ng_result measure_drag(const struct bench_neural_params *params, struct bench_neural *out)
{
    struct subject s;
    ng_entity lamps[BENCH_ROOM_LAMPS];
    NG_TRY(open_subject(params, &s));
    ng_result result = ng_entity_destroy(s.stage->world, s.stage->scene.root);
    if (result == NG_OK)
        result = bench_room_make(s.stage->world, s.stage->assets, lamps);
    if (result == NG_OK)
        result = measure_drag_rounds(&s, lamps[0], out);
    close_subject(&s);
    return result;
}

// The line through the steps by least squares; how far the steps are from it at most.
static void fit(const struct bench_neural_step *steps, const double *ms, double *slope, double *curve)
{
    double x = 0, y = 0, xx = 0, xy = 0;
    for (int i = 0; i < BENCH_STEPS; i++) {
        double n = steps[i].count;
        x += n / BENCH_STEPS;
        y += ms[i] / BENCH_STEPS;
        xx += n * n / BENCH_STEPS;
        xy += n * ms[i] / BENCH_STEPS;
    }
    *slope = (xy - x * y) / (xx - x * x);
    *curve = 0;
    for (int i = 0; i < BENCH_STEPS; i++)
        *curve = fmax(*curve, fabs(ms[i] / (y + *slope * (steps[i].count - x)) - 1));
}

static void fit_lights(struct bench_neural *out)
{
    double encode[BENCH_STEPS], gather[BENCH_STEPS];
    for (int i = 0; i < BENCH_STEPS; i++) {
        encode[i] = out->lights[i].encode_ms;
        gather[i] = out->lights[i].gather_ms;
    }
    fit(out->lights, encode, &out->encode_slope_ms, &out->encode_curve);
    fit(out->lights, gather, &out->gather_slope_ms, &out->gather_curve);
}

// ---- Processes of their own ------------------------------------------------------------------------------

static ng_result draw_many_lights(const struct bench_neural_params *params)
{
    struct subject s;
    NG_TRY(open_subject(params, &s));
    ng_entity lights[MEMORY_LIGHTS];
    uint32_t kinds;
    ng_result result = bench_scene_set_lights(s.stage->world, MEMORY_LIGHTS, lights, &kinds);
    if (result == NG_OK)
        result = warm_up(&s, WARM_UP);
    close_subject(&s);
    return result;
}

// Without the driver's cache of shaders, as after an installation.
static ng_result draw_first_frame(const struct bench_neural_params *params)
{
    struct subject s;
    double ms;
    setenv("MESA_SHADER_CACHE_DISABLE", "true", 1);
    NG_TRY(open_subject(params, &s));
    return draw(&s, &ms); // the process ends here: nothing is closed
}

static double seconds_of(const struct timeval *t)
{
    return (double)t->tv_sec + (double)t->tv_usec * 1e-6;
}

struct alone {
    double seconds, cpu_seconds, peak_bytes;
};

// Runs `work` in a process that has nothing yet. What fails in it is said there.
static ng_result run_alone(ng_result (*work)(const struct bench_neural_params *),
                           const struct bench_neural_params *params, struct alone *out)
{
    struct rusage usage;
    int status = 0;
    uint64_t start = ng_clock_ns();
    fflush(NULL);
    pid_t child = fork();
    if (child == 0)
        _exit((int)work(params));
    if (child < 0 || wait4(child, &status, 0, &usage) != child) {
        ng_log_error("%s: no process could be started to draw it alone", params->scene);
        return NG_ERROR_UNSUPPORTED;
    }
    if (!WIFEXITED(status)) {
        ng_log_error("%s: the process that drew it alone was ended by signal %d", params->scene,
                     WTERMSIG(status));
        return NG_ERROR_UNSUPPORTED;
    }
    out->seconds = (double)(ng_clock_ns() - start) * 1e-9;
    out->cpu_seconds = seconds_of(&usage.ru_utime) + seconds_of(&usage.ru_stime);
    out->peak_bytes = (double)usage.ru_maxrss * 1024;
    return (ng_result)WEXITSTATUS(status);
}

ng_result bench_neural_measure_processes(const struct bench_neural_params *params, struct bench_neural *out)
{
    struct alone first, many;
    *out = (struct bench_neural){0};
    if (params->budget)
        return NG_OK;
    NG_TRY(run_alone(draw_first_frame, params, &first));
    NG_TRY(run_alone(draw_many_lights, params, &many));
    out->first_frame_s = first.seconds;
    out->first_frame_cpu_s = first.cpu_seconds;
    out->memory_mib = many.peak_bytes / (1 << 20);
    return NG_OK;
}

// The network by itself, at the picture's size.
static ng_result measure_products(const struct bench_neural_params *params, struct bench_neural *out)
{
    char found[4096];
    struct bench_net_params net = {.size = {params->width, params->height},
                                   .lights = NET_LIGHTS,
                                   .frames = rounds_of(params),
                                   .threads = params->threads};
    if (params->weights)
        net.network = params->weights;
    else if (lf_neural_find_weights(params->scene, found, sizeof found))
        net.network = found;
    NG_REQUIRE(net.network, "the frames before this had weights");
    return bench_net_measure_shares(&net, &out->products);
}

ng_result bench_neural_measure(const struct bench_neural_params *params, struct bench_neural *out)
{
    out->budget_only = params->budget;
    NG_TRY(measure_budget(params, out));
    if (params->budget)
        return NG_OK;
    NG_TRY(measure_products(params, out));
    NG_TRY(measure_lights(params, out));
    NG_TRY(measure_pieces(params, out));
    NG_TRY(measure_drag(params, out));
    fit_lights(out);
    return NG_OK;
}

// ---- Telling ---------------------------------------------------------------------------------------------

void bench_neural_print(const struct bench_neural *b)
{
    printf(
        "\nneural, everything redone in every frame: %.2f ms; one sample a pixel of the path tracer, depth "
        "%u: %.2f ms\n",
        b->frame_ms, TRACER_DEPTH, b->sample_ms);
    printf("%-40s %10s %10s\n", "stage", "ms", "share");
    for (uint32_t i = 0; i < b->stage_count; i++)
        printf("%-40s %10.2f %9.1f%%\n", b->budget[i].name, b->budget[i].ms,
               100 * b->budget[i].ms / b->frame_ms);
    if (b->budget_only)
        return;
    printf("\n%-40s %10s %10s %10s\n", "", "encode ms", "gather ms", "network ms");
    for (uint32_t i = 0; i < BENCH_STEPS; i++)
        printf("%4u lights %29s %10.2f %10.2f %10.2f\n", b->lights[i].count, "", b->lights[i].encode_ms,
               b->lights[i].gather_ms, b->lights[i].network_ms);
    for (uint32_t i = 0; i < NG_COUNT(b->pieces); i++)
        printf("%4u pieces %29s %10.2f %10.2f %10.2f\n", b->pieces[i].count, "", b->pieces[i].encode_ms,
               b->pieces[i].gather_ms, b->pieces[i].network_ms);
    printf("a light more: %.2f ms to encode, %.2f ms to gather\n", b->encode_slope_ms, b->gather_slope_ms);
    printf("a room with %u lamps, of which one is dragged: %.2f ms; all redone: %.2f ms\n", BENCH_ROOM_LAMPS,
           b->drag_ms, b->redo_ms);
    printf("peak memory with %u lights: %.0f MiB; first picture after %.2f s, %.2f s of processor time\n",
           MEMORY_LIGHTS, b->memory_mib, b->first_frame_s, b->first_frame_cpu_s);
}

static void write_steps(struct json *j, const char *key, const struct bench_neural_step *steps, size_t count)
{
    json_array(j, key);
    for (size_t i = 0; i < count; i++) {
        json_object(j, NULL);
        json_number(j, "count", steps[i].count);
        json_number(j, "encode_ms", steps[i].encode_ms);
        json_number(j, "gather_ms", steps[i].gather_ms);
        json_number(j, "network_ms", steps[i].network_ms);
        json_end(j);
    }
    json_end(j);
}

static void write_growth(const struct bench_neural *b, struct json *j)
{
    write_steps(j, "lights", b->lights, BENCH_STEPS);
    write_steps(j, "pieces", b->pieces, NG_COUNT(b->pieces));
    json_number(j, "encode_slope_ms", b->encode_slope_ms);
    json_number(j, "gather_slope_ms", b->gather_slope_ms);
    json_number(j, "drag_ms", b->drag_ms);
    json_number(j, "redo_ms", b->redo_ms);
    json_number(j, "memory_mib", b->memory_mib);
    json_number(j, "first_frame_s", b->first_frame_s);
    json_number(j, "first_frame_cpu_s", b->first_frame_cpu_s);
}

void bench_neural_write(const struct bench_neural *b, struct json *j)
{
    json_object(j, "neural");
    json_number(j, "frame_ms", b->frame_ms);
    json_number(j, "sample_ms", b->sample_ms);
    json_object(j, "budget_ms");
    for (uint32_t i = 0; i < b->stage_count; i++)
        json_number(j, b->budget[i].name, b->budget[i].ms);
    json_end(j);
    if (!b->budget_only)
        write_growth(b, j);
    json_end(j);
}

// The i-th kernel that this CPU has.
static bool product_ratio(const struct bench_net_shares *shares, uint32_t index, char *name, size_t size,
                          double *value)
{
    for (int i = LF_KERNEL_PLAIN; i <= LF_KERNEL_AMX; i++) {
        if (shares->of[i] <= 0 || index-- > 0)
            continue;
        snprintf(name, size, "neural:products to the peak of %s", lf_net_kernel_name((enum lf_net_kernel)i));
        *value = shares->of[i];
        return true;
    }
    return false;
}

bool bench_neural_ratio(const struct bench_neural *b, uint32_t index, char *name, size_t size, double *value)
{
    const struct {
        const char *name;
        double value;
    } ratios[] = {
        {"frame to a sample a pixel", b->frame_ratio},
        {"encoding a light to a sample a pixel", b->encode_slope_ms / b->sample_ms},
        {"gathering a light to a sample a pixel", b->gather_slope_ms / b->sample_ms},
        {"encode, off the line of 1 to 16 lights", b->encode_curve},
        {"gather, off the line of 1 to 16 lights", b->gather_curve},
        {"network, 100 times the pieces", b->pieces[1].network_ms / b->pieces[0].network_ms},
        {"encode, 100 times the pieces", b->pieces[1].encode_ms / b->pieces[0].encode_ms},
        {"one of 7 lamps dragged to all redone", b->drag_ratio},
        {"memory of 7 lights to 700 MB", b->memory_mib * (1 << 20) / MEMORY_GOAL},
        {"first picture to 3 s", b->first_frame_s / FIRST_GOAL},
    };
    const uint32_t count = b->budget_only ? 1 : NG_COUNT(ratios);
    if (index < count) {
        snprintf(name, size, "neural:%s", ratios[index].name);
        *value = ratios[index].value;
        return true;
    }
    index -= count;
    if (index < b->stage_count) {
        snprintf(name, size, "neural:share of %s", b->budget[index].name);
        *value = b->budget[index].ms / b->frame_ms;
        return true;
    }
    return product_ratio(&b->products, index - b->stage_count, name, size, value);
}

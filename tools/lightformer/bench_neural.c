// Frames in which everything is redone, of the scene as it is and of others made from it: with more lights,
// with more things. What is compared is measured in turns within one process, so that what else the machine
// does touches it alike; peak memory and the first picture are those of processes of their own.
#define _DEFAULT_SOURCE // setenv, wait4
#include "bench_neural.h"

#include "bench_pace.h"
#include "bench_paths.h"
#include "bench_room.h"
#include "bench_scene.h"
#include "commands.h"
#include "opening.h"

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

#define WARM_UP       2
#define MAX_FRAMES    256u
#define MEMORY_LIGHTS 7u
#define MANY_LIGHTS   100u
#define MEMORY_GOAL   500.0 // MiB
#define FIRST_GOAL    3.0   // seconds
#define TRACER_DEPTH  5u

// Parts of the time that is given. What is left goes to what has no choice: starting, warming up.
#define SHARE_BUDGET      0.20
#define SHARE_BUDGET_ONLY 0.60
#define SHARE_LIGHTS      0.15
#define SHARE_MANY        0.10
#define SHARE_PIECES      0.06
#define SHARE_ROOM        0.12

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
    {NULL, "clues:arriving", "", GATHER, false},
    {NULL, LF_NEURAL_METHOD "/", "", GATHER, false}, // images of what was gathered
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

static void begin_pace(const struct subject *s, const char *label, uint32_t most, double share,
                       struct bench_pace *out)
{
    bench_pace_begin(out, label, most, share * s->params->seconds);
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
    struct bench_pace pace;
    NG_TRY(warm_up(s, WARM_UP));
    begin_pace(s, "frame", frames_of(s->params), s->params->budget ? SHARE_BUDGET_ONLY : SHARE_BUDGET, &pace);
    for (uint32_t i = 0; bench_pace_next(&pace, i); i++) {
        double ms[STAGES];
        NG_TRY(draw(s, &series->frame[i]));
        NG_TRY(read_stages(s, ms));
        for (int k = 0; k < STAGES; k++)
            series->stages[k][i] = ms[k];
        NG_TRY(trace_sample(s, r, &series->sample[i]));
        series->ratio[i] = series->frame[i] / series->sample[i];
    }
    series->count = pace.done;
    return NG_OK;
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
    double frame[MAX_ROUNDS], encode[MAX_ROUNDS], gather[MAX_ROUNDS], network[MAX_ROUNDS];
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
    out->frame[round] += share * frame_ms;
    out->encode[round] += share * (ms[RSM] + ms[CLUES] + ms[LIGHT] + ms[UNET]);
    out->gather[round] += share * ms[GATHER];
    out->network[round] += share * (ms[LIGHT] + ms[UNET] + ms[GATHER]);
    return NG_OK;
}

static void take_medians(struct growth *g, uint32_t rounds, struct bench_neural_step *out)
{
    out->frame_ms = median(g->frame, rounds);
    out->encode_ms = median(g->encode, rounds);
    out->gather_ms = median(g->gather, rounds);
    out->network_ms = median(g->network, rounds);
}

static uint32_t rounds_of(const struct bench_neural_params *params)
{
    uint32_t rounds = params->frames / 4 + 1;
    return rounds < MAX_ROUNDS ? rounds : MAX_ROUNDS;
}

// The line through the steps by least squares, and how far they are from it at most.
struct line {
    double fixed, slope, curve; // at no light, milliseconds; a light; as a share of the value
};

static struct line fit(const struct bench_neural_step *steps, const double *ms)
{
    struct line line = {0};
    double x = 0, y = 0, xx = 0, xy = 0;
    for (int i = 0; i < BENCH_STEPS; i++) {
        double n = steps[i].count;
        x += n / BENCH_STEPS;
        y += ms[i] / BENCH_STEPS;
        xx += n * n / BENCH_STEPS;
        xy += n * ms[i] / BENCH_STEPS;
    }
    line.slope = (xy - x * y) / (xx - x * x);
    line.fixed = y - line.slope * x;
    for (int i = 0; i < BENCH_STEPS; i++)
        line.curve = fmax(line.curve, fabs(ms[i] / (line.fixed + line.slope * steps[i].count) - 1));
    return line;
}

static void fit_lights(struct bench_neural *out)
{
    double frame[BENCH_STEPS], encode[BENCH_STEPS], gather[BENCH_STEPS];
    for (int i = 0; i < BENCH_STEPS; i++) {
        frame[i] = out->lights[i].frame_ms;
        encode[i] = out->lights[i].encode_ms;
        gather[i] = out->lights[i].gather_ms;
    }
    const struct line whole = fit(out->lights, frame), encoding = fit(out->lights, encode),
                      gathering = fit(out->lights, gather);
    out->fixed_ms = whole.fixed;
    out->light_ms = whole.slope;
    out->encode_slope_ms = encoding.slope;
    out->encode_curve = encoding.curve;
    out->gather_slope_ms = gathering.slope;
    out->gather_curve = gathering.curve;
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
    struct bench_pace pace;
    NG_TRY(bench_scene_set_lights(s->stage->world, MOST_LIGHTS, lights.all, &lights.kinds));
    NG_TRY(warm_up(s, 1));
    begin_pace(s, "lights", rounds_of(s->params), SHARE_LIGHTS, &pace);
    for (uint32_t round = 0; bench_pace_next(&pace, round); round++)
        for (uint32_t i = 0; i < BENCH_STEPS; i++) {
            steps[i].count = 1u << i;
            NG_TRY(measure_lights_round(s, &lights, steps[i].count, round, &growth[i]));
        }
    for (uint32_t i = 0; i < BENCH_STEPS; i++)
        take_medians(&growth[i], pace.done, &steps[i]);
    return NG_OK;
}

// Seven, and a hundred: of a picture of half the size, or it would take most of the time that there is.
static ng_result measure_many_rounds(struct subject *s, struct bench_neural *out)
{
    static const uint32_t counts[2] = {MEMORY_LIGHTS, MANY_LIGHTS};
    double frame[2][MAX_ROUNDS], ratio[MAX_ROUNDS];
    ng_entity lights[MANY_LIGHTS];
    uint32_t kinds;
    struct bench_pace pace;
    NG_TRY(bench_scene_set_lights(s->stage->world, MANY_LIGHTS, lights, &kinds));
    NG_TRY(bench_scene_switch_lights(s->stage->world, lights, MANY_LIGHTS, 0, counts[0]));
    NG_TRY(warm_up(s, 1)); // a hundred lights take too long for that; to find their memory is a small part
    begin_pace(s, "many lights", rounds_of(s->params), SHARE_MANY, &pace);
    for (uint32_t round = 0; bench_pace_next(&pace, round); round++) {
        for (int i = 0; i < 2; i++) {
            NG_TRY(bench_scene_switch_lights(s->stage->world, lights, MANY_LIGHTS, 0, counts[i]));
            NG_TRY(draw(s, &frame[i][round]));
        }
        ratio[round] = frame[1][round] / frame[0][round];
    }
    out->many_ms[0] = median(frame[0], pace.done);
    out->many_ms[1] = median(frame[1], pace.done);
    out->many_ratio = median(ratio, pace.done);
    return NG_OK;
}

static ng_result measure_lights(const struct bench_neural_params *params, struct bench_neural *out)
{
    struct bench_neural_params half = *params;
    struct subject s;
    half.width = (params->width + 1) / 2;
    half.height = (params->height + 1) / 2;
    NG_TRY(open_subject(params, &s));
    ng_result result = measure_light_rounds(&s, out->lights);
    fit_lights(out);
    s.params = &half;
    if (result == NG_OK)
        result = measure_many_rounds(&s, out);
    close_subject(&s);
    return result;
}

// Both scenes are open, and take turns.
static ng_result measure_piece_rounds(struct subject s[2], struct bench_neural_step steps[2])
{
    struct growth growth[2] = {0};
    struct bench_pace pace;
    for (int i = 0; i < 2; i++) {
        NG_TRY(bench_scene_set_copies(s[i].stage->world, i ? 100 : 1, &steps[i].count));
        NG_TRY(warm_up(&s[i], 1));
    }
    begin_pace(&s[0], "pieces", rounds_of(s[0].params), SHARE_PIECES, &pace);
    for (uint32_t round = 0; bench_pace_next(&pace, round); round++)
        for (int i = 0; i < 2; i++)
            NG_TRY(measure_round(&s[i], round, 1, &growth[i]));
    for (int i = 0; i < 2; i++)
        take_medians(&growth[i], pace.done, &steps[i]);
    return NG_OK;
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

// ---- A room with seven lamps, of which one is dragged
// -------------------------------------------------------

static ng_result move_lamp(struct subject *s, ng_entity lamp, uint32_t round)
{
    struct ng_transform *t = ng_world_edit(s->stage->world, lamp, NG_TRANSFORM);
    NG_REQUIRE(t, "a lamp has a place");
    t->translation[0] += round % 2 ? -0.05f : 0.05f;
    return NG_OK;
}

// The two kinds of frame and a sample of the path tracer take turns.
static ng_result measure_room_rounds(struct subject *s, struct rival *rival, ng_entity lamp,
                                     struct bench_neural *out)
{
    double drag[MAX_ROUNDS], redo[MAX_ROUNDS], sample[MAX_ROUNDS], drag_ratio[MAX_ROUNDS],
        redo_ratio[MAX_ROUNDS];
    struct ng_graph *graph = ng_renderer_graph(s->stage->renderer);
    struct bench_pace pace;
    NG_TRY(warm_up(s, WARM_UP));
    begin_pace(s, "seven lamps", rounds_of(s->params), SHARE_ROOM, &pace);
    for (uint32_t i = 0; bench_pace_next(&pace, i); i++) {
        ng_graph_ignore_keys(graph, false);
        NG_TRY(move_lamp(s, lamp, i));
        NG_TRY(draw(s, &drag[i]));
        ng_graph_ignore_keys(graph, true);
        NG_TRY(draw(s, &redo[i]));
        NG_TRY(trace_sample(s, rival, &sample[i]));
        drag_ratio[i] = drag[i] / redo[i];
        redo_ratio[i] = redo[i] / sample[i];
    }
    const struct ng_graph_counters memory = ng_graph_counters(graph);
    out->plan_mib = (double)(memory.transient_bytes + memory.persistent_bytes) / (1 << 20);
    out->drag_ms = median(drag, pace.done);
    out->redo_ms = median(redo, pace.done);
    out->room_sample_ms = median(sample, pace.done);
    out->drag_ratio = median(drag_ratio, pace.done);
    out->room_ratio = median(redo_ratio, pace.done);
    return NG_OK;
}

// The stage's own scene makes room.
static ng_result measure_room(const struct bench_neural_params *params, struct bench_neural *out)
{
    struct subject s;
    struct rival rival = {0};
    ng_entity lamps[BENCH_ROOM_LAMPS];
    NG_TRY(open_subject(params, &s));
    ng_result result = ng_entity_destroy(s.stage->world, s.stage->scene.root);
    if (result == NG_OK)
        result = bench_room_make(s.stage->world, s.stage->assets, lamps);
    if (result == NG_OK)
        result = open_rival(&s, &rival);
    if (result == NG_OK)
        result = measure_room_rounds(&s, &rival, lamps[0], out);
    close_rival(&rival);
    close_subject(&s);
    return result;
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

// ---- Telling ---------------------------------------------------------------------------------------------

static void print_budget(const struct bench_neural *b)
{
    printf(
        "\nneural, everything redone in every frame: %.2f ms; one sample a pixel of the path tracer, depth "
        "%u: %.2f ms\n",
        b->frame_ms, TRACER_DEPTH, b->sample_ms);
    printf("%-40s %10s %10s\n", "stage", "ms", "share");
    for (uint32_t i = 0; i < b->stage_count; i++)
        printf("%-40s %10.2f %9.1f%%\n", b->budget[i].name, b->budget[i].ms,
               100 * b->budget[i].ms / b->frame_ms);
}

static void print_paths(const struct bench_neural *b)
{
    bench_paths_print(&b->paths);
}

static void print_step(const struct bench_neural_step *step, const char *what)
{
    printf("%4u %-35s %10.2f %10.2f %10.2f %10.2f\n", step->count, what, step->frame_ms, step->encode_ms,
           step->gather_ms, step->network_ms);
}

static void print_lights(const struct bench_neural *b)
{
    printf("\n%-40s %10s %10s %10s %10s\n", "", "frame ms", "encode ms", "gather ms", "network ms");
    for (uint32_t i = 0; i < BENCH_STEPS; i++)
        print_step(&b->lights[i], "lights");
    printf("the fixed part: %.2f ms; a light more: %.2f ms, %.2f of them to encode, %.2f to gather\n",
           b->fixed_ms, b->light_ms, b->encode_slope_ms, b->gather_slope_ms);
    printf("a picture of half the size, %u lights: %.2f ms; %u lights: %.2f ms\n", MEMORY_LIGHTS,
           b->many_ms[0], MANY_LIGHTS, b->many_ms[1]);
}

static void print_pieces(const struct bench_neural *b)
{
    for (uint32_t i = 0; i < NG_COUNT(b->pieces); i++)
        print_step(&b->pieces[i], "pieces");
}

static void print_room(const struct bench_neural *b)
{
    printf("a room with %u lamps, of which one is dragged: %.2f ms; all redone: %.2f ms; one sample a pixel: "
           "%.2f ms\n",
           BENCH_ROOM_LAMPS, b->drag_ms, b->redo_ms, b->room_sample_ms);
    printf("peak memory with %u lights: %.0f MiB, of the frame's plan %.0f MiB; first picture after %.2f s, "
           "%.2f s of processor time\n",
           MEMORY_LIGHTS, b->memory_mib, b->plan_mib, b->first_frame_s, b->first_frame_cpu_s);
}

static ng_result measure_paths(const struct bench_neural_params *params, struct bench_neural *out)
{
    return bench_paths_measure(params, &out->paths);
}

ng_result bench_neural_measure(const struct bench_neural_params *params, struct bench_neural *out)
{
    static const struct {
        ng_result (*measure)(const struct bench_neural_params *params, struct bench_neural *out);
        void (*print)(const struct bench_neural *b);
        bool of_frame; // part of --budget
    } parts[] = {
        {measure_budget, print_budget, true},  {measure_paths, print_paths, true},
        {measure_lights, print_lights, false}, {measure_pieces, print_pieces, false},
        {measure_room, print_room, false},
    };
    out->budget_only = params->budget;
    for (size_t i = 0; i < NG_COUNT(parts); i++) {
        if (params->budget && !parts[i].of_frame)
            continue;
        NG_TRY(parts[i].measure(params, out));
        if (params->silent)
            continue;
        parts[i].print(out);
        fflush(stdout);
    }
    return NG_OK;
}

static void write_steps(struct json *j, const char *key, const struct bench_neural_step *steps, size_t count)
{
    json_array(j, key);
    for (size_t i = 0; i < count; i++) {
        json_object(j, NULL);
        json_number(j, "count", steps[i].count);
        json_number(j, "frame_ms", steps[i].frame_ms);
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
    json_number(j, "fixed_ms", b->fixed_ms);
    json_number(j, "light_ms", b->light_ms);
    json_number(j, "half_size_7_lights_ms", b->many_ms[0]);
    json_number(j, "half_size_100_lights_ms", b->many_ms[1]);
    json_number(j, "drag_ms", b->drag_ms);
    json_number(j, "redo_ms", b->redo_ms);
    json_number(j, "room_sample_ms", b->room_sample_ms);
    json_number(j, "plan_mib", b->plan_mib);
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
    bench_paths_write(&b->paths, j);
    if (!b->budget_only)
        write_growth(b, j);
    json_end(j);
}

bool bench_neural_ratio(const struct bench_neural *b, uint32_t index, char *name, size_t size, double *value)
{
    const struct {
        const char *name;
        double value;
    } ratios[] = {
        {"frame to a sample a pixel", b->frame_ratio},
        {"a light more to the fixed part", b->light_ms / b->fixed_ms},
        {"7 area lights, all redone, to a sample a pixel", b->room_ratio},
        {"one of 7 lamps dragged to all redone", b->drag_ratio},
        {"100 lights to 7 lights", b->many_ratio},
        {"peak memory of 7 lights to 500 MiB", b->memory_mib / MEMORY_GOAL},
        {"encoding a light to a sample a pixel", b->encode_slope_ms / b->sample_ms},
        {"gathering a light to a sample a pixel", b->gather_slope_ms / b->sample_ms},
        {"encode, off the line of 1 to 16 lights", b->encode_curve},
        {"gather, off the line of 1 to 16 lights", b->gather_curve},
        {"network, 100 times the pieces", b->pieces[1].network_ms / b->pieces[0].network_ms},
        {"encode, 100 times the pieces", b->pieces[1].encode_ms / b->pieces[0].encode_ms},
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
    return bench_paths_ratio(&b->paths, index - b->stage_count, name, size, value);
}

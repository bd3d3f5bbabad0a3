// lightformer bench: how long frames and their passes take, and what they need.
//
// Two runs over the same frames. The first is the scene as anybody would draw it: frame time, passes, memory.
// The second redraws every light in every frame and adds passes that draw depth alone; it gives the ratios,
// which mean the same on any machine, and nothing else. Each part is printed once it is known.
#include "bench_flicker.h"
#include "bench_interactive.h"
#include "bench_net.h"
#include "bench_neural.h"
#include "bench_pace.h"
#include "bench_reference.h"
#include "commands.h"
#include "json.h"
#include "opening.h"
#include "scene_file.h"

#include "app/stage.h"
#include "base/array.h"
#include "base/file.h"
#include "base/log.h"
#include "base/printable.h"
#include "base/system.h"
#include "gpu/device.h"
#include "lightformer/methods/methods.h"

#include <stdlib.h>
#include <string.h>

#define WARM_UP_FRAMES 2 // pipelines, first uploads, memory that grows
#define MAX_RATIOS     64
#define NAME_SIZE      192

// Parts of the time that is given, of the two runs; bench_neural.c has the rest.
#define SHARE_PLAIN  0.12
#define SHARE_RATIOS 0.08

struct bench {
    const char *scene, *device, *weights;
    uint32_t frames, seconds, threads, method, gbuffer;
    struct cli_size size, window;
    bool budget, flicker, interactive, reference, net, json;
    uint32_t samples, lights, kernel;
    struct opening opening;
};

// What the measurements that stand instead of frames have no use for.
static const char *const not_with_reference[] = {"--net",    "--frames", "--seconds", "--method", "--weights",
                                                 "--budget", "--device", "--gbuffer", NULL};
static const char *const not_with_interactive[] = {"--net",       "--frames",  "--budget", "--flicker",
                                                   "--reference", "--gbuffer", "--size",   NULL};
static const char *const not_with_flicker[] = {"--net",       "--frames",  "--budget",
                                               "--reference", "--gbuffer", NULL};
static const char *const not_with_net[] = {"--method", "--seconds", "--weights",   "--budget",
                                           "--device", "--gbuffer", OPENING_NAMES, NULL};

static const struct cli_option options[] = {
    CLI_SCENE(struct bench),
    {.name = "--frames",
     .kind = CLI_COUNT,
     .offset = offsetof(struct bench, frames),
     .value = "N",
     .fallback = "60",
     .min = 1,
     .max = 1e6,
     .doc = "how many frames to measure, after a few to warm up; fewer where they take too long"},
    {.name = "--seconds",
     .kind = CLI_COUNT,
     .offset = offsetof(struct bench, seconds),
     .value = "N",
     .fallback = "20",
     .min = 1,
     .max = 1e6,
     .doc = "how long to repeat measurements, all together; each is made once at least"},
    CLI_PIXELS(struct bench, "512x512"),
    CLI_METHOD(struct bench, method_bench_option),
    CLI_WEIGHTS(struct bench),
    CLI_GBUFFER(struct bench),
    {.name = "--budget",
     .kind = CLI_FLAG,
     .offset = offsetof(struct bench, budget),
     .doc = "only what a frame takes: neither ratios of passes, nor growth, memory and first picture"},
    {.name = "--interactive",
     .kind = CLI_FLAG,
     .offset = offsetof(struct bench, interactive),
     .excludes = not_with_interactive,
     .doc =
         "instead: pictures a second in windows of three sizes, and how soon they are whole after an edit"},
    {.name = "--flicker",
     .kind = CLI_FLAG,
     .offset = offsetof(struct bench, flicker),
     .excludes = not_with_flicker,
     .doc = "instead: what changes from frame to frame beyond what moves, while a camera or a lamp does"},
    {.name = "--window",
     .kind = CLI_SIZE,
     .offset = offsetof(struct bench, window),
     .value = "WxH",
     .min = 1,
     .max = 16384,
     .doc = "a window of this size alone (--interactive), or pictures (--flicker)"},
    {.name = "--reference",
     .kind = CLI_FLAG,
     .offset = offsetof(struct bench, reference),
     .excludes = not_with_reference,
     .doc = "instead: rays a second of the path tracer, and of a bare loop of closest hits"},
    {.name = "--spp",
     .kind = CLI_COUNT,
     .offset = offsetof(struct bench, samples),
     .value = "N",
     .fallback = "8",
     .min = 1,
     .max = 1e6,
     .needs = "--reference",
     .doc = "paths a pixel of each of five rounds (--reference)"},
    {.name = "--net",
     .kind = CLI_FLAG,
     .offset = offsetof(struct bench, net),
     .excludes = not_with_net,
     .doc = "instead: SCENE is a network (.safetensors); its stages and operations on made-up inputs"},
    {.name = "--lights",
     .kind = CLI_COUNT,
     .offset = offsetof(struct bench, lights),
     .value = "N",
     .fallback = "2",
     .max = 1024,
     .needs = "--net",
     .doc = "how many lights (--net)"},
    {.name = "--kernel",
     .kind = CLI_CHOICE,
     .offset = offsetof(struct bench, kernel),
     .value = "NAME",
     .fallback = "auto",
     .choice = bench_net_kernel,
     .needs = "--net",
     .doc = "how numbers are multiplied (--net)"},
    CLI_OPENING(struct bench),
    CLI_THREADS(struct bench),
    CLI_DEVICE(struct bench),
    CLI_JSON(struct bench),
};

// ---- Series of measurements

struct series {
    NG_ARRAY(double) values;
};

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// The value that this share of all values does not exceed; 0 of an empty series. Sorts.
static double quantile(struct series *s, double share)
{
    size_t n = s->values.count;
    if (n == 0)
        return 0;
    qsort(s->values.items, n, sizeof *s->values.items, compare_doubles);
    return s->values.items[(size_t)(share * (double)(n - 1) + 0.5)];
}

struct pass {
    char name[NAME_SIZE];
    struct series cpu_ms, gpu_ms;
    uint64_t runs_before, runs; // when measuring began, and now
    double median_cpu_ms, median_gpu_ms;
};

// The passes of a run and the time of its frames.
struct measurement {
    NG_ARRAY(struct pass) passes; // of the graph
    struct pass world, extract;   // before it, on the CPU: systems; skinning, subdivision, the snapshot
    struct series frame_ms;
};

static void finish_measurement(struct measurement *m)
{
    for (size_t i = 0; i < m->passes.count; i++) {
        ng_array_finish(&m->passes.items[i].cpu_ms.values);
        ng_array_finish(&m->passes.items[i].gpu_ms.values);
    }
    ng_array_finish(&m->passes);
    ng_array_finish(&m->world.cpu_ms.values);
    ng_array_finish(&m->extract.cpu_ms.values);
    ng_array_finish(&m->frame_ms.values);
}

static const struct pass *find_pass(const struct measurement *m, const char *name)
{
    for (size_t i = 0; i < m->passes.count; i++) {
        if (strcmp(m->passes.items[i].name, name) == 0)
            return &m->passes.items[i];
    }
    return NULL;
}

// ---- Measuring

// Takes the figures of the last frame. The graph lists passes in the order in which they first appeared, so
// that an index stands for the same pass in every frame. Only passes that ran are counted: the others would
// repeat their last figure.
static bool sample_passes(struct measurement *m, struct ng_graph *graph, bool measuring)
{
    size_t count;
    const struct ng_pass_stats *stats = ng_graph_stats(graph, &count);
    if (!ng_array_resize(&m->passes, count))
        return false;
    for (size_t i = 0; i < count; i++) {
        struct pass *p = &m->passes.items[i];
        bool ran = stats[i].runs > p->runs;
        if (!p->name[0])
            snprintf(p->name, sizeof p->name, "%s", stats[i].name);
        p->runs = stats[i].runs;
        if (!measuring)
            p->runs_before = p->runs;
        else if (ran && !(ng_array_push(&p->cpu_ms.values, stats[i].cpu_ms) &&
                          ng_array_push(&p->gpu_ms.values, stats[i].gpu_ms)))
            return false;
    }
    return true;
}

static bool sample_cpu(struct pass *p, const char *name, double ms)
{
    snprintf(p->name, sizeof p->name, "%s", name);
    p->runs++;
    return ng_array_push(&p->cpu_ms.values, ms);
}

static ng_result measure_frame(const struct bench *b, struct ng_stage *stage, uint32_t n,
                               struct measurement *m)
{
    static const char *const layers[] = {"display"}; // what nobody asks for would not be drawn
    struct ng_stage_frame frame = {
        .layers = layers,
        .layer_count = NG_COUNT(layers),
        .time = n / CLI_FRAMES_A_SECOND,
        .width = b->size.width,
        .height = b->size.height,
        .method = lf_method_name(b->method),
    };
    uint64_t start = ng_clock_ns();
    NG_TRY(ng_stage_draw(stage, &frame));
    double frame_ms = (double)(ng_clock_ns() - start) * 1e-6;
    bool measuring = n >= WARM_UP_FRAMES;
    if (sample_passes(m, ng_renderer_graph(stage->renderer), measuring) &&
        (!measuring || sample_cpu(&m->world, "world", stage->world_ms)) &&
        (!measuring || sample_cpu(&m->extract, "extract", stage->extract_ms)) &&
        (!measuring || ng_array_push(&m->frame_ms.values, frame_ms)))
        return NG_OK;
    ng_log_error("%s: out of memory for measurements", b->scene);
    return NG_ERROR_MEMORY;
}

// `share`: of the time that is given.
static ng_result measure(const struct bench *b, struct ng_stage *stage, const char *label, double share,
                         struct measurement *m)
{
    struct bench_pace pace;
    for (uint32_t n = 0; n < WARM_UP_FRAMES; n++)
        NG_TRY(measure_frame(b, stage, n, m));
    bench_pace_begin(&pace, label, b->frames, share * b->seconds);
    for (uint32_t n = 0; bench_pace_next(&pace, n); n++)
        NG_TRY(measure_frame(b, stage, WARM_UP_FRAMES + n, m));
    return NG_OK;
}

// Sorts the series: what pairs frames comes before.
static void take_medians(struct measurement *m)
{
    for (size_t i = 0; i < m->passes.count; i++) {
        struct pass *p = &m->passes.items[i];
        p->median_cpu_ms = quantile(&p->cpu_ms, 0.5);
        p->median_gpu_ms = quantile(&p->gpu_ms, 0.5);
    }
    m->world.median_cpu_ms = quantile(&m->world.cpu_ms, 0.5);
    m->extract.median_cpu_ms = quantile(&m->extract.cpu_ms, 0.5);
}

// ---- Ratios

struct ratio {
    char name[NAME_SIZE];
    double value;
};
struct ratios {
    struct ratio items[MAX_RATIOS];
    uint32_t count;
};

// The median over frames of (a + b) / bare: the three are measured within one frame, so that what else the
// machine does touches them alike. `b` may be null.
static bool add_ratio(struct ratios *r, const char *name, const struct pass *a, const struct pass *b,
                      const struct pass *bare)
{
    if (!a || !bare || r->count == MAX_RATIOS)
        return true;
    struct series paired = {0};
    size_t n = a->gpu_ms.values.count < bare->gpu_ms.values.count ? a->gpu_ms.values.count
                                                                  : bare->gpu_ms.values.count;
    bool ok = true;
    for (size_t i = 0; i < n && ok; i++) {
        double ms = a->gpu_ms.values.items[i], reference = bare->gpu_ms.values.items[i];
        if (b && i < b->gpu_ms.values.count)
            ms += b->gpu_ms.values.items[i];
        if (ms > 0 && reference > 0) // the G-buffer may be no work of the GPU
            ok = ng_array_push(&paired.values, ms / reference);
    }
    if (paired.values.count) {
        struct ratio *ratio = &r->items[r->count++];
        snprintf(ratio->name, sizeof ratio->name, "%s", name);
        ratio->value = quantile(&paired, 0.5);
    }
    ng_array_finish(&paired.values);
    return ok;
}

// Each pass that draws the scene to the pass that draws the depth of the same triangles alone: the G-buffer,
// and of each light the two passes of its reflective shadow map.
static bool compute_ratios(const struct measurement *m, struct ratios *r)
{
    bool ok = add_ratio(r, "gbuffer", find_pass(m, "gbuffer"), NULL, find_pass(m, "bare:camera"));
    for (size_t i = 0; i < m->passes.count && ok; i++) {
        const struct pass *depth = &m->passes.items[i];
        char light[160], name[NAME_SIZE];
        int end = 0;
        if (sscanf(depth->name, "rsm:%159[^/]/depth%n", light, &end) != 1 || !end || depth->name[end])
            continue;
        snprintf(name, sizeof name, "rsm:%s/surface", light);
        const struct pass *surface = find_pass(m, name);
        snprintf(name, sizeof name, "bare:%s/depth", light);
        const struct pass *bare = find_pass(m, name);
        snprintf(name, sizeof name, "rsm:%s", light);
        ok = add_ratio(r, name, depth, surface, bare);
    }
    return ok;
}

// ---- Printing

struct report {
    bool has_neural;
    struct bench_neural neural;
    struct measurement plain;
    struct ratios ratios;
    double frame_median_ms, frame_p95_ms, memory_mib;
    char device[VK_MAX_PHYSICAL_DEVICE_NAME_SIZE];
};

static uint64_t runs(const struct pass *p)
{
    return p->runs - p->runs_before;
}

static void print_pass(const struct pass *p)
{
    printf("%-40s %10.3f %10.3f %8llu\n", p->name, p->median_cpu_ms, p->median_gpu_ms,
           (unsigned long long)runs(p));
}

static void print_frames(const struct bench *b, const struct report *r)
{
    ng_print_line(stdout, "%s, %ux%u, %zu frames on %s", ng_path_name(b->scene), b->size.width,
                  b->size.height, r->plain.frame_ms.values.count, r->device);
    printf("frame: median %.2f ms, 95 %% below %.2f ms; memory %.0f MiB\n\n", r->frame_median_ms,
           r->frame_p95_ms, r->memory_mib);
    printf("%-40s %10s %10s %8s\n", "pass", "CPU ms", "GPU ms", "runs");
    print_pass(&r->plain.world);
    print_pass(&r->plain.extract);
    for (size_t i = 0; i < r->plain.passes.count; i++)
        print_pass(&r->plain.passes.items[i]);
    fflush(stdout);
}

static void print_ratios(const struct report *r)
{
    printf("\n%-52s %10s\n", "GPU time to depth alone, and others", "ratio");
    for (uint32_t i = 0; i < r->ratios.count; i++)
        printf("%-52s %10.3f\n", r->ratios.items[i].name, r->ratios.items[i].value);
}

static void write_pass(struct json *j, const struct pass *p)
{
    json_object(j, NULL);
    json_text(j, "name", p->name);
    json_number(j, "cpu_ms", p->median_cpu_ms);
    json_number(j, "gpu_ms", p->median_gpu_ms);
    json_number(j, "runs", (double)runs(p));
    json_end(j);
}

static void write_report(const struct bench *b, const struct report *r)
{
    struct json j = {.out = stdout};
    json_object(&j, NULL);
    json_text(&j, "scene", ng_path_name(b->scene));
    json_text(&j, "device", r->device);
    json_number(&j, "width", b->size.width);
    json_number(&j, "height", b->size.height);
    json_number(&j, "frames", (double)r->plain.frame_ms.values.count);
    json_object(&j, "frame_ms");
    json_number(&j, "median", r->frame_median_ms);
    json_number(&j, "p95", r->frame_p95_ms);
    json_end(&j);
    json_array(&j, "passes");
    write_pass(&j, &r->plain.world);
    write_pass(&j, &r->plain.extract);
    for (size_t i = 0; i < r->plain.passes.count; i++)
        write_pass(&j, &r->plain.passes.items[i]);
    json_end(&j);
    json_number(&j, "memory_mib", r->memory_mib);
    if (r->has_neural)
        bench_neural_write(&r->neural, &j);
    json_object(&j, "ratios");
    for (uint32_t i = 0; i < r->ratios.count; i++)
        json_number(&j, r->ratios.items[i].name, r->ratios.items[i].value);
    json_end(&j);
    json_end(&j);
}

// ---- The command

// The stage and the method that is measured on it.
struct subject {
    struct ng_stage *stage;
    struct lf_method *method;
};

static void close_subject(struct subject *s)
{
    lf_method_destroy(&s->method);
    ng_stage_destroy(&s->stage);
}

static ng_result open_subject(const struct bench *b, const struct ng_stage_params *stage, struct subject *s)
{
    *s = (struct subject){0};
    NG_TRY(ng_stage_create(stage, &s->stage));
    ng_result result =
        lf_method_create(&(struct lf_method_params){.name = lf_method_name(b->method),
                                                    .composer = ng_renderer_composer(s->stage->renderer),
                                                    .jobs = s->stage->jobs,
                                                    .scene = b->scene,
                                                    .weights = b->weights,
                                                    .gbuffer = (enum lf_raycast_use)b->gbuffer},
                         &s->method);
    if (result != NG_OK)
        close_subject(s);
    return result;
}

static ng_result measure_plain(const struct bench *b, struct report *r)
{
    struct subject subject;
    struct ng_stage_params params = {.scene = b->scene, .device = b->device, .threads = b->threads};
    opening_apply(&b->opening, &params);
    NG_TRY(open_subject(b, &params, &subject));
    snprintf(r->device, sizeof r->device, "%s", subject.stage->gpu->properties.deviceName);
    ng_result result = measure(b, subject.stage, "frame", SHARE_PLAIN, &r->plain);
    take_medians(&r->plain);
    r->frame_median_ms = quantile(&r->plain.frame_ms, 0.5);
    r->frame_p95_ms = quantile(&r->plain.frame_ms, 0.95);
    r->memory_mib = (double)ng_system_peak_memory() / (1 << 20);
    close_subject(&subject);
    return result;
}

static ng_result measure_ratios(const struct bench *b, struct report *r)
{
    struct subject subject;
    struct ng_stage_params params = {
        .scene = b->scene,
        .device = b->device,
        .threads = b->threads,
        .redraw_lights = true,
        .bare_passes = true,
    };
    opening_apply(&b->opening, &params);
    NG_TRY(open_subject(b, &params, &subject));
    struct measurement m = {0};
    ng_result result = measure(b, subject.stage, "comparison", SHARE_RATIOS, &m);
    if (!compute_ratios(&m, &r->ratios))
        result = ng_out_of_memory("ratios");
    finish_measurement(&m);
    close_subject(&subject);
    return result;
}

static struct bench_neural_params neural_params(const struct bench *b)
{
    return (struct bench_neural_params){.scene = b->scene,
                                        .opening = &b->opening,
                                        .device = b->device,
                                        .weights = b->weights,
                                        .gbuffer = b->gbuffer,
                                        .threads = b->threads,
                                        .width = b->size.width,
                                        .height = b->size.height,
                                        .frames = b->frames,
                                        .seconds = b->seconds,
                                        .budget = b->budget,
                                        .silent = b->json};
}

static void add_neural_ratios(struct report *r)
{
    struct ratio ratio;
    for (uint32_t i = 0; r->has_neural && r->ratios.count < MAX_RATIOS &&
                         bench_neural_ratio(&r->neural, i, ratio.name, sizeof ratio.name, &ratio.value);
         i++)
        r->ratios.items[r->ratios.count++] = ratio;
}

static bool is_neural(const struct bench *b)
{
    return strcmp(lf_method_name(b->method), "neural") == 0;
}

static ng_result measure_frames(const struct bench *b)
{
    const struct bench_neural_params neural = neural_params(b);
    struct report report = {.has_neural = is_neural(b)};
    ng_result result = NG_OK;
    if (report.has_neural)
        result = bench_neural_measure_processes(&neural, &report.neural);
    if (result == NG_OK)
        result = measure_plain(b, &report);
    if (result == NG_OK && !b->json)
        print_frames(b, &report);
    if (result == NG_OK && !b->budget)
        result = measure_ratios(b, &report);
    if (result == NG_OK && report.has_neural)
        result = bench_neural_measure(&neural, &report.neural);
    if (result == NG_OK) {
        add_neural_ratios(&report);
        if (b->json)
            write_report(b, &report);
        else
            print_ratios(&report);
    }
    finish_measurement(&report.plain);
    return result;
}

static int run(const void *args)
{
    struct bench values = *(const struct bench *)args, *b = &values;
    values.method = method_choose(method_bench_option(values.method), values.scene, values.weights);
    if ((b->weights || b->gbuffer) && !is_neural(b)) {
        fprintf(stderr, "lightformer bench: %s needs --method neural\n",
                b->weights ? "--weights" : "--gbuffer");
        return CLI_USAGE;
    }
    if (b->window.width && !b->interactive && !b->flicker) {
        fputs("lightformer bench: --window needs --interactive or --flicker\n", stderr);
        return CLI_USAGE;
    }
    if (!opening_check(&b->opening, "bench"))
        return CLI_USAGE;
    const struct bench_reference_params reference = {.scene = b->scene,
                                                     .opening = &b->opening,
                                                     .size = b->size,
                                                     .samples = b->samples,
                                                     .threads = b->threads,
                                                     .json = b->json};
    const struct bench_net_params net = {.network = b->scene,
                                         .size = b->size,
                                         .lights = b->lights,
                                         .frames = b->frames,
                                         .threads = b->threads,
                                         .kernel = b->kernel,
                                         .json = b->json};
    const struct bench_interactive_params interactive = {.scene = b->scene,
                                                         .device = b->device,
                                                         .weights = b->weights,
                                                         .opening = &b->opening,
                                                         .size = b->window,
                                                         .method = b->method,
                                                         .threads = b->threads,
                                                         .json = b->json};
    const struct bench_flicker_params flicker = {.scene = b->scene,
                                                 .device = b->device,
                                                 .weights = b->weights,
                                                 .opening = &b->opening,
                                                 .size = b->window,
                                                 .method = b->method,
                                                 .threads = b->threads,
                                                 .json = b->json};
    ng_result result = b->net ? NG_OK : scene_file_check(b->scene);
    if (result == NG_OK)
        result = b->net           ? bench_net(&net)
                 : b->interactive ? bench_interactive(&interactive)
                 : b->flicker     ? bench_flicker(&flicker)
                 : b->reference   ? bench_reference(&reference)
                                  : measure_frames(b);
    return result == NG_OK ? CLI_DONE : CLI_FAILED;
}

const struct cli_command cli_bench_command = {
    .name = "bench",
    .summary = "Measures frames and their passes.",
    .notes =
        "Ratios compare a pass with one that draws the depth of the same triangles alone, in the same run.",
    .options = options,
    .option_count = NG_COUNT(options),
    .values_size = sizeof(struct bench),
    .run = run,
};

// Every frame encodes every light anew and gathers: all that a network can have to do. Frames are timed
// first; then as many run under the profile, which slows them a little. Peaks are measured between the two.
#include "bench_net.h"

#include "json.h"

#include "base/array.h"
#include "base/jobs.h"
#include "base/log.h"
#include "base/rng.h"
#include "base/system.h"
#include "lightformer/net/net.h"

#include <stdlib.h>
#include <string.h>

#define WARM_UP 2
#define VPLS    128
#define TEXELS  2048

enum { LIGHT, VIEW, GATHER, FRAME, SPANS };
static const char *const span_names[SPANS] = {"light", "view", "gather", "frame"};

struct session {
    const struct bench_net_params *params;
    struct ng_jobs *jobs;
    struct lf_net *net;
    struct lf_net_executor *executor;
    struct lf_net_values values; // of every light and pixel
    float *outputs;
    NG_ARRAY(struct lf_net_encoding *) encodings;
    NG_ARRAY(struct lf_net_gathered) gathered;
};

struct results {
    NG_ARRAY(double) ms[SPANS];
    double median[SPANS];
    struct lf_net_figure figures[LF_NET_MAX_FIGURES];
    uint32_t figure_count;
    double peaks[LF_KERNEL_AMX + 1];
};

// ---- Inputs ---------------------------------------------------------------------------------------------

static size_t input_count(const struct session *s, enum lf_net_domain domain)
{
    switch (domain) {
    case LF_DOMAIN_VPL:
        return VPLS;
    case LF_DOMAIN_TEXEL:
        return TEXELS;
    case LF_DOMAIN_PIXEL:
    case LF_DOMAIN_VIEW:
        return (size_t)s->params->size.width * s->params->size.height;
    default:
        return 1;
    }
}

static ng_result make_inputs(struct session *s)
{
    struct ng_rng rng = ng_rng_make(1, 2);
    for (uint32_t i = 0; i < LF_INPUT_COUNT; i++) {
        size_t count = lf_net_inputs[i].channels * input_count(s, lf_net_inputs[i].domain);
        float *values = malloc(count * sizeof *values);
        if (!values)
            return ng_out_of_memory("the inputs of a network");
        for (size_t k = 0; k < count; k++)
            values[k] = ng_rng_range(&rng, 0, 1);
        s->values.of[i] = values;
    }
    s->outputs = malloc(9 * input_count(s, LF_DOMAIN_PIXEL) * sizeof *s->outputs);
    return s->outputs ? NG_OK : ng_out_of_memory("the outputs of a network");
}

static ng_result make_lights(struct session *s)
{
    if (!ng_array_resize(&s->encodings, s->params->lights) ||
        !ng_array_resize(&s->gathered, s->params->lights))
        return ng_out_of_memory("the lights of a network");
    for (uint32_t i = 0; i < s->params->lights; i++) {
        NG_TRY(lf_net_encoding_create(s->executor, &s->encodings.items[i]));
        s->gathered.items[i] = (struct lf_net_gathered){s->encodings.items[i], &s->values};
    }
    return NG_OK;
}

static ng_result open_session(struct session *s)
{
    NG_TRY(lf_net_load(s->params->network, &s->net));
    NG_TRY(ng_jobs_create(&(struct ng_jobs_params){s->params->threads}, &s->jobs));
    NG_TRY(lf_net_executor_create(
        &(struct lf_net_executor_params){
            .net = s->net, .jobs = s->jobs, .kernel = (enum lf_net_kernel)s->params->kernel, .compact = true},
        &s->executor));
    NG_TRY(make_inputs(s));
    return make_lights(s);
}

static void close_session(struct session *s)
{
    for (size_t i = 0; i < s->encodings.count; i++)
        lf_net_encoding_destroy(&s->encodings.items[i]);
    for (uint32_t i = 0; i < LF_INPUT_COUNT; i++)
        free((float *)s->values.of[i]);
    free(s->outputs);
    ng_array_finish(&s->encodings);
    ng_array_finish(&s->gathered);
    lf_net_executor_destroy(&s->executor);
    ng_jobs_destroy(&s->jobs);
    lf_net_destroy(&s->net);
}

// ---- Frames ---------------------------------------------------------------------------------------------

static double lap(uint64_t *since)
{
    uint64_t now = ng_clock_ns();
    double ms = (double)(now - *since) * 1e-6;
    *since = now;
    return ms;
}

static ng_result run_frame(struct session *s, double ms[SPANS])
{
    const struct lf_net_picture frame = {s->params->size.width, s->params->size.height, &s->values};
    const struct lf_net_light_inputs rows = {&s->values, VPLS, TEXELS};
    size_t plane = 3 * input_count(s, LF_DOMAIN_PIXEL);
    const struct lf_net_radiance out = {s->outputs, s->outputs + plane, s->outputs + 2 * plane};
    uint64_t since = ng_clock_ns();
    for (size_t i = 0; i < s->encodings.count; i++)
        NG_TRY(lf_net_encode_light(s->executor, s->encodings.items[i], &rows));
    ms[LIGHT] = lap(&since);
    for (size_t i = 0; i < s->encodings.count; i++)
        NG_TRY(lf_net_encode_view(s->executor, s->encodings.items[i], &frame, &s->values));
    ms[VIEW] = lap(&since);
    NG_TRY(lf_net_gather(s->executor, &frame, s->gathered.items, (uint32_t)s->gathered.count, &out));
    ms[GATHER] = lap(&since);
    ms[FRAME] = ms[LIGHT] + ms[VIEW] + ms[GATHER];
    return NG_OK;
}

static ng_result time_frames(struct session *s, struct results *r)
{
    double ms[SPANS];
    for (uint32_t i = 0; i < WARM_UP + s->params->frames; i++) {
        NG_TRY(run_frame(s, ms));
        for (int k = 0; i >= WARM_UP && k < SPANS; k++)
            if (!ng_array_push(&r->ms[k], ms[k]))
                return ng_out_of_memory("figures");
    }
    return NG_OK;
}

static ng_result profile_frames(struct session *s, struct results *r)
{
    double ms[SPANS];
    lf_net_profile(s->executor, true);
    for (uint32_t i = 0; i < s->params->frames; i++)
        NG_TRY(run_frame(s, ms));
    lf_net_profile(s->executor, false);
    r->figure_count = lf_net_figures(s->executor, r->figures);
    return NG_OK;
}

// ---- Figures --------------------------------------------------------------------------------------------

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void find_medians(struct results *r)
{
    for (int i = 0; i < SPANS; i++) {
        qsort(r->ms[i].items, r->ms[i].count, sizeof *r->ms[i].items, compare);
        r->median[i] = r->ms[i].items[r->ms[i].count / 2];
    }
}

static bool is_product(const struct lf_net_figure *f)
{
    return strcmp(f->operation, "linear") == 0 || strcmp(f->operation, "conv") == 0;
}

// The products and convolutions of all stages: GFLOP/s, all threads together.
static double product_speed(const struct results *r, uint32_t threads)
{
    double ms = 0, gflop = 0;
    for (uint32_t i = 0; i < r->figure_count; i++)
        if (is_product(&r->figures[i])) {
            ms += r->figures[i].ms;
            gflop += r->figures[i].gflop;
        }
    return ms > 0 ? gflop / ms * 1e3 * threads : 0;
}

static void print_table(const struct session *s, const struct results *r)
{
    uint32_t threads = ng_jobs_threads(s->jobs);
    enum lf_net_kernel kernel = lf_net_executor_kernel(s->executor);
    double frames = s->params->frames, speed = product_speed(r, threads), total = 0;
    printf("%s, %u x %u, %u lights, kernel %s, %u threads\n", s->params->network, s->params->size.width,
           s->params->size.height, s->params->lights, lf_net_kernel_name(kernel), threads);
    for (int i = 0; i < SPANS; i++)
        printf("  %-8s %9.3f ms\n", span_names[i], r->median[i]);
    for (uint32_t i = 0; i < r->figure_count; i++)
        total += r->figures[i].ms;
    puts("\nwhere the time of all threads goes, under the profile, a frame");
    for (uint32_t i = 0; i < r->figure_count; i++) {
        const struct lf_net_figure *f = &r->figures[i];
        printf("  %-8s %-20s %9.3f ms %5.1f %%", f->stage, f->operation, f->ms / frames, 100 * f->ms / total);
        if (f->gflop > 0)
            printf(" %9.1f GFLOP/s %5.1f %% of the peak", f->gflop / f->ms * 1e3 * threads,
                   100 * f->gflop / f->ms * 1e3 * threads / r->peaks[kernel]);
        putchar('\n');
    }
    puts("\npeaks, all threads");
    for (int i = LF_KERNEL_PLAIN; i <= LF_KERNEL_AMX; i++)
        if (r->peaks[i] > 0)
            printf("  %-8s %9.1f GFLOP/s; products and convolutions reach %.0f %% of it\n",
                   lf_net_kernel_name((enum lf_net_kernel)i), r->peaks[i], 100 * speed / r->peaks[i]);
}

static void print_json(const struct session *s, const struct results *r)
{
    struct json j = {.out = stdout};
    enum lf_net_kernel kernel = lf_net_executor_kernel(s->executor);
    double frames = s->params->frames, speed = product_speed(r, ng_jobs_threads(s->jobs));
    json_object(&j, NULL);
    json_text(&j, "kernel", lf_net_kernel_name(kernel));
    json_number(&j, "threads", ng_jobs_threads(s->jobs));
    json_number(&j, "width", s->params->size.width);
    json_number(&j, "height", s->params->size.height);
    json_number(&j, "lights", s->params->lights);
    json_object(&j, "median_ms");
    for (int i = 0; i < SPANS; i++)
        json_number(&j, span_names[i], r->median[i]);
    json_end(&j);
    json_array(&j, "operations");
    for (uint32_t i = 0; i < r->figure_count; i++) {
        json_object(&j, NULL);
        json_text(&j, "stage", r->figures[i].stage);
        json_text(&j, "operation", r->figures[i].operation);
        json_number(&j, "thread_ms", r->figures[i].ms / frames);
        json_number(&j, "gflop", r->figures[i].gflop / frames);
        json_end(&j);
    }
    json_end(&j);
    json_object(&j, "peak_gflops");
    for (int i = LF_KERNEL_PLAIN; i <= LF_KERNEL_AMX; i++)
        json_number(&j, lf_net_kernel_name((enum lf_net_kernel)i), r->peaks[i]);
    json_end(&j);
    json_object(&j, "ratios");
    for (int i = LF_KERNEL_PLAIN; i <= LF_KERNEL_AMX; i++) {
        char name[64];
        snprintf(name, sizeof name, "products_to_%s_peak", lf_net_kernel_name((enum lf_net_kernel)i));
        if (r->peaks[i] > 0)
            json_number(&j, name, speed / r->peaks[i]);
    }
    json_end(&j);
    json_end(&j);
}

const char *bench_net_kernel(uint32_t index)
{
    return index <= LF_KERNEL_AMX ? lf_net_kernel_name((enum lf_net_kernel)index) : NULL;
}

static ng_result measure(struct session *s, struct results *r)
{
    NG_TRY(open_session(s));
    NG_TRY(time_frames(s, r));
    for (int i = LF_KERNEL_PLAIN; i <= LF_KERNEL_AMX; i++)
        r->peaks[i] = lf_net_peak((enum lf_net_kernel)i, s->jobs);
    NG_TRY(profile_frames(s, r));
    find_medians(r);
    return NG_OK;
}

static void close_results(struct results *r)
{
    for (int i = 0; i < SPANS; i++)
        ng_array_finish(&r->ms[i]);
}

ng_result bench_net(const struct bench_net_params *params)
{
    struct session s = {.params = params};
    struct results r = {0};
    ng_result result = measure(&s, &r);
    if (result == NG_OK)
        (params->json ? print_json : print_table)(&s, &r);
    close_results(&r);
    close_session(&s);
    return result;
}

static void set_stages(const struct results *r, uint32_t frames, struct bench_net_shares *out)
{
    for (uint32_t i = 0; i < BENCH_NET_STAGES; i++)
        out->stages[i].ms = r->median[i];
    for (uint32_t i = 0; i < r->figure_count; i++)
        for (uint32_t k = 0; k < BENCH_NET_STAGES && is_product(&r->figures[i]); k++)
            if (strcmp(r->figures[i].stage, span_names[k]) == 0)
                out->stages[k].gflop += r->figures[i].gflop / frames;
}

ng_result bench_net_measure_shares(const struct bench_net_params *params, struct bench_net_shares *out)
{
    struct session s = {.params = params};
    struct results r = {0};
    *out = (struct bench_net_shares){0};
    ng_result result = measure(&s, &r);
    for (int i = LF_KERNEL_PLAIN; i <= LF_KERNEL_AMX && result == NG_OK; i++)
        if (r.peaks[i] > 0)
            out->of[i] = product_speed(&r, ng_jobs_threads(s.jobs)) / r.peaks[i];
    if (result == NG_OK) {
        out->peak = r.peaks[lf_net_executor_kernel(s.executor)];
        set_stages(&r, params->frames, out);
    }
    close_results(&r);
    close_session(&s);
    return result;
}

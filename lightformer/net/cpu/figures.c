// Where the executor's time goes, and how fast its multiplications could be.
#include "lightformer/net/cpu/executor_internal.h"

#include "base/printable.h"
#include "base/system.h"

#include <string.h>

#define PEAK_ROUNDS 200000u // a few milliseconds
#define PEAK_TRIES  5

static const char *const stage_names[LF_STAGE_COUNT] = {"light", "view", "gather"};
static const char *const figure_names[LF_FIGURE_COUNT] = {
    [LF_CODE_LOAD_INPUT] = "load input",
    [LF_CODE_LOAD_VECTOR] = "load vector",
    [LF_CODE_SPREAD] = "spread vector",
    [LF_CODE_LOAD_IMAGE] = "load image",
    [LF_CODE_LOAD_PACKED] = "load packed image",
    [LF_CODE_PACK] = "pack",
    [LF_CODE_PRODUCT] = "linear",
    [LF_FIGURE_CONV] = "conv",
    [LF_CODE_PAIRWISE] = "pairwise",
    [LF_CODE_EACH] = "elementwise",
    [LF_CODE_COPY] = "copy",
    [LF_CODE_DOT] = "dot",
    [LF_CODE_NORMALIZE] = "normalize",
    [LF_CODE_RESAMPLE] = "resample",
    [LF_CODE_CLEAR] = "clear",
    [LF_CODE_ADD_SCALED] = "sum over lights",
    [LF_CODE_ATTEND] = "attend",
    [LF_CODE_ATTEND_END] = "end of attend",
    [LF_CODE_STORE_IMAGE] = "store image",
    [LF_CODE_STORE_PACKED] = "store packed image",
    [LF_CODE_STORE_VECTOR] = "store vector",
    [LF_CODE_STORE_OUTPUT] = "store output",
    [LF_CODE_REDUCE] = "sum over rows",
};

void lf_net_profile(struct lf_net_executor *executor, bool on)
{
    executor->profiling = on;
    for (size_t i = 0; on && i < executor->workers.count; i++)
        memset(executor->workers.items[i].figures, 0, sizeof executor->workers.items[i].figures);
}

uint32_t lf_net_figures(const struct lf_net_executor *executor, struct lf_net_figure out[LF_NET_MAX_FIGURES])
{
    uint32_t count = 0;
    for (uint32_t stage = 0; stage < LF_STAGE_COUNT; stage++)
        for (uint32_t kind = 0; kind < LF_FIGURE_COUNT; kind++) {
            struct lf_net_figure figure = {.stage = stage_names[stage], .operation = figure_names[kind]};
            for (size_t i = 0; i < executor->workers.count; i++) {
                const struct lf_figures *f = &executor->workers.items[i].figures[stage];
                figure.ms += (double)f->ns[kind] * 1e-6;
                figure.gflop += (double)f->multiplications[kind] * 2e-9;
                figure.tiles += f->tiles[kind];
            }
            if (figure.tiles)
                out[count++] = figure;
        }
    return count;
}

struct peak {
    const struct lf_kernel *kernel;
};

static void run_peak(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    const struct peak *peak = user;
    NG_UNUSED(worker);
    for (; begin < end; begin++)
        peak->kernel->peak(PEAK_ROUNDS);
}

// The best of a few tries: others may need the processor too.
double lf_net_peak(enum lf_net_kernel kernel, struct ng_jobs *jobs)
{
    struct peak peak = {lf_kernel_find(kernel)};
    uint32_t threads = ng_jobs_threads(jobs);
    double best = 0;
    if (!peak.kernel)
        return 0;
    double gflop = peak.kernel->peak(1) * PEAK_ROUNDS * threads;
    for (int i = 0; i < PEAK_TRIES; i++) {
        uint64_t start = ng_clock_ns();
        ng_jobs_for(jobs, threads, 1, run_peak, &peak);
        double speed = gflop * 1e9 / (double)(ng_clock_ns() - start);
        best = speed > best ? speed : best;
    }
    return best;
}

// ---- The plan, for people -------------------------------------------------------------------------------

// Names come from the file of the network.
static const char *shown(const char *name, char out[LF_NAME])
{
    snprintf(out, LF_NAME, "%s", name);
    ng_make_printable(out);
    return out;
}

static void print_code(const struct lf_net_executor *e, const struct lf_code *code, FILE *out)
{
    const struct lf_value *values = e->net->values.items;
    char name[LF_NAME];
    fprintf(out, "      %-18s", figure_names[code->kind]);
    if (code->op)
        fprintf(out, " %-10s %-16s", lf_op_name(code->op->kind), shown(values[code->op->out].name, name));
    else if (code->value != LF_NO_VALUE && code->kind != LF_CODE_STORE_OUTPUT)
        fprintf(out, " %-27s", shown(values[code->value].name, name));
    if (code->product != LF_NO_VALUE) {
        const struct lf_product *p = &e->plan.products.items[code->product];
        fprintf(out, " %u x %u", p->outputs, p->weights_channels);
    } else if (code->channels) {
        fprintf(out, " %u", code->channels);
    }
    fputc('\n', out);
}

static void print_segment(const struct lf_net_executor *e, const struct lf_segment *s, FILE *out)
{
    static const char *const domains[] = {"frame", "light", "vpl", "texel", "pixel", "picture"};
    fprintf(out, "  %s, level %u, %u rows%s%s\n", domains[s->domain], s->level, s->rows,
            s->nested ? ", within a later one" : "", s->inner != LF_NO_VALUE ? ", with an inner one" : "");
    for (uint32_t i = s->phase_begin; i < s->phase_end; i++) {
        const struct lf_phase *phase = &e->plan.phases.items[i];
        for (uint32_t k = phase->begin; k < phase->end; k++) {
            if (k == phase->lights)
                fputs("    for each light\n", out);
            print_code(e, &e->plan.codes.items[k], out);
        }
    }
}

void lf_net_print_plan(const struct lf_net_executor *executor, FILE *out)
{
    const struct lf_plan *plan = &executor->plan;
    for (uint32_t stage = 0; stage < LF_STAGE_COUNT; stage++) {
        fprintf(out, "%s\n", stage_names[stage]);
        for (uint32_t i = plan->stage_begin[stage]; i < plan->stage_begin[stage + 1]; i++)
            print_segment(executor, &plan->segments.items[i], out);
    }
}

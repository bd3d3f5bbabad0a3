// lightformer net: what a network is; or runs it on inputs from a file, for comparison with other executors.
#include "bench_net.h"
#include "commands.h"
#include "json.h"

#include "base/jobs.h"
#include "base/log.h"
#include "base/printable.h"
#include "lightformer/net/net.h"
#include "lightformer/tensors/tensors.h"

#include <stdio.h>
#include <string.h>

struct net {
    const char *file, *inputs, *output;
    uint32_t kernel, threads;
    bool plan, json;
};

static const char *const not_with_plan[] = {"--run", "--json", NULL};
static const char *const not_with_run[] = {"--json", NULL};

static const struct cli_option options[] = {
    CLI_ARGUMENT(struct net, file, "NETWORK", "a weights file (.safetensors)"),
    {.name = "--run",
     .kind = CLI_TEXT,
     .flags = CLI_READS,
     .offset = offsetof(struct net, inputs),
     .value = "INPUTS",
     .needs = "--output",
     .excludes = not_with_run,
     .doc = "run it on the tensors of this file (.safetensors)"},
    {.name = "--output",
     .letter = 'o',
     .kind = CLI_TEXT,
     .flags = CLI_WRITES,
     .offset = offsetof(struct net, output),
     .value = "FILE",
     .needs = "--run",
     .doc = "with --run: where the outputs go (.safetensors)"},
    {.name = "--kernel",
     .kind = CLI_CHOICE,
     .offset = offsetof(struct net, kernel),
     .value = "NAME",
     .fallback = "auto",
     .choice = bench_net_kernel,
     .doc = "how numbers are multiplied"},
    {.name = "--plan",
     .kind = CLI_FLAG,
     .offset = offsetof(struct net, plan),
     .excludes = not_with_plan,
     .doc = "print what runs in which order"},
    CLI_THREADS(struct net),
    CLI_JSON(struct net),
};

// ---- Inputs from a file

struct light {
    struct lf_net_values values;
    struct lf_net_encoding *encoding;
    uint32_t rows[2]; // direct VPLs, texels
};

struct inputs {
    struct lf_tensors file;
    struct lf_net_values frame;
    uint32_t width, height;
    NG_ARRAY(struct light) lights;
};

// A domain's shape: channels, and then rows, or height and width. 0 stands for what is not known yet.
static bool take_sizes(const struct lf_tensor *t, enum lf_net_domain domain, uint32_t sizes[2])
{
    uint32_t dimensions = domain == LF_DOMAIN_FRAME || domain == LF_DOMAIN_LIGHT ? 0
                          : domain == LF_DOMAIN_VPL || domain == LF_DOMAIN_TEXEL ? 1
                                                                                 : 2;
    if (t->rank != 1 + dimensions)
        return false;
    for (uint32_t i = 0; i < dimensions; i++) {
        if (t->shape[1 + i] > UINT32_MAX || (sizes[i] && sizes[i] != t->shape[1 + i]))
            return false;
        sizes[i] = (uint32_t)t->shape[1 + i];
    }
    return true;
}

static bool take_tensor(struct inputs *in, const struct lf_tensor *t, struct light *light, const char *name)
{
    uint32_t i = 0, picture[] = {in->height, in->width}, none[2] = {0};
    while (i < LF_INPUT_COUNT && strcmp(lf_net_inputs[i].name, name) != 0)
        i++;
    if (i == LF_INPUT_COUNT || t->dtype != LF_F32 || t->rank == 0 || t->shape[0] != lf_net_inputs[i].channels)
        return false;
    enum lf_net_domain domain = lf_net_inputs[i].domain;
    bool of_frame = domain == LF_DOMAIN_FRAME || domain == LF_DOMAIN_PIXEL;
    bool of_picture = domain == LF_DOMAIN_PIXEL || domain == LF_DOMAIN_VIEW;
    uint32_t *sizes = of_picture                           ? picture
                      : light && domain == LF_DOMAIN_VPL   ? &light->rows[0]
                      : light && domain == LF_DOMAIN_TEXEL ? &light->rows[1]
                                                           : none;
    if (of_frame == (light != NULL) || !take_sizes(t, domain, sizes))
        return false;
    in->height = picture[0];
    in->width = picture[1];
    (light ? &light->values : &in->frame)->of[i] = t->data;
    return true;
}

// "light.3/vpl.offset" is input vpl.offset of light 3; without such a beginning it is the frame's.
static ng_result sort_tensor(struct inputs *in, const struct lf_tensor *t, const char *path)
{
    unsigned number;
    int length = 0;
    struct light *light = NULL;
    bool ok = true;
    if (sscanf(t->name, "light.%u/%n", &number, &length) == 1 && length) {
        ok = number < 1024;
        if (ok && number >= in->lights.count && !ng_array_resize(&in->lights, number + 1))
            return ng_out_of_memory("the lights of a network's inputs");
        light = ok ? &in->lights.items[number] : NULL;
    }
    if (ok && take_tensor(in, t, light, t->name + length))
        return NG_OK;
    ng_log_error("%s: its tensor \"%s\" is no input of a network, or of another type or shape", path,
                 t->name);
    return NG_ERROR_FORMAT;
}

static ng_result read_inputs(const char *path, struct inputs *in)
{
    NG_TRY(lf_tensors_read(path, &in->file));
    for (size_t i = 0; i < in->file.list.count; i++)
        NG_TRY(sort_tensor(in, &in->file.list.items[i], path));
    if (in->width && in->height)
        return NG_OK;
    ng_log_error("%s: has no tensor of a picture, such as pixel.mask", path);
    return NG_ERROR_FORMAT;
}

// ---- Running

static ng_result encode(struct lf_net_executor *executor, const struct lf_net_picture *frame,
                        struct light *light)
{
    struct lf_net_light_inputs inputs = {&light->values, light->rows[0], light->rows[1]};
    for (uint32_t i = 0; i < LF_INPUT_COUNT; i++)
        if (lf_net_inputs[i].domain == LF_DOMAIN_FRAME)
            light->values.of[i] = frame->values->of[i];
    NG_TRY(lf_net_encoding_create(executor, &light->encoding));
    NG_TRY(lf_net_encode_light(executor, light->encoding, &inputs));
    return lf_net_encode_view(executor, light->encoding, frame, &light->values);
}

static ng_result gather(struct lf_net_executor *executor, const struct lf_net_picture *frame,
                        const struct inputs *in, struct lf_tensors *out)
{
    const uint64_t shape[] = {3, in->height, in->width};
    struct lf_net_radiance radiance = {.unshadowed = lf_tensors_add(out, "unshadowed", LF_F32, 3, shape),
                                       .direct = lf_tensors_add(out, "direct", LF_F32, 3, shape),
                                       .indirect = lf_tensors_add(out, "indirect", LF_F32, 3, shape)};
    NG_ARRAY(struct lf_net_gathered) gathered = {0};
    if (!radiance.unshadowed || !radiance.direct || !radiance.indirect)
        return NG_ERROR_MEMORY;
    if (!ng_array_resize(&gathered, in->lights.count))
        return ng_out_of_memory("the lights of a network's inputs");
    for (size_t i = 0; i < in->lights.count; i++)
        gathered.items[i] =
            (struct lf_net_gathered){in->lights.items[i].encoding, &in->lights.items[i].values};
    ng_result result = lf_net_gather(executor, frame, gathered.items, (uint32_t)gathered.count, &radiance);
    ng_array_finish(&gathered);
    return result;
}

static ng_result run_on(struct lf_net_executor *executor, struct inputs *in, const char *output)
{
    struct lf_tensors out = {0};
    struct lf_net_picture frame = {in->width, in->height, &in->frame};
    ng_result result = NG_OK;
    for (size_t i = 0; result == NG_OK && i < in->lights.count; i++)
        result = encode(executor, &frame, &in->lights.items[i]);
    if (result == NG_OK)
        result = gather(executor, &frame, in, &out);
    if (result == NG_OK)
        result = lf_tensors_note(&out, "kernel", lf_net_kernel_name(lf_net_executor_kernel(executor)));
    if (result == NG_OK)
        result = lf_tensors_write(&out, output);
    lf_tensors_finish(&out);
    return result;
}

static ng_result run_network(const struct net *n, const struct lf_net *net)
{
    struct lf_net_executor *executor = NULL;
    struct ng_jobs *jobs = NULL;
    struct inputs in = {0};
    ng_result result = ng_jobs_create(&(struct ng_jobs_params){n->threads}, &jobs);
    if (result == NG_OK)
        result = lf_net_executor_create(
            &(struct lf_net_executor_params){
                .net = net, .jobs = jobs, .kernel = (enum lf_net_kernel)n->kernel},
            &executor);
    if (result == NG_OK)
        result = read_inputs(n->inputs, &in);
    if (result == NG_OK)
        result = run_on(executor, &in, n->output);
    for (size_t i = 0; i < in.lights.count; i++)
        lf_net_encoding_destroy(&in.lights.items[i].encoding);
    ng_array_finish(&in.lights);
    lf_tensors_finish(&in.file);
    lf_net_executor_destroy(&executor);
    ng_jobs_destroy(&jobs);
    return result;
}

static ng_result print_plan(const struct net *n, const struct lf_net *net)
{
    struct lf_net_executor *executor;
    NG_TRY(lf_net_executor_create(
        &(struct lf_net_executor_params){.net = net, .kernel = (enum lf_net_kernel)n->kernel}, &executor));
    lf_net_print_plan(executor, stdout);
    lf_net_executor_destroy(&executor);
    return NG_OK;
}

// ---- What it is

static const char *const notes[] = {"family", "preset", "training", "data", "dataset", "quality"};

static void print_table(const struct net *n, const struct lf_net *net)
{
    ng_print_line(stdout, "%s: %llu parameters", n->file, (unsigned long long)lf_net_parameters(net));
    for (size_t i = 0; i < NG_COUNT(notes); i++)
        if (lf_net_note(net, notes[i]))
            ng_print_line(stdout, "  %-9s %s", notes[i], lf_net_note(net, notes[i]));
    printf("  reads    ");
    for (uint32_t i = 0; i < LF_INPUT_COUNT; i++)
        if (lf_net_reads(net, (enum lf_net_input)i))
            printf(" %s", lf_net_inputs[i].name);
    putchar('\n');
}

static void print_json(const struct lf_net *net)
{
    struct json j = {.out = stdout};
    json_object(&j, NULL);
    json_number(&j, "parameters", (double)lf_net_parameters(net));
    for (size_t i = 0; i < NG_COUNT(notes); i++)
        json_text(&j, notes[i], lf_net_note(net, notes[i]));
    json_array(&j, "inputs");
    for (uint32_t i = 0; i < LF_INPUT_COUNT; i++)
        if (lf_net_reads(net, (enum lf_net_input)i))
            json_text(&j, NULL, lf_net_inputs[i].name);
    json_end(&j);
    json_end(&j);
}

static int run(const void *args)
{
    const struct net *n = args;
    struct lf_net *net;
    if (lf_net_load(n->file, &net) != NG_OK)
        return CLI_FAILED;
    ng_result result = NG_OK;
    if (n->inputs)
        result = run_network(n, net);
    else if (n->plan)
        result = print_plan(n, net);
    else if (n->json)
        print_json(net);
    else
        print_table(n, net);
    lf_net_destroy(&net);
    return result == NG_OK ? CLI_DONE : CLI_FAILED;
}

const struct cli_command cli_net_command = {
    .name = "net",
    .summary = "Shows what a network is, or runs it on inputs from a file.",
    .notes =
        "INPUTS: fp32 tensors by the names of lightformer/net/inputs.inc; a light's begin with its number:\n"
        "pixel.normal [3, h, w], light.0/light.color [3], light.0/vpl.offset [3, n], light.0/view.direction "
        "[3, h, w].\nWhat is missing is zero. The outputs are unshadowed, direct and indirect, [3, h, w].",
    .options = options,
    .option_count = NG_COUNT(options),
    .values_size = sizeof(struct net),
    .run = run,
};

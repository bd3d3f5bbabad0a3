// lightformer compare: how far a picture is from its reference.
#include "commands.h"
#include "json.h"

#include "lightformer/metrics/metrics.h"

struct compare {
    const char *a, *b, *b2, *layer, *mask, *mask_layer;
    bool json;
};

static const struct cli_option options[] = {
    {.name = "A",
     .kind = CLI_TEXT,
     .flags = CLI_REQUIRED,
     .offset = offsetof(struct compare, a),
     .doc = "the picture that is judged, OpenEXR or PNG"},
    {.name = "B",
     .kind = CLI_TEXT,
     .flags = CLI_REQUIRED,
     .offset = offsetof(struct compare, b),
     .doc = "its reference"},
    {.name = "B2",
     .kind = CLI_TEXT,
     .offset = offsetof(struct compare, b2),
     .doc = "a second reference, made with another seed: removes the noise of both from the RSE"},
    {.name = "--layer",
     .kind = CLI_TEXT,
     .offset = offsetof(struct compare, layer),
     .value = "NAME",
     .doc = "compare this layer of OpenEXR files, such as indirect, not the beauty"},
    {.name = "--mask",
     .kind = CLI_TEXT,
     .offset = offsetof(struct compare, mask),
     .value = "FILE",
     .doc = "only pixels where this picture is not 0"},
    {.name = "--mask-layer",
     .kind = CLI_TEXT,
     .offset = offsetof(struct compare, mask_layer),
     .value = "NAME",
     .doc = "the mask is this layer, of B unless --mask names another file"},
    CLI_JSON(struct compare),
};

// What is read for a comparison.
struct pictures {
    struct lf_picture a, b, b2, mask;
};

static ng_result load(const struct compare *c, struct pictures *p)
{
    NG_TRY(lf_picture_load(c->a, c->layer, &p->a));
    NG_TRY(lf_picture_load(c->b, c->layer, &p->b));
    if (c->b2)
        NG_TRY(lf_picture_load(c->b2, c->layer, &p->b2));
    if (c->mask || c->mask_layer)
        NG_TRY(lf_picture_load(c->mask ? c->mask : c->b, c->mask_layer, &p->mask));
    return NG_OK;
}

static void finish(struct pictures *p)
{
    lf_picture_finish(&p->a);
    lf_picture_finish(&p->b);
    lf_picture_finish(&p->b2);
    lf_picture_finish(&p->mask);
}

static ng_result compute(const struct pictures *p, struct lf_metrics *out)
{
    const struct lf_metrics_params params = {
        .a = &p->a,
        .b = &p->b,
        .b2 = p->b2.pixels ? &p->b2 : NULL,
        .mask = p->mask.pixels ? &p->mask : NULL,
    };
    return lf_metrics_compute(&params, out);
}

static void print_metrics(const struct lf_metrics *m)
{
    printf("RSE         %.6g\n", m->rse);
    printf("L1          %.6g\n", m->l1);
    printf("PSNR        %.4g dB\n", m->psnr);
    printf("mean ratio  %.6g\n", m->mean_ratio);
    printf("pixels      %llu\n", (unsigned long long)m->pixels);
}

static void write_metrics(const struct compare *c, const struct lf_metrics *m)
{
    struct json j = {.out = stdout};
    json_object(&j, NULL);
    json_text(&j, "a", c->a);
    json_text(&j, "b", c->b);
    json_text(&j, "b2", c->b2);
    json_text(&j, "layer", c->layer);
    json_number(&j, "rse", m->rse);
    json_number(&j, "l1", m->l1);
    json_number(&j, "psnr", m->psnr);
    json_number(&j, "mean_ratio", m->mean_ratio);
    json_number(&j, "pixels", (double)m->pixels);
    json_end(&j);
}

static int run(const void *args)
{
    const struct compare *c = args;
    struct pictures pictures = {0};
    struct lf_metrics metrics;
    ng_result result = load(c, &pictures);
    if (result == NG_OK)
        result = compute(&pictures, &metrics);
    if (result == NG_OK && c->json)
        write_metrics(c, &metrics);
    else if (result == NG_OK)
        print_metrics(&metrics);
    finish(&pictures);
    return result == NG_OK ? CLI_DONE : CLI_FAILED;
}

const struct cli_command cli_compare_command = {
    .name = "compare",
    .summary = "Measures how far a picture is from its reference.",
    .notes =
        "RSE, L1, PSNR and the ratio of means are defined in lightformer/metrics/README.md. The PSNR of "
        "equal pictures is\ninfinite, in JSON null. tools/eval/compare adds perceptual metrics and a page.",
    .options = options,
    .option_count = NG_COUNT(options),
    .values_size = sizeof(struct compare),
    .run = run,
};

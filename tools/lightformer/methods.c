#include "methods.h"

#include "app/stage.h"
#include "lightformer/progressive/progressive.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

// ---- reference, live -------------------------------------------------------------------------------------

static ng_result create_reference(const struct method_params *params, void **state)
{
    struct lf_progressive_params progressive = {.jobs = params->stage->jobs, .samples = params->samples};
    struct lf_progressive *p;
    NG_TRY(lf_progressive_create(&progressive, &p));
    *state = p;
    struct ng_provider provider = lf_progressive_provider(p);
    return ng_composer_register(ng_renderer_composer(params->stage->renderer), &provider);
}

static void destroy_reference(void **state)
{
    struct lf_progressive *p = *state;
    lf_progressive_destroy(&p);
    *state = NULL;
}

static void describe_reference(const void *state, char *out, size_t size)
{
    struct lf_progressive_stats stats = lf_progressive_stats_of(state);
    if (!stats.samples)
        snprintf(out, size, "preview"); // all that moving pictures get
    else
        snprintf(out, size, "%" PRIu32 " spp, %.1f s, %.1f million rays", stats.samples, stats.seconds,
                 (double)stats.rays * 1e-6);
}

// ---- the table -------------------------------------------------------------------------------------------

static const struct method methods[] = {
    {.name = "raster",
     .key = '1',
     .uses = METHOD_RENDER | METHOD_VIEW | METHOD_BENCH,
     .doc = "direct light, rasterized"},
    {.name = "reference",
     .key = '3',
     .uses = METHOD_RENDER | METHOD_VIEW,
     .doc = "all light, path traced",
     .create = create_reference,
     .destroy = destroy_reference,
     .describe = describe_reference},
};

_Static_assert(NG_COUNT(methods) <= METHOD_MAX, "callers keep a state for each");

const struct method *method_of(unsigned use, uint32_t index)
{
    for (size_t i = 0; i < NG_COUNT(methods); i++)
        if (methods[i].uses & use && index-- == 0)
            return &methods[i];
    return NULL;
}

static const char *name_of(const struct method *method)
{
    return method ? method->name : NULL;
}

const char *method_render_name(uint32_t index)
{
    return name_of(method_of(METHOD_RENDER, index));
}

const char *method_view_name(uint32_t index)
{
    return name_of(method_of(METHOD_VIEW, index));
}

const char *method_bench_name(uint32_t index)
{
    return name_of(method_of(METHOD_BENCH, index));
}

ng_result method_open(const struct method *method, const struct method_params *params, void **state)
{
    *state = NULL;
    return method->create ? method->create(params, state) : NG_OK;
}

void method_close(const struct method *method, void **state)
{
    if (method->destroy && *state)
        method->destroy(state);
}

void method_describe(const struct method *method, const void *state, char *out, size_t size)
{
    if (size)
        out[0] = 0;
    if (method->describe && state)
        method->describe(state, out, size);
}

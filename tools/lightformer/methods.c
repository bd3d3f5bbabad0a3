#include "methods.h"

#include "app/stage.h"
#include "base/file.h"
#include "base/log.h"
#include "lightformer/neural/neural.h"
#include "lightformer/progressive/progressive.h"
#include "render/frame.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- neural ----------------------------------------------------------------------------------------------

const char *const method_gbuffers[] = {
    [LF_RAYCAST_AUTO] = "auto", [LF_RAYCAST_RAYS] = "rays", [LF_RAYCAST_RASTER] = "raster", NULL};

// Null `neural`: there are no weights, and the method computes nothing.
struct neural {
    struct lf_neural *neural;
    struct ng_composer *composer;
};

static ng_result publish_nothing(struct ng_composer *composer, void *user)
{
    NG_UNUSED(user);
    if (!ng_frame_wants(ng_composer_get(composer, &ng_frame_item, 0), LF_NEURAL_METHOD))
        return NG_OK;
    return ng_composer_publish(composer, &ng_radiance_item,
                               &(struct ng_radiance){.method = LF_NEURAL_METHOD});
}

static ng_result join_neural(struct neural *n, const struct method_params *params, const char *weights)
{
    const struct ng_provider absent = {.name = LF_NEURAL_METHOD, .consume = publish_nothing};
    const struct lf_neural_params neural = {
        .weights = weights, .jobs = params->stage->jobs, .gbuffer = (enum lf_raycast_use)params->gbuffer};
    if (!weights && params->optional)
        return ng_composer_register(n->composer, &absent);
    if (!weights) {
        ng_log_error("%s: there are no weights beside it; name some with --weights", params->scene);
        return NG_ERROR_NOT_FOUND;
    }
    NG_TRY(lf_neural_create(&neural, &n->neural));
    return lf_neural_join(n->neural, n->composer);
}

static ng_result create_neural(const struct method_params *params, void **state)
{
    char found[4096];
    const char *weights = params->weights;
    struct neural *n = calloc(1, sizeof *n);
    if (!n)
        return ng_out_of_memory("the neural method");
    *state = n;
    n->composer = ng_renderer_composer(params->stage->renderer);
    if (!weights && lf_neural_find_weights(params->scene, found, sizeof found))
        weights = found;
    return join_neural(n, params, weights);
}

static void destroy_neural(void **state)
{
    struct neural *n = *state;
    lf_neural_destroy(&n->neural);
    free(n);
    *state = NULL;
}

static void describe_neural(const void *state, char *out, size_t size)
{
    const struct neural *n = state;
    if (!n->neural) {
        snprintf(out, size, "no weights");
        return;
    }
    const char *preset = lf_net_note(lf_neural_net(n->neural), "preset");
    struct lf_neural_counters c = lf_neural_counters_of(n->neural);
    snprintf(out, size, "%s; made so far: %" PRIu64 " RSMs, %" PRIu64 " views, %" PRIu64 " gathers",
             preset ? preset : "a network", c.encoder.rsm, c.encoder.view, c.gather);
}

// ---- reference, live -------------------------------------------------------------------------------------

static ng_result create_reference(const struct method_params *params, void **state)
{
    struct lf_progressive_params progressive = {.jobs = params->stage->jobs, .samples = params->samples};
    struct lf_progressive *p;
    NG_TRY(lf_progressive_create(&progressive, &p));
    *state = p;
    return lf_progressive_join(p, ng_renderer_composer(params->stage->renderer));
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

static struct method_progress progress_of_reference(const void *state)
{
    struct lf_progressive_stats stats = lf_progressive_stats_of(state);
    return (struct method_progress){!stats.resting, stats.samples};
}

// ---- the table -------------------------------------------------------------------------------------------

static const struct method methods[] = {
    {.name = "raster",
     .key = '1',
     .uses = METHOD_RENDER | METHOD_VIEW | METHOD_BENCH,
     .doc = "direct light, rasterized"},
    {.name = LF_NEURAL_METHOD,
     .key = '2',
     .uses = METHOD_RENDER | METHOD_VIEW | METHOD_BENCH,
     .indirect = true,
     .doc = "all light, by a network",
     .create = create_neural,
     .destroy = destroy_neural,
     .describe = describe_neural},
    {.name = "reference",
     .key = '3',
     .uses = METHOD_RENDER | METHOD_VIEW,
     .indirect = true,
     .doc = "all light, path traced",
     .create = create_reference,
     .destroy = destroy_reference,
     .describe = describe_reference,
     .progress = progress_of_reference},
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

// The names, then "auto", then null.
static const char *option_of(unsigned use, uint32_t index)
{
    if (method_of(use, index))
        return method_of(use, index)->name;
    return method_of(use, index - 1) ? "auto" : NULL;
}

const char *method_render_option(uint32_t index)
{
    return option_of(METHOD_RENDER, index);
}

const char *method_view_option(uint32_t index)
{
    return option_of(METHOD_VIEW, index);
}

const char *method_bench_option(uint32_t index)
{
    return option_of(METHOD_BENCH, index);
}

uint32_t method_choose(unsigned use, uint32_t option, const char *scene, const char *weights)
{
    char found[4096];
    const struct method *m = method_of(use, option);
    if (m)
        return option;
    bool neural = weights || lf_neural_find_weights(scene, found, sizeof found);
    if (!neural && ng_file_exists(found) && !ng_file_is_below(found, scene))
        ng_log_warn("%s: a link out of the scene's folder is not followed; name it with --weights", found);
    const char *name = neural ? LF_NEURAL_METHOD : "raster";
    for (option = 0; (m = method_of(use, option)) && strcmp(m->name, name) != 0; option++)
        ;
    return option;
}

ng_result method_open(const struct method *method, const struct method_params *params, void **state)
{
    *state = NULL;
    return method->create ? method->create(params, state) : NG_OK;
}

struct lf_neural *method_neural(const struct method *method, void *state)
{
    return method->create == create_neural && state ? ((struct neural *)state)->neural : NULL;
}

void method_close(const struct method *method, void **state)
{
    if (method->destroy && *state)
        method->destroy(state);
}

struct method_progress method_progress(const struct method *method, const void *state)
{
    return method->progress && state ? method->progress(state) : (struct method_progress){0};
}

void method_describe(const struct method *method, const void *state, char *out, size_t size)
{
    if (size)
        out[0] = 0;
    if (method->describe && state)
        method->describe(state, out, size);
}

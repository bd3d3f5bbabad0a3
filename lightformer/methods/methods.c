#include "lightformer/methods/methods.h"

#include "base/file.h"
#include "base/log.h"
#include "lightformer/neural/neural.h"
#include "lightformer/progressive/progressive.h"
#include "render/frame.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct row {
    struct lf_method_info info;
    // Null: the renderer has it.
    ng_result (*join)(struct lf_method *m, const struct lf_method_params *params);
    // Null: there is nothing to say; each picture is finished.
    void (*describe)(const struct lf_method *m, char *out, size_t size);
    struct lf_method_progress (*progress)(const struct lf_method *m);
};

struct lf_method {
    const struct row *row;
    struct ng_composer *composer;
    struct lf_neural *neural;
    struct lf_progressive *progressive;
    bool stands_in; // for a network that is not there
};

// ---- neural ----------------------------------------------------------------------------------------------

static ng_result publish_nothing(struct ng_composer *composer, void *user)
{
    NG_UNUSED(user);
    if (!ng_frame_wants(ng_composer_get(composer, &ng_frame_item, 0), LF_NEURAL_METHOD))
        return NG_OK;
    return ng_composer_publish(composer, &ng_radiance_item,
                               &(struct ng_radiance){.method = LF_NEURAL_METHOD});
}

static ng_result join_stand_in(struct lf_method *m)
{
    const struct ng_provider provider = {.name = LF_NEURAL_METHOD, .consume = publish_nothing};
    NG_TRY(ng_composer_register(m->composer, &provider));
    m->stands_in = true;
    return NG_OK;
}

static ng_result join_neural(struct lf_method *m, const struct lf_method_params *params)
{
    char found[4096];
    struct lf_neural_params neural = {
        .weights = params->weights, .jobs = params->jobs, .gbuffer = params->gbuffer};
    if (!neural.weights && params->scene && lf_neural_find_weights(params->scene, found, sizeof found))
        neural.weights = found;
    if (!neural.weights && params->optional)
        return join_stand_in(m);
    if (!neural.weights) {
        ng_log_error("%s: there are no weights beside it; name some with --weights",
                     params->scene ? params->scene : "no scene");
        return NG_ERROR_NOT_FOUND;
    }
    NG_TRY(lf_neural_create(&neural, &m->neural));
    return lf_neural_join(m->neural, m->composer);
}

static void describe_neural(const struct lf_method *m, char *out, size_t size)
{
    if (!m->neural) {
        snprintf(out, size, "no weights");
        return;
    }
    const char *preset = lf_net_note(lf_neural_net(m->neural), "preset");
    struct lf_neural_counters c = lf_neural_counters_of(m->neural);
    snprintf(out, size, "%s; made so far: %" PRIu64 " RSMs, %" PRIu64 " views, %" PRIu64 " gathers",
             preset ? preset : "a network", c.encoder.rsm, c.encoder.view, c.gather);
}

// ---- reference, live -------------------------------------------------------------------------------------

static ng_result join_reference(struct lf_method *m, const struct lf_method_params *params)
{
    const struct lf_progressive_params progressive = {
        .jobs = params->jobs, .samples = params->samples, .slice = params->slice};
    NG_TRY(lf_progressive_create(&progressive, &m->progressive));
    return lf_progressive_join(m->progressive, m->composer);
}

static void describe_reference(const struct lf_method *m, char *out, size_t size)
{
    struct lf_progressive_stats stats = lf_progressive_stats_of(m->progressive);
    if (!stats.samples)
        snprintf(out, size, "preview"); // all that moving pictures get
    else
        snprintf(out, size, "%" PRIu32 " spp, %.1f s, %.1f million rays", stats.samples, stats.seconds,
                 (double)stats.rays * 1e-6);
}

static struct lf_method_progress progress_of_reference(const struct lf_method *m)
{
    struct lf_progressive_stats stats = lf_progressive_stats_of(m->progressive);
    return (struct lf_method_progress){!stats.resting, stats.samples};
}

// ---- The table -------------------------------------------------------------------------------------------

static const struct row rows[] = {
    {.info = {.name = "raster"}},
    {.info = {.name = LF_NEURAL_METHOD, .indirect = true}, .join = join_neural, .describe = describe_neural},
    {.info = {.name = "reference", .indirect = true, .progressive = true},
     .join = join_reference,
     .describe = describe_reference,
     .progress = progress_of_reference},
};

_Static_assert(NG_COUNT(rows) == LF_METHODS, "callers keep a method of each row");

const struct lf_method_info *lf_method_info(uint32_t index)
{
    return index < LF_METHODS ? &rows[index].info : NULL;
}

const char *lf_method_name(uint32_t index)
{
    return index < LF_METHODS ? rows[index].info.name : NULL;
}

uint32_t lf_method_find(const char *name)
{
    for (uint32_t i = 0; i < LF_METHODS; i++)
        if (strcmp(rows[i].info.name, name) == 0)
            return i;
    return LF_METHOD_NONE;
}

const char *lf_method_default(const char *scene, const char *weights)
{
    char found[4096];
    if (weights || lf_neural_find_weights(scene, found, sizeof found))
        return LF_NEURAL_METHOD;
    if (ng_file_exists(found) && !ng_file_is_below(found, scene))
        ng_log_warn("%s: a link out of the scene's folder is not followed; name it with --weights", found);
    return "raster";
}

// ---- A method in a renderer ------------------------------------------------------------------------------

ng_result lf_method_create(const struct lf_method_params *params, struct lf_method **out)
{
    uint32_t index = lf_method_find(params->name);
    *out = NULL;
    if (index == LF_METHOD_NONE) {
        ng_log_error("there is no method \"%s\"", params->name);
        return NG_ERROR_NOT_FOUND;
    }
    struct lf_method *m = calloc(1, sizeof *m);
    if (!m)
        return ng_out_of_memory("a method");
    *m = (struct lf_method){.row = &rows[index], .composer = params->composer};
    ng_result result = m->row->join ? m->row->join(m, params) : NG_OK;
    if (result != NG_OK)
        lf_method_destroy(&m);
    *out = m;
    return result;
}

void lf_method_destroy(struct lf_method **method)
{
    struct lf_method *m = *method;
    *method = NULL;
    if (!m)
        return;
    if (m->stands_in)
        ng_composer_unregister(m->composer, LF_NEURAL_METHOD);
    lf_neural_destroy(&m->neural);
    lf_progressive_destroy(&m->progressive);
    free(m);
}

struct lf_neural *lf_method_neural(const struct lf_method *m)
{
    return m->neural;
}

struct lf_method_progress lf_method_progress_of(const struct lf_method *m)
{
    return m->row->progress ? m->row->progress(m) : (struct lf_method_progress){0};
}

void lf_method_describe(const struct lf_method *m, char *out, size_t size)
{
    if (size)
        out[0] = 0;
    if (m->row->describe)
        m->row->describe(m, out, size);
}

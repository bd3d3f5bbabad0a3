#include "render_reference.h"
#include "progress.h"

#include "base/interrupt.h"
#include "base/log.h"
#include "base/printable.h"
#include "lightformer/reference/check.h"

#include <stdlib.h>

struct render_reference {
    struct render_reference_params params;
    struct lf_tracer *tracer;
    struct lf_reference *reference;
    struct lf_layer fetched[OUTPUT_MAX_LAYERS]; // of the last picture; their pixels are ours
    struct output_layer layers[OUTPUT_MAX_LAYERS];
    uint32_t fetched_count;
    uint8_t *display;
    bool checked; // a picture of the scene was begun
};

ng_result render_reference_create(const struct render_reference_params *params, struct render_reference **out)
{
    struct render_reference *r = calloc(1, sizeof *r);
    *out = r;
    if (!r)
        return ng_out_of_memory("a reference");
    r->params = *params;
    ng_result result = lf_tracer_create(&r->tracer);
    if (result == NG_OK)
        result = lf_reference_create(&params->reference, &r->reference);
    if (result != NG_OK)
        render_reference_destroy(out);
    return result;
}

static void forget(struct render_reference *r)
{
    for (uint32_t i = 0; i < r->fetched_count; i++)
        free(r->fetched[i].pixels);
    free(r->display);
    r->fetched_count = 0;
    r->display = NULL;
}

void render_reference_destroy(struct render_reference **reference)
{
    struct render_reference *r = *reference;
    *reference = NULL;
    if (!r)
        return;
    forget(r);
    lf_reference_destroy(&r->reference);
    lf_tracer_destroy(&r->tracer);
    free(r);
}

static bool show_progress(void *user, const struct lf_reference_progress *p)
{
    progress_update(user, p->samples);
    return !ng_interrupt_came();
}

// Ends the process if a signal came: what there is is in the checkpoint.
static void obey(const struct render_reference *r, ng_result result)
{
    struct lf_reference_stats stats = lf_reference_stats_of(r->reference);
    if (result == NG_OK && ng_interrupt_came() && !stats.unsaved)
        ng_print_line(stderr, "%s: holds %u of %u samples a pixel; the same command goes on from there",
                      r->params.checkpoint, stats.samples, r->params.samples);
    ng_interrupt_release();
}

// Faults are said of the first picture.
static ng_result check(struct render_reference *r, const struct ng_snapshot *snapshot)
{
    enum lf_check_faults faults = r->params.strict ? LF_CHECK_REFUSE
                                  : r->checked     ? LF_CHECK_PASS
                                                   : LF_CHECK_WARN;
    r->checked = true;
    return lf_check_scene(r->params.world, snapshot, r->params.scene, faults);
}

ng_result render_reference_draw(struct render_reference *r, const struct ng_snapshot *snapshot,
                                uint32_t *samples)
{
    const struct render_reference_params *p = &r->params;
    struct progress progress;
    struct lf_reference_run_params run = {.samples = p->samples,
                                          .time_limit = p->time_limit,
                                          .progress = show_progress,
                                          .user = &progress,
                                          .checkpoint = p->checkpoint,
                                          .picture = p->picture};
    NG_TRY(check(r, snapshot));
    NG_TRY(lf_tracer_update(r->tracer, snapshot));
    NG_TRY(lf_reference_begin(r->reference, r->tracer));
    progress_begin(&progress, "sample", p->samples);
    if (p->checkpoint)
        ng_interrupt_hold();
    ng_result result = lf_reference_run(r->reference, &run);
    progress_end(&progress);
    obey(r, result);
    *samples = lf_reference_stats_of(r->reference).samples;
    return result;
}

bool render_reference_unsaved(const struct render_reference *r)
{
    return r && lf_reference_stats_of(r->reference).unsaved;
}

ng_result render_reference_fetch(struct render_reference *r, const char *const *layers, uint32_t layer_count,
                                 bool display, struct output_picture *out)
{
    forget(r);
    for (uint32_t i = 0; i < layer_count; i++) {
        struct lf_layer *layer = &r->fetched[i];
        NG_TRY(lf_reference_layer(r->reference, layers[i], layer));
        r->fetched_count++;
        r->layers[i] = (struct output_layer){.name = layer->info->name,
                                             .channel_names = layer->info->channels,
                                             .channels = layer->channels,
                                             .uint = layer->info->uint,
                                             .pixels = layer->pixels};
    }
    if (display)
        NG_TRY(lf_reference_display(r->reference, &r->display));
    *out = (struct output_picture){.width = r->params.reference.width,
                                   .height = r->params.reference.height,
                                   .layers = r->layers,
                                   .layer_count = layer_count,
                                   .display = r->display};
    return NG_OK;
}

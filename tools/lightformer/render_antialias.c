#include "render_antialias.h"
#include "progress.h"

#include "base/log.h"

#include <string.h>

void render_middles_finish(struct render_middles *m)
{
    for (uint32_t i = 0; i < OUTPUT_MAX_LAYERS; i++)
        ng_array_finish(&m->pixels[i]);
}

const struct output_layer *render_middles_find(const struct render_middles *m, const char *name)
{
    for (uint32_t i = 0; i < m->count; i++)
        if (strcmp(m->layers[i].name, name) == 0)
            return &m->layers[i];
    return NULL;
}

ng_result render_fetch_layer(struct ng_renderer *renderer, const char *name, struct output_layer *out,
                             uint32_t *width, uint32_t *height)
{
    struct ng_layer layer;
    NG_TRY(ng_renderer_layer(renderer, name, &layer));
    *out = (struct output_layer){.name = layer.info->name,
                                 .channel_names = layer.info->channels,
                                 .channels = layer.channels,
                                 .uint = layer.info->uint,
                                 .pixels = layer.info->uint ? (const void *)layer.ids : layer.pixels};
    *width = layer.width;
    *height = layer.height;
    return NG_OK;
}

static bool is_averaged(const char *layer)
{
    return strcmp(layer, "beauty") == 0 || strcmp(layer, "display") == 0;
}

static ng_result keep(struct render_middles *m, struct ng_renderer *renderer, const char *name)
{
    struct output_layer *layer = &m->layers[m->count];
    uint32_t width, height;
    NG_TRY(render_fetch_layer(renderer, name, layer, &width, &height));
    size_t size = (size_t)width * height * layer->channels * sizeof(float); // as wide as a uint
    if (!ng_array_resize(&m->pixels[m->count], size))
        return ng_out_of_memory("a layer of the picture");
    memcpy(m->pixels[m->count].items, layer->pixels, size);
    layer->pixels = m->pixels[m->count++].items;
    return NG_OK;
}

ng_result render_antialias_draw(struct ng_stage *stage, const struct ng_stage_frame *frame, uint32_t samples,
                                struct render_middles *m)
{
    struct ng_stage_frame next = *frame;
    const char *averaged[2];
    next.averaged = 1;
    NG_TRY(ng_stage_draw(stage, &next)); // through the middles: with motion, and the exposure of all
    m->count = next.layer_count = 0;
    next.layers = averaged;
    for (uint32_t i = 0; i < frame->layer_count; i++) {
        if (is_averaged(frame->layers[i]))
            averaged[next.layer_count++] = frame->layers[i];
        else
            NG_TRY(keep(m, stage->renderer, frame->layers[i]));
    }
    struct progress progress;
    ng_result result = NG_OK;
    progress_begin(&progress, "sample", samples);
    while (next.averaged < samples && result == NG_OK) {
        progress_update(&progress, next.averaged++);
        result = ng_stage_draw(stage, &next);
    }
    progress_end(&progress);
    return result;
}

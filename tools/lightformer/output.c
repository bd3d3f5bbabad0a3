#include "output.h"

#include "asset/exr.h"
#include "asset/png.h"
#include "base/file.h"
#include "render/renderer.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#define MAX_CHANNELS 64
#define TEXT_COUNT   3

static bool is_exr(const char *path)
{
    return strcmp(ng_path_extension(path), "exr") == 0;
}

bool output_knows(const char *path)
{
    return is_exr(path) || strcmp(ng_path_extension(path), "png") == 0;
}

const char *output_base_layer(const char *path)
{
    return is_exr(path) ? "beauty" : "display";
}

bool output_numbered(const char *path, uint32_t frame, char *out, size_t size)
{
    const char *extension = ng_path_extension(path);
    int stem = (int)(strlen(path) - strlen(extension)) - 1;
    int n = snprintf(out, size, "%.*s.%04" PRIu32 ".%s", stem, path, frame, extension);
    return n >= 0 && (size_t)n < size;
}

// The metadata of both formats.
struct texts {
    const char *name[TEXT_COUNT], *value[TEXT_COUNT];
    char hash[17];
};

static void describe(const struct output_origin *origin, struct texts *t)
{
    *t = (struct texts){
        .name = {"command", "program", "scene_hash"},
        .value = {origin->command, "lightformer " NG_VERSION, t->hash},
    };
    snprintf(t->hash, sizeof t->hash, "%016" PRIx64, origin->scene_hash);
}

// The channels of one EXR and the names they borrow.
struct channels {
    struct ng_exr_channel items[MAX_CHANNELS];
    char names[MAX_CHANNELS][48];
    uint32_t count;
};

static void add_layer(struct channels *c, const struct ng_layer *layer)
{
    bool root = strcmp(layer->info->name, "beauty") == 0;
    for (uint32_t i = 0; i < layer->channels && c->count < MAX_CHANNELS; i++) {
        char *name = c->names[c->count];
        snprintf(name, sizeof c->names[0], "%s%s%s", root ? "" : layer->info->name, root ? "" : ".",
                 layer->info->channels[i]);
        c->items[c->count++] = (struct ng_exr_channel){
            .name = name,
            .type = layer->info->uint ? NG_EXR_UINT : NG_EXR_FLOAT,
            .pixels = layer->info->uint ? (const void *)(layer->ids + i) : layer->pixels + i,
            .stride = layer->channels,
        };
    }
}

static ng_result write_exr(const char *path, struct ng_renderer *renderer, const char *const *layers,
                           uint32_t layer_count, const struct texts *t)
{
    struct channels channels = {.count = 0};
    struct ng_layer layer;
    for (uint32_t i = 0; i < layer_count; i++) {
        NG_TRY(ng_renderer_layer(renderer, layers[i], &layer));
        add_layer(&channels, &layer);
    }
    struct ng_exr_text texts[TEXT_COUNT];
    for (uint32_t i = 0; i < TEXT_COUNT; i++)
        texts[i] = (struct ng_exr_text){t->name[i], t->value[i]};
    struct ng_exr_params params = {
        .width = layer.width,
        .height = layer.height,
        .channels = channels.items,
        .channel_count = channels.count,
        .texts = texts,
        .text_count = TEXT_COUNT,
    };
    return ng_exr_write(path, &params);
}

static ng_result write_png(const char *path, struct ng_renderer *renderer, const struct texts *t)
{
    struct ng_png_text texts[TEXT_COUNT];
    for (uint32_t i = 0; i < TEXT_COUNT; i++)
        texts[i] = (struct ng_png_text){t->name[i], t->value[i]};
    struct ng_png_params params = {.texts = texts, .text_count = TEXT_COUNT};
    const uint8_t *pixels;
    NG_TRY(ng_renderer_display(renderer, &pixels, &params.width, &params.height));
    params.pixels = pixels;
    return ng_png_write(path, &params);
}

ng_result output_write(const char *path, struct ng_renderer *renderer, const char *const *layers,
                       uint32_t layer_count, const struct output_origin *origin)
{
    struct texts t;
    describe(origin, &t);
    return is_exr(path) ? write_exr(path, renderer, layers, layer_count, &t) : write_png(path, renderer, &t);
}

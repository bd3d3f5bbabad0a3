#include "output.h"

#include "asset/exr.h"
#include "asset/png.h"
#include "base/file.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#define MAX_CHANNELS (OUTPUT_MAX_LAYERS * 4)
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

static void add_layer(struct channels *c, const struct output_layer *layer)
{
    bool root = strcmp(layer->name, "beauty") == 0;
    for (uint32_t i = 0; i < layer->channels && c->count < MAX_CHANNELS; i++) {
        char *name = c->names[c->count];
        snprintf(name, sizeof c->names[0], "%s%s%s", root ? "" : layer->name, root ? "" : ".",
                 layer->channel_names[i]);
        c->items[c->count++] = (struct ng_exr_channel){
            .name = name,
            .type = layer->uint ? NG_EXR_UINT : NG_EXR_FLOAT,
            .pixels = (const uint32_t *)layer->pixels + i,
            .stride = layer->channels,
        };
    }
}

static ng_result write_exr(const char *path, const struct output_picture *picture, const struct texts *t)
{
    struct channels channels = {.count = 0};
    for (uint32_t i = 0; i < picture->layer_count; i++)
        add_layer(&channels, &picture->layers[i]);
    struct ng_exr_text texts[TEXT_COUNT];
    for (uint32_t i = 0; i < TEXT_COUNT; i++)
        texts[i] = (struct ng_exr_text){t->name[i], t->value[i]};
    struct ng_exr_params params = {
        .width = picture->width,
        .height = picture->height,
        .channels = channels.items,
        .channel_count = channels.count,
        .texts = texts,
        .text_count = TEXT_COUNT,
    };
    return ng_exr_write(path, &params);
}

static struct ng_png_params png_params(const struct output_picture *picture, const struct texts *t,
                                       struct ng_png_text texts[TEXT_COUNT])
{
    for (uint32_t i = 0; i < TEXT_COUNT; i++)
        texts[i] = (struct ng_png_text){t->name[i], t->value[i]};
    return (struct ng_png_params){.width = picture->width,
                                  .height = picture->height,
                                  .pixels = picture->display,
                                  .texts = texts,
                                  .text_count = TEXT_COUNT};
}

static ng_result write_png(const char *path, const struct output_picture *picture, const struct texts *t)
{
    struct ng_png_text texts[TEXT_COUNT];
    const struct ng_png_params params = png_params(picture, t, texts);
    return ng_png_write(path, &params);
}

ng_result output_encode_png(const struct output_picture *picture, const struct output_origin *origin,
                            void **data, size_t *size)
{
    struct texts t;
    struct ng_png_text texts[TEXT_COUNT];
    describe(origin, &t);
    const struct ng_png_params params = png_params(picture, &t, texts);
    return ng_png_encode("the picture", &params, data, size);
}

ng_result output_write(const char *path, const struct output_picture *picture,
                       const struct output_origin *origin)
{
    struct texts t;
    describe(origin, &t);
    return is_exr(path) ? write_exr(path, picture, &t) : write_png(path, picture, &t);
}

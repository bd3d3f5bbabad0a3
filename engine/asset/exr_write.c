// OpenEXRCore encodes into memory; base/file.h then makes the file whole or not at all.
#include "asset/exr.h"
#include "base/array.h"
#include "base/file.h"
#include "base/log.h"

#include <openexr.h>

#include <stdlib.h>
#include <string.h>

#define MAX_HALF 65504.0f

struct writer {
    const char *path;
    const struct ng_exr_params *params;
    exr_context_t context;
    NG_ARRAY(unsigned char) bytes;
    uint32_t *lines; // one chunk: [channel_count][lines][width]
    bool reported;
};

static void on_error(exr_const_context_t context, exr_result_t code, const char *text)
{
    void *user = NULL;
    NG_UNUSED(code);
    if (exr_get_user_data(context, &user) != EXR_ERR_SUCCESS || !user)
        return;
    struct writer *w = user;
    if (!w->reported)
        ng_log_error("%s: OpenEXR: %s", w->path, text);
    w->reported = true;
}

static int64_t write_bytes(exr_const_context_t context, void *user, const void *buffer, uint64_t size,
                           uint64_t offset, exr_stream_error_func_ptr_t error)
{
    struct writer *w = user;
    size_t end = (size_t)(offset + size);
    NG_UNUSED(context);
    NG_UNUSED(error);
    if (end > w->bytes.count && !ng_array_resize(&w->bytes, end))
        return -1;
    memcpy(w->bytes.items + offset, buffer, (size_t)size);
    return (int64_t)size;
}

static bool write_header(struct writer *w)
{
    const struct ng_exr_params *p = w->params;
    int part;
    bool ok = exr_add_part(w->context, "", EXR_STORAGE_SCANLINE, &part) == EXR_ERR_SUCCESS &&
              exr_initialize_required_attr_simple(w->context, part, (int32_t)p->width, (int32_t)p->height,
                                                  EXR_COMPRESSION_ZIP) == EXR_ERR_SUCCESS;
    for (uint32_t i = 0; ok && i < p->channel_count; i++)
        ok = exr_add_channel(w->context, part, p->channels[i].name, (exr_pixel_type_t)p->channels[i].type,
                             EXR_PERCEPTUALLY_LINEAR, 1, 1) == EXR_ERR_SUCCESS;
    for (uint32_t i = 0; ok && i < p->text_count; i++)
        ok = exr_attr_set_string(w->context, part, p->texts[i].name, p->texts[i].value) == EXR_ERR_SUCCESS;
    return ok && exr_write_header(w->context) == EXR_ERR_SUCCESS;
}

static const struct ng_exr_channel *find_channel(const struct ng_exr_params *p, const char *name)
{
    uint32_t i = 0;
    while (strcmp(p->channels[i].name, name) != 0)
        i++;
    return &p->channels[i];
}

// Lines of a channel, planar; what a half cannot hold becomes the largest that it can.
static void copy_lines(const struct ng_exr_params *p, const struct ng_exr_channel *c, size_t y, size_t count,
                       uint32_t *out)
{
    size_t stride = c->stride ? c->stride : 1, pixels = count * p->width;
    const uint32_t *in = (const uint32_t *)c->pixels + y * p->width * stride;
    for (size_t i = 0; i < pixels; i++) {
        out[i] = in[i * stride];
        if (c->type != NG_EXR_HALF)
            continue;
        float v;
        memcpy(&v, &out[i], sizeof v);
        v = v > MAX_HALF ? MAX_HALF : v < -MAX_HALF ? -MAX_HALF : v;
        memcpy(&out[i], &v, sizeof v);
    }
}

static bool encode_chunk(struct writer *w, exr_encode_pipeline_t *pipeline, const exr_chunk_info_t *chunk)
{
    const struct ng_exr_params *p = w->params;
    bool first = pipeline->channels == NULL;
    exr_result_t result = first ? exr_encoding_initialize(w->context, 0, chunk, pipeline)
                                : exr_encoding_update(w->context, 0, chunk, pipeline);
    if (result != EXR_ERR_SUCCESS)
        return false;
    for (int i = 0; i < pipeline->channel_count; i++) {
        exr_coding_channel_info_t *channel = &pipeline->channels[i];
        const struct ng_exr_channel *c = find_channel(p, channel->channel_name);
        uint32_t *lines = w->lines + (size_t)i * (size_t)chunk->height * p->width;
        copy_lines(p, c, (size_t)chunk->start_y, (size_t)chunk->height, lines);
        channel->user_data_type = c->type == NG_EXR_UINT ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
        channel->user_bytes_per_element = 4;
        channel->user_pixel_stride = 4;
        channel->user_line_stride = (int32_t)(p->width * 4);
        channel->encode_from_ptr = (const uint8_t *)lines;
    }
    if (first)
        result = exr_encoding_choose_default_routines(w->context, 0, pipeline);
    return result == EXR_ERR_SUCCESS && exr_encoding_run(w->context, 0, pipeline) == EXR_ERR_SUCCESS;
}

static bool write_pixels(struct writer *w)
{
    const struct ng_exr_params *p = w->params;
    int32_t step;
    if (exr_get_scanlines_per_chunk(w->context, 0, &step) != EXR_ERR_SUCCESS)
        return false;
    w->lines = calloc((size_t)p->channel_count * (size_t)step, (size_t)p->width * 4);
    exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
    bool ok = w->lines != NULL;
    for (int64_t y = 0; ok && y < p->height; y += step) {
        exr_chunk_info_t chunk;
        ok = exr_write_scanline_chunk_info(w->context, 0, (int)y, &chunk) == EXR_ERR_SUCCESS &&
             encode_chunk(w, &pipeline, &chunk);
    }
    exr_encoding_destroy(w->context, &pipeline);
    free(w->lines);
    return ok;
}

static ng_result check(const struct ng_exr_params *p)
{
    NG_REQUIRE(p->width && p->height && p->width < 1u << 24 && p->height < 1u << 24,
               "a picture of %u x %u pixels cannot be written", p->width, p->height);
    NG_REQUIRE(p->channel_count > 0 && p->channel_count < 1024, "a picture has 1 to 1023 channels, not %u",
               p->channel_count);
    for (uint32_t i = 0; i < p->channel_count; i++) {
        NG_REQUIRE(p->channels[i].pixels && p->channels[i].name[0], "channel %u needs a name and pixels", i);
        for (uint32_t k = 0; k < i; k++)
            NG_REQUIRE(strcmp(p->channels[i].name, p->channels[k].name) != 0, "channel %s is there twice",
                       p->channels[i].name);
    }
    return NG_OK;
}

ng_result ng_exr_write(const char *path, const struct ng_exr_params *params)
{
    NG_TRY(check(params));
    struct writer w = {.path = path, .params = params};
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = on_error;
    init.user_data = &w;
    init.write_fn = write_bytes;
    bool ok = exr_start_write(&w.context, path, EXR_WRITE_FILE_DIRECTLY, &init) == EXR_ERR_SUCCESS &&
              write_header(&w) && write_pixels(&w);
    // The table of chunks is written when the context ends.
    ok = exr_finish(&w.context) == EXR_ERR_SUCCESS && ok;
    ng_result result = NG_ERROR_MEMORY;
    if (ok)
        result = ng_file_write(path, w.bytes.items, w.bytes.count);
    else if (!w.reported)
        ng_log_error("%s: out of memory while encoding", path);
    ng_array_finish(&w.bytes);
    return result;
}

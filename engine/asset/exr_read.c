// OpenEXRCore decodes chunk by chunk, straight into one plane a channel. What its version 3.1 cannot do, and
// sizes over the limits, are refused from the header.
#define _POSIX_C_SOURCE 200809L // strdup
#include "asset/exr.h"
#include "asset/image_internal.h"
#include "base/file.h"
#include "base/log.h"

#include <openexr.h>

#include <stdlib.h>
#include <string.h>

struct reader {
    const char *name;
    const unsigned char *data;
    size_t size;
    bool reported; // OpenEXRCore may complain more than once about one fault
    exr_context_t context;
    struct ng_exr *out;
    exr_attr_box2i_t window;
};

static ng_result damaged(struct reader *r, const char *what)
{
    if (!r->reported)
        ng_log_error("%s: OpenEXR: %s", r->name, what);
    r->reported = true;
    return NG_ERROR_FORMAT;
}

static void on_error(exr_const_context_t context, exr_result_t code, const char *text)
{
    void *user = NULL;
    NG_UNUSED(code);
    if (exr_get_user_data(context, &user) == EXR_ERR_SUCCESS && user)
        damaged(user, text);
}

static int64_t read_bytes(exr_const_context_t context, void *user, void *buffer, uint64_t size,
                          uint64_t offset, exr_stream_error_func_ptr_t error)
{
    struct reader *r = user;
    NG_UNUSED(context);
    NG_UNUSED(error);
    if (offset > r->size)
        return -1;
    uint64_t left = r->size - offset;
    size = size < left ? size : left;
    memcpy(buffer, r->data + offset, size);
    return (int64_t)size;
}

static int64_t query_size(exr_const_context_t context, void *user)
{
    NG_UNUSED(context);
    return (int64_t)((struct reader *)user)->size;
}

static const char *compression_name(exr_compression_t c)
{
    static const char *const names[] = {"none",  "RLE", "ZIPS", "ZIP",  "PIZ",
                                        "PXR24", "B44", "B44A", "DWAA", "DWAB"};
    return (size_t)c < NG_COUNT(names) ? names[c] : "unknown";
}

static ng_result check_header(struct reader *r, const struct ng_exr_limits *limits)
{
    exr_storage_t storage;
    exr_compression_t compression;
    if (exr_get_storage(r->context, 0, &storage) != EXR_ERR_SUCCESS ||
        exr_get_compression(r->context, 0, &compression) != EXR_ERR_SUCCESS ||
        exr_get_data_window(r->context, 0, &r->window) != EXR_ERR_SUCCESS)
        return damaged(r, "the header lacks a required attribute");
    if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED) {
        ng_log_error("%s: deep OpenEXR data is not supported", r->name);
        return NG_ERROR_UNSUPPORTED;
    }
    if (compression > EXR_COMPRESSION_B44A) {
        ng_log_error("%s: OpenEXR compression %s is not supported; save it with ZIP", r->name,
                     compression_name(compression));
        return NG_ERROR_UNSUPPORTED;
    }
    int64_t width = (int64_t)r->window.max.x - r->window.min.x + 1;
    int64_t height = (int64_t)r->window.max.y - r->window.min.y + 1;
    int64_t max_side = limits && limits->max_side ? limits->max_side : NG_IMAGE_MAX_SIDE;
    if (width < 1 || height < 1)
        return damaged(r, "the data window is empty");
    if (width > max_side || height > max_side) {
        ng_log_error("%s: %lld x %lld pixels, more than the limit of %lld a side", r->name, (long long)width,
                     (long long)height, (long long)max_side);
        return NG_ERROR_MEMORY;
    }
    r->out->width = (uint32_t)width;
    r->out->height = (uint32_t)height;
    return NG_OK;
}

static ng_result out_of_memory(const struct reader *r)
{
    ng_log_error("%s: out of memory", r->name);
    return NG_ERROR_MEMORY;
}

static ng_result make_planes(struct reader *r, const struct ng_exr_limits *limits)
{
    const exr_attr_chlist_t *channels;
    if (exr_get_channels(r->context, 0, &channels) != EXR_ERR_SUCCESS || channels->num_channels < 1)
        return damaged(r, "the header has no channels");
    struct ng_exr *out = r->out;
    uint64_t max_memory = limits && limits->max_memory ? limits->max_memory : NG_IMAGE_MAX_MEMORY;
    uint64_t plane = (uint64_t)out->width * out->height * 4;
    if (plane > max_memory / (uint64_t)channels->num_channels) {
        ng_log_error("%s: %d channels of %u x %u pixels need more than the limit of %llu bytes", r->name,
                     channels->num_channels, out->width, out->height, (unsigned long long)max_memory);
        return NG_ERROR_MEMORY;
    }
    out->planes = calloc((size_t)channels->num_channels, sizeof *out->planes);
    if (!out->planes)
        return out_of_memory(r);
    for (int i = 0; i < channels->num_channels; i++) {
        const exr_attr_chlist_entry_t *c = &channels->entries[i];
        if (c->x_sampling != 1 || c->y_sampling != 1) {
            ng_log_error("%s: channel %.100s is subsampled, which is not supported", r->name, c->name.str);
            return NG_ERROR_UNSUPPORTED;
        }
        struct ng_exr_plane *p = &out->planes[out->plane_count++];
        p->type = (enum ng_exr_type)c->pixel_type;
        p->name = strdup(c->name.str);
        p->pixels = calloc(1, (size_t)plane);
        if (!p->name || !p->pixels)
            return out_of_memory(r);
    }
    return NG_OK;
}

static ng_result copy_texts(struct reader *r)
{
    int32_t count = 0;
    struct ng_exr *out = r->out;
    if (exr_get_attribute_count(r->context, 0, &count) != EXR_ERR_SUCCESS || count < 0)
        return damaged(r, "the header has no attributes");
    out->texts = calloc((size_t)count + 1, sizeof *out->texts);
    if (!out->texts)
        return out_of_memory(r);
    for (int32_t i = 0; i < count; i++) {
        const exr_attribute_t *a;
        if (exr_get_attribute_by_index(r->context, 0, EXR_ATTR_LIST_FILE_ORDER, i, &a) != EXR_ERR_SUCCESS ||
            a->type != EXR_ATTR_STRING || !a->string->str)
            continue;
        struct ng_exr_text *t = &out->texts[out->text_count++];
        t->name = strdup(a->name);
        t->value = strdup(a->string->str);
        if (!t->name || !t->value)
            return out_of_memory(r);
    }
    return NG_OK;
}

// Runs the pipeline for one chunk whose first pixel is at (x, y) of the window.
static ng_result decode_chunk(struct reader *r, exr_decode_pipeline_t *pipeline,
                              const exr_chunk_info_t *chunk, int64_t x, int64_t y)
{
    const struct ng_exr *out = r->out;
    bool first = pipeline->channels == NULL;
    if (x < 0 || y < 0 || x + chunk->width > out->width || y + chunk->height > out->height)
        return damaged(r, "a chunk lies outside the data window");
    exr_result_t result = first ? exr_decoding_initialize(r->context, 0, chunk, pipeline)
                                : exr_decoding_update(r->context, 0, chunk, pipeline);
    if (result != EXR_ERR_SUCCESS)
        return damaged(r, exr_get_error_code_as_string(result));
    for (int c = 0; c < pipeline->channel_count; c++) {
        exr_coding_channel_info_t *channel = &pipeline->channels[c];
        const struct ng_exr_plane *p = ng_exr_plane(out, channel->channel_name);
        channel->user_data_type = p->type == NG_EXR_UINT ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
        channel->user_bytes_per_element = 4;
        channel->user_pixel_stride = 4;
        channel->user_line_stride = (int32_t)(out->width * 4);
        channel->decode_to_ptr = (uint8_t *)p->pixels + ((size_t)y * out->width + (size_t)x) * 4;
    }
    if (first)
        result = exr_decoding_choose_default_routines(r->context, 0, pipeline);
    if (result == EXR_ERR_SUCCESS)
        result = exr_decoding_run(r->context, 0, pipeline);
    return result == EXR_ERR_SUCCESS ? NG_OK : damaged(r, exr_get_error_code_as_string(result));
}

static ng_result decode_scan_lines(struct reader *r, exr_decode_pipeline_t *pipeline)
{
    int32_t step;
    if (exr_get_scanlines_per_chunk(r->context, 0, &step) != EXR_ERR_SUCCESS || step < 1)
        return damaged(r, "the compression is unknown");
    for (int64_t y = 0; y < r->out->height; y += step) {
        exr_chunk_info_t chunk;
        if (exr_read_scanline_chunk_info(r->context, 0, (int)(y + r->window.min.y), &chunk) !=
            EXR_ERR_SUCCESS)
            return damaged(r, "scan lines are missing");
        NG_TRY(decode_chunk(r, pipeline, &chunk, 0, (int64_t)chunk.start_y - r->window.min.y));
    }
    return NG_OK;
}

static ng_result decode_tiles(struct reader *r, exr_decode_pipeline_t *pipeline)
{
    int32_t width, height;
    if (exr_get_tile_sizes(r->context, 0, 0, 0, &width, &height) != EXR_ERR_SUCCESS || width < 1 ||
        height < 1)
        return damaged(r, "the tile description is missing");
    for (int64_t y = 0; y < r->out->height; y += height)
        for (int64_t x = 0; x < r->out->width; x += width) {
            exr_chunk_info_t chunk;
            exr_result_t result =
                exr_read_tile_chunk_info(r->context, 0, (int)(x / width), (int)(y / height), 0, 0, &chunk);
            if (result != EXR_ERR_SUCCESS)
                return damaged(r, "tiles are missing");
            NG_TRY(decode_chunk(r, pipeline, &chunk, x, y));
        }
    return NG_OK;
}

static ng_result decode(struct reader *r, const struct ng_exr_limits *limits)
{
    exr_storage_t storage;
    NG_TRY(check_header(r, limits));
    NG_TRY(make_planes(r, limits));
    NG_TRY(copy_texts(r));
    exr_decode_pipeline_t pipeline = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_get_storage(r->context, 0, &storage);
    ng_result result =
        storage == EXR_STORAGE_TILED ? decode_tiles(r, &pipeline) : decode_scan_lines(r, &pipeline);
    exr_decoding_destroy(r->context, &pipeline);
    return result;
}

ng_result ng_exr_decode(const char *name, const void *data, size_t size, const struct ng_exr_limits *limits,
                        struct ng_exr *out)
{
    *out = (struct ng_exr){0};
    struct reader r = {.name = name, .data = data, .size = size, .out = out};
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = on_error;
    init.user_data = &r;
    init.read_fn = read_bytes;
    init.size_fn = query_size;
    init.flags = EXR_CONTEXT_FLAG_SILENT_HEADER_PARSE | EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    ng_result result;
    if (exr_start_read(&r.context, name, &init) == EXR_ERR_SUCCESS)
        result = decode(&r, limits);
    else
        result = damaged(&r, "the header is malformed");
    exr_finish(&r.context);
    if (result != NG_OK)
        ng_exr_finish(out);
    return result;
}

ng_result ng_exr_read(const char *path, const struct ng_exr_limits *limits, struct ng_exr *out)
{
    void *data;
    size_t size;
    *out = (struct ng_exr){0};
    NG_TRY(ng_file_read(path, 0, &data, &size));
    ng_result r = ng_exr_decode(path, data, size, limits, out);
    free(data);
    return r;
}

void ng_exr_finish(struct ng_exr *exr)
{
    for (uint32_t i = 0; i < exr->plane_count; i++) {
        free(exr->planes[i].name);
        free(exr->planes[i].pixels);
    }
    for (uint32_t i = 0; i < exr->text_count; i++) {
        free((char *)exr->texts[i].name);
        free((char *)exr->texts[i].value);
    }
    free(exr->planes);
    free(exr->texts);
    *exr = (struct ng_exr){0};
}

const struct ng_exr_plane *ng_exr_plane(const struct ng_exr *exr, const char *name)
{
    for (uint32_t i = 0; i < exr->plane_count; i++)
        if (strcmp(exr->planes[i].name, name) == 0)
            return &exr->planes[i];
    return NULL;
}

const char *ng_exr_text(const struct ng_exr *exr, const char *name)
{
    for (uint32_t i = 0; i < exr->text_count; i++)
        if (strcmp(exr->texts[i].name, name) == 0)
            return exr->texts[i].value;
    return NULL;
}

// OpenEXRCore decodes chunk by chunk, straight into one plane a channel; what its version 3.1 cannot do, and
// sizes over the limits, are refused from the header. It encodes into memory, and base/file.h then makes the
// file whole or not at all.
#define _POSIX_C_SOURCE 200809L // strdup
#include "asset/exr.h"
#include "asset/image_internal.h"
#include "base/array.h"
#include "base/file.h"
#include "base/log.h"

#include <openexr.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- reading ----------------------------------------------------------------------------------------------

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

static void on_read_error(exr_const_context_t context, exr_result_t code, const char *text)
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

// Where the picture is, and in what colours.
static void read_look(struct reader *r)
{
    exr_attr_box2i_t display;
    exr_attr_chromaticities_t c;
    struct ng_exr *out = r->out;
    out->display_width = out->width;
    out->display_height = out->height;
    if (exr_get_display_window(r->context, 0, &display) == EXR_ERR_SUCCESS &&
        display.max.x >= display.min.x && display.max.y >= display.min.y) {
        out->display_x = (int64_t)display.min.x - r->window.min.x;
        out->display_y = (int64_t)display.min.y - r->window.min.y;
        out->display_width = (int64_t)display.max.x - display.min.x + 1;
        out->display_height = (int64_t)display.max.y - display.min.y + 1;
    }
    if (exr_attr_get_chromaticities(r->context, 0, "chromaticities", &c) != EXR_ERR_SUCCESS)
        return;
    const float all[8] = {c.red_x, c.red_y, c.green_x, c.green_y, c.blue_x, c.blue_y, c.white_x, c.white_y};
    memcpy(out->chromaticities, all, sizeof all);
    out->has_chromaticities = true;
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
        char allowed[64];
        snprintf(allowed, sizeof allowed, "the %llu bytes that are allowed", (unsigned long long)max_memory);
        ng_log_error("%s: %d channels of %u x %u pixels need more than %s", r->name, channels->num_channels,
                     out->width, out->height, limits && limits->limit ? limits->limit : allowed);
        return NG_ERROR_MEMORY;
    }
    out->planes = calloc((size_t)channels->num_channels, sizeof *out->planes);
    if (!out->planes)
        return ng_out_of_memory(r->name);
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
            return ng_out_of_memory(r->name);
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
        return ng_out_of_memory(r->name);
    for (int32_t i = 0; i < count; i++) {
        const exr_attribute_t *a;
        if (exr_get_attribute_by_index(r->context, 0, EXR_ATTR_LIST_FILE_ORDER, i, &a) != EXR_ERR_SUCCESS ||
            a->type != EXR_ATTR_STRING || !a->string->str)
            continue;
        struct ng_exr_text *t = &out->texts[out->text_count++];
        t->name = strdup(a->name);
        t->value = strdup(a->string->str);
        if (!t->name || !t->value)
            return ng_out_of_memory(r->name);
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
    read_look(r);
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
    init.error_handler_fn = on_read_error;
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

// ---- writing ----------------------------------------------------------------------------------------------

#define MAX_HALF 65504.0f

struct writer {
    const char *path;
    const struct ng_exr_params *params;
    exr_context_t context;
    NG_ARRAY(unsigned char) bytes;
    uint32_t *lines; // one chunk: [channel_count][lines][width]
    bool reported;
    exr_result_t (*compress)(exr_encode_pipeline_t *pipeline); // OpenEXR's
};

static void on_write_error(exr_const_context_t context, exr_result_t code, const char *text)
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

// What is as long compressed as it is uncompressed is taken for uncompressed by whoever reads it, and OpenEXR
// up to 3.4.7 writes it compressed (its issue 2306).
static exr_result_t compress(exr_encode_pipeline_t *pipeline)
{
    const struct writer *w = pipeline->encoding_user_data;
    exr_result_t result = w->compress(pipeline);
    if (result == EXR_ERR_SUCCESS && pipeline->compressed_bytes == pipeline->packed_bytes)
        memcpy(pipeline->compressed_buffer, pipeline->packed_buffer, pipeline->packed_bytes);
    return result;
}

static exr_result_t choose_routines(struct writer *w, exr_encode_pipeline_t *pipeline)
{
    exr_result_t result = exr_encoding_choose_default_routines(w->context, 0, pipeline);
    w->compress = pipeline->compress_fn;
    pipeline->compress_fn = w->compress ? compress : NULL;
    pipeline->encoding_user_data = w;
    return result;
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
        result = choose_routines(w, pipeline);
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

static ng_result check_params(const struct ng_exr_params *p)
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

ng_result ng_exr_encode(const char *name, const struct ng_exr_params *params, void **data, size_t *size)
{
    *data = NULL;
    NG_TRY(check_params(params));
    struct writer w = {.path = name, .params = params};
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = on_write_error;
    init.user_data = &w;
    init.write_fn = write_bytes;
    bool ok = exr_start_write(&w.context, name, EXR_WRITE_FILE_DIRECTLY, &init) == EXR_ERR_SUCCESS &&
              write_header(&w) && write_pixels(&w);
    // The table of chunks is written when the context ends.
    ok = exr_finish(&w.context) == EXR_ERR_SUCCESS && ok;
    if (!ok) {
        if (!w.reported)
            ng_log_error("%s: out of memory while encoding", name);
        ng_array_finish(&w.bytes);
        return NG_ERROR_MEMORY;
    }
    *data = w.bytes.items;
    *size = w.bytes.count;
    return NG_OK;
}

ng_result ng_exr_write(const char *path, const struct ng_exr_params *params)
{
    void *data;
    size_t size;
    NG_TRY(ng_exr_encode(path, params, &data, &size));
    ng_result result = ng_file_write(path, data, size);
    free(data);
    return result;
}

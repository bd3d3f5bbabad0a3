// libjpeg-turbo with its two ways out replaced: an error, or a warning (damaged data), ends the decoding. A
// progressive file may hold any number of scans of a few bytes each, so their number is bounded.
#include "asset/jpeg.h"
#include "asset/image_internal.h"
#include "base/log.h"

#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>

#include <jpeglib.h>

#define MAX_SCANS 256

struct decoder {
    struct jpeg_decompress_struct jpeg;
    struct jpeg_error_mgr errors;
    struct jpeg_progress_mgr progress;
    jmp_buf escape;
    const char *name;
    struct ng_image image;
    ng_result result;
};

static void fail(j_common_ptr common)
{
    struct decoder *d = common->client_data;
    char text[JMSG_LENGTH_MAX];
    common->err->format_message(common, text);
    ng_log_error("%s: damaged JPEG: %s", d->name, text);
    d->result = NG_ERROR_FORMAT;
    longjmp(d->escape, 1);
}

static void on_message(j_common_ptr common, int level)
{
    if (level < 0)
        fail(common);
}

static void on_progress(j_common_ptr common)
{
    struct decoder *d = common->client_data;
    if (d->jpeg.input_scan_number <= MAX_SCANS)
        return;
    ng_log_error("%s: JPEG of more than %d scans", d->name, MAX_SCANS);
    d->result = NG_ERROR_FORMAT;
    longjmp(d->escape, 1);
}

static ng_result decode(struct decoder *d, const void *data, size_t size,
                        const struct ng_image_params *params)
{
    if (setjmp(d->escape))
        return d->result;
    jpeg_create_decompress(&d->jpeg);
    d->jpeg.client_data = d;
    d->jpeg.progress = &d->progress;
    jpeg_mem_src(&d->jpeg, data, size);
    jpeg_read_header(&d->jpeg, TRUE);
    if (d->jpeg.jpeg_color_space == JCS_CMYK || d->jpeg.jpeg_color_space == JCS_YCCK) {
        ng_log_error("%s: CMYK JPEG is not supported; convert it to RGB", d->name);
        return NG_ERROR_UNSUPPORTED;
    }
    d->jpeg.out_color_space = JCS_EXT_RGBA;
    enum ng_pixel_format format = params->srgb ? NG_PIXEL_RGBA8_SRGB : NG_PIXEL_RGBA8;
    NG_TRY(ng_image_allocate(d->name, d->jpeg.image_width, d->jpeg.image_height, format, params, &d->image));
    jpeg_start_decompress(&d->jpeg);
    while (d->jpeg.output_scanline < d->jpeg.output_height) {
        JSAMPROW row = (JSAMPROW)d->image.pixels + (size_t)d->jpeg.output_scanline * d->image.width * 4;
        jpeg_read_scanlines(&d->jpeg, &row, 1);
    }
    jpeg_finish_decompress(&d->jpeg);
    return NG_OK;
}

ng_result ng_jpeg_decode(const char *name, const void *data, size_t size,
                         const struct ng_image_params *params, struct ng_image *out)
{
    *out = (struct ng_image){0};
    struct decoder *d = calloc(1, sizeof *d);
    if (!d)
        return ng_out_of_memory(name);
    d->name = name;
    d->jpeg.err = jpeg_std_error(&d->errors);
    d->errors.error_exit = fail;
    d->errors.emit_message = on_message;
    d->progress.progress_monitor = on_progress;
    d->jpeg.client_data = d;
    ng_result r = decode(d, data, size, params);
    jpeg_destroy_decompress(&d->jpeg);
    if (r == NG_OK)
        *out = d->image;
    else
        ng_image_finish(&d->image);
    free(d);
    return r;
}

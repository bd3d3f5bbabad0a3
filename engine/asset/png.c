// libpng, reading from and writing to memory; files go through base/file.h, which makes them whole or not at
// all.
#include "asset/png.h"
#include "asset/image_internal.h"
#include "base/array.h"
#include "base/file.h"
#include "base/log.h"

#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

static void on_error(png_structp png, png_const_charp text)
{
    ng_log_error("%s: PNG: %s", (const char *)png_get_error_ptr(png), text);
    longjmp(png_jmpbuf(png), 1);
}

// What libpng warns about (a strange profile, an unknown chunk) does not touch the pixels.
static void on_warning(png_structp png, png_const_charp text)
{
    NG_UNUSED(png);
    NG_UNUSED(text);
}

// ---- reading ---------------------------------------------------------------------------------------------

struct reader {
    png_structp png;
    png_infop info;
    const unsigned char *data;
    size_t left;
    struct ng_image image;
    png_bytep *rows;
};

static void read_bytes(png_structp png, png_bytep out, size_t size)
{
    struct reader *r = png_get_io_ptr(png);
    if (size > r->left)
        png_error(png, "the data ends too early");
    memcpy(out, r->data, size);
    r->data += size;
    r->left -= size;
}

static bool reader_init(struct reader *r, const char *name, const void *data, size_t size)
{
    *r = (struct reader){.data = data, .left = size};
    r->png = png_create_read_struct(PNG_LIBPNG_VER_STRING, (void *)name, on_error, on_warning);
    r->info = r->png ? png_create_info_struct(r->png) : NULL;
    if (!r->info) {
        png_destroy_read_struct(&r->png, NULL, NULL);
        ng_out_of_memory(name);
        return false;
    }
    png_set_read_fn(r->png, r, read_bytes);
    png_set_user_limits(r->png, PNG_UINT_31_MAX, PNG_UINT_31_MAX); // ng_image_allocate has the limits
    png_set_chunk_malloc_max(r->png, 8u << 20);                    // a small chunk may unpack to this,
    png_set_chunk_cache_max(r->png, 16);                           // and so many are kept
    return true;
}

static void reader_finish(struct reader *r)
{
    png_destroy_read_struct(&r->png, &r->info, NULL);
    free(r->rows);
}

// Whether each chunk ends within the file: libpng allocates what a chunk claims to hold before it is read.
static bool chunks_fit(const unsigned char *data, size_t size)
{
    for (size_t at = 8; at + 12 <= size;) {
        uint32_t length = png_get_uint_32(data + at);
        if (length > size - at - 12)
            return false;
        if (memcmp(data + at + 4, "IEND", 4) == 0)
            break;
        at += 12 + (size_t)length;
    }
    return true;
}

// Whatever is in the file, rows of RGBA8 come out.
static void set_conversions(png_structp png, png_infop info)
{
    png_set_scale_16(png);
    png_set_expand(png);
    png_set_gray_to_rgb(png);
    png_set_add_alpha(png, 0xff, PNG_FILLER_AFTER);
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
}

static ng_result read_image(struct reader *r, const char *name, const struct ng_image_params *params)
{
    if (setjmp(png_jmpbuf(r->png)))
        return NG_ERROR_FORMAT;
    if (r->left < 24 || !chunks_fit(r->data, r->left))
        png_error(r->png, "the data ends too early");
    // The size stands in a fixed place: it is checked before libpng sees anything.
    uint32_t width = png_get_uint_32(r->data + 16), height = png_get_uint_32(r->data + 20);
    enum ng_pixel_format format = params->srgb ? NG_PIXEL_RGBA8_SRGB : NG_PIXEL_RGBA8;
    NG_TRY(ng_image_allocate(name, width, height, format, params, &r->image));
    png_read_info(r->png, r->info);
    set_conversions(r->png, r->info);
    if (png_get_rowbytes(r->png, r->info) != (size_t)width * 4 ||
        png_get_image_height(r->png, r->info) != height)
        png_error(r->png, "IHDR is not the first chunk");
    r->rows = malloc(height * sizeof *r->rows);
    if (!r->rows)
        png_error(r->png, "out of memory");
    for (uint32_t y = 0; y < height; y++)
        r->rows[y] = (png_bytep)r->image.pixels + (size_t)y * width * 4;
    png_read_image(r->png, r->rows);
    png_read_end(r->png, NULL);
    return NG_OK;
}

ng_result ng_png_decode(const char *name, const void *data, size_t size, const struct ng_image_params *params,
                        struct ng_image *out)
{
    *out = (struct ng_image){0};
    struct reader r;
    if (!reader_init(&r, name, data, size))
        return NG_ERROR_MEMORY;
    ng_result result = read_image(&r, name, params);
    if (result == NG_OK)
        *out = r.image;
    else
        ng_image_finish(&r.image);
    reader_finish(&r);
    return result;
}

static char *find_text(struct reader *r, const char *key)
{
    if (setjmp(png_jmpbuf(r->png)))
        return NULL;
    if (!chunks_fit(r->data, r->left))
        return NULL;
    png_read_info(r->png, r->info);
    png_textp texts;
    int count = png_get_text(r->png, r->info, &texts, NULL);
    for (int i = 0; i < count; i++) {
        if (strcmp(texts[i].key, key) != 0 || !texts[i].text)
            continue;
        size_t size = strlen(texts[i].text) + 1;
        char *copy = malloc(size);
        return copy ? memcpy(copy, texts[i].text, size) : NULL;
    }
    return NULL;
}

char *ng_png_text(const void *data, size_t size, const char *key)
{
    struct reader r;
    if (!reader_init(&r, "picture", data, size))
        return NULL;
    char *text = find_text(&r, key);
    reader_finish(&r);
    return text;
}

// ---- writing ---------------------------------------------------------------------------------------------

struct writer {
    png_structp png;
    png_infop info;
    png_textp texts;
    NG_ARRAY(unsigned char) bytes;
};

static void write_bytes(png_structp png, png_bytep data, size_t size)
{
    struct writer *w = png_get_io_ptr(png);
    if (!ng_array_reserve(&w->bytes, w->bytes.count + size))
        png_error(png, "out of memory");
    memcpy(w->bytes.items + w->bytes.count, data, size);
    w->bytes.count += size;
}

static void no_flush(png_structp png)
{
    NG_UNUSED(png);
}

static bool is_ascii(const char *text)
{
    while (*text && (unsigned char)*text < 128)
        text++;
    return *text == 0;
}

static void add_texts(struct writer *w, const struct ng_png_params *p)
{
    w->texts = calloc(p->text_count + (size_t)1, sizeof *w->texts);
    if (!w->texts)
        png_error(w->png, "out of memory");
    for (uint32_t i = 0; i < p->text_count; i++) {
        png_textp t = &w->texts[i];
        bool ascii = is_ascii(p->texts[i].value);
        t->compression = ascii ? PNG_TEXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_NONE;
        t->key = (png_charp)p->texts[i].key;
        t->text = (png_charp)p->texts[i].value;
        t->text_length = ascii ? strlen(t->text) : 0;
        t->itxt_length = ascii ? 0 : strlen(t->text);
    }
    png_set_text(w->png, w->info, w->texts, (int)p->text_count);
}

static ng_result encode(struct writer *w, const struct ng_png_params *p)
{
    if (setjmp(png_jmpbuf(w->png)))
        return NG_ERROR_MEMORY;
    uint32_t channels = p->channels ? p->channels : 4;
    png_set_write_fn(w->png, w, write_bytes, no_flush);
    png_set_IHDR(w->png, w->info, p->width, p->height, 8,
                 channels == 3 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_RGB_ALPHA, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_BASE, PNG_FILTER_TYPE_BASE);
    png_set_sRGB(w->png, w->info, PNG_sRGB_INTENT_PERCEPTUAL);
    add_texts(w, p);
    png_write_info(w->png, w->info);
    for (uint32_t y = 0; y < p->height; y++)
        png_write_row(w->png, (png_const_bytep)p->pixels + (size_t)y * p->width * channels);
    png_write_end(w->png, w->info);
    return NG_OK;
}

ng_result ng_png_encode(const char *name, const struct ng_png_params *params, void **data, size_t *size)
{
    *data = NULL;
    NG_REQUIRE(params->width && params->height && params->pixels, "a picture needs pixels");
    NG_REQUIRE(params->channels == 0 || params->channels == 3 || params->channels == 4,
               "a picture has 3 or 4 channels, not %u", params->channels);
    struct writer w = {0};
    w.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, (void *)name, on_error, on_warning);
    w.info = w.png ? png_create_info_struct(w.png) : NULL;
    ng_result r = NG_ERROR_MEMORY;
    if (w.info)
        r = encode(&w, params);
    else
        ng_out_of_memory(name);
    png_destroy_write_struct(&w.png, &w.info);
    free(w.texts);
    if (r != NG_OK) {
        ng_array_finish(&w.bytes);
        return r;
    }
    *data = w.bytes.items;
    *size = w.bytes.count;
    return NG_OK;
}

ng_result ng_png_write(const char *path, const struct ng_png_params *params)
{
    void *data;
    size_t size;
    NG_TRY(ng_png_encode(path, params, &data, &size));
    ng_result r = ng_file_write(path, data, size);
    free(data);
    return r;
}

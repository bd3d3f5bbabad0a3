// A text header, then one scan line after the other of pixels in four bytes: three mantissas with one
// exponent.
//
// New lines begin with 2, 2, width and hold the four components one after the other, each in runs (a count
// above 128) and literals. Otherwise pixels follow flat, where mantissas 1, 1, 1 repeat the last pixel.
#include "asset/hdr.h"
#include "asset/image_internal.h"
#include "base/log.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct reader {
    const char *name;
    const unsigned char *at, *end;
    float exposure;
    bool rgbe;
    uint32_t width, height;
};

static ng_result damaged(const struct reader *r, const char *what)
{
    ng_log_error("%s: Radiance HDR: %s", r->name, what);
    return NG_ERROR_FORMAT;
}

static bool read_line(struct reader *r, char *out, size_t size)
{
    size_t n = 0;
    while (r->at < r->end && *r->at != '\n') {
        if (n + 1 >= size)
            return false;
        out[n++] = (char)*r->at++;
    }
    out[n] = 0;
    if (r->at == r->end)
        return false;
    r->at++;
    return true;
}

static ng_result read_header(struct reader *r)
{
    char line[512];
    r->exposure = 1;
    if (!read_line(r, line, sizeof line) || strncmp(line, "#?", 2) != 0)
        return damaged(r, "the first line does not start with \"#?\"");
    for (;;) {
        if (!read_line(r, line, sizeof line))
            return damaged(r, "the header does not end");
        if (line[0] == 0)
            break;
        if (strncmp(line, "FORMAT=", 7) == 0 && strcmp(line + 7, "32-bit_rle_rgbe") != 0)
            return damaged(r, "only the format 32-bit_rle_rgbe is supported");
        if (strncmp(line, "EXPOSURE=", 9) == 0)
            r->exposure *= strtof(line + 9, NULL); // several lines multiply
    }
    if (!(r->exposure > 0) || !isfinite(r->exposure))
        return damaged(r, "EXPOSURE is not a positive number");
    unsigned width, height;
    char rest;
    if (!read_line(r, line, sizeof line) || sscanf(line, "-Y %9u +X %9u%c", &height, &width, &rest) != 2)
        return damaged(r, "the size is not of the form \"-Y height +X width\"");
    r->width = width;
    r->height = height;
    return NG_OK;
}

// One component of a new scan line, into every fourth byte.
static bool read_runs(struct reader *r, unsigned char *out)
{
    for (uint32_t x = 0; x < r->width;) {
        if (r->end - r->at < 2)
            return false;
        uint32_t count = *r->at++;
        bool run = count > 128;
        count = run ? count - 128 : count;
        if (count == 0 || count > r->width - x || (!run && (size_t)(r->end - r->at) < count))
            return false;
        for (uint32_t i = 0; i < count; i++, x++)
            out[x * (size_t)4] = run ? *r->at : *r->at++;
        r->at += run;
    }
    return true;
}

static bool read_flat(struct reader *r, unsigned char *out)
{
    unsigned shift = 0;
    for (uint32_t x = 0; x < r->width;) {
        if (r->end - r->at < 4)
            return false;
        const unsigned char *p = r->at;
        r->at += 4;
        if (p[0] != 1 || p[1] != 1 || p[2] != 1) {
            memcpy(out + x * (size_t)4, p, 4);
            x++;
            shift = 0;
            continue;
        }
        if (x == 0 || shift > 16)
            return false;
        uint32_t count = (uint32_t)p[3] << shift;
        if (count > r->width - x)
            return false;
        for (uint32_t i = 0; i < count; i++, x++)
            memcpy(out + x * (size_t)4, out + (x - 1) * (size_t)4, 4);
        shift += 8;
    }
    return true;
}

static bool read_scan_line(struct reader *r, unsigned char *out)
{
    const unsigned char *p = r->at;
    bool runs = r->width >= 8 && r->width < 32768 && r->end - p >= 4 && p[0] == 2 && p[1] == 2 &&
                ((uint32_t)p[2] << 8 | p[3]) == r->width;
    if (!runs)
        return read_flat(r, out);
    r->at += 4;
    for (int c = 0; c < 4; c++)
        if (!read_runs(r, out + c))
            return false;
    return true;
}

static void convert(const struct reader *r, const unsigned char *rgbe, float *out)
{
    for (size_t x = 0; x < r->width; x++) {
        const unsigned char *p = rgbe + x * 4;
        float unit = p[3] ? ldexpf(1.0f, p[3] - 136) / r->exposure : 0.0f;
        for (int c = 0; c < 3; c++)
            out[x * 4 + (size_t)c] = (float)p[c] * unit;
        out[x * 4 + 3] = 1;
    }
}

static ng_result read_pixels(struct reader *r, struct ng_image *image)
{
    unsigned char *line = malloc((size_t)r->width * 4);
    if (!line)
        return ng_out_of_memory(r->name);
    ng_result result = NG_OK;
    for (uint32_t y = 0; result == NG_OK && y < r->height; y++) {
        if (read_scan_line(r, line))
            convert(r, line, (float *)image->pixels + (size_t)y * r->width * 4);
        else
            result = damaged(r, "a scan line is damaged or missing");
    }
    free(line);
    return result;
}

ng_result ng_hdr_decode(const char *name, const void *data, size_t size, const struct ng_image_params *params,
                        struct ng_image *out)
{
    struct reader r = {.name = name, .at = data, .end = (const unsigned char *)data + size};
    *out = (struct ng_image){0};
    NG_TRY(read_header(&r));
    NG_TRY(ng_image_allocate(name, r.width, r.height, NG_PIXEL_RGBA32F, params, out));
    ng_result result = read_pixels(&r, out);
    if (result != NG_OK)
        ng_image_finish(out);
    return result;
}

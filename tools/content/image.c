// PNG needs a zlib stream; one of stored blocks is a few lines and the same bytes everywhere. Pictures here
// are small, and those that are not use a palette.
#include "image.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool bytes_append(struct bytes *b, const void *data, size_t size)
{
    size_t at = b->count;
    if (!size)
        return true;
    if (!ng_array_reserve(b, b->count + size))
        return false;
    memcpy(b->items + at, data, size);
    b->count += size;
    return true;
}

void bytes_finish(struct bytes *b)
{
    ng_array_finish(b);
}

// ---- PNG (ISO/IEC 15948) ----

static void put32(unsigned char *p, uint32_t v)
{
    for (int i = 0; i < 4; i++)
        p[i] = (unsigned char)(v >> (24 - 8 * i));
}

static uint32_t crc32(const unsigned char *p, size_t size)
{
    uint32_t crc = UINT32_MAX;
    for (size_t i = 0; i < size; i++) {
        crc ^= p[i];
        for (int k = 0; k < 8; k++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

static bool put_chunk(struct bytes *out, const char *type, const struct bytes *body)
{
    unsigned char word[4];
    put32(word, (uint32_t)body->count);
    if (!bytes_append(out, word, 4))
        return false;
    size_t start = out->count;
    if (!bytes_append(out, type, 4) || !bytes_append(out, body->items, body->count))
        return false;
    put32(word, crc32(out->items + start, out->count - start));
    return bytes_append(out, word, 4);
}

// Stored deflate blocks of at most 65535 bytes (RFC 1950, 1951).
static bool put_zlib(struct bytes *out, const struct bytes *raw)
{
    uint32_t a = 1, b = 0;
    bool ok = bytes_append(out, "\x78\x01", 2);
    for (size_t at = 0; ok && at < raw->count;) {
        size_t n = raw->count - at < 65535 ? raw->count - at : 65535;
        unsigned char head[5] = {at + n == raw->count, (unsigned char)(n & 255), (unsigned char)(n >> 8),
                                 (unsigned char)(~n & 255), (unsigned char)(~n >> 8 & 255)};
        ok = bytes_append(out, head, 5) && bytes_append(out, raw->items + at, n);
        at += n;
    }
    for (size_t i = 0; i < raw->count; i++) {
        a = (a + raw->items[i]) % 65521;
        b = (b + a) % 65521;
    }
    unsigned char adler[4];
    put32(adler, b << 16 | a);
    return ok && bytes_append(out, adler, 4);
}

static bool put_png(struct bytes *out, const unsigned char header[13], const struct bytes *palette,
                    uint32_t height, size_t row, const unsigned char *pixels)
{
    struct bytes raw = {0}, zlib = {0}, ihdr = {0}, none = {0};
    bool ok = bytes_append(&ihdr, header, 13);
    for (uint32_t y = 0; ok && y < height; y++)
        ok = bytes_append(&raw, "", 1) && bytes_append(&raw, pixels + y * row, row); // filter 0
    ok = ok && put_zlib(&zlib, &raw) && bytes_append(out, "\x89PNG\r\n\x1a\n", 8) &&
         put_chunk(out, "IHDR", &ihdr) && (!palette || put_chunk(out, "PLTE", palette)) &&
         put_chunk(out, "IDAT", &zlib) && put_chunk(out, "IEND", &none);
    bytes_finish(&raw);
    bytes_finish(&zlib);
    bytes_finish(&ihdr);
    return ok;
}

ng_result image_png(uint32_t width, uint32_t height, uint32_t channels, const unsigned char *pixels,
                    struct bytes *out)
{
    static const unsigned char color_type[5] = {0, 0, 0, 2, 6};
    unsigned char header[13] = {0};
    put32(header, width);
    put32(header + 4, height);
    header[8] = 8;
    header[9] = color_type[channels];
    return put_png(out, header, NULL, height, (size_t)width * channels, pixels) ? NG_OK : NG_ERROR_MEMORY;
}

ng_result image_png_indexed(uint32_t width, uint32_t height, const unsigned char *pixels,
                            const unsigned char (*palette)[3], uint32_t colors, struct bytes *out)
{
    unsigned char header[13] = {0};
    put32(header, width);
    put32(header + 4, height);
    header[8] = 8;
    header[9] = 3;
    struct bytes plte = {0};
    bool ok = bytes_append(&plte, palette, (size_t)colors * 3) &&
              put_png(out, header, &plte, height, width, pixels);
    bytes_finish(&plte);
    return ok ? NG_OK : NG_ERROR_MEMORY;
}

// ---- Radiance RGBE (Ward, "Real Pixels", Graphics Gems II) ----

static void rgbe_pack(const float rgb[3], unsigned char out[4])
{
    float most = fmaxf(rgb[0], fmaxf(rgb[1], rgb[2]));
    int exponent = 0;
    memset(out, 0, 4);
    if (most < 1e-32f)
        return;
    frexpf(most, &exponent);
    for (int i = 0; i < 3; i++)
        out[i] = (unsigned char)ldexpf(rgb[i], 8 - exponent);
    out[3] = (unsigned char)(exponent + 128);
}

// One component of a scanline: runs of three or more as (128 + n, value), the rest as (n, values...).
static bool put_runs(struct bytes *out, const unsigned char *row, uint32_t width)
{
    for (uint32_t x = 0; x < width;) {
        uint32_t run = 1, literal = 0;
        while (x + run < width && run < 127 && row[(x + run) * 4] == row[x * 4])
            run++;
        if (run >= 3) {
            unsigned char pair[2] = {(unsigned char)(128 + run), row[x * 4]};
            if (!bytes_append(out, pair, 2))
                return false;
            x += run;
            continue;
        }
        unsigned char values[129];
        while (x < width && literal < 128 &&
               !(x + 2 < width && row[x * 4] == row[x * 4 + 4] && row[x * 4] == row[x * 4 + 8]))
            values[++literal] = row[x++ * 4];
        values[0] = (unsigned char)literal;
        if (!bytes_append(out, values, literal + 1))
            return false;
    }
    return true;
}

ng_result image_hdr(uint32_t width, uint32_t height, const float *rgb, struct bytes *out)
{
    char header[96];
    int n =
        snprintf(header, sizeof header, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %u +X %u\n", height, width);
    unsigned char *row = malloc((size_t)width * 4);
    bool ok = row && bytes_append(out, header, (size_t)n);
    for (uint32_t y = 0; ok && y < height; y++) {
        for (uint32_t x = 0; x < width; x++)
            rgbe_pack(rgb + ((size_t)y * width + x) * 3, row + (size_t)x * 4);
        unsigned char start[4] = {2, 2, (unsigned char)(width >> 8), (unsigned char)(width & 255)};
        ok = bytes_append(out, start, 4);
        for (int channel = 0; ok && channel < 4; channel++)
            ok = put_runs(out, row + channel, width);
    }
    free(row);
    return ok ? NG_OK : NG_ERROR_MEMORY;
}

// Formats are told apart by their first bytes, never by the file's name.
//
// A mip level is made from the one above it. Where a side is odd, a texel of the smaller level covers parts
// of three: the weights of Guthe and Heckbert ("Non-power-of-two mipmapping", 2005) make the filter exact.
#include "asset/image.h"
#include "asset/exr.h"
#include "asset/hdr.h"
#include "asset/image_internal.h"
#include "asset/jpeg.h"
#include "asset/png.h"
#include "asset/webp.h"
#include "base/log.h"

#include <cglm/cglm.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

uint32_t ng_pixel_size(enum ng_pixel_format format)
{
    return format == NG_PIXEL_RGBA32F ? 16 : 4;
}

void ng_image_finish(struct ng_image *image)
{
    free(image->pixels);
    *image = (struct ng_image){0};
}

static uint32_t half_of(uint32_t side)
{
    return side > 1 ? side / 2 : 1;
}

// Bytes of all levels down to 1x1, and their number.
static uint64_t mip_chain(uint32_t width, uint32_t height, enum ng_pixel_format format, uint32_t *levels)
{
    uint64_t size = 0;
    *levels = 0;
    for (uint32_t w = width, h = height;; w = half_of(w), h = half_of(h)) {
        size += (uint64_t)w * h * ng_pixel_size(format);
        ++*levels;
        if (w == 1 && h == 1)
            return size;
    }
}

void *ng_image_level(const struct ng_image *image, uint32_t level, uint32_t *w, uint32_t *h)
{
    uint32_t width = image->width, height = image->height;
    size_t offset = 0;
    for (uint32_t i = 0; i < level; i++) {
        offset += (size_t)width * height * ng_pixel_size(image->format);
        width = half_of(width);
        height = half_of(height);
    }
    if (w)
        *w = width;
    if (h)
        *h = height;
    return (char *)image->pixels + offset;
}

ng_result ng_image_allocate(const char *name, uint32_t width, uint32_t height, enum ng_pixel_format format,
                            const struct ng_image_params *params, struct ng_image *out)
{
    uint32_t max_side = params->max_side ? params->max_side : NG_IMAGE_MAX_SIDE;
    uint64_t max_memory = params->max_memory ? params->max_memory : NG_IMAGE_MAX_MEMORY;
    *out = (struct ng_image){0};
    if (width == 0 || height == 0) {
        ng_log_error("%s: picture of %u x %u pixels", name, width, height);
        return NG_ERROR_FORMAT;
    }
    if (width > max_side || height > max_side) {
        ng_log_error("%s: %u x %u pixels, more than the limit of %u a side", name, width, height, max_side);
        return NG_ERROR_UNSUPPORTED;
    }
    uint32_t levels;
    uint64_t size = (uint64_t)width * height * ng_pixel_size(format);
    uint64_t full_size = params->no_mips ? size : mip_chain(width, height, format, &levels);
    if (full_size > max_memory) {
        char allowed[64];
        snprintf(allowed, sizeof allowed, "the %llu that are allowed", (unsigned long long)max_memory);
        ng_log_error("%s: %u x %u pixels need %llu bytes, more than %s", name, width, height,
                     (unsigned long long)full_size, params->limit ? params->limit : allowed);
        return NG_ERROR_MEMORY;
    }
    out->pixels = calloc(1, (size_t)full_size);
    if (!out->pixels) {
        ng_log_error("%s: out of memory for %u x %u pixels", name, width, height);
        return NG_ERROR_MEMORY;
    }
    out->width = width;
    out->height = height;
    out->levels = 1;
    out->format = format;
    out->sampling = params->sampling;
    out->size = (size_t)size;
    return NG_OK;
}

// ---- EXR as an image -------------------------------------------------------------------------------------
static uint32_t side_of(int64_t size)
{
    return size > UINT32_MAX ? UINT32_MAX : (uint32_t)size;
}

// Of the display window what there is data of; the rest stays black.
static void copy_display_window(const struct ng_exr *exr, const struct ng_exr_plane *const planes[4],
                                struct ng_image *out)
{
    for (int64_t y = 0; y < out->height; y++)
        for (int64_t x = 0; x < out->width; x++) {
            int64_t u = x + exr->display_x, v = y + exr->display_y;
            bool inside = u >= 0 && v >= 0 && u < exr->width && v < exr->height;
            float *to = (float *)out->pixels + (y * out->width + x) * 4;
            for (int c = 0; inside && c < 4; c++)
                to[c] = planes[c] ? ((const float *)planes[c]->pixels)[v * exr->width + u] : 1.0f;
        }
}

// From RGB of these chromaticities to XYZ, of white (1, 1, 1) with Y = 1; false if they are no colours.
static bool find_to_xyz(const float chromaticities[8], mat3 out)
{
    mat3 primaries, inverse;
    vec3 white, weights;
    for (int i = 0; i < 4; i++) {
        float x = chromaticities[2 * i], y = chromaticities[2 * i + 1];
        vec3 xyz = {x / y, 1, (1 - x - y) / y};
        if (!(fabsf(y) > 1e-4f) || !(fabsf(x) < 4) || !(fabsf(y) < 4))
            return false;
        glm_vec3_copy(xyz, i < 3 ? primaries[i] : white);
    }
    if (!(fabsf(glm_mat3_det(primaries)) > 1e-6f))
        return false;
    glm_mat3_inv(primaries, inverse);
    glm_mat3_mulv(inverse, white, weights);
    for (int i = 0; i < 3; i++)
        glm_vec3_scale(primaries[i], weights[i], out[i]);
    return true;
}

// To Rec. 709; white stays white (Bradford's adaptation).
static bool find_to_rec709(const float chromaticities[8], mat3 out)
{
    static const float rec709[8] = {0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f};
    mat3 bradford = {
        {0.8951f, -0.7502f, 0.0389f}, {0.2664f, 1.7135f, -0.0685f}, {-0.1614f, 0.0367f, 1.0296f}};
    mat3 from, to, adapt = GLM_MAT3_IDENTITY_INIT, inverse;
    vec3 one = {1, 1, 1}, white, seen, wanted;
    if (!find_to_xyz(chromaticities, from) || !find_to_xyz(rec709, to))
        return false;
    glm_mat3_mulv(from, one, white);
    glm_mat3_mulv(bradford, white, seen);
    glm_mat3_mulv(to, one, white);
    glm_mat3_mulv(bradford, white, wanted);
    for (int i = 0; i < 3; i++) {
        if (!(seen[i] > 1e-4f))
            return false;
        adapt[i][i] = wanted[i] / seen[i];
    }
    glm_mat3_mul(bradford, from, out);
    glm_mat3_mul(adapt, out, out);
    glm_mat3_inv(bradford, inverse);
    glm_mat3_mul(inverse, out, out);
    glm_mat3_inv(to, inverse);
    glm_mat3_mul(inverse, out, out);
    return true;
}

static void convert_colors(const struct ng_exr *exr, struct ng_image *image)
{
    mat3 m;
    float change = 0;
    if (!exr->has_chromaticities || !find_to_rec709(exr->chromaticities, m))
        return;
    for (int i = 0; i < 9; i++)
        change = fmaxf(change, fabsf(m[i / 3][i % 3] - (i % 4 == 0 ? 1.0f : 0.0f)));
    for (size_t i = 0; change > 1e-3f && i < (size_t)image->width * image->height; i++) {
        float *rgb = (float *)image->pixels + i * 4;
        glm_mat3_mulv(m, rgb, rgb);
    }
}

static ng_result exr_decode(const char *name, const void *data, size_t size,
                            const struct ng_image_params *params, struct ng_image *out)
{
    static const char *const names[4] = {"R", "G", "B", "A"};
    struct ng_exr_limits limits = {params->max_side, params->max_memory, params->limit};
    struct ng_exr exr;
    NG_TRY(ng_exr_decode(name, data, size, &limits, &exr));
    const struct ng_exr_plane *planes[4];
    for (int c = 0; c < 4; c++) {
        planes[c] = ng_exr_plane(&exr, names[c]);
        if (planes[c] && planes[c]->type == NG_EXR_UINT)
            planes[c] = NULL;
    }
    const struct ng_exr_plane *grey = ng_exr_plane(&exr, "Y");
    for (int c = 0; c < 3; c++)
        planes[c] = planes[c] ? planes[c] : grey;
    ng_result r = NG_ERROR_FORMAT;
    if (planes[0] && planes[1] && planes[2] && planes[0]->type != NG_EXR_UINT)
        r = ng_image_allocate(name, side_of(exr.display_width), side_of(exr.display_height), NG_PIXEL_RGBA32F,
                              params, out);
    else
        ng_log_error("%s: has no channels R, G, B nor Y", name);
    if (r == NG_OK) {
        copy_display_window(&exr, planes, out);
        convert_colors(&exr, out);
    }
    ng_exr_finish(&exr);
    return r;
}

// ---- any format ------------------------------------------------------------------------------------------

// Light that overflowed half floats, as of a sun, is as bright as they can be.
static float repaired(float v)
{
    const float most = 65504;
    return isfinite(v) ? v : v > 0 ? most : 0;
}

static ng_result check_finite(const char *name, const struct ng_image_params *params, struct ng_image *image)
{
    float *value = (float *)image->pixels;
    size_t count = 0, first = 0;
    for (size_t i = (size_t)image->width * image->height * 4; i-- > 0;)
        if (!isfinite(value[i])) {
            value[i] = repaired(value[i]);
            count++;
            first = i / 4;
        }
    if (count == 0)
        return NG_OK;
    size_t x = first % image->width, y = first / image->width;
    if (params->repair) {
        ng_log_warn("%s: pixel %zu, %zu is not a finite number (%zu values in all are none); they are moved "
                    "to 0 .. 65504",
                    name, x, y, count);
        return NG_OK;
    }
    ng_log_error("%s: pixel %zu, %zu is not a finite number; repair the picture", name, x, y);
    return NG_ERROR_FORMAT;
}

typedef ng_result decode_fn(const char *, const void *, size_t, const struct ng_image_params *,
                            struct ng_image *);

static const struct format {
    const char *magic;
    size_t size, skip; // `skip` bytes come before it
    decode_fn *decode;
} formats[] = {
    {"\x89PNG", 4, 0, ng_png_decode},       {"\xff\xd8\xff", 3, 0, ng_jpeg_decode},
    {"\x76\x2f\x31\x01", 4, 0, exr_decode}, {"#?", 2, 0, ng_hdr_decode},
    {"WEBP", 4, 8, ng_webp_decode},
};

ng_result ng_image_decode(const char *name, const void *data, size_t size,
                          const struct ng_image_params *params, struct ng_image *out)
{
    *out = (struct ng_image){0};
    for (size_t i = 0; i < NG_COUNT(formats); i++) {
        const struct format *f = &formats[i];
        if (size < f->skip + f->size || memcmp((const char *)data + f->skip, f->magic, f->size) != 0)
            continue;
        NG_TRY(f->decode(name, data, size, params, out));
        ng_result r = out->format == NG_PIXEL_RGBA32F ? check_finite(name, params, out) : NG_OK;
        if (r == NG_OK && !params->no_mips)
            r = ng_image_make_mips(out);
        if (r != NG_OK)
            ng_image_finish(out);
        return r;
    }
    ng_log_error("%s: not a PNG, JPEG, WebP, OpenEXR or Radiance HDR picture", name);
    return NG_ERROR_FORMAT;
}

// ---- mip maps --------------------------------------------------------------------------------------------

// The texels of the larger level that texel i of the smaller one covers along one axis.
struct taps {
    uint32_t first, count;
    float weights[3];
};

static struct taps find_taps(uint32_t larger, uint32_t i)
{
    uint32_t smaller = half_of(larger);
    if (larger == 1)
        return (struct taps){0, 1, {1}};
    if (larger % 2 == 0)
        return (struct taps){i * 2, 2, {0.5f, 0.5f}};
    float n = (float)larger;
    return (struct taps){i * 2, 3, {(float)(smaller - i) / n, (float)smaller / n, (float)(i + 1) / n}};
}

// How 8-bit values map to linear light: value i has linear[i]; it is the nearest code up to edges[i].
struct codes {
    float linear[256], edges[256];
};

static float srgb_to_linear(float s)
{
    return s <= 0.04045f ? s / 12.92f : powf((s + 0.055f) / 1.055f, 2.4f);
}

static void make_codes(bool srgb, struct codes *codes)
{
    for (int i = 0; i < 256; i++) {
        float v = (float)i / 255.0f, edge = ((float)i + 0.5f) / 255.0f;
        codes->linear[i] = srgb ? srgb_to_linear(v) : v;
        codes->edges[i] = srgb ? srgb_to_linear(edge) : edge;
    }
}

static unsigned char encode(const struct codes *codes, float v)
{
    unsigned low = 0, high = 255; // the first code whose edge is not below v
    while (low < high) {
        unsigned middle = (low + high) / 2;
        if (codes->edges[middle] < v)
            low = middle + 1;
        else
            high = middle;
    }
    return (unsigned char)low;
}

void ng_image_linear_values(float linear[256])
{
    for (int i = 0; i < 256; i++)
        linear[i] = srgb_to_linear((float)i / 255.0f);
}

unsigned char ng_image_srgb_code(float v)
{
    float s = v <= 0.0031308f ? v * 12.92f : 1.055f * powf(v, 1 / 2.4f) - 0.055f;
    return (unsigned char)(fminf(fmaxf(s, 0.0f), 1.0f) * 255.0f + 0.5f);
}

struct reduction {
    const unsigned char *from;
    unsigned char *to;
    uint32_t from_width, from_height;
    enum ng_pixel_format format;
    struct codes color, alpha;
};

static void read_texel(const struct reduction *r, size_t index, float out[4])
{
    const unsigned char *p = r->from + index * ng_pixel_size(r->format);
    if (r->format == NG_PIXEL_RGBA32F) {
        memcpy(out, p, 16);
        return;
    }
    for (int c = 0; c < 3; c++)
        out[c] = r->color.linear[p[c]];
    out[3] = r->alpha.linear[p[3]];
}

static void write_texel(const struct reduction *r, size_t index, const float in[4])
{
    unsigned char *p = r->to + index * ng_pixel_size(r->format);
    if (r->format == NG_PIXEL_RGBA32F) {
        memcpy(p, in, 16);
        return;
    }
    for (int c = 0; c < 3; c++)
        p[c] = encode(&r->color, in[c]);
    p[3] = encode(&r->alpha, in[3]);
}

static void reduce(const struct reduction *r)
{
    uint32_t width = half_of(r->from_width), height = half_of(r->from_height);
    for (uint32_t y = 0; y < height; y++) {
        struct taps v = find_taps(r->from_height, y);
        for (uint32_t x = 0; x < width; x++) {
            struct taps u = find_taps(r->from_width, x);
            float sum[4] = {0}, texel[4];
            for (uint32_t j = 0; j < v.count; j++)
                for (uint32_t i = 0; i < u.count; i++) {
                    read_texel(r, (size_t)(v.first + j) * r->from_width + u.first + i, texel);
                    for (int c = 0; c < 4; c++)
                        sum[c] += texel[c] * v.weights[j] * u.weights[i];
                }
            write_texel(r, (size_t)y * width + x, sum);
        }
    }
}

void ng_image_update_mips(struct ng_image *image)
{
    struct reduction r = {.format = image->format};
    make_codes(image->format == NG_PIXEL_RGBA8_SRGB, &r.color);
    make_codes(false, &r.alpha);
    for (uint32_t level = 1; level < image->levels; level++) {
        r.from = ng_image_level(image, level - 1, &r.from_width, &r.from_height);
        r.to = ng_image_level(image, level, NULL, NULL);
        reduce(&r);
    }
}

ng_result ng_image_make_mips(struct ng_image *image)
{
    NG_REQUIRE(image->pixels && image->levels == 1, "the image must have one level");
    struct ng_image full = *image;
    full.size = (size_t)mip_chain(image->width, image->height, image->format, &full.levels);
    full.pixels = realloc(image->pixels, full.size); // the decoders left room: nothing moves
    if (!full.pixels) {
        ng_log_error("out of memory for the mip maps of %u x %u pixels", image->width, image->height);
        return NG_ERROR_MEMORY;
    }
    *image = full;
    ng_image_update_mips(image);
    return NG_OK;
}

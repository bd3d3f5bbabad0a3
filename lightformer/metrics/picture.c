// The first bytes tell PNG from OpenEXR. Planes of a layer are found by name, then interleaved.
#include "lightformer/metrics/picture.h"

#include "asset/exr.h"
#include "asset/png.h"
#include "base/file.h"
#include "base/log.h"
#include "shaders/shared/tonemap.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- Layers

// Whether a plane belongs to a layer (null: the root); then `*channel` is the rest of its name.
static bool in_layer(const char *plane, const char *layer, const char **channel)
{
    const char *dot = strrchr(plane, '.');
    *channel = dot ? dot + 1 : plane;
    if (!layer)
        return !dot;
    return dot && strlen(layer) == (size_t)(dot - plane) && memcmp(plane, layer, strlen(layer)) == 0;
}

static const struct ng_exr_plane *find_plane(const struct ng_exr *exr, const char *layer, const char *channel)
{
    for (uint32_t i = 0; i < exr->plane_count; i++) {
        const char *name;
        if (in_layer(exr->planes[i].name, layer, &name) && strcmp(name, channel) == 0)
            return &exr->planes[i];
    }
    return NULL;
}

// The only plane of a layer apart from alpha; null if there are none or several. `*count` says how many.
static const struct ng_exr_plane *find_single(const struct ng_exr *exr, const char *layer, uint32_t *count)
{
    const struct ng_exr_plane *found = NULL;
    *count = 0;
    for (uint32_t i = 0; i < exr->plane_count; i++) {
        const char *channel;
        if (in_layer(exr->planes[i].name, layer, &channel) && strcmp(channel, "A") != 0) {
            found = &exr->planes[i];
            (*count)++;
        }
    }
    return *count == 1 ? found : NULL;
}

// "direct, indirect, normal": every layer but the root, each once, cut where it does not fit.
static void list_layers(const struct ng_exr *exr, char *out, size_t size)
{
    out[0] = 0;
    const char *last = "";
    size_t last_length = 0;
    for (uint32_t i = 0; i < exr->plane_count; i++) {
        const char *name = exr->planes[i].name, *dot = strrchr(name, '.');
        size_t length = dot ? (size_t)(dot - name) : 0, used = strlen(out);
        if (length == 0 || (length == last_length && memcmp(name, last, length) == 0))
            continue;
        snprintf(out + used, size - used, "%s%.*s", used ? ", " : "", (int)length, name);
        last = name;
        last_length = length;
    }
}

static ng_result no_layer(const char *path, const char *layer, const struct ng_exr *exr, uint32_t channels)
{
    char layers[512];
    if (channels > 0) {
        ng_log_error("%s: the %u channels of %s are neither R, G, B nor X, Y, Z nor one alone", path,
                     channels, layer ? layer : "the root");
        return NG_ERROR_UNSUPPORTED;
    }
    list_layers(exr, layers, sizeof layers);
    ng_log_error("%s: no layer \"%s\"; it has %s", path, layer ? layer : "R, G, B",
                 layers[0] ? layers : "no layers, only a root");
    return NG_ERROR_NOT_FOUND;
}

static ng_result find_layer(const char *path, const char *layer, const struct ng_exr *exr,
                            const struct ng_exr_plane *planes[3])
{
    static const char *const triples[][3] = {{"R", "G", "B"}, {"X", "Y", "Z"}};
    for (size_t t = 0; t < NG_COUNT(triples); t++) {
        for (int c = 0; c < 3; c++)
            planes[c] = find_plane(exr, layer, triples[t][c]);
        if (planes[0] && planes[1] && planes[2])
            return NG_OK;
    }
    uint32_t count;
    planes[0] = planes[1] = planes[2] = find_single(exr, layer, &count);
    return planes[0] ? NG_OK : no_layer(path, layer, exr, count);
}

// ---- Pixels

static ng_result allocate(uint32_t width, uint32_t height, struct lf_picture *out)
{
    out->width = width;
    out->height = height;
    out->pixels = malloc((size_t)width * height * 3 * sizeof *out->pixels); // 16,384 a side at most
    if (out->pixels)
        return NG_OK;
    ng_log_error("%s: out of memory for %u x %u pixels", out->name, width, height);
    return NG_ERROR_MEMORY;
}

static float plane_value(const struct ng_exr_plane *plane, size_t i)
{
    return plane->type == NG_EXR_UINT ? (float)((const uint32_t *)plane->pixels)[i]
                                      : ((const float *)plane->pixels)[i];
}

static ng_result take_layer(const char *path, const char *layer, const struct ng_exr *exr,
                            struct lf_picture *out)
{
    const struct ng_exr_plane *planes[3];
    NG_TRY(find_layer(path, layer, exr, planes));
    NG_TRY(allocate(exr->width, exr->height, out));
    for (size_t i = 0; i < (size_t)exr->width * exr->height; i++) {
        for (int c = 0; c < 3; c++)
            out->pixels[i * 3 + (size_t)c] = plane_value(planes[c], i);
    }
    return NG_OK;
}

static ng_result decode_exr(const char *path, const char *layer, const void *data, size_t size,
                            struct lf_picture *out)
{
    struct ng_exr exr;
    NG_TRY(ng_exr_decode(path, data, size, NULL, &exr));
    ng_result result = take_layer(path, layer, &exr, out);
    ng_exr_finish(&exr);
    return result;
}

static ng_result decode_png(const char *path, const char *layer, const void *data, size_t size,
                            struct lf_picture *out)
{
    if (layer) {
        ng_log_error("%s: no layer \"%s\"; a PNG has no layers", path, layer);
        return NG_ERROR_NOT_FOUND;
    }
    struct ng_image image;
    NG_TRY(ng_png_decode(path, data, size, &(struct ng_image_params){.srgb = true, .no_mips = true}, &image));
    ng_result result = allocate(image.width, image.height, out);
    const uint8_t *rgba = image.pixels;
    for (size_t i = 0; result == NG_OK && i < (size_t)image.width * image.height; i++) {
        for (size_t c = 0; c < 3; c++)
            out->pixels[i * 3 + c] = ng_srgb_decode((float)rgba[i * 4 + c] / 255.0f);
    }
    out->display = true;
    ng_image_finish(&image);
    return result;
}

static ng_result decode(const char *path, const char *layer, const void *data, size_t size,
                        struct lf_picture *out)
{
    if (size >= 4 && memcmp(data, "\x76\x2f\x31\x01", 4) == 0)
        return decode_exr(path, layer, data, size, out);
    if (size >= 4 && memcmp(data, "\x89PNG", 4) == 0)
        return decode_png(path, layer, data, size, out);
    ng_log_error("%s: neither an OpenEXR nor a PNG file", path);
    return NG_ERROR_FORMAT;
}

ng_result lf_picture_load(const char *path, const char *layer, struct lf_picture *out)
{
    NG_REQUIRE(path && out, "path and out must be given");
    *out = (struct lf_picture){0};
    snprintf(out->name, sizeof out->name, "%s%s%s", path, layer ? ", layer " : "", layer ? layer : "");
    void *data;
    size_t size;
    NG_TRY(ng_file_read(path, 0, &data, &size));
    ng_result result = decode(path, layer, data, size, out);
    free(data);
    if (result != NG_OK)
        lf_picture_finish(out);
    return result;
}

void lf_picture_finish(struct lf_picture *picture)
{
    free(picture->pixels);
    *picture = (struct lf_picture){0};
}

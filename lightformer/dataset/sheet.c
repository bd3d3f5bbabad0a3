// A picture of tiles: a row for each crop, a tile for each channel. A tile is how the values of a pixel are
// read and how they become a colour. Radiance is shown at one exposure a crop (its mean at 0.18), everything
// else as numbers from 0 to 1.
#include "lightformer/dataset/dataset.h"

#include "asset/png.h"
#include "base/half.h"
#include "base/log.h"
#include "lightformer/dataset/manifest.h"
#include "shaders/shared/tonemap.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ROWS       16
#define GAP        4
#define MAX_LIGHTS 3 // shown
#define MAX_WIDTH  16384u

struct row {
    const struct lf_tensors *tensors;
    uint64_t seed;
    size_t crop, side;    // which crop of the sample; pixels a side
    size_t lights, light; // of the sample; the one that a tile shows
    float exposure;
};

// A picture under construction.
struct sheet {
    uint32_t width, height;
    uint32_t used; // pixels of a row that tiles cover
    unsigned char *rgb;
};

typedef void (*read_fn)(const struct row *row, const char *name, size_t pixel, float out[3]);

struct tile {
    read_fn read;
    const char *name;                                   // of the tensor, where it is one
    void (*color)(const struct row *row, float rgb[3]); // null: as it is
};

// ---- values ----------------------------------------------------------------------------------------------

static const struct lf_tensor *tensor(const struct row *row, const char *name)
{
    char full[LF_TENSOR_NAME];
    snprintf(full, sizeof full, "%" PRIu64 "/%s", row->seed, name);
    return lf_tensors_find(row->tensors, full);
}

static float number(const struct lf_tensor *t, size_t index)
{
    return t->dtype == LF_F16  ? ng_half_to_float(((const uint16_t *)t->data)[index])
           : t->dtype == LF_U8 ? (float)((const uint8_t *)t->data)[index]
                               : ((const float *)t->data)[index];
}

// A pixel of a tensor [crops][channels][side][side].
static void planes(const struct row *row, const char *name, size_t pixel, float out[3])
{
    const struct lf_tensor *t = tensor(row, name);
    size_t channels = t->shape[1], n = row->side * row->side;
    for (size_t c = 0; c < 3; c++)
        out[c] = number(t, (row->crop * channels + (c < channels ? c : 0)) * n + pixel);
}

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void fill(float value, float out[3])
{
    out[0] = out[1] = out[2] = value;
}

// ---- colours ---------------------------------------------------------------------------------------------

static void radiance(const struct row *row, float rgb[3])
{
    for (int c = 0; c < 3; c++)
        rgb[c] = fmaxf(rgb[c] * row->exposure, 0);
    float peak = fmaxf(rgb[0], fmaxf(rgb[1], rgb[2])), toe = fminf(rgb[0], fminf(rgb[1], rgb[2]));
    for (int c = 0; c < 3; c++)
        rgb[c] = ng_srgb_encode(ng_tonemap(rgb[c], peak, toe));
}

static void reflectance(const struct row *row, float rgb[3])
{
    NG_UNUSED(row);
    for (int c = 0; c < 3; c++)
        rgb[c] = ng_srgb_encode(rgb[c]);
}

static void vector(const struct row *row, float rgb[3])
{
    NG_UNUSED(row);
    for (int c = 0; c < 3; c++)
        rgb[c] = rgb[c] * 0.5f + 0.5f;
}

static void distance(const struct row *row, float rgb[3])
{
    NG_UNUSED(row);
    fill(rgb[0] * 0.5f, rgb);
}

// ---- values of a crop ------------------------------------------------------------------------------------

static void beauty(const struct row *row, const char *name, size_t i, float out[3])
{
    float direct[3], shadow[3], indirect[3], emission[3];
    NG_UNUSED(name);
    planes(row, "target.unshadowed", i, direct);
    planes(row, "target.shadow", i, shadow);
    planes(row, "target.indirect", i, indirect);
    planes(row, "gbuffer.emission", i, emission);
    for (int c = 0; c < 3; c++)
        out[c] = direct[c] * shadow[c] + indirect[c] + emission[c];
}

// ---- values of a light -----------------------------------------------------------------------------------

// A pixel of a tensor [crops][lights][channels][side][side].
static void view(const struct row *row, const char *name, size_t pixel, float out[3])
{
    const struct lf_tensor *t = tensor(row, name);
    size_t channels = t->shape[2], n = row->side * row->side, light = row->crop * row->lights + row->light;
    for (size_t c = 0; c < 3; c++)
        out[c] = number(t, (light * channels + (c < channels ? c : 0)) * n + pixel);
}

// What arrives of all lights.
static void arriving(const struct row *row, const char *name, size_t pixel, float out[3])
{
    float unit = number(tensor(row, "frame.radiance"), 0);
    planes(row, name, pixel, out);
    for (int c = 0; c < 3; c++)
        out[c] *= unit;
}

// What a light's radiance at unit power adds to the picture.
static void light(const struct row *row, const char *name, size_t pixel, float out[3])
{
    float share = number(tensor(row, "light.share"), row->light),
          unit = number(tensor(row, "frame.radiance"), 0);
    view(row, name, pixel, out);
    for (int c = 0; c < 3; c++)
        out[c] *= share * unit;
}

static void ratio(const struct row *row, const char *name, size_t i, float out[3])
{
    float d[3], d_f[3];
    NG_UNUSED(name);
    view(row, "view.occluder", i, d);
    view(row, "view.distance", i, d_f);
    fill(d_f[0] > 0 ? d[0] / d_f[0] : 1, out);
}

// Blue where something stands before the point; a tenth of the radius is full.
static void difference(const struct row *row, const char *name, size_t i, float out[3])
{
    float d[3], d_f[3];
    NG_UNUSED(name);
    view(row, "view.occluder", i, d);
    view(row, "view.distance", i, d_f);
    out[0] = out[1] = 0.2f;
    out[2] = 0.2f + (d_f[0] - d[0]) * 10;
}

static void light_cosine(const struct row *row, const char *name, size_t i, float out[3])
{
    float n[3], l[3];
    NG_UNUSED(name);
    planes(row, "pixel.normal", i, n);
    view(row, "view.direction", i, l);
    fill(dot(n, l), out);
}

static void view_cosine(const struct row *row, const char *name, size_t i, float out[3])
{
    float n[3], v[3];
    NG_UNUSED(name);
    planes(row, "pixel.normal", i, n);
    planes(row, "pixel.view", i, v);
    fill(dot(n, v), out);
}

// The rows of the RSM one after another, over the whole tile.
static void texel(const struct row *row, const char *name, size_t i, float out[3])
{
    const struct lf_tensor *t = tensor(row, name);
    size_t rows = t->shape[2], at = i * rows / (row->side * row->side);
    fill(0, out);
    for (size_t c = 0; at < rows && c < 3; c++)
        out[c] = number(t, (row->light * 3 + c) * rows + at);
}

// ---- tiles -----------------------------------------------------------------------------------------------

static const struct tile crop_tiles[] = {
    {beauty, NULL, radiance},
    {planes, "target.unshadowed", radiance},
    {planes, "target.shadow", NULL},
    {planes, "target.indirect", radiance},
    {planes, "gbuffer.emission", radiance},
    {planes, "pixel.position", vector},
    {planes, "pixel.normal", vector},
    {planes, "pixel.diffuse", reflectance},
    {planes, "pixel.specular", reflectance},
    {planes, "pixel.roughness", NULL},
    {planes, "pixel.mirror", NULL},
    {planes, "pixel.mirror_albedo", reflectance},
    {arriving, "pixel.mirror_light", radiance},
    {arriving, "pixel.gathered", radiance},
};
static const struct tile light_tiles[] = {
    {view, "view.distance", distance},
    {ratio, NULL, NULL},
    {difference, NULL, NULL},
    {light_cosine, NULL, NULL},
    {view_cosine, NULL, NULL},
    {light, "view.diffuse", radiance},
    {light, "view.glossy", radiance},
    {light, "view.bounce", radiance},
    {view, "view.diffuse_reached", NULL},
    {view, "view.glossy_reached", NULL},
    {texel, "texel.flux", reflectance}, // a texel's even share of the light comes out bright
    {texel, "texel.normal", vector},
    {texel, "texel.position", vector},
};

// ---- the sheet -------------------------------------------------------------------------------------------

static unsigned char to_byte(float x)
{
    return (unsigned char)(fminf(fmaxf(x, 0), 1) * 255 + 0.5f);
}

static void draw_tile(struct sheet *sheet, const struct row *row, const struct tile *tile, size_t column,
                      size_t line)
{
    size_t x0 = GAP + column * (row->side + GAP), y0 = GAP + line * (row->side + GAP);
    if (x0 + row->side > sheet->width || y0 + row->side > sheet->height)
        return;
    if (sheet->used < x0 + row->side + GAP)
        sheet->used = (uint32_t)(x0 + row->side + GAP);
    for (size_t i = 0; i < row->side * row->side; i++) {
        float rgb[3];
        tile->read(row, tile->name, i, rgb);
        if (tile->color)
            tile->color(row, rgb);
        for (size_t c = 0; c < 3; c++)
            sheet->rgb[((y0 + i / row->side) * sheet->width + x0 + i % row->side) * 3 + c] = to_byte(rgb[c]);
    }
}

static void draw_row(struct sheet *sheet, struct row *row, size_t line)
{
    double mean = 0;
    size_t n = row->side * row->side, column = 0;
    for (size_t i = 0; i < n; i++) {
        float rgb[3];
        beauty(row, NULL, i, rgb);
        mean += ((double)rgb[0] + (double)rgb[1] + (double)rgb[2]) / 3 / (double)n;
    }
    row->exposure = mean > 0 ? (float)(0.18 / mean) : 1;
    for (size_t t = 0; t < NG_COUNT(crop_tiles); t++)
        draw_tile(sheet, row, &crop_tiles[t], column++, line);
    for (row->light = 0; row->light < row->lights && row->light < MAX_LIGHTS; row->light++)
        for (size_t t = 0; t < NG_COUNT(light_tiles); t++)
            draw_tile(sheet, row, &light_tiles[t], column++, line);
}

// Everything that the tiles read, in the shape that they read it. The shard is whole, but who wrote it?
static bool has_shapes(const struct row *row, uint64_t crops)
{
    const uint64_t s = row->side, l = row->lights, any = UINT64_MAX;
    const struct {
        const char *name;
        enum lf_dtype dtype;
        uint32_t rank;
        uint64_t shape[LF_TENSOR_RANK];
    } wanted[] = {
        {"target.unshadowed", LF_F32, 4, {crops, 3, s, s}},
        {"target.shadow", LF_F16, 4, {crops, 3, s, s}},
        {"target.indirect", LF_F32, 4, {crops, 3, s, s}},
        {"gbuffer.emission", LF_F32, 4, {crops, 3, s, s}},
        {"pixel.position", LF_F32, 4, {crops, 3, s, s}},
        {"pixel.normal", LF_F16, 4, {crops, 3, s, s}},
        {"pixel.view", LF_F16, 4, {crops, 3, s, s}},
        {"pixel.diffuse", LF_F16, 4, {crops, 3, s, s}},
        {"pixel.specular", LF_F16, 4, {crops, 3, s, s}},
        {"pixel.roughness", LF_F16, 4, {crops, 1, s, s}},
        {"pixel.mirror", LF_F16, 4, {crops, 1, s, s}},
        {"pixel.mirror_albedo", LF_F16, 4, {crops, 3, s, s}},
        {"pixel.mirror_light", LF_F16, 4, {crops, 3, s, s}},
        {"pixel.gathered", LF_F16, 4, {crops, 3, s, s}},
        {"frame.radiance", LF_F32, 1, {1}},
        {"light.share", LF_F32, 2, {l, 1}},
        {"texel.flux", LF_F16, 3, {l, 3, any}},
        {"texel.normal", LF_F16, 3, {l, 3, any}},
        {"texel.position", LF_F32, 3, {l, 3, any}},
        {"view.direction", LF_F16, 5, {crops, l, 3, s, s}},
        {"view.distance", LF_F32, 5, {crops, l, 1, s, s}},
        {"view.occluder", LF_F32, 5, {crops, l, 1, s, s}},
        {"view.diffuse", LF_F16, 5, {crops, l, 3, s, s}},
        {"view.glossy", LF_F16, 5, {crops, l, 3, s, s}},
        {"view.bounce", LF_F16, 5, {crops, l, 3, s, s}},
        {"view.diffuse_reached", LF_F16, 5, {crops, l, 1, s, s}},
        {"view.glossy_reached", LF_F16, 5, {crops, l, 1, s, s}},
    };
    for (size_t i = 0; i < NG_COUNT(wanted); i++) {
        const struct lf_tensor *t = tensor(row, wanted[i].name);
        bool same = t && t->dtype == wanted[i].dtype && t->rank == wanted[i].rank;
        for (uint32_t k = 0; same && k < t->rank; k++)
            same = wanted[i].shape[k] == t->shape[k] || wanted[i].shape[k] == any;
        if (!same)
            return false;
    }
    return true;
}

static ng_result draw_sample(struct sheet *sheet, struct row *row, uint32_t *line, uint32_t rows)
{
    const struct lf_tensor *lights = tensor(row, "light.share"), *target = tensor(row, "target.indirect");
    row->lights = lights && lights->rank ? (size_t)lights->shape[0] : 0;
    uint64_t crops = target && target->rank == 4 ? target->shape[0] : 0;
    if (!has_shapes(row, crops)) {
        ng_log_error("sample %" PRIu64 " of the data set lacks tensors; make it again", row->seed);
        return NG_ERROR_FORMAT;
    }
    for (row->crop = 0; row->crop < crops && *line < rows; row->crop++)
        draw_row(sheet, row, (*line)++);
    return NG_OK;
}

static ng_result draw_shards(struct sheet *sheet, const char *directory, const struct lf_manifest *m,
                             uint32_t side, uint32_t rows, uint32_t *line)
{
    for (size_t i = 0; i < m->shards.count && *line < rows; i++) {
        struct lf_tensors tensors;
        NG_TRY(lf_shard_read(directory, &m->settings, &m->shards.items[i], &tensors));
        struct row row = {.tensors = &tensors, .side = side};
        ng_result result = NG_OK;
        for (uint32_t k = 0; result == NG_OK && k < m->shards.items[i].samples && *line < rows; k++) {
            row.seed = m->shards.items[i].first_seed + k;
            result = draw_sample(sheet, &row, line, rows);
        }
        lf_tensors_finish(&tensors);
        NG_TRY(result);
    }
    return NG_OK;
}

// Cuts off the columns of lights that no sample has.
static void trim(struct sheet *sheet)
{
    uint32_t width = sheet->used < sheet->width ? sheet->used : sheet->width;
    for (size_t y = 0; y < sheet->height; y++)
        memmove(sheet->rgb + y * width * 3, sheet->rgb + y * sheet->width * 3, (size_t)width * 3);
    sheet->width = width;
}

static uint32_t crop_side(const struct lf_manifest *m)
{
    for (int i = 0; i < LF_SETTING_COUNT; i++)
        if (strcmp(m->settings.items[i].key, "crop") == 0)
            return (uint32_t)strtoul(m->settings.items[i].value, NULL, 10);
    return 0;
}

static ng_result draw_sheet(const char *directory, const char *path, const struct lf_manifest *m,
                            uint32_t rows)
{
    uint32_t tiles = NG_COUNT(crop_tiles) + MAX_LIGHTS * NG_COUNT(light_tiles), side = crop_side(m), line = 0;
    uint64_t width = (uint64_t)tiles * (side + GAP) + GAP, height = (uint64_t)rows * (side + GAP) + GAP;
    if (!side || height > MAX_WIDTH) {
        ng_log_error("%s: %u crops of %u pixels do not fit into a picture", path, rows, side);
        return NG_ERROR_FORMAT;
    }
    struct sheet sheet = {.width = width < MAX_WIDTH ? (uint32_t)width : MAX_WIDTH,
                          .height = (uint32_t)height};
    sheet.rgb = calloc((size_t)sheet.width * 3, sheet.height);
    if (!sheet.rgb) {
        ng_log_error("%s: out of memory for %u x %u pixels", path, sheet.width, sheet.height);
        return NG_ERROR_MEMORY;
    }
    ng_result result = draw_shards(&sheet, directory, m, side, rows, &line);
    if (result == NG_OK && line == 0) {
        ng_log_error("%s: the data set has no samples to show", directory);
        result = NG_ERROR_NOT_FOUND;
    }
    trim(&sheet);
    struct ng_png_params png = {
        .width = sheet.width, .height = line * (side + GAP) + GAP, .channels = 3, .pixels = sheet.rgb};
    if (result == NG_OK)
        result = ng_png_write(path, &png);
    free(sheet.rgb);
    return result;
}

ng_result lf_dataset_contact_sheet(const char *directory, const char *path, uint32_t rows)
{
    struct lf_manifest manifest;
    ng_result result = lf_manifest_read(directory, &manifest);
    if (result == NG_ERROR_NOT_FOUND)
        ng_log_error("%s: no data set is here (there is no manifest.json)", directory);
    NG_TRY(result);
    result = draw_sheet(directory, path, &manifest, rows ? rows : ROWS);
    lf_manifest_finish(&manifest);
    return result;
}

// Importance tables. A density over a grid is kept as cumulative sums only: the probability of a cell is a
// difference of two of them, so that sampling and density agree to the last bit.
//
// A texel's weight is the exact mean, over the texel, of the bilinear surface that lookups see: by each axis
// (1 6 1) / 8 of the texel and its neighbours. So nothing that a lookup can return has zero density.
#include "light/light_internal.h"

#include "base/log.h"

#include <stdlib.h>

#define MAX_CELLS 1024u

ng_result ng_light_reserve(void **items, size_t *capacity, size_t count, size_t size)
{
    if (count <= *capacity)
        return NG_OK;
    void *grown = count > SIZE_MAX / size ? NULL : realloc(*items, count * size);
    if (!grown) {
        ng_log_error("light: out of memory for %zu importance cells", count);
        return NG_ERROR_MEMORY;
    }
    *items = grown;
    *capacity = count;
    return NG_OK;
}

// Cumulative sums of `count` weights, ending at exactly 1; all zero weights give a uniform row. Returns the
// sum.
static double accumulate(const float *weights, uint32_t count, float *out)
{
    double sum = 0, run = 0;
    for (uint32_t i = 0; i < count; i++)
        sum += (double)weights[i];
    out[0] = 0;
    for (uint32_t i = 0; i < count; i++) {
        run += sum > 0 ? (double)weights[i] / sum : 1.0 / count;
        out[i + 1] = (float)fmin(run, 1.0);
    }
    // Trailing cells without weight must stay empty, so everything that reached the end becomes 1.
    float last = out[count];
    for (uint32_t i = count; i > 0 && out[i] == last; i--)
        out[i] = 1;
    return sum;
}

ng_result ng_light_grid_build(struct ng_light_tables *t, uint32_t width, uint32_t height,
                              const float *weights)
{
    struct ng_light_grid *g = &t->grid;
    t->dark = true;
    size_t row = (size_t)width + 1;
    NG_TRY(ng_light_reserve((void **)&g->cells, &g->cell_capacity, row * height, sizeof(float)));
    NG_TRY(ng_light_reserve((void **)&g->rows, &g->row_capacity, 2 * (size_t)height + 1, sizeof(float)));
    g->width = width;
    g->height = height;
    float *row_weights = g->rows + height + 1;
    for (uint32_t y = 0; y < height; y++)
        row_weights[y] = (float)accumulate(weights + (size_t)y * width, width, g->cells + y * row);
    double sum = accumulate(row_weights, height, g->rows);
    t->dark = !(sum > 0) || !isfinite(sum);
    return NG_OK;
}

// The last i with cumulative[i] <= u, whose interval is never empty. u becomes the place in the interval.
static uint32_t pick(const float *cumulative, uint32_t count, float *u)
{
    if (count == 1)
        return 0;
    uint32_t low = 0, high = count; // cumulative[low] <= u < cumulative[high]
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (cumulative[middle] <= *u)
            low = middle;
        else
            high = middle;
    }
    float place = (*u - cumulative[low]) / (cumulative[low + 1] - cumulative[low]);
    *u = fminf(fmaxf(place, 0.0f), 0x1.fffffep-1f);
    return low;
}

void ng_light_grid_sample(const struct ng_light_grid *g, float u[2], uint32_t cell[2])
{
    cell[1] = pick(g->rows, g->height, &u[1]);
    cell[0] = pick(g->cells + (size_t)cell[1] * (g->width + 1), g->width, &u[0]);
}

float ng_light_grid_probability(const struct ng_light_grid *g, uint32_t x, uint32_t y)
{
    const float *row = g->cells + (size_t)y * (g->width + 1);
    return (g->rows[y + 1] - g->rows[y]) * (row[x + 1] - row[x]);
}

// ---- texels ----------------------------------------------------------------------------------------------
static uint32_t wrap(int64_t i, uint32_t size, enum ng_light_wrap mode)
{
    int64_t period = mode == NG_LIGHT_WRAP_MIRROR ? 2 * (int64_t)size : size;
    if (mode == NG_LIGHT_WRAP_CLAMP)
        return (uint32_t)(i < 0 ? 0 : i >= size ? size - 1 : i);
    int64_t r = i % period;
    r = r < 0 ? r + period : r;
    return (uint32_t)(r < size ? r : period - 1 - r);
}

// A coordinate within the picture (or it and its mirror image), so that large ones keep their fraction.
static float wrap_coordinate(float t, enum ng_light_wrap mode)
{
    if (mode == NG_LIGHT_WRAP_CLAMP)
        return fminf(fmaxf(t, 0.0f), 1.0f);
    return mode == NG_LIGHT_WRAP_MIRROR ? 2 * (t * 0.5f - floorf(t * 0.5f)) : t - floorf(t);
}

static void fetch(const struct ng_light_tables *t, const struct ng_light_image *image, uint32_t x, uint32_t y,
                  float rgb[3])
{
    size_t at = ((size_t)y * image->width + x) * 4;
    for (int i = 0; i < 3; i++) {
        float value;
        if (image->format == NG_LIGHT_TEXEL_FLOAT32)
            value = ((const float *)image->pixels)[at + (size_t)i];
        else if (image->format == NG_LIGHT_TEXEL_SRGB8)
            value = t->srgb[((const unsigned char *)image->pixels)[at + (size_t)i]];
        else
            value = (float)((const unsigned char *)image->pixels)[at + (size_t)i] / 255.0f;
        // A map may hold infinities (a clipped sun) and NaNs; neither may reach an integral.
        rgb[i] = value > 0 ? fminf(value, 1e18f) : 0;
    }
}

void ng_light_texel(const struct ng_light_tables *t, const struct ng_light_image *image, float u, float v,
                    float rgb[3])
{
    rgb[0] = rgb[1] = rgb[2] = 1;
    if (!image->width || !image->height || !isfinite(u) || !isfinite(v))
        return;
    float x = wrap_coordinate(u, image->wrap_u) * (float)image->width - 0.5f;
    float y = wrap_coordinate(v, image->wrap_v) * (float)image->height - 0.5f;
    float x0 = floorf(x), y0 = floorf(y), fx = x - x0, fy = y - y0;
    if (image->nearest) {
        fx = fx < 0.5f ? 0.0f : 1.0f;
        fy = fy < 0.5f ? 0.0f : 1.0f;
    }
    float sum[3] = {0};
    for (int j = 0; j < 2; j++)
        for (int i = 0; i < 2; i++) {
            float texel[3], weight = (i ? fx : 1 - fx) * (j ? fy : 1 - fy);
            fetch(t, image, wrap((int64_t)x0 + i, image->width, image->wrap_u),
                  wrap((int64_t)y0 + j, image->height, image->wrap_v), texel);
            ng_light_mad(sum, texel, weight, sum);
        }
    memcpy(rgb, sum, sizeof sum);
}

// One row of texels, blurred along x.
static void blur_row(const struct ng_light_tables *t, const struct ng_light_image *image, int64_t y,
                     float *out)
{
    uint32_t row = wrap(y, image->height, image->wrap_v);
    float before[3], here[3], after[3];
    fetch(t, image, wrap(-1, image->width, image->wrap_u), row, before);
    fetch(t, image, 0, row, here);
    for (uint32_t x = 0; x < image->width; x++) {
        fetch(t, image, wrap((int64_t)x + 1, image->width, image->wrap_u), row, after);
        for (int i = 0; i < 3; i++) {
            out[x * 3 + (uint32_t)i] = (before[i] + 6 * here[i] + after[i]) / 8;
            before[i] = here[i];
            here[i] = after[i];
        }
    }
}

static uint32_t cells_along(uint32_t texels, uint32_t block)
{
    return (texels + block - 1) / block;
}

ng_result ng_light_grid_from_image(struct ng_light_tables *t, const struct ng_light_image *image,
                                   const struct ng_light_image_walk *walk)
{
    uint32_t w = image->width, h = image->height;
    if (!w || !h) {
        t->block = 1;
        float measure = walk->measure(&(struct ng_light_image){.width = 1, .height = 1}, 0);
        walk->visit(walk->user, 0, 0, measure, (const float[3]){1, 1, 1});
        return ng_light_grid_build(t, 1, 1, &measure);
    }
    uint32_t largest = w > h ? w : h;
    t->block = cells_along(largest, MAX_CELLS);
    uint32_t grid_w = cells_along(w, t->block), grid_h = cells_along(h, t->block);
    size_t cells = (size_t)grid_w * grid_h, row = (size_t)w * 3;
    NG_TRY(ng_light_reserve((void **)&t->weights, &t->weight_capacity, cells + 3 * row, sizeof(float)));
    memset(t->weights, 0, cells * sizeof(float));
    float *rows[3];
    for (uint32_t i = 0; i < 3; i++) {
        rows[i] = t->weights + cells + i * row;
        blur_row(t, image, (int64_t)i - 1, rows[i]);
    }
    for (uint32_t y = 0; y < h; y++) {
        float measure = walk->measure(image, y);
        for (uint32_t x = 0; x < w; x++) {
            float rgb[3];
            for (uint32_t i = 0; i < 3; i++)
                rgb[i] = (rows[0][x * 3 + i] + 6 * rows[1][x * 3 + i] + rows[2][x * 3 + i]) / 8;
            t->weights[(size_t)(y / t->block) * grid_w + x / t->block] += ng_light_mean(rgb) * measure;
            walk->visit(walk->user, x, y, measure, rgb);
        }
        float *oldest = rows[0];
        rows[0] = rows[1];
        rows[1] = rows[2];
        rows[2] = oldest;
        blur_row(t, image, (int64_t)y + 2, rows[2]);
    }
    return ng_light_grid_build(t, grid_w, grid_h, t->weights);
}

static uint32_t texels_along(uint32_t texels)
{
    return texels ? texels : 1;
}

void ng_light_cell_bounds(const struct ng_light_tables *t, const struct ng_light_image *image, uint32_t x,
                          uint32_t y, float low[2], float high[2])
{
    uint32_t cell[2] = {x, y}, size[2] = {texels_along(image->width), texels_along(image->height)};
    for (int i = 0; i < 2; i++) {
        low[i] = 0;
        high[i] = 1;
        if (size[i] == 1) // most lights have no texture
            continue;
        uint32_t begin = cell[i] * t->block, end = begin + t->block;
        low[i] = (float)begin / (float)size[i];
        high[i] = (float)(end < size[i] ? end : size[i]) / (float)size[i];
    }
}

void ng_light_cell_at(const struct ng_light_tables *t, const struct ng_light_image *image, float u, float v,
                      uint32_t cell[2])
{
    float place[2] = {u, v};
    uint32_t size[2] = {texels_along(image->width), texels_along(image->height)};
    for (int i = 0; i < 2; i++) {
        float texel = fminf(fmaxf(place[i], 0.0f), 1.0f) * (float)size[i];
        uint32_t at = (uint32_t)texel;
        cell[i] = (at < size[i] ? at : size[i] - 1) / t->block;
    }
}

void ng_light_center(const struct ng_light_tables *t, const float tint[3], float out[3])
{
    float sum[3] = {0}, weight = 0;
    for (int channel = 0; channel < 3; channel++) {
        ng_light_mad(sum, t->moments[channel], tint[channel], sum);
        weight += tint[channel] * t->integral[channel];
    }
    ng_light_scaled(sum, weight > 0 ? 1.0f / weight : 0, out);
}

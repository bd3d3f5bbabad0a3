#include "lightformer/trace/texture.h"

#include "asset/assets.h"
#include "asset/image.h"
#include "shaders/shared/tonemap.h"

#include <math.h>
#include <stdbool.h>

void lf_srgb_make(struct lf_srgb *table)
{
    for (int i = 0; i < 256; i++)
        table->linear[i] = ng_srgb_decode((float)i / 255.0f);
}

// One level of an image.
struct level {
    const struct ng_image *image;
    const void *pixels;
    uint32_t width, height;
};

static struct level level_of(const struct ng_image *image, uint32_t index)
{
    struct level l = {.image = image};
    l.pixels = ng_image_level(image, index, &l.width, &l.height);
    return l;
}

static void fetch(const struct lf_srgb *srgb, const struct level *l, uint32_t x, uint32_t y, float rgba[4])
{
    size_t at = ((size_t)y * l->width + x) * 4;
    const unsigned char *bytes = l->pixels;
    const float *floats = l->pixels;
    for (size_t i = 0; i < 4; i++) {
        if (l->image->format == NG_PIXEL_RGBA32F)
            rgba[i] = floats[at + i];
        else if (l->image->format == NG_PIXEL_RGBA8_SRGB && i < 3)
            rgba[i] = srgb->linear[bytes[at + i]];
        else
            rgba[i] = (float)bytes[at + i] / 255.0f;
    }
}

static uint32_t wrap(int64_t i, uint32_t size, enum ng_wrap mode)
{
    int64_t period = mode == NG_WRAP_MIRROR ? 2 * (int64_t)size : size;
    if (mode == NG_WRAP_CLAMP)
        return (uint32_t)(i < 0 ? 0 : i >= size ? size - 1 : i);
    i = i < 0 ? i + period : i >= period ? i - period : i; // coordinates have been wrapped
    return (uint32_t)(i < size ? i : period - 1 - i);
}

// The two texels around a coordinate along one axis, and the weight of the second.
static float neighbours(float t, uint32_t size, enum ng_wrap mode, enum ng_filter filter, uint32_t out[2])
{
    // Wrapped first, so that large coordinates keep their fraction.
    if (mode == NG_WRAP_CLAMP)
        t = fminf(fmaxf(t, 0.0f), 1.0f);
    else
        t = mode == NG_WRAP_MIRROR ? 2 * (t * 0.5f - floorf(t * 0.5f)) : t - floorf(t);
    float x = t * (float)size - (filter == NG_FILTER_NEAREST ? 0.0f : 0.5f), low = floorf(x);
    out[0] = wrap((int64_t)low, size, mode);
    out[1] = wrap((int64_t)low + 1, size, mode);
    return filter == NG_FILTER_NEAREST ? 0 : x - low;
}

static void filter_level(const struct lf_srgb *srgb, const struct level *l, enum ng_filter filter,
                         const float uv[2], float rgba[4])
{
    uint32_t x[2], y[2];
    const struct ng_sampling *s = &l->image->sampling;
    float fx = neighbours(uv[0], l->width, s->wrap_u, filter, x);
    float fy = neighbours(uv[1], l->height, s->wrap_v, filter, y);
    for (int i = 0; i < 4; i++)
        rgba[i] = 0;
    for (int j = 0; j < 2; j++)
        for (int i = 0; i < 2; i++) {
            float texel[4], weight = (i ? fx : 1 - fx) * (j ? fy : 1 - fy);
            fetch(srgb, l, x[i], y[j], texel);
            for (int c = 0; c < 4; c++)
                rgba[c] += weight * texel[c];
        }
}

// White without an image, black where there is no place. False: that is all.
static bool begin(const struct ng_image *image, const float uv[2], float rgba[4])
{
    for (int i = 0; i < 4; i++)
        rgba[i] = image ? 0 : 1;
    return image && isfinite(uv[0]) && isfinite(uv[1]);
}

void lf_texture_at(const struct lf_srgb *srgb, const struct ng_image *image, const float uv[2], float rgba[4])
{
    if (!begin(image, uv, rgba))
        return;
    const struct level l = level_of(image, 0);
    filter_level(srgb, &l, image->sampling.magnify, uv, rgba);
}

// Of texels that a step of a pixel passes; negative where they are larger than pixels.
static float find_level(const struct ng_image *image, const float dx[2], const float dy[2])
{
    float width = (float)image->width, height = (float)image->height;
    float x = dx[0] * width, y = dx[1] * height, right = x * x + y * y;
    x = dy[0] * width, y = dy[1] * height;
    float down = x * x + y * y, square = right > down ? right : down;
    return square > 0 && isfinite(square) ? 0.5f * log2f(square) : -1;
}

float lf_texture_seen(const struct lf_srgb *srgb, const struct ng_image *image, const float uv[2],
                      const float dx[2], const float dy[2], float rgba[4])
{
    if (!begin(image, uv, rgba))
        return 0;
    const struct ng_sampling *s = &image->sampling;
    float level = find_level(image, dx, dy), smallest = image->levels ? (float)(image->levels - 1) : 0;
    enum ng_filter filter = level > 0 ? s->minify : s->magnify;
    level = level < 0 || s->mips == NG_MIP_NONE ? 0 : level < smallest ? level : smallest;
    if (s->mips == NG_MIP_NEAREST)
        level = ceilf(level + 0.5f) - 1;
    float whole = floorf(level), part = level - whole, next[4];
    struct level l = level_of(image, (uint32_t)whole);
    filter_level(srgb, &l, filter, uv, rgba);
    if (!(part > 0))
        return level;
    l = level_of(image, (uint32_t)whole + 1);
    filter_level(srgb, &l, filter, uv, next);
    for (int i = 0; i < 4; i++)
        rgba[i] += part * (next[i] - rgba[i]);
    return level;
}

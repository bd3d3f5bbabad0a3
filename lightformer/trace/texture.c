#include "lightformer/trace/texture.h"

#include "asset/assets.h"
#include "shaders/shared/tonemap.h"

#include <math.h>
#include <stdbool.h>

void lf_srgb_make(struct lf_srgb *table)
{
    for (int i = 0; i < 256; i++)
        table->linear[i] = ng_srgb_decode((float)i / 255.0f);
}

static void fetch(const struct lf_srgb *srgb, const struct ng_image *image, uint32_t x, uint32_t y,
                  float rgba[4])
{
    size_t at = ((size_t)y * image->width + x) * 4;
    const unsigned char *bytes = image->pixels;
    const float *floats = image->pixels;
    for (size_t i = 0; i < 4; i++) {
        if (image->format == NG_PIXEL_RGBA32F)
            rgba[i] = floats[at + i];
        else if (image->format == NG_PIXEL_RGBA8_SRGB && i < 3)
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

void lf_texture_at(const struct lf_srgb *srgb, const struct ng_image *image, const float uv[2], float rgba[4])
{
    for (int i = 0; i < 4; i++)
        rgba[i] = image ? 0 : 1;
    if (!image || !isfinite(uv[0]) || !isfinite(uv[1]))
        return;
    uint32_t x[2], y[2];
    const struct ng_sampling *s = &image->sampling;
    float fx = neighbours(uv[0], image->width, s->wrap_u, s->magnify, x);
    float fy = neighbours(uv[1], image->height, s->wrap_v, s->magnify, y);
    for (int j = 0; j < 2; j++)
        for (int i = 0; i < 2; i++) {
            float texel[4], weight = (i ? fx : 1 - fx) * (j ? fy : 1 - fy);
            fetch(srgb, image, x[i], y[j], texel);
            for (int c = 0; c < 4; c++)
                rgba[c] += weight * texel[c];
        }
}

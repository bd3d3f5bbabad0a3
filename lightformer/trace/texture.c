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

// The two texels around a coordinate along one axis, and the weight of the second.
static float neighbours(float t, uint32_t size, bool repeat, uint32_t out[2])
{
    // Wrapped first, so that large coordinates keep their fraction.
    t = repeat ? t - floorf(t) : fminf(fmaxf(t, 0.0f), 1.0f);
    float x = t * (float)size - 0.5f, low = floorf(x);
    int64_t first = (int64_t)low, last = (int64_t)size - 1;
    int64_t a = first, b = first + 1;
    if (repeat) {
        a = a < 0 ? last : a;
        b = b > last ? 0 : b;
    } else {
        a = a < 0 ? 0 : a;
        b = b > last ? last : b;
    }
    out[0] = (uint32_t)(a > last ? last : a);
    out[1] = (uint32_t)b;
    return x - low;
}

void lf_texture_at(const struct lf_srgb *srgb, const struct ng_image *image, const float uv[2], float rgba[4])
{
    for (int i = 0; i < 4; i++)
        rgba[i] = image ? 0 : 1;
    if (!image || !isfinite(uv[0]) || !isfinite(uv[1]))
        return;
    uint32_t x[2], y[2];
    float fx = neighbours(uv[0], image->width, image->repeat_u, x);
    float fy = neighbours(uv[1], image->height, image->repeat_v, y);
    for (int j = 0; j < 2; j++)
        for (int i = 0; i < 2; i++) {
            float texel[4], weight = (i ? fx : 1 - fx) * (j ? fy : 1 - fy);
            fetch(srgb, image, x[i], y[j], texel);
            for (int c = 0; c < 4; c++)
                rgba[c] += weight * texel[c];
        }
}

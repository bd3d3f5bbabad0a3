// The project's tone map, for the screen, for PNG files and for metrics on HDR images: Khronos PBR Neutral
// (Khronos 2024), which keeps hues and leaves everything but highlights nearly as it is; then the sRGB curve.
//
// Included by C and GLSL. Channels one at a time, so that both read the same text.
#ifndef NG_SHARED_TONEMAP_H
#define NG_SHARED_TONEMAP_H

#ifdef GL_core_profile
#define NG_TONEMAP_FN   float
#define ng_tonemap_pow_ pow
#else
#include <math.h>
#define NG_TONEMAP_FN   static inline float
#define ng_tonemap_pow_ powf
#endif

// One channel of a linear colour (exposure applied, not negative); `peak` and `toe` are the largest and the
// smallest of the three channels. Without branches, so that C compilers take many at once.
NG_TONEMAP_FN ng_tonemap(float x, float peak, float toe)
{
    const float start = 0.8f - 0.04f, desaturation = 0.15f;
    float offset = toe < 0.08f ? toe - 6.25f * toe * toe : 0.04f;
    x -= offset;
    float bright = peak - offset < start ? start : peak - offset;
    float d = 1.0f - start;
    float compressed = 1.0f - d * d / (bright + d - start);
    float scaled = x * (compressed / bright);
    float g = 1.0f - 1.0f / (desaturation * (bright - compressed) + 1.0f);
    return peak - offset < start ? x : scaled * (1.0f - g) + compressed * g;
}

// Linear 0..1 to sRGB 0..1 (IEC 61966-2-1).
NG_TONEMAP_FN ng_srgb_encode(float x)
{
    x = x < 0.0f ? 0.0f : x > 1.0f ? 1.0f : x;
    return x <= 0.0031308f ? 12.92f * x : 1.055f * ng_tonemap_pow_(x, 1.0f / 2.4f) - 0.055f;
}

NG_TONEMAP_FN ng_srgb_decode(float x)
{
    return x <= 0.04045f ? x / 12.92f : ng_tonemap_pow_((x + 0.055f) / 1.055f, 2.4f);
}

#endif

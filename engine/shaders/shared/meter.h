// The light meter: from how bright the pixels of a picture are to its exposure. One text for the shaders and
// for the path tracer's pictures on the host.
//
// Pixels that some light reaches are counted by the logarithm of their luminance. The brighter half counts,
// but not its brightest few, which are lamps and highlights: their mean becomes NG_METER_KEY.
//
// Direct light and emission count, which every method has, so that all of them show a scene alike. Where
// nearly all light is indirect that would be white: so the whole picture may be brighter by a stop than the
// key, and no more.
#ifndef NG_SHARED_METER_H
#define NG_SHARED_METER_H

#ifdef GL_core_profile
#define NG_METER_FN    float
#define ng_meter_log2_ log2
#define ng_meter_exp2_ exp2
#else
#include <math.h>
#define NG_METER_FN    static inline float
#define ng_meter_log2_ log2f
#define ng_meter_exp2_ exp2f
#endif

#define NG_METER_BINS 1024
#define NG_METER_LAST 1023.0f
#define NG_METER_LOW  -28.0f // log2 of the luminance of the first bin
#define NG_METER_STOP 16.0f  // bins a stop
#define NG_METER_KEY  0.36f
#define NG_METER_OVER 2.0f // times the key, to which the whole picture may be exposed at most

NG_METER_FN ng_meter_luminance(float r, float g, float b)
{
    return 0.2126f * r + 0.7152f * g + 0.0722f * b;
}

// The bin of a luminance above 0; its whole part is the index.
NG_METER_FN ng_meter_bin(float luminance)
{
    float bin = (ng_meter_log2_(luminance) - NG_METER_LOW) * NG_METER_STOP;
    return bin < 0.0f ? 0.0f : bin > NG_METER_LAST ? NG_METER_LAST : bin;
}

// How many of `count` pixels of a bin count, if `before` of `total` are darker.
NG_METER_FN ng_meter_share(float before, float count, float total)
{
    float low = 0.5f * total, high = 0.95f * total;
    low = before > low ? before : low;
    high = before + count < high ? before + count : high;
    return high > low ? high - low : 0.0f;
}

// The exposure from the sum over bins of share * index and that of the shares alone; 0 for a picture in the
// dark.
NG_METER_FN ng_meter_exposure(float sum, float shares)
{
    if (!(shares > 0.0f))
        return 0.0f;
    return NG_METER_KEY / ng_meter_exp2_((sum / shares + 0.5f) / NG_METER_STOP + NG_METER_LOW);
}

// The exposure of a picture, from those of its direct light and of all its light; 1 in the dark.
NG_METER_FN ng_meter_both(float direct, float whole)
{
    float most = NG_METER_OVER * whole;
    if (!(whole > 0.0f))
        return direct > 0.0f ? direct : 1.0f;
    return direct > 0.0f && direct < most ? direct : direct > 0.0f ? most : whole;
}

#endif

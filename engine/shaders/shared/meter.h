// The light meter: from how bright the pixels of a picture are to its exposure. One text for the shaders and
// for the path tracer's pictures on the host.
//
// Pixels that some light reaches are counted by the logarithm of their luminance. The brighter half counts,
// but not its brightest few, which are lamps and highlights: their mean becomes NG_METER_KEY.
//
// Surfaces count, and not the sky that is seen behind them: a small thing is exposed as it would be in front
// of nothing. Where there is hardly anything but sky, it counts as well. What is unlit is shown as it is, so
// it says nothing.
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
#define NG_METER_OVER 2.0f  // times the key, to which the whole picture may be exposed at most
#define NG_METER_SEEN 0.02f // share of surfaces in a picture from which on its sky does not count

// What is counted apart, each in NG_METER_BINS.
#define NG_METER_DIRECT 0 // direct light and emission of surfaces
#define NG_METER_WHOLE  1 // all their light
#define NG_METER_SKY    2 // an environment where no surface is seen
#define NG_METER_COUNTS 3

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

// The exposure of surfaces, from those of their direct light and of all their light; 0 in the dark.
NG_METER_FN ng_meter_both(float direct, float whole)
{
    float most = NG_METER_OVER * whole;
    if (!(whole > 0.0f))
        return direct;
    return direct > 0.0f && direct < most ? direct : direct > 0.0f ? most : whole;
}

// The exposure of a picture, from those of its surfaces, which are `share` of what is lit in it, and of its
// sky; 1 in the dark.
NG_METER_FN ng_meter_picture(float surfaces, float sky, float share)
{
    float part = share < NG_METER_SEEN ? share / NG_METER_SEEN : 1.0f;
    if (!(sky > 0.0f))
        return surfaces > 0.0f ? surfaces : 1.0f;
    if (!(surfaces > 0.0f))
        return sky;
    return ng_meter_exp2_(part * ng_meter_log2_(surfaces) + (1.0f - part) * ng_meter_log2_(sky));
}

#endif

// The exposure that the counts ask for (shared/meter.h), or a part of the way there from the last frame's.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/meter.h"

layout(local_size_x = 1) in;

layout(set = 0, binding = 0) readonly buffer Counts { uint counts[NG_METER_COUNTS * NG_METER_BINS]; };
layout(set = 0, binding = 1) readonly buffer Before { float before_exposure, before_found; };
layout(set = 0, binding = 2) writeonly buffer After { float exposure, found; };
layout(set = 0, binding = 3) readonly buffer Params {
    float factor;     // on what the meter says
    float adaptation; // part of the way, in stops; 1: all of it
    float keeps;      // 1: what was found in the last frame is true still; 0: the counts say it
};

float total_of(int which)
{
    float total = 0;
    for (int i = 0; i < NG_METER_BINS; i++)
        total += float(counts[which * NG_METER_BINS + i]);
    return total;
}

float exposure_of(int which)
{
    const int first = which * NG_METER_BINS;
    const float total = total_of(which);
    float before = 0, sum = 0, shares = 0;
    for (int i = 0; i < NG_METER_BINS; i++) {
        float count = float(counts[first + i]), share = ng_meter_share(before, count, total);
        before += count;
        shares += share;
        sum += share * float(i);
    }
    return ng_meter_exposure(sum, shares);
}

void main()
{
    const float surfaces = total_of(NG_METER_WHOLE), sky = total_of(NG_METER_SKY);
    const float counted = ng_meter_picture(ng_meter_both(exposure_of(NG_METER_DIRECT), exposure_of(NG_METER_WHOLE)),
                                           exposure_of(NG_METER_SKY), surfaces / max(surfaces + sky, 1));
    const float meter = keeps > 0 ? before_found : counted;
    const float wanted = factor * meter;
    found = meter;
    exposure = adaptation < 1 && before_exposure > 0 && wanted > 0
                   ? before_exposure * exp2(adaptation * log2(wanted / before_exposure))
                   : wanted;
}

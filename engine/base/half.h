// IEEE 754 binary16 ("half") to and from single precision, in integer operations and without branches on the
// usual path, so that loops over pictures vectorise. The same on every machine, whatever it does with
// subnormal singles.
#ifndef NG_BASE_HALF_H
#define NG_BASE_HALF_H

#include <stdint.h>
#include <string.h>

static inline uint32_t ng_float_bits(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static inline float ng_float_of_bits(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

// Rounds to nearest, ties to even. 65520 and above become infinite; a NaN stays one, its payload is lost.
static inline uint16_t ng_half_from_float(float value)
{
    uint32_t bits = ng_float_bits(value), sign = bits >> 16 & 0x8000u, magnitude = bits & 0x7fffffffu, half;
    if (magnitude >= 0x47800000u) // 65536
        half = magnitude > 0x7f800000u ? 0x7e00u : 0x7c00u;
    else if (magnitude < 0x38800000u) // 2^-14: below, one step of a half is one step of a single at 0.5
        half = ng_float_bits(ng_float_of_bits(magnitude) + 0.5f) - 0x3f000000u;
    else // the exponent's bias falls from 127 to 15; a carry out of the mantissa moves the exponent
        half = (magnitude - (112u << 23) + 0xfffu + (magnitude >> 13 & 1u)) >> 13;
    return (uint16_t)(sign | half);
}

// Exact; a NaN keeps its payload.
static inline float ng_half_to_float(uint16_t half)
{
    uint32_t magnitude = (half & 0x7fffu) << 13, bits = magnitude + (112u << 23);
    if (magnitude >= 0x0f800000u) // infinite or NaN
        bits = magnitude + (224u << 23);
    else if (magnitude < 0x00800000u) // subnormal: a mantissa that counts in 2^-24
        bits = ng_float_bits(ng_float_of_bits(magnitude + (113u << 23)) - 0x1p-14f);
    return ng_float_of_bits(bits | (half & 0x8000u) << 16);
}

#endif

// The random numbers of a path.
//
// LF_SAMPLER_SOBOL: points of Sobol's first two dimensions, Owen-scrambled and shuffled anew for every draw
// (padded), so that any number of samples of a pixel is spread evenly in each draw. Source: Burley,
// "Practical Hash-based Owen Scrambling", 2020; hash of Laine and Karras, 2011. LF_SAMPLER_INDEPENDENT:
// uncorrelated.
//
// Numbers follow from seed, pixel, sample and the order of draws alone, and lie in [0, 1). All is inline
// arithmetic, so that loops over the samplers of many paths vectorise.
#ifndef LF_REFERENCE_SAMPLER_H
#define LF_REFERENCE_SAMPLER_H

#include "base/extern_c.h"
#include "base/rng.h"

NG_EXTERN_C_BEGIN

enum lf_sampler_kind { LF_SAMPLER_SOBOL, LF_SAMPLER_INDEPENDENT };

struct lf_sampler {
    enum lf_sampler_kind kind;
    uint64_t pixel;    // hash of seed and pixel
    uint32_t reversed; // index of the sample, its bits in reverse
    uint32_t draw;     // so far
    struct ng_rng rng;
};

struct lf_sampler lf_sampler_start(enum lf_sampler_kind kind, uint64_t seed, uint32_t x, uint32_t y,
                                   uint32_t sample);
float lf_sampler_1d(struct lf_sampler *s);
void lf_sampler_2d(struct lf_sampler *s, float u[2]);

static inline uint32_t lf_reverse_bits(uint32_t x)
{
    x = x >> 24 | (x >> 8 & 0xff00u) | (x & 0xff00u) << 8 | x << 24;
    x = (x & 0xf0f0f0f0u) >> 4 | (x & 0x0f0f0f0fu) << 4;
    x = (x & 0xccccccccu) >> 2 | (x & 0x33333333u) << 2;
    return (x & 0xaaaaaaaau) >> 1 | (x & 0x55555555u) << 1;
}

// Each bit is flipped by a hash of the bits below it. Owen's nested uniform scramble, which flips by the bits
// above, is this between two reversals; the points below are made reversed, so that one of the two drops out.
static inline uint32_t lf_hash_upwards(uint32_t x, uint32_t seed)
{
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return x;
}

// Sobol's second dimension before reversal: Pascal's triangle modulo 2 times the index. The triangle of size
// 2n is [T T; 0 T] of those of size n, hence five steps.
static inline uint32_t lf_pascal(uint32_t x)
{
    x ^= (x & 0xaaaaaaaau) >> 1;
    x ^= (x & 0xccccccccu) >> 2;
    x ^= (x & 0xf0f0f0f0u) >> 4;
    x ^= (x & 0xff00ff00u) >> 8;
    x ^= (x & 0xffff0000u) >> 16;
    return x;
}

static inline float lf_unit_float(uint32_t x)
{
    return (float)(int32_t)(x >> 8) * 0x1p-24f; // signed: what processors convert at once
}

// The point of a draw's shuffle that the sample takes; `seeds` scrambles its two coordinates.
static inline uint32_t lf_sobol_index(uint64_t pixel, uint32_t reversed, uint32_t draw, uint64_t *seeds)
{
    uint64_t order = ng_hash_combine(pixel, draw);
    *seeds = ng_hash_u64(order);
    return lf_reverse_bits(lf_hash_upwards(reversed, (uint32_t)order));
}

static inline float lf_sobol_1d(uint64_t pixel, uint32_t reversed, uint32_t draw)
{
    uint64_t seeds;
    uint32_t index = lf_sobol_index(pixel, reversed, draw, &seeds);
    return lf_unit_float(lf_reverse_bits(lf_hash_upwards(index, (uint32_t)seeds)));
}

static inline void lf_sobol_2d(uint64_t pixel, uint32_t reversed, uint32_t draw, float *x, float *y)
{
    uint64_t seeds;
    uint32_t index = lf_sobol_index(pixel, reversed, draw, &seeds);
    *x = lf_unit_float(lf_reverse_bits(lf_hash_upwards(index, (uint32_t)seeds)));
    *y = lf_unit_float(lf_reverse_bits(lf_hash_upwards(lf_pascal(index), (uint32_t)(seeds >> 32))));
}

NG_EXTERN_C_END

#endif

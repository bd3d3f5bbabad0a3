// Random numbers that are the same on every machine: PCG32 (O'Neill 2014), 64 bits of state.
#ifndef NG_BASE_RNG_H
#define NG_BASE_RNG_H

#include "base/hash.h"

struct ng_rng {
    uint64_t state, stream;
};

static inline uint32_t ng_rng_u32(struct ng_rng *r)
{
    uint64_t old = r->state;
    r->state = old * 6364136223846793005u + (r->stream | 1u);
    uint32_t x = (uint32_t)(((old >> 18) ^ old) >> 27), rot = (uint32_t)(old >> 59);
    return (x >> rot) | (x << ((32u - rot) & 31u));
}

// Streams with different (seed, sequence) are independent.
static inline struct ng_rng ng_rng_make(uint64_t seed, uint64_t sequence)
{
    struct ng_rng r = {ng_hash_combine(seed, sequence), ng_hash_u64(sequence * 2 + 1)};
    ng_rng_u32(&r);
    return r;
}

// Uniform in [0, 1): 24 bits, so never 1.
static inline float ng_rng_float(struct ng_rng *r)
{
    return (float)(ng_rng_u32(r) >> 8) * 0x1p-24f;
}

static inline float ng_rng_range(struct ng_rng *r, float low, float high)
{
    return low + (high - low) * ng_rng_float(r);
}

// Uniform in [0, n), without modulo bias worth the name for n below 2^24 (Lemire's multiply-shift).
static inline uint32_t ng_rng_below(struct ng_rng *r, uint32_t n)
{
    return (uint32_t)(((uint64_t)ng_rng_u32(r) * n) >> 32);
}

#endif

#include "lightformer/reference/sampler.h"

static uint32_t reverse_bits(uint32_t x)
{
    x = __builtin_bswap32(x);
    x = (x & 0xf0f0f0f0u) >> 4 | (x & 0x0f0f0f0fu) << 4;
    x = (x & 0xccccccccu) >> 2 | (x & 0x33333333u) << 2;
    return (x & 0xaaaaaaaau) >> 1 | (x & 0x55555555u) << 1;
}

// Of both halves.
static uint64_t reverse_bits_of_two(uint64_t x)
{
    x = (x & 0xff00ff00ff00ff00u) >> 8 | (x & 0x00ff00ff00ff00ffu) << 8;
    x = (x & 0xffff0000ffff0000u) >> 16 | (x & 0x0000ffff0000ffffu) << 16;
    x = (x & 0xf0f0f0f0f0f0f0f0u) >> 4 | (x & 0x0f0f0f0f0f0f0f0fu) << 4;
    x = (x & 0xccccccccccccccccu) >> 2 | (x & 0x3333333333333333u) << 2;
    return (x & 0xaaaaaaaaaaaaaaaau) >> 1 | (x & 0x5555555555555555u) << 1;
}

// Each bit is flipped by a hash of the bits below it. Owen's nested uniform scramble, which flips by the bits
// above, is this between two reversals; the points below are made reversed, so that one of the two drops out.
static uint32_t hash_upwards(uint32_t x, uint32_t seed)
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
static uint32_t pascal(uint32_t x)
{
    x ^= (x & 0xaaaaaaaau) >> 1;
    x ^= (x & 0xccccccccu) >> 2;
    x ^= (x & 0xf0f0f0f0u) >> 4;
    x ^= (x & 0xff00ff00u) >> 8;
    x ^= (x & 0xffff0000u) >> 16;
    return x;
}

static float to_unit(uint32_t x)
{
    return (float)(x >> 8) * 0x1p-24f;
}

struct lf_sampler lf_sampler_start(enum lf_sampler_kind kind, uint64_t seed, uint32_t x, uint32_t y,
                                   uint32_t sample)
{
    uint64_t pixel = ng_hash_combine(ng_hash_u64(seed), (uint64_t)y << 32 | x);
    struct lf_sampler s = {.kind = kind, .pixel = pixel, .reversed = reverse_bits(sample)};
    if (kind == LF_SAMPLER_INDEPENDENT)
        s.rng = ng_rng_make(pixel, sample);
    return s;
}

// The point of this draw's shuffle that the sample takes, and the seeds that scramble its two coordinates.
static uint32_t shuffle(struct lf_sampler *s, uint64_t *seeds)
{
    uint64_t order = ng_hash_combine(s->pixel, s->draw++);
    *seeds = ng_hash_u64(order);
    return reverse_bits(hash_upwards(s->reversed, (uint32_t)order));
}

void lf_sampler_2d(struct lf_sampler *s, float u[2])
{
    if (s->kind == LF_SAMPLER_INDEPENDENT) {
        u[0] = ng_rng_float(&s->rng);
        u[1] = ng_rng_float(&s->rng);
        return;
    }
    uint64_t seeds;
    uint32_t index = shuffle(s, &seeds);
    uint64_t first = hash_upwards(index, (uint32_t)seeds);
    uint64_t second = hash_upwards(pascal(index), (uint32_t)(seeds >> 32));
    uint64_t both = reverse_bits_of_two(second << 32 | first);
    u[0] = to_unit((uint32_t)both);
    u[1] = to_unit((uint32_t)(both >> 32));
}

float lf_sampler_1d(struct lf_sampler *s)
{
    if (s->kind == LF_SAMPLER_INDEPENDENT)
        return ng_rng_float(&s->rng);
    uint64_t seeds;
    uint32_t index = shuffle(s, &seeds);
    return to_unit(reverse_bits(hash_upwards(index, (uint32_t)seeds)));
}

#include "lightformer/reference/sampler.h"

struct lf_sampler lf_sampler_start(enum lf_sampler_kind kind, uint64_t seed, uint32_t x, uint32_t y,
                                   uint32_t sample)
{
    uint64_t pixel = ng_hash_combine(ng_hash_u64(seed), (uint64_t)y << 32 | x);
    struct lf_sampler s = {.kind = kind, .pixel = pixel, .reversed = lf_reverse_bits(sample)};
    if (kind == LF_SAMPLER_INDEPENDENT)
        s.rng = ng_rng_make(pixel, sample);
    return s;
}

void lf_sampler_2d(struct lf_sampler *s, float u[2])
{
    if (s->kind == LF_SAMPLER_INDEPENDENT) {
        u[0] = ng_rng_float(&s->rng);
        u[1] = ng_rng_float(&s->rng);
        return;
    }
    lf_sobol_2d(s->pixel, s->reversed, s->draw++, &u[0], &u[1]);
}

float lf_sampler_1d(struct lf_sampler *s)
{
    if (s->kind == LF_SAMPLER_INDEPENDENT)
        return ng_rng_float(&s->rng);
    return lf_sobol_1d(s->pixel, s->reversed, s->draw++);
}

// The random numbers of a path.
//
// LF_SAMPLER_SOBOL: points of Sobol's first two dimensions, Owen-scrambled and shuffled anew for every draw
// (padded), so that any number of samples of a pixel is spread evenly in each draw. Source: Burley,
// "Practical Hash-based Owen Scrambling", 2020; hash of Laine and Karras, 2011. LF_SAMPLER_INDEPENDENT:
// uncorrelated.
//
// Numbers follow from seed, pixel, sample and the order of draws alone, and lie in [0, 1).
#ifndef LF_REFERENCE_SAMPLER_H
#define LF_REFERENCE_SAMPLER_H

#include "base/rng.h"

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

#endif

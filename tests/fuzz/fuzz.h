// What the fuzzers share: their arguments, and random numbers by round, so that a round that fails can be
// repeated alone.
#ifndef NG_TESTS_FUZZ_H
#define NG_TESTS_FUZZ_H

#include "test.h"

#include "base/rng.h"

#include <stdbool.h>

struct fuzz {
    uint32_t rounds, seed, first;
};
extern struct fuzz fuzz;

// [ROUNDS [SEED [FIRST]]] of the command line.
void fuzz_arguments(int argc, char **argv);
// Random numbers of a round; before it runs, the file "round" in the scratch directory names it.
struct ng_rng fuzz_round(uint32_t round);
// True once in `n`.
static inline bool fuzz_one_in(struct ng_rng *r, uint32_t n)
{
    return ng_rng_below(r, n) == 0;
}

#endif

// How often something is measured: as often as was asked for, but no longer than its share of the time, and
// once at least.
#ifndef LIGHTFORMER_BENCH_PACE_H
#define LIGHTFORMER_BENCH_PACE_H

#include "progress.h"

#include <stdbool.h>
#include <stdint.h>

struct bench_pace {
    uint32_t most, done;
    double seconds;
    uint64_t begun_ns;
    struct progress progress;
};

// Shows a bar under that label until bench_pace_next says false.
void bench_pace_begin(struct bench_pace *pace, const char *label, uint32_t most, double seconds);
// Whether to measure once more: `done` turns are over, and the next one would end in time if it takes as long
// as they did.
bool bench_pace_next(struct bench_pace *pace, uint32_t done);

#endif

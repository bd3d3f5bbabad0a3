// bench --reference: how fast the path tracer traces, against a bare loop of closest hits of incoherent rays
// in the same scene on as many threads.
#ifndef LIGHTFORMER_BENCH_REFERENCE_H
#define LIGHTFORMER_BENCH_REFERENCE_H

#include "options.h"

#include "base/result.h"

struct opening;

struct bench_reference_params {
    const char *scene;
    const struct opening *opening;
    struct cli_size size;
    uint32_t samples; // a pixel, of each round
    uint32_t threads; // 0: one a processor
    bool json;
};

// Measures, and prints to stdout. Failures were logged.
NG_NODISCARD ng_result bench_reference(const struct bench_reference_params *params);

#endif

// bench --flicker: how much pictures change from frame to frame beyond what moves in them, while a camera or
// a lamp moves slowly: those that `view` makes then, whole ones, and path traced ones.
#ifndef LIGHTFORMER_BENCH_FLICKER_H
#define LIGHTFORMER_BENCH_FLICKER_H

#include "options.h"

#include "base/result.h"

struct opening;

struct bench_flicker_params {
    const char *scene, *device, *weights;
    const struct opening *opening;
    struct cli_size size; // of the pictures; 0: small ones
    uint32_t method;      // of the table of methods
    uint32_t threads;     // 0: one a processor
    bool json;
};

// Measures, and prints to stdout as it goes. Failures were logged.
NG_NODISCARD ng_result bench_flicker(const struct bench_flicker_params *params);

#endif

// bench --interactive: what a person has of `view`: pictures a second while something moves, and how long
// after an edit the picture has all its pixels, at sizes of windows.
#ifndef LIGHTFORMER_BENCH_INTERACTIVE_H
#define LIGHTFORMER_BENCH_INTERACTIVE_H

#include "options.h"

#include "base/result.h"

#include <stdbool.h>
#include <stdint.h>

struct opening;

struct bench_interactive_params {
    const char *scene, *device, *weights;
    const struct opening *opening;
    struct cli_size size; // of the window; 0: of three windows
    uint32_t method;      // of the table of methods
    uint32_t threads;     // 0: one a processor
    bool json;
};

// Measures, and prints to stdout as it goes. Failures were logged.
NG_NODISCARD ng_result bench_interactive(const struct bench_interactive_params *params);

#endif

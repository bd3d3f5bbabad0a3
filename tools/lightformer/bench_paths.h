// The kinds of work in a frame of the method "neural", each beside its bound: what the same machine does in a
// bare loop of rays, of multiplications, or of copying, measured in the same run.
#ifndef LIGHTFORMER_BENCH_PATHS_H
#define LIGHTFORMER_BENCH_PATHS_H

#include "base/result.h"
#include "bench_net.h"
#include "json.h"

#include <stdbool.h>
#include <stdint.h>

struct bench_neural_params;

enum bench_bound { BENCH_LONE_RAYS, BENCH_RAY_PACKETS, BENCH_PRODUCTS, BENCH_BYTES, BENCH_BOUNDS };

#define BENCH_PATHS_MOST 16

struct bench_paths {
    struct bench_path {
        const char *name;
        enum bench_bound bound;
        double ms, amount; // a frame; rays, floating-point operations, bytes
    } paths[BENCH_PATHS_MOST];
    uint32_t count;
    double bounds[BENCH_BOUNDS];      // a second, on all threads
    struct bench_net_shares products; // of the network, with two lights
};

// Errors, logged: those of the parts.
NG_NODISCARD ng_result bench_paths_measure(const struct bench_neural_params *params, struct bench_paths *out);
void bench_paths_print(const struct bench_paths *b);
// Members of the object that is open.
void bench_paths_write(const struct bench_paths *b, struct json *j);
// The i-th ratio; false past the end.
bool bench_paths_ratio(const struct bench_paths *b, uint32_t index, char *name, size_t size, double *value);

#endif

// lightformer bench NETWORK --net: how long a network's stages take on made-up inputs, and where the time
// goes.
#ifndef LIGHTFORMER_BENCH_NET_H
#define LIGHTFORMER_BENCH_NET_H

#include "options.h"

#include "base/result.h"
#include "lightformer/net/net.h"

struct bench_net_params {
    const char *network;
    struct cli_size size;
    uint32_t lights, frames, threads, kernel; // enum lf_net_kernel
    bool json;
};

// Names of kernels by enum lf_net_kernel; null past the last.
const char *bench_net_kernel(uint32_t index);

NG_NODISCARD ng_result bench_net(const struct bench_net_params *params);

#define BENCH_NET_STAGES 3 // lights, views, gather

// The speed of all products and convolutions over each kernel's peak, measured beside it; 0: not on this CPU.
struct bench_net_shares {
    double of[LF_KERNEL_AMX + 1];
    double peak; // of the kernel that ran, GFLOP/s
    struct {
        double ms, gflop; // a frame; of products and convolutions
    } stages[BENCH_NET_STAGES];
};
NG_NODISCARD ng_result bench_net_measure_shares(const struct bench_net_params *params,
                                                struct bench_net_shares *out);

#endif

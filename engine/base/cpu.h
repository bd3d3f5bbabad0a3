// What the processor can do beyond what the compiler may assume. Thread-safe.
//
// The environment variable NG_ISA makes a lesser one of it, so that any machine shows what another would
// compute: sse4.2, avx2, avx512, bf16 or amx is the most that the process uses, with Embree. It is read once.
// The C library and the Vulkan driver choose by themselves.
#ifndef NG_BASE_CPU_H
#define NG_BASE_CPU_H

#include "base/extern_c.h"
#include "base/result.h"

#include <stdbool.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

enum ng_cpu_feature { // each with those above it
    NG_CPU_SSE42,
    NG_CPU_AVX2,   // with FMA
    NG_CPU_AVX512, // F, BW, DQ, VL
    NG_CPU_AVX512_BF16,
    NG_CPU_AMX_BF16, // asks the system for leave to use tiles, for all threads
    NG_CPU_FEATURES,
};

// True if the processor has it, the system lets this process use it, and NG_ISA allows it.
bool ng_cpu_has(enum ng_cpu_feature feature);
// False if NG_ISA holds the process below it, whatever the processor has: for what chooses by itself, as
// Embree.
bool ng_cpu_allowed(enum ng_cpu_feature feature);
// Whoever computes asks this first. NG_ERROR_UNSUPPORTED, logged: NG_ISA is none of these words, or the
// processor lacks it; it then holds nothing.
NG_NODISCARD ng_result ng_cpu_check(void);

// The sets of instructions that ng_kernels() (tools/cmake/ng_targets.cmake) builds a file for, the fastest
// first.
enum ng_cpu_set { NG_CPU_SET_AVX512, NG_CPU_SET_AVX2, NG_CPU_SET_PLAIN, NG_CPU_SETS };
// Number `index` of those that this processor has; NG_CPU_SETS past the end.
enum ng_cpu_set ng_cpu_set_of(uint32_t index);

NG_EXTERN_C_END

#endif

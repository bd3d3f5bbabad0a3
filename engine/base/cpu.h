// What the processor can do beyond what the compiler may assume. Thread-safe.
#ifndef NG_BASE_CPU_H
#define NG_BASE_CPU_H

#include <stdbool.h>
#include <stdint.h>

enum ng_cpu_feature {
    NG_CPU_AVX2,        // with FMA
    NG_CPU_AVX512,      // F, BW, DQ, VL
    NG_CPU_AVX512_BF16, // with the above
    NG_CPU_AMX_BF16,    // with the above; asks the system for leave to use tiles, for all threads
};

// True if the processor has it and the system lets this process use it.
bool ng_cpu_has(enum ng_cpu_feature feature);

// The sets of instructions that ng_kernels() (tools/cmake/ng_targets.cmake) builds a file for, the fastest
// first.
enum ng_cpu_set { NG_CPU_SET_AVX512, NG_CPU_SET_AVX2, NG_CPU_SET_PLAIN, NG_CPU_SETS };
// Number `index` of those that this processor has; NG_CPU_SETS past the end.
enum ng_cpu_set ng_cpu_set_of(uint32_t index);

#endif

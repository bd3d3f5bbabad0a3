// What the processor can do beyond what the compiler may assume. Thread-safe.
#ifndef NG_BASE_CPU_H
#define NG_BASE_CPU_H

#include <stdbool.h>

enum ng_cpu_feature {
    NG_CPU_AVX2,        // with FMA
    NG_CPU_AVX512,      // F, BW, DQ, VL
    NG_CPU_AVX512_BF16, // with the above
    NG_CPU_AMX_BF16,    // with the above; asks the system for leave to use tiles, for all threads
};

// True if the processor has it and the system lets this process use it.
bool ng_cpu_has(enum ng_cpu_feature feature);

#endif

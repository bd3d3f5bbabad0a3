// The compiler's own tests know which registers the system saves. Tiles are newer: Linux hands them out on
// request (Documentation/arch/x86/xstate.rst).
#define _DEFAULT_SOURCE
#include "base/cpu.h"

#if defined(__x86_64__) && defined(__linux__)
#include <cpuid.h>
#include <stdint.h>
#include <sys/syscall.h>
#include <unistd.h>

#define ARCH_REQ_XCOMP_PERM 0x1023
#define XFEATURE_XTILEDATA  18

static bool has_amx_bf16(void)
{
    const uint32_t amx_bf16 = 1u << 22, amx_tile = 1u << 24;
    uint32_t a, b, c, d;
    return __get_cpuid_count(7, 0, &a, &b, &c, &d) && (d & amx_bf16) && (d & amx_tile) &&
           syscall(SYS_arch_prctl, ARCH_REQ_XCOMP_PERM, XFEATURE_XTILEDATA) == 0;
}

static bool has_avx512_bf16(void)
{
    const uint32_t avx512_bf16 = 1u << 5;
    uint32_t a, b, c, d;
    return ng_cpu_has(NG_CPU_AVX512) && __get_cpuid_count(7, 1, &a, &b, &c, &d) && (a & avx512_bf16);
}

bool ng_cpu_has(enum ng_cpu_feature feature)
{
    __builtin_cpu_init();
    switch (feature) {
    case NG_CPU_AVX2:
        return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    case NG_CPU_AVX512:
        return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
               __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
    case NG_CPU_AVX512_BF16:
        return has_avx512_bf16();
    case NG_CPU_AMX_BF16:
        return has_avx512_bf16() && has_amx_bf16();
    }
    return false;
}
#else
bool ng_cpu_has(enum ng_cpu_feature feature)
{
    (void)feature;
    return false;
}
#endif

enum ng_cpu_set ng_cpu_set_of(uint32_t index)
{
    if (ng_cpu_has(NG_CPU_AVX512) && index-- == 0)
        return NG_CPU_SET_AVX512;
    if (ng_cpu_has(NG_CPU_AVX2) && index-- == 0)
        return NG_CPU_SET_AVX2;
    return index == 0 ? NG_CPU_SET_PLAIN : NG_CPU_SETS;
}

// The compiler's own tests know which registers the system saves. Tiles are newer: Linux hands them out on
// request (Documentation/arch/x86/xstate.rst).
#define _DEFAULT_SOURCE
#include "base/cpu.h"

#include "base/log.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

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

static bool has_avx512(void)
{
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
           __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
}

static bool has_avx512_bf16(void)
{
    const uint32_t avx512_bf16 = 1u << 5;
    uint32_t a, b, c, d;
    return has_avx512() && __get_cpuid_count(7, 1, &a, &b, &c, &d) && (a & avx512_bf16);
}

static bool processor_has(enum ng_cpu_feature feature)
{
    __builtin_cpu_init();
    switch (feature) {
    case NG_CPU_SSE42:
        return __builtin_cpu_supports("sse4.2");
    case NG_CPU_AVX2:
        return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    case NG_CPU_AVX512:
        return has_avx512();
    case NG_CPU_AVX512_BF16:
        return has_avx512_bf16();
    case NG_CPU_AMX_BF16:
        return has_avx512_bf16() && has_amx_bf16();
    case NG_CPU_FEATURES:
        break;
    }
    return false;
}
#else
static bool processor_has(enum ng_cpu_feature feature)
{
    NG_UNUSED(feature);
    return false;
}
#endif

// ---- NG_ISA ----------------------------------------------------------------------------------------------
// Null where it is not set.
static const char *wanted_name(void)
{
    const char *value = getenv("NG_ISA");
    return value && *value ? value : NULL;
}

static enum ng_cpu_feature feature_named(const char *name)
{
    static const char *const names[NG_CPU_FEATURES] = {"sse4.2", "avx2", "avx512", "bf16", "amx"};
    int i = 0;
    while (i < NG_CPU_FEATURES && strcmp(name, names[i]) != 0)
        i++;
    return (enum ng_cpu_feature)i;
}

static enum ng_cpu_feature most_allowed = NG_CPU_FEATURES; // once it was read

static void read_most_allowed(void)
{
    const char *name = wanted_name();
    if (name && processor_has(feature_named(name)))
        most_allowed = feature_named(name);
}

bool ng_cpu_allowed(enum ng_cpu_feature feature)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, read_most_allowed);
    return feature <= most_allowed;
}

bool ng_cpu_has(enum ng_cpu_feature feature)
{
    return ng_cpu_allowed(feature) && processor_has(feature);
}

ng_result ng_cpu_check(void)
{
    const char *name = wanted_name();
    if (!name || processor_has(feature_named(name)))
        return NG_OK;
    ng_log_error("NG_ISA=%s: %s; unset it, or give the most of sse4.2, avx2, avx512, bf16, amx to be used",
                 name,
                 feature_named(name) == NG_CPU_FEATURES ? "not a set of instructions" : "this CPU lacks it");
    return NG_ERROR_UNSUPPORTED;
}

enum ng_cpu_set ng_cpu_set_of(uint32_t index)
{
    if (ng_cpu_has(NG_CPU_AVX512) && index-- == 0)
        return NG_CPU_SET_AVX512;
    if (ng_cpu_has(NG_CPU_AVX2) && index-- == 0)
        return NG_CPU_SET_AVX2;
    return index == 0 ? NG_CPU_SET_PLAIN : NG_CPU_SETS;
}

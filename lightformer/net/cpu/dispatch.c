// Which kernels this build has and this CPU runs.
#include "lightformer/net/cpu/kernel_internal.h"

#include "base/cpu.h"

const struct lf_kernel *lf_kernel_find(enum lf_net_kernel id)
{
    switch (id) {
    case LF_KERNEL_PLAIN:
        return &lf_kernel_plain;
#ifdef __x86_64__
    case LF_KERNEL_AVX2:
        return ng_cpu_has(NG_CPU_AVX2) ? &lf_kernel_avx2 : NULL;
    case LF_KERNEL_AVX512:
        return ng_cpu_has(NG_CPU_AVX512) ? &lf_kernel_avx512 : NULL;
    case LF_KERNEL_BF16:
        return ng_cpu_has(NG_CPU_AVX512_BF16) ? &lf_kernel_bf16 : NULL;
    case LF_KERNEL_AMX:
        return ng_cpu_has(NG_CPU_AMX_BF16) ? &lf_kernel_amx : NULL;
#endif
    default:
        return NULL;
    }
}

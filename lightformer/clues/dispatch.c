// Which kernels this CPU can run.
#include "lightformer/clues/kernels.h"

#include "base/cpu.h"

#include <stddef.h>

extern const struct lf_kernels lf_kernels_plain;
#ifdef __x86_64__
extern const struct lf_kernels lf_kernels_avx2, lf_kernels_avx512;
#endif

const struct lf_kernels *lf_kernels_of(uint32_t index)
{
    static const struct lf_kernels *const sets[NG_CPU_SETS + 1] = {
        [NG_CPU_SET_PLAIN] = &lf_kernels_plain,
#ifdef __x86_64__
        [NG_CPU_SET_AVX2] = &lf_kernels_avx2,
        [NG_CPU_SET_AVX512] = &lf_kernels_avx512,
#endif
    };
    return sets[ng_cpu_set_of(index)];
}

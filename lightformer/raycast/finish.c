// Which kernels this CPU can run.
#include "lightformer/raycast/finish.h"

#include "base/cpu.h"

extern const struct lf_finish_kernels lf_finish_kernels_plain;
#ifdef __x86_64__
extern const struct lf_finish_kernels lf_finish_kernels_avx2, lf_finish_kernels_avx512;
#endif

const struct lf_finish_kernels *lf_finish_kernels_of(uint32_t index)
{
    static const struct lf_finish_kernels *const sets[NG_CPU_SETS + 1] = {
        [NG_CPU_SET_PLAIN] = &lf_finish_kernels_plain,
#ifdef __x86_64__
        [NG_CPU_SET_AVX2] = &lf_finish_kernels_avx2,
        [NG_CPU_SET_AVX512] = &lf_finish_kernels_avx512,
#endif
    };
    return sets[ng_cpu_set_of(index)];
}

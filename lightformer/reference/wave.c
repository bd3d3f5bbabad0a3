// Which kernels this CPU can run.
#include "lightformer/reference/wave.h"

#include "base/cpu.h"

extern const struct lf_wave_kernels lf_wave_kernels_plain;
#ifdef __x86_64__
extern const struct lf_wave_kernels lf_wave_kernels_avx2, lf_wave_kernels_avx512;
#endif

const struct lf_wave_kernels *lf_wave_kernels_of(uint32_t index)
{
#ifdef __x86_64__
    if (ng_cpu_has(NG_CPU_AVX512) && index-- == 0)
        return &lf_wave_kernels_avx512;
    if (ng_cpu_has(NG_CPU_AVX2) && index-- == 0)
        return &lf_wave_kernels_avx2;
#endif
    return index == 0 ? &lf_wave_kernels_plain : NULL;
}

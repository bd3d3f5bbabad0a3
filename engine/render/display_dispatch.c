// Which kernels this CPU can run.
#include "render/display_kernels.h"

#include "base/cpu.h"

extern const struct ng_display_kernels ng_display_kernels_plain;
#ifdef __x86_64__
extern const struct ng_display_kernels ng_display_kernels_avx2, ng_display_kernels_avx512;
#endif

const struct ng_display_kernels *ng_display_kernels_of(uint32_t index)
{
    static const struct ng_display_kernels *const sets[NG_CPU_SETS + 1] = {
        [NG_CPU_SET_PLAIN] = &ng_display_kernels_plain,
#ifdef __x86_64__
        [NG_CPU_SET_AVX2] = &ng_display_kernels_avx2,
        [NG_CPU_SET_AVX512] = &ng_display_kernels_avx512,
#endif
    };
    return sets[ng_cpu_set_of(index)];
}

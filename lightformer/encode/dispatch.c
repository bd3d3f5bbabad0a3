// Which kernels this CPU can run.
#include "lightformer/encode/kernels.h"

#include "base/cpu.h"

#include <stddef.h>

// A spiral: the angle of sample k is k times the golden angle, its u2 (k + 1/2) / 16.
const float lf_lobe_samples[LF_LOBE_SAMPLES][3] = {
    {1.0f, 0.0f, 0.03125f},
    {-0.737368878f, 0.675490294f, 0.09375f},
    {0.0874257247f, -0.996171041f, 0.15625f},
    {0.608438861f, 0.793600751f, 0.21875f},
    {-0.984713485f, -0.17418195f, 0.28125f},
    {0.843755295f, -0.536728053f, 0.34375f},
    {-0.259604305f, 0.965715074f, 0.40625f},
    {-0.460907025f, -0.887448429f, 0.46875f},
    {0.939321296f, 0.343038631f, 0.53125f},
    {-0.924345556f, 0.381556408f, 0.59375f},
    {0.423845995f, -0.905734273f, 0.65625f},
    {0.299283864f, 0.95416412f, 0.71875f},
    {-0.86521121f, -0.501407581f, 0.78125f},
    {0.976675774f, -0.214719429f, 0.84375f},
    {-0.575129429f, 0.81806243f, 0.90625f},
    {-0.12851069f, -0.991708124f, 0.96875f},
};

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

// Compiled once for each instruction set (CMakeLists.txt), NG_KERNELS being the name of its table.
#include "base/half.h"
#include "lightformer/raycast/pack.h"

static void to_halfs(const float from[LF_PACK_HALFS], uint16_t to[LF_PACK_HALFS])
{
#pragma omp simd
    for (int i = 0; i < LF_PACK_HALFS; i++)
        to[i] = ng_half_from_float(from[i]);
}

#define JOIN_(a, b) a##b
#define JOIN(a, b)  JOIN_(a, b)
extern const struct lf_pack_kernels JOIN(lf_pack_kernels_, NG_KERNELS);
const struct lf_pack_kernels JOIN(lf_pack_kernels_, NG_KERNELS) = {to_halfs};

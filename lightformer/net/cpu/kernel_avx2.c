// AVX2 and FMA: vectors of eight; the compiler makes one instruction of a product and a sum.
#define LF_LANES               8
#define LF_BLOCK               4
#define LF_GROUP               1
#define LF_KERNEL              lf_kernel_avx2
#define LF_KERNEL_ID           LF_KERNEL_AVX2
#define LF_MULTIPLY(sum, w, x) ((sum) + lf_splat(lf_float(w)) * (lf_floats)(x))

#include "lightformer/net/cpu/kernel_text.inc"

// AVX-512: vectors of sixteen; the compiler makes one instruction of a product and a sum.
#define LF_LANES               16
#define LF_BLOCK               8
#define LF_GROUP               1
#define LF_KERNEL              lf_kernel_avx512
#define LF_KERNEL_ID           LF_KERNEL_AVX512
#define LF_MULTIPLY(sum, w, x) ((sum) + lf_splat(lf_float(w)) * (lf_floats)(x))

#include "lightformer/net/cpu/kernel_text.inc"

// Any CPU: vectors of four, which compilers have for all of them.
#define LF_LANES               4
#define LF_BLOCK               4
#define LF_GROUP               1
#define LF_KERNEL              lf_kernel_plain
#define LF_KERNEL_ID           LF_KERNEL_PLAIN
#define LF_MULTIPLY(sum, w, x) ((sum) + lf_splat(lf_float(w)) * (lf_floats)(x))

#include "lightformer/net/cpu/kernel_text.inc"

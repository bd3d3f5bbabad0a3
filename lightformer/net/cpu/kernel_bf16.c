// AVX-512 bf16: products of pairs of channels, sums in fp32.
#include "lightformer/net/cpu/bf16_internal.h"

#define LF_LANES           16
#define LF_BLOCK           8
#define LF_GROUP           2
#define LF_KERNEL          lf_kernel_bf16
#define LF_KERNEL_ID       LF_KERNEL_BF16
#define LF_MULTIPLY        lf_bf16_multiply
#define LF_PAIR(low, high) lf_bf16_pair(low, high)
#define LF_ROUND           lf_bf16_round

#include "lightformer/net/cpu/kernel_text.inc"

// Numbers of 16 bits with the exponent of fp32, on CPUs with AVX-512 bf16.
#ifndef LF_NET_CPU_BF16_INTERNAL_H
#define LF_NET_CPU_BF16_INTERNAL_H

#include <immintrin.h>
#include <stdint.h>

typedef uint32_t lf_bf16_words __attribute__((vector_size(64)));
typedef float lf_bf16_floats __attribute__((vector_size(64)));

// Lane by lane a word: `low` and `high` rounded to the nearest, ties to even.
static inline lf_bf16_words lf_bf16_pair(lf_bf16_floats low, lf_bf16_floats high)
{
    const __m512i order = _mm512_set_epi16(31, 15, 30, 14, 29, 13, 28, 12, 27, 11, 26, 10, 25, 9, 24, 8, 23,
                                           7, 22, 6, 21, 5, 20, 4, 19, 3, 18, 2, 17, 1, 16, 0);
    __m512bh both = _mm512_cvtne2ps_pbh((__m512)high, (__m512)low);
    return (lf_bf16_words)_mm512_permutexvar_epi16(order, (__m512i)both);
}

static inline lf_bf16_floats lf_bf16_multiply(lf_bf16_floats sum, uint32_t weights, lf_bf16_words in)
{
    return (lf_bf16_floats)_mm512_dpbf16_ps((__m512)sum, (__m512bh)_mm512_set1_epi32((int)weights),
                                            (__m512bh)in);
}

static inline uint16_t lf_bf16_round(float f)
{
    return (uint16_t)_mm512_cvtsi512_si32((__m512i)lf_bf16_pair(_mm512_set1_ps(f), _mm512_setzero_ps()));
}

#endif

// What one kind of CPU does to a tile: the functions behind the executor's codes.
//
// A tile is a run of at most LF_TILE neighbours of one row of a picture (or of rows of a light). Its values
// are rows of LF_ROW words of 32 bits: an fp32 row holds one channel; a *packed* row, which products read,
// holds `group` channels: one as fp32, or two as bf16, the first in the low half. Widths are multiples of
// LF_STEP; what lies beyond the valid ones is anything.
#ifndef LF_NET_CPU_KERNEL_INTERNAL_H
#define LF_NET_CPU_KERNEL_INTERNAL_H

#include "lightformer/net/program_internal.h"

#define LF_STEP 32u
#define LF_TILE 256u
#define LF_ROW  272u // an odd number of cache lines, so that the rows of a column lie in different sets

// A stored picture: rows of channels beside each other, [y][row][x], a border of zeros around it. Of one that
// is never whole, `words` holds the part that begins at (x0, y0).
#define LF_BORDER 16u
struct lf_image {
    uint32_t *words;
    uint32_t width, height, channels, rows, x0, y0;
    size_t stride; // of a row, words
};

static inline uint32_t *lf_image_at(const struct lf_image *image, uint32_t y, uint32_t row)
{
    return image->words + (((size_t)(y - image->y0) + 1) * image->rows + row) * image->stride + LF_BORDER -
           image->x0;
}

// outputs [N][x] = act(bias + sum over taps and rows of weights * inputs), fp32 rows and packed rows as
// wanted.
struct lf_product_call {
    const void *weights; // as `pack` made them
    const float *bias;   // padded to a multiple of LF_OUTPUTS
    uint32_t outputs, taps, rows, width;
    const uint32_t *in[9]; // a tap's first row
    size_t stride;         // from row to row, words
    enum lf_op_kind act;   // LF_OP_COUNT, LF_OP_RELU or LF_OP_LEAKY
    float *out;            // or null
    uint32_t *packed;      // or null
};
#define LF_OUTPUTS 16u

struct lf_weights_call {
    const struct lf_op *op;
    const uint32_t *columns; // of the weights, [rows][group]; LF_NO_VALUE: nothing
    uint32_t outputs, inputs, taps, rows;
};

// Elementwise: out[c] = op(a[c], b[c]); an operand of one channel is repeated.
struct lf_pairwise_call {
    enum lf_op_kind op;
    const float *a, *b;
    uint32_t a_channels, b_channels, width;
    float *out;
};
struct lf_each_call {
    enum lf_op_kind op;
    const float *a;
    uint32_t channels, width;
    float x, y; // scale, offset; low, high
    float *out;
};

// One light's part of an attention.
struct lf_attend_call {
    const float *query, *key,
        *value; // fp32 rows; key and value of one light alone: stride 0, a number a channel
    bool key_is_vector, value_is_vector, softmax;
    uint32_t heads, key_channels, value_channels, width;
    float weight;
    float *sum;             // value_channels rows, to add to
    float *largest, *total; // softmax: a row a head
};

// Compact numbers have 16 bits: a sign, 6 of the exponent, 9 of the mantissa. So they are within 0.1 % from
// 5e-10 to 8e9, which is more than what halfs reach. What is less is 0, what is more is infinite. Images may
// be kept so where products are fp32.
#define LF_COMPACT_LEAST (96u << 9)

static inline uint32_t lf_compact_bits(uint32_t half)
{
    uint32_t q = half & 0x7fffu, magnitude = (q + LF_COMPACT_LEAST) << 14;
    magnitude = q ? magnitude : 0;
    magnitude = q == 0x7fffu ? 0x7f800000u : magnitude;
    return magnitude | (half & 0x8000u) << 16;
}

struct lf_kernel {
    enum lf_net_kernel id;
    uint32_t group;
    void (*begin)(void); // a thread starts and ends a run of tiles
    void (*end)(void);

    // Rows are padded to what a product reads.
    uint32_t (*pad_rows)(uint32_t rows);
    size_t (*weights_size)(const struct lf_weights_call *call); // bytes
    void (*pack_weights)(const struct lf_weights_call *call, void *out);
    void (*product)(const struct lf_product_call *call);

    // `rows` fp32 rows to packed ones; null: zeros.
    void (*pack)(const float *const *rows, uint32_t count, uint32_t width, uint32_t *out);
    void (*unpack)(const uint32_t *packed, size_t stride, uint32_t channels, uint32_t width, float *out);
    // One or two fp32 rows to a row of compact pairs (null: there is no second), and back.
    void (*compact)(const float *low, const float *high, uint32_t width, uint32_t *out);
    void (*expand)(const uint32_t *compact, size_t stride, uint32_t channels, uint32_t width, float *out);
    void (*pairwise)(const struct lf_pairwise_call *call);
    void (*each)(const struct lf_each_call *call);
    void (*dot)(const float *a, const float *b, uint32_t channels, uint32_t width, float *out);
    void (*normalize)(const float *a, uint32_t channels, uint32_t width, float *out);
    void (*add_scaled)(const float *a, float scale, uint32_t channels, uint32_t width, float *sum);
    void (*attend)(const struct lf_attend_call *call);
    void (*attend_end)(const struct lf_attend_call *call);
    // Of the tile that begins at column x of row y of the result.
    void (*resample)(enum lf_op_kind op, const struct lf_image *in, uint32_t x, uint32_t y, uint32_t width,
                     float *out);
    // `peak` rounds of the kernel's multiplication in registers: GFLOP, for benchmarks.
    double (*peak)(uint32_t rounds);
};

// Null where this build or this CPU does not have it.
const struct lf_kernel *lf_kernel_find(enum lf_net_kernel id);

extern const struct lf_kernel lf_kernel_plain, lf_kernel_avx2, lf_kernel_avx512, lf_kernel_bf16,
    lf_kernel_amx;

#endif

// AMX: products of tiles of 16 outputs x 16 columns, 32 channels at a time; everything else as AVX-512 bf16.
//
// A step multiplies two blocks of 16 outputs by two of 16 columns: four sums, each weight and each input used
// twice. A term (a tap of a convolution) is cut into chunks of equally many rows, at most 16, so that one
// configuration of tiles serves a whole product.
#include "lightformer/net/cpu/bf16_internal.h"

#define LF_OWN_PRODUCT
#define LF_OWN_THREADS
#define LF_LANES           16
#define LF_BLOCK           16
#define LF_GROUP           2
#define LF_KERNEL          lf_kernel_amx
#define LF_KERNEL_ID       LF_KERNEL_AMX
#define LF_PAIR(low, high) lf_bf16_pair(low, high)
#define LF_ROUND           lf_bf16_round

#include "lightformer/net/cpu/kernel_internal.h"
#include "lightformer/net/program_internal.h"

static uint32_t pad_rows(uint32_t rows);
static size_t weights_size(const struct lf_weights_call *c);
static void pack_weights(const struct lf_weights_call *c, void *out);
static void product(const struct lf_product_call *c);
static double peak(uint32_t rounds);
static void begin(void);
static void end(void);

#include "lightformer/net/cpu/kernel_text.inc"

#define TILE_ROWS  16
#define TILE_WORDS (16 * 16)

struct tiles {
    uint8_t palette, start, reserved[14];
    uint16_t bytes[16]; // of a row
    uint8_t rows[16];
};

static uint32_t chunk_count(uint32_t rows)
{
    return (rows + TILE_ROWS - 1) / TILE_ROWS;
}

static uint32_t pad_rows(uint32_t rows)
{
    uint32_t chunks = chunk_count(rows);
    return (rows + chunks - 1) / chunks * chunks;
}

static uint32_t block_count(uint32_t outputs)
{
    return (outputs + LF_BLOCK - 1) / LF_BLOCK;
}

static size_t weights_size(const struct lf_weights_call *c)
{
    return (size_t)block_count(c->outputs) * c->taps * chunk_count(c->rows) * TILE_WORDS * sizeof(uint32_t);
}

// [block of outputs][tap][chunk][output][row]
static void pack_weights(const struct lf_weights_call *c, void *out)
{
    uint32_t *word = out, chunks = chunk_count(c->rows), rows = c->rows / chunks;
    for (uint32_t n = 0; n < c->outputs; n += LF_BLOCK)
        for (uint32_t tap = 0; tap < c->taps; tap++)
            for (uint32_t chunk = 0; chunk < chunks; chunk++)
                for (uint32_t i = 0; i < LF_BLOCK; i++)
                    for (uint32_t row = 0; row < TILE_ROWS; row++)
                        *word++ = row < rows ? lf_word(c, n + i, tap, chunk * rows + row) : 0;
}

// Tiles 0 to 3: sums; 4, 5: weights of two blocks; 6, 7: inputs of two blocks.
static void configure(uint32_t rows)
{
    struct tiles t = {.palette = 1};
    for (int i = 0; i < 8; i++) {
        t.bytes[i] = (uint16_t)(i == 4 || i == 5 ? 4 * rows : 64);
        t.rows[i] = (uint8_t)(i >= 6 ? rows : TILE_ROWS);
    }
    __asm__ volatile("" : : "r"(&t) : "memory"); // GCC 12 believes that the next line reads eight bytes
    _tile_loadconfig(&t);
}

static inline __m512 act_of(__m512 x, enum lf_op_kind act)
{
    if (act == LF_OP_RELU)
        return _mm512_max_ps(x, _mm512_setzero_ps());
    if (act == LF_OP_LEAKY)
        return _mm512_max_ps(x, _mm512_mul_ps(x, _mm512_set1_ps(0.01f)));
    return x;
}

// A block of sums: bias, act, and out of the way. The last outputs of an odd count are alone.
static void finish(const struct lf_product_call *c, const float *sums, uint32_t n, uint32_t x)
{
    uint32_t count = c->outputs - n < LF_BLOCK ? c->outputs - n : LF_BLOCK;
    for (uint32_t i = 0; i < count; i += 2) {
        __m512 low = _mm512_add_ps(_mm512_load_ps(sums + i * 16), _mm512_set1_ps(c->bias[n + i]));
        __m512 high = _mm512_add_ps(_mm512_load_ps(sums + i * 16 + 16), _mm512_set1_ps(c->bias[n + i + 1]));
        low = act_of(low, c->act);
        high = act_of(high, c->act);
        if (c->out) {
            float *out = c->out + (size_t)(n + i) * LF_ROW + x;
            _mm512_storeu_ps(out, low);
            if (i + 1 < count)
                _mm512_storeu_ps(out + LF_ROW, high);
        }
        if (c->packed)
            *(lf_loose_words *)(c->packed + (size_t)((n + i) / 2) * LF_ROW + x) =
                lf_bf16_pair((lf_bf16_floats)low, (lf_bf16_floats)high);
    }
}

// One or two blocks of outputs, `block` words apart, by two blocks of inputs.
static inline __attribute__((always_inline)) void multiply(const struct lf_product_call *c,
                                                           const uint32_t *weights, size_t block, bool two,
                                                           uint32_t n, uint32_t x, float (*sums)[TILE_WORDS])
{
    const uint32_t chunks = chunk_count(c->rows), rows = c->rows / chunks;
    const size_t stride = c->stride * sizeof(uint32_t);
    _tile_zero(0);
    _tile_zero(1);
    _tile_zero(2);
    _tile_zero(3);
    for (uint32_t tap = 0; tap < c->taps; tap++) {
        const uint32_t *in = c->in[tap] + x;
        for (uint32_t chunk = 0; chunk < chunks; chunk++, in += rows * c->stride, weights += TILE_WORDS) {
            _tile_loadd(4, weights, 64);
            _tile_loadd(6, in, stride);
            _tile_dpbf16ps(0, 4, 6);
            _tile_loadd(7, in + 16, stride);
            _tile_dpbf16ps(1, 4, 7);
            if (two) {
                _tile_loadd(5, weights + block, 64);
                _tile_dpbf16ps(2, 5, 6);
                _tile_dpbf16ps(3, 5, 7);
            }
        }
    }
    _tile_stored(0, sums[0], 64);
    _tile_stored(1, sums[1], 64);
    finish(c, sums[0], n, x);
    finish(c, sums[1], n, x + 16);
    if (!two)
        return;
    _tile_stored(2, sums[2], 64);
    _tile_stored(3, sums[3], 64);
    finish(c, sums[2], n + LF_BLOCK, x);
    finish(c, sums[3], n + LF_BLOCK, x + 16);
}

static void product(const struct lf_product_call *c)
{
    _Alignas(64) float sums[4][TILE_WORDS];
    const uint32_t blocks = block_count(c->outputs), chunks = chunk_count(c->rows);
    const size_t block = (size_t)c->taps * chunks * TILE_WORDS;
    const uint32_t *weights = c->weights;
    configure(c->rows / chunks);
    for (uint32_t i = 0; i < blocks; i += 2, weights += 2 * block)
        for (uint32_t x = 0; x < c->width; x += 32)
            if (i + 1 < blocks)
                multiply(c, weights, block, true, i * LF_BLOCK, x, sums);
            else
                multiply(c, weights, block, false, i * LF_BLOCK, x, sums);
}

static double peak(uint32_t rounds)
{
    configure(TILE_ROWS);
    for (uint32_t i = 0; i < rounds; i++) {
        _tile_dpbf16ps(0, 4, 6);
        _tile_dpbf16ps(1, 4, 7);
        _tile_dpbf16ps(2, 5, 6);
        _tile_dpbf16ps(3, 5, 7);
    }
    _tile_release();
    return 4 * 2e-9 * 16 * 16 * 32 * rounds;
}

static void begin(void)
{
}

// Tiles in use make a thread's switches slow.
static void end(void)
{
    _tile_release();
}

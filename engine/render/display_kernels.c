// Compiled once for each instruction set (CMakeLists.txt), NG_KERNELS being the name of its table. Loops over
// lanes are free of branches and calls, so that one iteration becomes one vector operation. The shaders are
// the text that this follows.
#include "render/display_kernels.h"

#include "base/half.h"
#include "shaders/shared/tonemap.h"

#include <stdbool.h>

#define LANES    16
#define FOR_EACH _Pragma("omp simd") for (int i = 0; i < LANES; i++)

struct colors {
    float of[3][LANES];
};
struct texels {
    float of[4][LANES];
};

static inline float larger(float a, float b)
{
    return a > b ? a : b;
}

static inline float smaller(float a, float b)
{
    return a < b ? a : b;
}

// ---- Reading ---------------------------------------------------------------------------------------------

static void load_halfs(const uint16_t *from, int count, struct texels *out)
{
    for (int i = 0; i < count; i++)
        for (int c = 0; c < 4; c++)
            out->of[c][i] = ng_half_to_float(from[i * 4 + c]);
}

static void load_floats(const float *from, int count, struct texels *out)
{
    for (int i = 0; i < count; i++)
        for (int c = 0; c < 4; c++)
            out->of[c][i] = from[i * 4 + c];
}

// Of the last pixels there may be fewer than lanes; the others are black.
static void load(const struct ng_display_map *map, size_t first, int count, struct texels *out)
{
    if (count < LANES || !(map->floats || map->halfs))
        *out = (struct texels){0};
    if (map->floats && count == LANES)
        load_floats(map->floats + 4 * first, LANES, out);
    else if (map->floats)
        load_floats(map->floats + 4 * first, count, out);
    else if (map->halfs)
        load_halfs(map->halfs + 4 * first, count, out);
}

// ---- Arithmetic ------------------------------------------------------------------------------------------

// x^(1/2.4) of 0.003 to 1, within 2e-6 of it, and of less some small number: by the logarithm, in two halves
// of the mantissa's range.
static inline float root(float x)
{
    uint32_t bits = ng_float_bits(x), above = (bits & 0x7fffffu) > 0x3504f3u; // the root of 2
    float exponent = (float)((int32_t)(bits >> 23) - 127 + (int32_t)above);
    float m = ng_float_of_bits((bits & 0x7fffffu) | (127u - above) << 23); // 0.7 to 1.4
    float t = (m - 1) / (m + 1), s = t * t;
    float log2 = t * (2.88539008f + s * (0.961796694f + s * (0.577078016f + s * 0.412198583f))) + exponent;
    float y = log2 * (1 / 2.4f); // not positive
    float whole = (float)(int32_t)(y - 0.5f), f = y - whole;
    float power =
        1 + f * (0.693147181f +
                 f * (0.240226507f + f * (0.0555041087f + f * (0.00961812911f + f * 0.00133335581f))));
    return power * ng_float_of_bits((uint32_t)((int32_t)whole + 127) << 23);
}

// Of 0 to 1.
static inline float srgb(float x)
{
    float line = 12.92f * x, curve = 1.055f * root(x) - 0.055f;
    uint32_t curved = 0u - (uint32_t)(x > 0.0031308f); // all bits; a choice would become a branch
    return ng_float_of_bits((ng_float_bits(curve) & curved) | (ng_float_bits(line) & ~curved));
}

static void expose(const struct texels *t, const float position[LANES], bool beauty, float exposure,
                   struct colors *out)
{
    for (int c = 0; c < 3; c++)
        FOR_EACH
        {
            float factor = beauty && position[i] < 0 ? 1 : exposure;
            out->of[c][i] = larger(t->of[c][i] * factor, 0);
        }
}

// As value_of of the shader.
static void find_values(const struct ng_display_picture *p, uint32_t encoding, const struct texels *texel,
                        const struct texels *divisor, const float position[LANES], struct colors *out)
{
    if (encoding == NG_SHOWN_RADIANCE || encoding == NG_SHOWN_BEAUTY) {
        expose(texel, position, encoding == NG_SHOWN_BEAUTY, p->exposure, out);
        return;
    }
    for (int c = 0; c < 3; c++)
        FOR_EACH
        {
            float x = texel->of[c][i], d = divisor->of[c][i];
            float ratio = d > 0 ? x / larger(d, 1e-30f) : 1;
            float direction = x * 0.5f + 0.5f;
            x = encoding == NG_SHOWN_W ? texel->of[3][i] : x;
            x = encoding == NG_SHOWN_RATIO ? ratio : x;
            out->of[c][i] = encoding == NG_SHOWN_DIRECTION ? direction : x;
        }
}

// As encode of the shader.
static void encode(const struct ng_display_picture *p, uint32_t encoding, const float position[LANES],
                   struct colors *x)
{
    const float *b = p->shown.background;
    bool beauty = encoding == NG_SHOWN_BEAUTY, radiance = beauty || encoding == NG_SHOWN_RADIANCE;
    bool background = beauty && ((b[0] > 0) | (b[1] > 0) | (b[2] > 0));
    if (encoding == NG_SHOWN_DIRECTION)
        return;
    // Where the position's w is 0 the background, and where it is negative what is unlit, is shown as it is.
    float w[LANES], peak[LANES], toe[LANES];
    FOR_EACH w[i] = beauty ? ((background | (position[i] < 0)) ? position[i] : 1) : radiance ? 1 : -1;
    for (int c = 0; c < 3 && background; c++)
        FOR_EACH x->of[c][i] = w[i] == 0 ? b[c] : x->of[c][i];
    FOR_EACH
    {
        peak[i] = larger(x->of[0][i], larger(x->of[1][i], x->of[2][i]));
        toe[i] = smaller(x->of[0][i], smaller(x->of[1][i], x->of[2][i]));
    }
    for (int c = 0; c < 3; c++) {
        FOR_EACH
        {
            float value = x->of[c][i], mapped = ng_tonemap(value, peak[i], toe[i]);
            x->of[c][i] = smaller(larger(w[i] > 0 ? mapped : value, 0), 1);
        }
        FOR_EACH x->of[c][i] = srgb(x->of[c][i]);
    }
}

// As difference of the shader.
static void compare(const struct colors *left, const struct colors *right, struct colors *out)
{
    FOR_EACH
    {
        float error = 0;
        for (int c = 0; c < 3; c++) {
            float r = right->of[c][i];
            error += (left->of[c][i] - r) / ((r < 0 ? -r : r) + 0.02f) * (1 / 3.0f);
        }
        float size = smaller((error < 0 ? -error : error) / (float)NG_DIFFERENCE_FULL, 1);
        float strength = __builtin_sqrtf(size);
        out->of[0][i] = (error > 0 ? 1 : 0.15f) * strength;
        out->of[1][i] = 0.5f * strength;
        out->of[2][i] = (error > 0 ? 0.1f : 1) * strength;
    }
}

// ---- Pictures --------------------------------------------------------------------------------------------

static void store(const struct colors *x, int count, uint8_t *out)
{
    uint8_t bytes[LANES * 4];
    FOR_EACH
    {
        for (int c = 0; c < 3; c++) {
            float value = x->of[c][i];
            bytes[i * 4 + c] = (uint8_t)(smaller(larger(value, 0), 1) * 255 + 0.5f);
        }
        bytes[i * 4 + 3] = 255;
    }
    __builtin_memcpy(out, bytes, (size_t)count * 4);
}

// The right side and the line between, by the pixels' distance from the divider.
static void split(const struct ng_display_picture *p, size_t first, const struct colors *right,
                  struct colors *left)
{
    float from[LANES];
    for (int i = 0; i < LANES; i++)
        from[i] = (float)((first + (size_t)i) % p->width) + 0.5f - p->shown.divider;
    for (int c = 0; c < 3; c++)
        FOR_EACH
        {
            float side = from[i] > 0 ? right->of[c][i] : left->of[c][i];
            left->of[c][i] = ((from[i] < 1) & (from[i] > -1)) ? 1 : side;
        }
}

static void show_side(const struct ng_display_picture *p, bool right, size_t first, int count,
                      const float position[LANES], struct colors *out)
{
    struct texels texel, divisor;
    load(right ? &p->right : &p->left, first, count, &texel);
    load(right ? &p->right_divisor : &p->left_divisor, first, count, &divisor);
    find_values(p, right ? p->shown.other_encoding : p->shown.encoding, &texel, &divisor, position, out);
}

static void show_lanes(const struct ng_display_picture *p, size_t first, int count)
{
    struct texels position;
    struct colors left, right;
    load(&p->position, first, count, &position);
    show_side(p, false, first, count, position.of[3], &left);
    if (p->shown.comparison != NG_COMPARE_NOTHING)
        show_side(p, true, first, count, position.of[3], &right);
    if (p->shown.comparison == NG_COMPARE_DIFFERENCE) {
        compare(&left, &right, &left);
    } else {
        encode(p, p->shown.encoding, position.of[3], &left);
        if (p->shown.comparison == NG_COMPARE_SPLIT) {
            encode(p, p->shown.other_encoding, position.of[3], &right);
            split(p, first, &right, &left);
        }
    }
    store(&left, count, p->out + 4 * first);
}

static void show(const struct ng_display_picture *p, size_t begin, size_t end)
{
    for (size_t i = begin; i < end; i += LANES)
        show_lanes(p, i, end - i < LANES ? (int)(end - i) : LANES);
}

static void compose(const struct ng_display_map parts[3], size_t begin, size_t end, float *out)
{
    static const float black[4 * LANES];
    for (size_t first = begin; first < end; first += LANES) {
        size_t count = end - first < LANES ? end - first : LANES;
        const float *at[3];
        for (int k = 0; k < 3; k++)
            at[k] = parts[k].floats ? parts[k].floats + 4 * first : black;
        for (size_t i = 0; i < 4 * count; i++)
            out[4 * first + i] = i % 4 == 3 ? 1 : at[0][i] + at[1][i] + at[2][i];
    }
}

#define TABLE_(x) ng_display_kernels_##x
#define TABLE(x)  TABLE_(x)
extern const struct ng_display_kernels TABLE(NG_KERNELS);
const struct ng_display_kernels TABLE(NG_KERNELS) = {compose, show};

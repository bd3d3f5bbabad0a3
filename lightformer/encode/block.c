// First, by bytes, where a block is of one opinion, which is nearly everywhere; then sums over the others.
#include "lightformer/encode/block.h"

#include "lightformer/encode/clues_internal.h"

#include <string.h>

#define ROWS   4    // a job
#define NARROW 0.1f // alpha

const unsigned char lf_block_order[LF_BLOCK * LF_BLOCK] = {0, 8,  2, 10, 12, 4, 14, 6,
                                                           3, 11, 1, 9,  15, 7, 13, 5};

void lf_block_window(float at, float out[LF_BLOCK_REACH])
{
    for (int i = 0; i < LF_BLOCK_REACH; i++)
        out[i] = ng_clamp(0.5f * LF_BLOCK + 0.5f - fabsf((float)i - at), 0.0f, 1.0f);
}

struct average {
    const struct lf_pixel_clues *pixels;
    const float *part, *weight;
    bool lobes;
    unsigned char *opinions; // of a pixel and its neighbours in its row
    float *out;
};

// What pixels found, as sets of these.
enum { LIT = 1, HIDDEN = 2 };

// Most blocks are of one opinion: then nothing has to be weighed. Sets of bytes are found out quickly.
static void ask_row(const struct average *a, uint32_t y)
{
    const uint32_t width = a->pixels->width, half = LF_BLOCK_HALF;
    const float *part = a->part + (size_t)y * width, *weight = a->weight + (size_t)y * width;
    unsigned char *out = a->opinions + (size_t)y * width;
    memset(out, 0, width);
    for (uint32_t x = 0; x < width; x++) {
        unsigned char found = (unsigned char)((part[x] > 0 ? LIT : 0) | (part[x] < 1 ? HIDDEN : 0));
        found = weight[x] > 0 ? found : 0;
        uint32_t end = x + half < width ? x + half + 1 : width;
        for (uint32_t i = x > half ? x - half : 0; found && i < end; i++)
            out[i] |= found;
    }
}

static void ask_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    for (uint32_t y = begin; y < end; y++)
        ask_row(user, y);
}

// The neighbours of a pixel, within the picture.
struct neighbours {
    uint32_t x0, y0, x1, y1; // ends are outside
};

static struct neighbours find_neighbours(const struct lf_pixel_clues *p, uint32_t x, uint32_t y)
{
    const uint32_t half = LF_BLOCK_HALF;
    return (struct neighbours){x > half ? x - half : 0, y > half ? y - half : 0,
                               x + half < p->width ? x + half + 1 : p->width,
                               y + half < p->height ? y + half + 1 : p->height};
}

// How much of a neighbour's lobe is in the pixel's: GGX of the normal between, the peak being 1.
static float lobe_likeness(const struct lf_pixel_clues *p, size_t pixel, size_t other)
{
    float cosine = 0, alpha = ng_brdf_alpha(p->roughness[pixel]);
    for (int c = 0; c < 3; c++)
        cosine += p->normal[c][pixel] * p->normal[c][other];
    float tangent = fmaxf(1 - cosine * cosine, 0) / fmaxf(cosine * cosine, 1e-6f);
    float spread = 1 + tangent / (alpha * alpha);
    return 1 / (spread * spread);
}

// A narrow lobe has one answer, which its own rays know better than those of its neighbours.
static bool is_sure(const struct average *a, size_t pixel)
{
    return ng_brdf_alpha(a->pixels->roughness[pixel]) < NARROW && a->weight[pixel] > 0 &&
           (a->part[pixel] <= 0 || a->part[pixel] >= 1);
}

static float weigh(const struct average *a, uint32_t x, uint32_t y)
{
    const struct lf_pixel_clues *p = a->pixels;
    struct neighbours n = find_neighbours(p, x, y);
    size_t pixel = (size_t)y * p->width + x;
    float window[LF_BLOCK_REACH], sum = 0, weights = 0;
    lf_block_window(LF_BLOCK_HALF, window);
    for (uint32_t row = n.y0; row < n.y1; row++)
        for (uint32_t column = n.x0; column < n.x1; column++) {
            size_t other = (size_t)row * p->width + column;
            if (!(a->weight[other] > 0))
                continue;
            float weight = a->weight[other] * window[row + LF_BLOCK_HALF - y] *
                           window[column + LF_BLOCK_HALF - x] * lf_pixel_likeness(p, pixel, other);
            if (a->lobes)
                weight *= lobe_likeness(p, pixel, other);
            weights += weight;
            sum += weight * a->part[other];
        }
    return weights > 0 && isfinite(weights) ? sum / weights : a->part[pixel];
}

static void average_row(const struct average *a, uint32_t y)
{
    const struct lf_pixel_clues *p = a->pixels;
    struct neighbours n = find_neighbours(p, 0, y);
    for (uint32_t x = 0; x < p->width; x++) {
        size_t pixel = (size_t)y * p->width + x;
        unsigned opinions = 0;
        for (size_t row = n.y0; row < n.y1; row++)
            opinions |= a->opinions[row * p->width + x];
        bool agreed = opinions != (LIT | HIDDEN);
        a->out[pixel] = opinions == LIT ? 1 : 0;
        if (!(p->mask[pixel] > 0))
            a->out[pixel] = 0;
        else if (!agreed)
            a->out[pixel] = a->lobes && is_sure(a, pixel) ? a->part[pixel] : weigh(a, x, y);
    }
}

static void average_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    for (uint32_t y = begin; y < end; y++)
        average_row(user, y);
}

void lf_block_average(const struct lf_encode_scene *scene, const struct lf_pixel_clues *pixels,
                      const struct lf_block_rays *rays, bool lobes, float *out)
{
    struct average average = {pixels, rays->part, rays->weight, lobes, (unsigned char *)rays->scratch, out};
    ng_jobs_for(scene->jobs, pixels->height, ROWS, ask_rows, &average);
    ng_jobs_for(scene->jobs, pixels->height, ROWS, average_rows, &average);
}

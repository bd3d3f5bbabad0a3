#include "lightformer/encode/block.h"

#include "lightformer/encode/clues_internal.h"

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
    float *out;
};

// The neighbours of a pixel, within the picture.
struct neighbours {
    uint32_t x0, y0, x1, y1; // ends are outside
};

static struct neighbours find_neighbours(const struct lf_pixel_clues *p, uint32_t x, uint32_t y)
{
    const uint32_t half = LF_BLOCK / 2;
    return (struct neighbours){x > half ? x - half : 0, y > half ? y - half : 0,
                               x + half < p->width ? x + half + 1 : p->width,
                               y + half < p->height ? y + half + 1 : p->height};
}

// Most blocks are of one opinion.
static bool agree(const struct average *a, const struct neighbours *n, float *out)
{
    float least = INFINITY, most = -INFINITY;
    for (size_t y = n->y0; y < n->y1; y++)
        for (size_t i = y * a->pixels->width + n->x0; i < y * a->pixels->width + n->x1; i++)
            if (a->weight[i] > 0) {
                least = fminf(least, a->part[i]);
                most = fmaxf(most, a->part[i]);
            }
    *out = most >= 0 ? most : 0;
    return !(most > least);
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

static float average_at(const struct average *a, uint32_t x, uint32_t y)
{
    const struct lf_pixel_clues *p = a->pixels;
    struct neighbours n = find_neighbours(p, x, y);
    size_t pixel = (size_t)y * p->width + x;
    float window[LF_BLOCK_REACH], sum = 0, weights = 0, all;
    if (!(p->mask[pixel] > 0))
        return 0;
    if (agree(a, &n, &all))
        return all;
    if (a->lobes && is_sure(a, pixel))
        return a->part[pixel];
    lf_block_window(LF_BLOCK / 2, window);
    for (uint32_t row = n.y0; row < n.y1; row++)
        for (uint32_t column = n.x0; column < n.x1; column++) {
            size_t other = (size_t)row * p->width + column;
            if (!(a->weight[other] > 0))
                continue;
            float weight = a->weight[other] * window[row + LF_BLOCK / 2 - y] *
                           window[column + LF_BLOCK / 2 - x] * lf_pixel_likeness(p, pixel, other);
            if (a->lobes)
                weight *= lobe_likeness(p, pixel, other);
            weights += weight;
            sum += weight * a->part[other];
        }
    return weights > 0 ? sum / weights : a->part[pixel];
}

static void average_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct average *a = user;
    for (uint32_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < a->pixels->width; x++)
            a->out[(size_t)y * a->pixels->width + x] = average_at(a, x, y);
}

void lf_block_average(const struct lf_encode_scene *scene, const struct lf_pixel_clues *pixels,
                      const float *part, const float *weight, bool lobes, float *out)
{
    struct average average = {pixels, part, weight, lobes, out};
    ng_jobs_for(scene->jobs, pixels->height, ROWS, average_rows, &average);
}

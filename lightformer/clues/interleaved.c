// First, by bytes, where all rays of a block found the same, which is nearly everywhere; then the bilateral
// filter over the others.
#include "lightformer/clues/interleaved.h"

#include "lightformer/clues/clues_internal.h"

#include <string.h>

#define ROWS   4      // a job
#define NARROW 0.1f   // alpha
#define SAME   0.999f // overlap of lobes

const unsigned char lf_interleave_order[LF_INTERLEAVE * LF_INTERLEAVE] = {0, 8,  2, 10, 12, 4, 14, 6,
                                                                          3, 11, 1, 9,  15, 7, 13, 5};

void lf_interleave_window(float at, float out[LF_INTERLEAVE_TAPS])
{
    for (int i = 0; i < LF_INTERLEAVE_TAPS; i++)
        out[i] = ng_clamp(0.5f * LF_INTERLEAVE + 0.5f - fabsf((float)i - at), 0.0f, 1.0f);
}

// What a pixel and its neighbours in its row found.
static unsigned char *found_of(const struct lf_interleaved *rays)
{
    return (unsigned char *)rays->scratch;
}

struct asking {
    const struct lf_pixel_clues *pixels;
    const struct lf_interleaved *rays;
};

// In most blocks all rays found the same: then nothing has to be weighed. Sets of bytes are found out
// quickly.
static void ask_row(const struct asking *a, uint32_t y)
{
    const uint32_t width = a->pixels->width, half = LF_INTERLEAVE_HALF;
    const float *part = a->rays->part + (size_t)y * width, *weight = a->rays->weight + (size_t)y * width;
    unsigned char *out = found_of(a->rays) + (size_t)y * width;
    memset(out, 0, width);
    for (uint32_t x = 0; x < width; x++) {
        unsigned char found =
            (unsigned char)((part[x] > 0 ? LF_FOUND_LIT : 0) | (part[x] < 1 ? LF_FOUND_HIDDEN : 0));
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

void lf_interleaved_collect(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                            const struct lf_interleaved *rays)
{
    struct asking asking = {pixels, rays};
    ng_jobs_for(scene->jobs, pixels->height, ROWS, ask_rows, &asking);
}

// The neighbours of a pixel, within the picture.
struct neighbours {
    uint32_t x0, y0, x1, y1; // ends are outside
};

static struct neighbours find_neighbours(const struct lf_pixel_clues *p, uint32_t x, uint32_t y)
{
    const uint32_t half = LF_INTERLEAVE_HALF;
    return (struct neighbours){x > half ? x - half : 0, y > half ? y - half : 0,
                               x + half < p->width ? x + half + 1 : p->width,
                               y + half < p->height ? y + half + 1 : p->height};
}

unsigned lf_interleaved_found(const struct lf_pixel_clues *pixels, const struct lf_interleaved *rays,
                              uint32_t x, uint32_t y)
{
    struct neighbours n = find_neighbours(pixels, x, y);
    unsigned found = 0;
    for (size_t row = n.y0; row < n.y1; row++)
        found |= found_of(rays)[row * pixels->width + x];
    return found;
}

// ---- averages --------------------------------------------------------------------------------------------

struct average {
    const struct lf_pixel_clues *pixels;
    const struct lf_interleaved *rays;
    bool specular;
    float *out;
};

// How much of a neighbour's lobe is in the pixel's: GGX of the normal between, the peak being 1.
static float lobe_overlap(const struct lf_pixel_clues *p, size_t pixel, size_t other)
{
    float chord = 0, alpha = ng_brdf_alpha(p->roughness[pixel]); // squared: 2 - 2 cosine, 0 for equal normals
    for (int c = 0; c < 3; c++) {
        float apart = p->normal[c][pixel] - p->normal[c][other];
        chord += apart * apart;
    }
    float cosine = fmaxf(1 - 0.5f * chord, 1e-3f), sine = chord * (1 - 0.25f * chord);
    float spread = 1 + fmaxf(sine, 0) / (cosine * cosine * alpha * alpha);
    return 1 / (spread * spread);
}

// A narrow lobe has an answer of its own, which only neighbours know that look into the same directions.
static float lobe_weight(const struct lf_pixel_clues *p, size_t pixel, size_t other)
{
    float overlap = lobe_overlap(p, pixel, other);
    bool narrow = ng_brdf_alpha(p->roughness[pixel]) < NARROW;
    return narrow && overlap < SAME ? 0 : overlap;
}

static float weigh(const struct average *a, uint32_t x, uint32_t y)
{
    const struct lf_pixel_clues *p = a->pixels;
    struct neighbours n = find_neighbours(p, x, y);
    size_t pixel = (size_t)y * p->width + x;
    float window[LF_INTERLEAVE_TAPS], sum = 0, weights = 0;
    lf_interleave_window(LF_INTERLEAVE_HALF, window);
    for (uint32_t row = n.y0; row < n.y1; row++)
        for (uint32_t column = n.x0; column < n.x1; column++) {
            size_t other = (size_t)row * p->width + column;
            if (!(a->rays->weight[other] > 0))
                continue;
            float weight = a->rays->weight[other] * window[row + LF_INTERLEAVE_HALF - y] *
                           window[column + LF_INTERLEAVE_HALF - x] * lf_bilateral_weight(p, pixel, other);
            if (a->specular)
                weight *= lobe_weight(p, pixel, other);
            weights += weight;
            sum += weight * a->rays->part[other];
        }
    return weights > 0 && isfinite(weights) ? sum / weights : a->rays->part[pixel];
}

static void average_row(const struct average *a, uint32_t y)
{
    const struct lf_pixel_clues *p = a->pixels;
    for (uint32_t x = 0; x < p->width; x++) {
        size_t pixel = (size_t)y * p->width + x;
        unsigned found = lf_interleaved_found(p, a->rays, x, y);
        bool agreed = found != (LF_FOUND_LIT | LF_FOUND_HIDDEN);
        a->out[pixel] = found == LF_FOUND_LIT ? 1 : 0;
        if (!(p->mask[pixel] > 0))
            a->out[pixel] = 0;
        else if (!agreed)
            a->out[pixel] = weigh(a, x, y);
    }
}

static void average_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    for (uint32_t y = begin; y < end; y++)
        average_row(user, y);
}

void lf_interleaved_filter(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                           const struct lf_interleaved *rays, bool specular, float *out)
{
    struct average average = {pixels, rays, specular, out};
    lf_interleaved_collect(scene, pixels, rays);
    ng_jobs_for(scene->jobs, pixels->height, ROWS, average_rows, &average);
}

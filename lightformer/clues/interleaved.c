// First, by bytes, where all rays of a block found the same, which is nearly everywhere; then the bilateral
// filter over the others.
#include "lightformer/clues/interleaved.h"

#include "lightformer/clues/clues_internal.h"

#include <string.h>

#define ROWS 4 // a job

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

// A neighbourhood that reaches over the picture's edge, where nothing is.
struct padded {
    float planes[11][LF_INTERLEAVE_TAPS][LF_LANES + LF_INTERLEAVE_TAPS - 1];
};

static const float *pad(const struct lf_pixel_clues *p, const float *plane, uint32_t x, uint32_t y,
                        float out[LF_INTERLEAVE_TAPS][LF_LANES + LF_INTERLEAVE_TAPS - 1])
{
    const uint32_t half = LF_INTERLEAVE_HALF;
    for (uint32_t j = 0; j < LF_INTERLEAVE_TAPS; j++)
        for (uint32_t i = 0; i < LF_LANES + LF_INTERLEAVE_TAPS - 1; i++) {
            uint32_t column = x + i - half, row = y + j - half; // wraps left of the picture and above
            bool inside = column < p->width && row < p->height;
            out[j][i] = inside ? plane[(size_t)row * p->width + column] : 0;
        }
    return &out[half][half];
}

static struct lf_neighbourhood neighbourhood(const struct average *a, uint32_t x, uint32_t y,
                                             struct padded *room)
{
    const struct lf_pixel_clues *p = a->pixels;
    const uint32_t half = LF_INTERLEAVE_HALF;
    bool inside = x >= half && y >= half && x + LF_LANES + half <= p->width && y + half < p->height;
    struct lf_neighbourhood n = {.mask = p->mask,
                                 .distance = p->distance,
                                 .roughness = p->roughness,
                                 .part = a->rays->part,
                                 .weight = a->rays->weight,
                                 .stride = inside ? p->width : LF_LANES + LF_INTERLEAVE_TAPS - 1};
    for (int c = 0; c < 3; c++) {
        n.position[c] = p->position[c];
        n.normal[c] = p->normal[c];
    }
    const float **planes[] = {&n.position[0], &n.position[1], &n.position[2], &n.normal[0],
                              &n.normal[1],   &n.normal[2],   &n.mask,        &n.distance,
                              &n.roughness,   &n.part,        &n.weight};
    for (size_t i = 0; i < NG_COUNT(planes); i++)
        *planes[i] =
            inside ? *planes[i] + (size_t)y * p->width + x : pad(p, *planes[i], x, y, room->planes[i]);
    return n;
}

// Where all rays around a pixel found the same, that is the mean.
static void average_lanes(const struct average *a, uint32_t x, uint32_t y)
{
    const struct lf_pixel_clues *p = a->pixels;
    uint32_t count = p->width - x < LF_LANES ? p->width - x : LF_LANES;
    size_t first = (size_t)y * p->width + x;
    unsigned found[LF_LANES];
    bool agreed = true;
    for (uint32_t i = 0; i < count; i++) {
        found[i] = p->mask[first + i] > 0 ? lf_interleaved_found(p, a->rays, x + i, y) : 0;
        a->out[first + i] = found[i] == LF_FOUND_LIT ? 1 : 0;
        agreed = agreed && found[i] != (LF_FOUND_LIT | LF_FOUND_HIDDEN);
    }
    if (agreed)
        return;
    float mean[LF_LANES];
    struct padded room;
    const struct lf_neighbourhood n = neighbourhood(a, x, y, &room);
    lf_kernels_of(0)->average(&n, a->specular, mean);
    for (uint32_t i = 0; i < count; i++)
        if (found[i] == (LF_FOUND_LIT | LF_FOUND_HIDDEN))
            a->out[first + i] = mean[i];
}

static void average_row(const struct average *a, uint32_t y)
{
    for (uint32_t x = 0; x < a->pixels->width; x += LF_LANES)
        average_lanes(a, x, y);
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

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

bool lf_interleaved_asks_first(const struct lf_pixel_clues *p, uint32_t x, uint32_t y)
{
    bool turn = x % 2 == x / LF_INTERLEAVE % 2 && y % 2 == y / LF_INTERLEAVE % 2;
    return turn || p->relief.items[(size_t)y * p->width + x] & LF_EDGE;
}

// Planes of bytes in scratch: what a pixel found, what it and its neighbours in its row did, and those of all
// rows around it.
enum { OWN, ROW, BLOCK };

static unsigned char *found_of(const struct lf_pixel_clues *p, const struct lf_interleaved *rays, int plane)
{
    return (unsigned char *)rays->scratch + (size_t)plane * p->width * p->height;
}

struct asking {
    const struct lf_pixel_clues *pixels;
    const struct lf_interleaved *rays;
};

static void collect_row(const struct asking *a, uint32_t y)
{
    const uint32_t width = a->pixels->width;
    const size_t first = (size_t)y * width;
    const float *part = a->rays->part + first, *weight = a->rays->weight + first;
    unsigned char *own = found_of(a->pixels, a->rays, OWN) + first,
                  *row = found_of(a->pixels, a->rays, ROW) + first;
    for (uint32_t x = 0; x < width; x++) {
        unsigned char lit = part[x] > 0 ? LF_FOUND_LIT : 0, hidden = part[x] < 1 ? LF_FOUND_HIDDEN : 0;
        own[x] = weight[x] > 0 ? lit | hidden : 0;
    }
    memcpy(row, own, width);
    for (uint32_t k = 1; k <= LF_INTERLEAVE_HALF && k < width; k++)
        for (uint32_t x = 0; x < width - k; x++) {
            row[x] |= own[x + k];
            row[x + k] |= own[x];
        }
}

static void collect_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    for (uint32_t y = begin; y < end; y++)
        collect_row(user, y);
}

static void collect_blocks(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct asking *a = user;
    const uint32_t width = a->pixels->width, height = a->pixels->height, half = LF_INTERLEAVE_HALF;
    const unsigned char *rows = found_of(a->pixels, a->rays, ROW);
    for (uint32_t y = begin; y < end; y++) {
        unsigned char *block = found_of(a->pixels, a->rays, BLOCK) + (size_t)y * width;
        memcpy(block, rows + (size_t)y * width, width);
        for (uint32_t other = y > half ? y - half : 0; other < height && other <= y + half; other++)
            for (uint32_t x = 0; x < width; x++)
                block[x] |= rows[(size_t)other * width + x];
    }
}

void lf_interleaved_collect(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                            const struct lf_interleaved *rays)
{
    struct asking asking = {pixels, rays};
    ng_jobs_for(scene->jobs, pixels->height, 4 * ROWS, collect_rows, &asking);
    ng_jobs_for(scene->jobs, pixels->height, 4 * ROWS, collect_blocks, &asking);
}

unsigned lf_interleaved_found(const struct lf_pixel_clues *pixels, const struct lf_interleaved *rays,
                              uint32_t x, uint32_t y)
{
    return found_of(pixels, rays, BLOCK)[(size_t)y * pixels->width + x];
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

// ---- edges -----------------------------------------------------------------------------------------------

struct owning {
    const struct lf_pixel_clues *pixels;
    const struct lf_interleaved *rays;
    float own, *out;
};

static void own_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct owning *o = user;
    const struct lf_pixel_clues *p = o->pixels;
    for (uint32_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < p->width; x++) {
            size_t i = (size_t)y * p->width + x;
            if (p->relief.items[i] & LF_EDGE && o->rays->weight[i] > 0 &&
                lf_interleaved_found(p, o->rays, x, y) == (LF_FOUND_LIT | LF_FOUND_HIDDEN))
                o->out[i] += o->own * (o->rays->part[i] - o->out[i]);
        }
}

void lf_interleaved_own_at_edges(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                                 const struct lf_interleaved *rays, float own, float *out)
{
    struct owning owning = {pixels, rays, own, out};
    ng_jobs_for(scene->jobs, pixels->height, ROWS, own_rows, &owning);
}

// Indirect light by rays over the hemisphere of each point of the grid: two, and where they end near by,
// where light changes from point to point, two more. A block of 4 x 4 points has 32 of 256 directions (64),
// and four blocks have all of them. Every point takes the mean of the block around it, weighed by plane and
// normal (lf_bilateral_weight), along rows and then along columns, and a wide mean, of nine such blocks: a
// mean may be as wide as what is met is far away. Coarse, but it knows what stands in the way, which light of
// RSM texels (rsm_gather.c) does not.
#include "lightformer/clues/clues_internal.h"

#include <string.h>

#define SIDE       4 // points of a block each way
#define RAYS       LF_HEMISPHERE_RAYS
#define DIRECTIONS (LF_INTERLEAVE_DIRECTIONS * 2 * RAYS)
_Static_assert(SIDE == LF_INTERLEAVE, "a block holds all that lf_interleave_direction spreads over one");
_Static_assert(LF_HEMISPHERE_TAPS == SIDE + 1, "a block whose outer points count half");

// How far away, in widths of the wide mean, what is met is where that mean begins to count, and where it is
// all.
#define WIDE_BEGINS 0.5f
#define WIDE_WHOLE  2.0f
#define WIDE_POINTS (4 * SIDE) // width of the wide mean: four of its standard deviations

// ---- rays ------------------------------------------------------------------------------------------------

struct casting {
    const struct lf_clues_scene *scene;
    struct lf_pixel_clues *pixels;
    float spiral[DIRECTIONS][3]; // as lf_brdf_samples
};

// Cosine-weighted. Rays of a point look to different sides.
static void choose_direction(const struct casting *job, const struct lf_shading_point *at, uint32_t x,
                             uint32_t y, uint32_t ray, float out[3])
{
    static const unsigned char order[2 * RAYS] = {0, 2, 1, 3};
    const float *u = job->spiral[lf_interleave_direction(x, y) * 2 * RAYS + order[ray]];
    struct ng_local_direction l = ng_brdf_cosine(u[0], u[1], u[2]);
    const struct lf_frame frame = lf_frame_toward(at->normal, at->view);
    lf_local_to_world(&frame, &l, out);
}

// A direction that would lead into the surface stays zero: it meets nothing, and misses nothing.
static void cast(const struct casting *job, uint32_t point, uint32_t ray, struct lf_secondary_hit *hit)
{
    struct lf_pixel_clues *p = job->pixels;
    uint32_t x = point % p->grid_width, y = point / p->grid_width;
    size_t pixel = lf_grid_pixel(p, x, y);
    struct lf_shading_point at;
    float position[3];
    *hit = (struct lf_secondary_hit){.pixel = (uint32_t)pixel,
                                     .interleave_index = (lf_interleave_index(x, y) + 5 * ray) %
                                                         (LF_INTERLEAVE * LF_INTERLEAVE)};
    if (!(p->mask[pixel] > 0))
        return;
    lf_pixel_position(p, pixel, position);
    lf_pixel_shading_point(p, pixel, &at);
    choose_direction(job, &at, x, y, ray, hit->direction);
    if (lf_dot(hit->direction, at.flat) > 0)
        lf_secondary_cast(job->scene, &p->space, position, at.flat, 1, hit);
    else
        memset(hit->direction, 0, sizeof hit->direction);
}

static void cast_first(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct casting *job = user;
    for (uint32_t point = begin; point < end; point++)
        for (uint32_t ray = 0; ray < RAYS; ray++)
            cast(job, point, ray, &job->pixels->hemisphere.hits.items[(size_t)point * RAYS + ray]);
}

static void cast_more(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct casting *job = user;
    struct lf_hemisphere *h = &job->pixels->hemisphere;
    struct lf_secondary_hit *hits = h->hits.items + RAYS * lf_grid_points(job->pixels);
    for (uint32_t i = begin; i < end; i++)
        for (uint32_t ray = 0; ray < RAYS; ray++)
            cast(job, h->more.items[i], RAYS + ray, &hits[(size_t)i * RAYS + ray]);
}

// ---- neighbours ------------------------------------------------------------------------------------------

// A mean over neighbours in a row or a column.
struct pass {
    uint32_t taps, step; // points from one to the next
    bool down;
    float window[LF_HEMISPHERE_TAPS];
};

// The block around a point, then the blocks around that.
static const struct pass passes[LF_HEMISPHERE_PASSES] = {
    {.taps = SIDE + 1, .step = 1, .down = false, .window = {0.5f, 1, 1, 1, 0.5f}},
    {.taps = SIDE + 1, .step = 1, .down = true, .window = {0.5f, 1, 1, 1, 0.5f}},
    {.taps = 5, .step = SIDE, .down = false, .window = {1, 4, 6, 4, 1}},
    {.taps = 5, .step = SIDE, .down = true, .window = {1, 4, 6, 4, 1}},
};
#define NARROW 2 // passes to the block's mean

// Place `k` of a pass around a point. False if it is outside.
static bool neighbour(const struct lf_pixel_clues *p, const struct pass *pass, uint32_t x, uint32_t y,
                      uint32_t k, size_t *out)
{
    uint32_t offset =
        (k - pass->taps / 2) * pass->step; // wraps, as what is left or above of the picture does
    uint32_t column = x + (pass->down ? 0 : offset), row = y + (pass->down ? offset : 0);
    *out = (size_t)row * p->grid_width + column;
    return column < p->grid_width && row < p->grid_height;
}

static float *weights_of(const struct lf_pixel_clues *p, uint32_t pass, size_t point)
{
    return p->hemisphere.weights.items + (pass * lf_grid_points(p) + point) * LF_HEMISPHERE_TAPS;
}

static void weigh(struct lf_pixel_clues *p, uint32_t pass, uint32_t x, uint32_t y)
{
    size_t at = (size_t)y * p->grid_width + x, pixel = lf_grid_pixel(p, x, y), other;
    float *weight = weights_of(p, pass, at), sum = 0;
    for (uint32_t k = 0; k < passes[pass].taps; k++) {
        weight[k] = 0;
        if (!neighbour(p, &passes[pass], x, y, k, &other))
            continue;
        size_t of = lf_grid_pixel(p, other % p->grid_width, other / p->grid_width);
        weight[k] = passes[pass].window[k] * lf_bilateral_weight(p, pixel, of);
        sum += weight[k];
    }
    for (uint32_t k = 0; k < passes[pass].taps; k++)
        weight[k] = sum > 0 ? weight[k] / sum : 0;
}

static void weigh_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct casting *job = user;
    for (uint32_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < job->pixels->grid_width; x++)
            for (uint32_t pass = 0; pass < LF_HEMISPHERE_PASSES; pass++)
                weigh(job->pixels, pass, x, y);
}

struct averaging {
    const struct lf_pixel_clues *pixels;
    const float *from; // [channels][grid points]
    float *to;
    uint32_t pass, channels;
};

static void average_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct averaging *job = user;
    const struct lf_pixel_clues *p = job->pixels;
    const struct pass *pass = &passes[job->pass];
    size_t points = lf_grid_points(p);
    for (uint32_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < p->grid_width; x++) {
            size_t at = (size_t)y * p->grid_width + x, other;
            const float *weight = weights_of(p, job->pass, at);
            float sum[LF_HIT_CHANNELS] = {0};
            for (uint32_t k = 0; k < pass->taps; k++)
                if (neighbour(p, pass, x, y, k, &other))
                    for (size_t c = 0; c < job->channels; c++)
                        sum[c] += weight[k] * job->from[c * points + other];
            for (size_t c = 0; c < job->channels; c++)
                job->to[c * points + at] = sum[c];
        }
}

// Passes from one plane to another and back, so of an even number.
static void average(const struct lf_clues_scene *scene, const struct lf_pixel_clues *p, uint32_t first,
                    uint32_t channels, float *planes, float *between)
{
    for (uint32_t pass = first; pass < first + 2; pass++) {
        bool back = pass % 2;
        struct averaging job = {p, back ? between : planes, back ? planes : between, pass, channels};
        ng_jobs_for(scene->jobs, p->grid_height, 8, average_rows, &job);
    }
}

// ---- how far things are ----------------------------------------------------------------------------------

// Harmonic mean of the distances that a block's rays go, over the width of the wide mean there. What is met
// near by rules it, as it does the change of light (Ward and Heckbert 1992).
static void find_open(const struct lf_clues_scene *scene, struct lf_pixel_clues *p, float focal,
                      float *scratch)
{
    struct lf_hemisphere *h = &p->hemisphere;
    size_t points = lf_grid_points(p);
    for (size_t i = 0; i < points; i++) {
        const struct lf_secondary_hit *hits = h->hits.items + i * RAYS;
        float width = WIDE_POINTS * LF_GRID_STEP * p->distance[hits->pixel] / focal, sum = 0;
        for (int ray = 0; ray < RAYS; ray++)
            sum += hits[ray].met ? fminf(width / lf_max(hits[ray].distance, 1e-9f), 1e3f) : 0;
        h->open.items[i] = sum / RAYS;
    }
    average(scene, p, 0, 1, h->open.items, scratch);
    h->more.count = 0;
    for (size_t i = 0; i < points; i++) {
        float far = 1 / lf_max(h->open.items[i], 1e-6f);
        h->open.items[i] = ng_clamp((far - WIDE_BEGINS) / (WIDE_WHOLE - WIDE_BEGINS), 0.0f, 1.0f);
        if (h->open.items[i] < 1 && p->mask[h->hits.items[i * RAYS].pixel] > 0)
            h->more.items[h->more.count++] = (uint32_t)i;
    }
}

// ---- what arrives ----------------------------------------------------------------------------------------

// The mean of the rays of each point. `hits`: [hits][LF_HIT_CHANNELS].
static void add_channels(const struct lf_pixel_clues *p, const float *hits, uint32_t channels, float *out)
{
    const struct lf_hemisphere *h = &p->hemisphere;
    size_t points = lf_grid_points(p), next = 0;
    for (size_t i = 0; i < points; i++) {
        bool more = next < h->more.count && h->more.items[next] == i;
        const float *first = hits + i * RAYS * LF_HIT_CHANNELS,
                    *others = hits + (points + next) * RAYS * LF_HIT_CHANNELS;
        for (uint32_t c = 0; c < channels; c++) {
            float sum = 0;
            for (uint32_t ray = 0; ray < RAYS; ray++)
                sum += first[ray * LF_HIT_CHANNELS + c] + (more ? others[ray * LF_HIT_CHANNELS + c] : 0);
            out[c * points + i] = lf_finite(sum / (float)(more ? 2 * RAYS : RAYS));
        }
        next += more;
    }
}

// The point of the grid around a pixel that is most like it, however little; the one above left of equal
// ones.
static size_t most_alike(const struct lf_pixel_clues *p, size_t pixel)
{
    uint32_t x = (uint32_t)(pixel % p->width) / LF_GRID_STEP, y = (uint32_t)(pixel / p->width) / LF_GRID_STEP;
    size_t best = (size_t)y * p->grid_width + x;
    float most = -1;
    for (uint32_t k = 0; k < 4; k++) {
        uint32_t column = x + (k & 1), row = y + (k >> 1);
        if (column >= p->grid_width || row >= p->grid_height)
            continue;
        size_t other = lf_grid_pixel(p, column, row);
        float like = p->mask[other] > 0 ? lf_bilateral_weight(p, pixel, other) : -0.5f;
        if (like > most) {
            most = like;
            best = (size_t)row * p->grid_width + column;
        }
    }
    return best;
}

static void fill_alone(const struct lf_pixel_clues *p, const float *grid, uint32_t channels,
                       float *const out[])
{
    for (size_t i = 0; i < p->alone.count; i++) {
        size_t pixel = p->alone.items[i], from = most_alike(p, pixel);
        for (size_t c = 0; c < channels; c++)
            out[c][pixel] = grid[c * lf_grid_points(p) + from];
    }
}

// Means of what the points' rays found, on the grid and then at the pixels. `scratch`:
// [2][channels][grid points].
static void spread(const struct lf_clues_scene *scene, const struct lf_pixel_clues *p, const float *hits,
                   uint32_t channels, float *narrow, float *scratch, float *const out[])
{
    size_t points = lf_grid_points(p);
    float *wide = scratch, *between = scratch + channels * points;
    add_channels(p, hits, channels, narrow);
    average(scene, p, 0, channels, narrow, between);
    memcpy(wide, narrow, channels * points * sizeof *wide);
    average(scene, p, NARROW, channels, wide, between);
    for (size_t c = 0; c < channels; c++)
        for (size_t i = 0; i < points; i++)
            narrow[c * points + i] +=
                p->hemisphere.open.items[i] * (wide[c * points + i] - narrow[c * points + i]);
    lf_grid_spread(scene, p, narrow, channels, out);
    fill_alone(p, narrow, channels, out);
}

// What hits are, but for light.
static void fill_pixels(const struct lf_clues_scene *scene, struct lf_pixel_clues *p, float *scratch)
{
    const struct lf_hemisphere *h = &p->hemisphere;
    size_t points = lf_grid_points(p);
    float *seen = scratch, *planes = seen + LF_HIT_CHANNELS * h->hits.count;
    for (size_t i = 0; i < h->hits.count; i++) {
        const struct lf_secondary_hit *hit = &h->hits.items[i];
        float *out = seen + i * LF_HIT_CHANNELS;
        lf_mad(hit->albedo, hit->f0, 1, out);
        out[3] = !hit->met && lf_dot(hit->direction, hit->direction) > 0 ? 1 : 0;
    }
    float *out[LF_HIT_CHANNELS] = {p->gathered_albedo[0], p->gathered_albedo[1], p->gathered_albedo[2],
                                   p->gathered_missed};
    spread(scene, p, seen, LF_HIT_CHANNELS, planes, planes + LF_HIT_CHANNELS * points, out);
    p->values.of[LF_INPUT_PIXEL_GATHERED_ALBEDO] = p->gathered_albedo[0];
    p->values.of[LF_INPUT_PIXEL_GATHERED_MISSED] = p->gathered_missed;
}

static bool wants_any(const struct lf_clues_scene *s)
{
    return lf_clues_wants(s, LF_INPUT_PIXEL_GATHERED) || lf_clues_wants(s, LF_INPUT_PIXEL_GATHERED_ALBEDO) ||
           lf_clues_wants(s, LF_INPUT_PIXEL_GATHERED_MISSED);
}

ng_result lf_hemisphere_cast(const struct lf_clues_scene *scene, float focal, struct lf_pixel_clues *out)
{
    struct casting job = {.scene = scene, .pixels = out};
    struct lf_hemisphere *h = &out->hemisphere;
    struct lf_memory *memory = &out->memory[LF_PIXEL_GRID];
    uint32_t points = (uint32_t)lf_grid_points(out);
    LF_PART(float) scratch;
    if (!wants_any(scene))
        return NG_OK;
    if (!lf_take(memory, &h->hits, 2 * RAYS * (size_t)points) ||
        !lf_take(memory, &h->weights, LF_HEMISPHERE_PASSES * LF_HEMISPHERE_TAPS * (size_t)points) ||
        !lf_take(memory, &h->open, points) || !lf_take(memory, &h->more, points) ||
        !lf_take(memory, &scratch, (size_t)points * LF_HEMISPHERE_SCRATCH))
        return ng_out_of_memory("the surroundings of a picture");
    lf_brdf_spiral(DIRECTIONS, job.spiral);
    ng_jobs_for(scene->jobs, points, 256, cast_first, &job);
    ng_jobs_for(scene->jobs, out->grid_height, 1, weigh_rows, &job);
    find_open(scene, out, focal, scratch.items);
    ng_jobs_for(scene->jobs, (uint32_t)h->more.count, 256, cast_more, &job);
    h->hits.count = RAYS * (points + h->more.count);
    fill_pixels(scene, out, scratch.items);
    return NG_OK;
}

ng_result lf_hemisphere_light(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                              struct lf_light_clues *light)
{
    size_t hits = pixels->hemisphere.hits.count;
    if (!lf_take(&light->memory[LF_LIGHT_HITS], &light->hemisphere, LF_HIT_CHANNELS * hits))
        return ng_out_of_memory("the view of a light");
    lf_secondary_light(scene, light, pixels->hemisphere.hits.items, (uint32_t)hits, 0,
                       light->hemisphere.items);
    return NG_OK;
}

void lf_hemisphere_spread(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                          const float *seen, float *scratch, float *const out[3])
{
    spread(scene, pixels, seen, 3, scratch, scratch + 3 * lf_grid_points(pixels), out);
}

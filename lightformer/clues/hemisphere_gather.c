// Indirect light by rays over the hemisphere: two for each point of the grid, in two of 128 directions,
// interleaved over blocks of 8 x 8 points, lit where they end by each light on its own. Each point takes the
// mean of a block around it, weighed by plane and normal (lf_bilateral_weight), along rows and then along
// columns; then the mean of three such means half a block apart, each way, since rays from different places
// do not agree as well as different directions do. Coarse, but it knows what stands in the way, which light
// of RSM texels (rsm_gather.c) does not.
#include "lightformer/clues/clues_internal.h"

#include <string.h>

#define SIDE       8 // points of a block each way
#define DIRECTIONS (SIDE * SIDE * LF_HEMISPHERE_RAYS)
_Static_assert(LF_HEMISPHERE_TAPS == SIDE + 1, "a block whose outer points count half");

// ---- rays ------------------------------------------------------------------------------------------------

struct casting {
    const struct lf_clues_scene *scene;
    struct lf_pixel_clues *pixels;
    float spiral[DIRECTIONS][3]; // as lf_brdf_samples
};

// Cosine-weighted.
static void choose_direction(const struct casting *job, const float normal[3], uint32_t x, uint32_t y,
                             uint32_t ray, float out[3])
{
    const float *u = job->spiral[lf_interleave_direction(x, y) * LF_HEMISPHERE_RAYS + ray];
    struct ng_local_direction l = ng_brdf_cosine(u[0], u[1], u[2]);
    const struct lf_frame frame = lf_frame_around(normal[0], normal[1], normal[2]);
    lf_local_to_world(&frame, &l, out);
}

static void cast_at(const struct casting *job, uint32_t x, uint32_t y, uint32_t ray)
{
    struct lf_pixel_clues *p = job->pixels;
    size_t pixel = lf_grid_pixel(p, x, y);
    struct lf_secondary_hit *hit =
        &p->hemisphere.hits.items[ray * lf_grid_points(p) + (size_t)y * p->grid_width + x];
    struct lf_shading_point point;
    float position[3];
    *hit = (struct lf_secondary_hit){.pixel = (uint32_t)pixel, .interleave_index = lf_interleave_index(x, y)};
    if (!(p->mask[pixel] > 0))
        return;
    lf_pixel_position(p, pixel, position);
    lf_pixel_shading_point(p, pixel, &point);
    choose_direction(job, point.normal, x, y, ray, hit->direction);
    if (lf_dot(hit->direction, point.flat) > 0)
        lf_secondary_cast(job->scene, &p->space, position, point.flat, 1, hit);
}

static void cast_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct casting *job = user;
    for (uint32_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < job->pixels->grid_width; x++)
            for (uint32_t ray = 0; ray < LF_HEMISPHERE_RAYS; ray++)
                cast_at(job, x, y, ray);
}

// ---- neighbours ------------------------------------------------------------------------------------------

// A mean over neighbours in a row or a column.
struct pass {
    uint32_t taps, step; // points from one to the next
    bool down;
    float window[LF_HEMISPHERE_TAPS];
};

static const struct pass passes[LF_HEMISPHERE_PASSES] = {
    {.taps = SIDE + 1, .step = 1, .down = false, .window = {0.5f, 1, 1, 1, 1, 1, 1, 1, 0.5f}},
    {.taps = SIDE + 1, .step = 1, .down = true, .window = {0.5f, 1, 1, 1, 1, 1, 1, 1, 0.5f}},
    {.taps = 3, .step = SIDE / 2, .down = false, .window = {1, 2, 1}},
    {.taps = 3, .step = SIDE / 2, .down = true, .window = {1, 2, 1}},
};

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
    size_t at = (size_t)y * p->grid_width + x, other;
    float *weight = weights_of(p, pass, at), sum = 0;
    for (uint32_t k = 0; k < passes[pass].taps; k++) {
        weight[k] = 0;
        if (!neighbour(p, &passes[pass], x, y, k, &other))
            continue;
        size_t pixel = p->hemisphere.hits.items[other].pixel;
        weight[k] =
            passes[pass].window[k] * lf_bilateral_weight(p, p->hemisphere.hits.items[at].pixel, pixel);
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

ng_result lf_hemisphere_cast(const struct lf_clues_scene *scene, struct lf_pixel_clues *out)
{
    struct casting job = {.scene = scene, .pixels = out};
    size_t points = lf_grid_points(out);
    if (!lf_clues_wants(scene, LF_INPUT_PIXEL_GATHERED))
        return NG_OK;
    struct lf_memory *memory = &out->memory[LF_PIXEL_GRID];
    if (!lf_take(memory, &out->hemisphere.hits, LF_HEMISPHERE_RAYS * points) ||
        !lf_take(memory, &out->hemisphere.weights, LF_HEMISPHERE_PASSES * LF_HEMISPHERE_TAPS * points))
        return ng_out_of_memory("the surroundings of a picture");
    lf_brdf_spiral(DIRECTIONS, job.spiral);
    ng_jobs_for(scene->jobs, out->grid_height, 1, cast_rows, &job);
    ng_jobs_for(scene->jobs, out->grid_height, 1, weigh_rows, &job);
    return NG_OK;
}

// ---- what arrives ----------------------------------------------------------------------------------------

struct averaging {
    const struct lf_pixel_clues *pixels;
    const float *from; // [3][grid points]
    float *to;
    uint32_t pass;
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
            float sum[3] = {0};
            for (uint32_t k = 0; k < pass->taps; k++)
                if (neighbour(p, pass, x, y, k, &other))
                    for (size_t c = 0; c < 3; c++)
                        sum[c] += weight[k] * job->from[c * points + other];
            for (size_t c = 0; c < 3; c++)
                job->to[c * points + at] = sum[c];
        }
}

// The mean of the rays of each point.
static void add_channels(const float *hits, size_t points, float *out)
{
    for (size_t i = 0; i < points; i++)
        for (size_t c = 0; c < 3; c++) {
            float sum = 0;
            for (size_t ray = 0; ray < LF_HEMISPHERE_RAYS; ray++)
                sum += hits[(ray * points + i) * LF_HIT_CHANNELS + c];
            out[c * points + i] = lf_finite(sum / LF_HEMISPHERE_RAYS);
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

static void fill_alone(const struct lf_pixel_clues *p, const float *grid, float *const out[3])
{
    for (size_t i = 0; i < p->alone.count; i++) {
        size_t pixel = p->alone.items[i], from = most_alike(p, pixel);
        for (size_t c = 0; c < 3; c++)
            out[c][pixel] = grid[c * lf_grid_points(p) + from];
    }
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
    size_t points = lf_grid_points(pixels);
    float *first = scratch, *second = scratch + 3 * points;
    add_channels(seen, points, first);
    for (uint32_t pass = 0; pass < LF_HEMISPHERE_PASSES; pass++) {
        bool back = pass % 2; // to the first, after an even number of passes
        struct averaging job = {pixels, back ? second : first, back ? first : second, pass};
        ng_jobs_for(scene->jobs, pixels->grid_height, 8, average_rows, &job);
    }
    lf_grid_spread(scene, pixels, first, out);
    fill_alone(pixels, first, out);
}

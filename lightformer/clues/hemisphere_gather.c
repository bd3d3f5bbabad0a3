// Indirect light by rays over the hemisphere: two for each point of the grid, in two of 128 directions by its
// place in blocks of 8 x 8 points, lit where they end. Each point takes the mean of a block around it, over
// surfaces like its own, along rows and then along columns; then the mean of three such means half a block
// apart, each way, since rays from different places do not agree as well as different directions do. Coarse,
// but it knows what stands in the way, which light of RSM texels (rsm_gather.c) does not.
#include "lightformer/clues/clues_internal.h"

#include <string.h>

#define SIDE       8 // points of a block each way
#define DIRECTIONS (SIDE * SIDE * LF_AROUND_RAYS)
_Static_assert(LF_AROUND_REACH == SIDE + 1, "a block whose outer points count half");

// ---- rays ------------------------------------------------------------------------------------------------

struct casting {
    const struct lf_encode_scene *scene;
    struct lf_pixel_clues *pixels;
    float spiral[DIRECTIONS][3]; // as lf_lobe_samples
};

// Cosine-weighted.
static void choose_direction(const struct casting *job, const float normal[3], uint32_t x, uint32_t y,
                             uint32_t ray, float out[3])
{
    const float *u = job->spiral[lf_block_choice(x, y) * LF_AROUND_RAYS + ray];
    struct ng_local_direction l = ng_brdf_cosine(u[0], u[1], u[2]);
    const struct lf_frame frame = lf_frame_around(normal[0], normal[1], normal[2]);
    lf_lobe_to_world(&frame, &l, out);
}

static void cast_at(const struct casting *job, uint32_t x, uint32_t y, uint32_t ray)
{
    struct lf_pixel_clues *p = job->pixels;
    size_t pixel = lf_grid_pixel(p, x, y);
    struct lf_ray_end *end = &p->around.ends.items[ray * lf_grid_points(p) + (size_t)y * p->grid_width + x];
    struct lf_lobe lobe;
    float position[3];
    *end = (struct lf_ray_end){.pixel = (uint32_t)pixel, .block = lf_block_place(x, y)};
    if (!(p->mask[pixel] > 0))
        return;
    lf_pixel_position(p, pixel, position);
    lf_pixel_lobe(p, pixel, &lobe);
    choose_direction(job, lobe.normal, x, y, ray, end->direction);
    if (lf_dot(end->direction, lobe.flat) > 0)
        lf_ray_cast(job->scene, &p->space, position, lobe.flat, 1, end);
}

static void cast_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct casting *job = user;
    for (uint32_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < job->pixels->grid_width; x++)
            for (uint32_t ray = 0; ray < LF_AROUND_RAYS; ray++)
                cast_at(job, x, y, ray);
}

// ---- neighbours ------------------------------------------------------------------------------------------

// A mean over neighbours in a row or a column.
struct pass {
    uint32_t taps, step; // points from one to the next
    bool down;
    float window[LF_AROUND_REACH];
};

static const struct pass passes[LF_AROUND_PASSES] = {
    {.taps = SIDE + 1, .step = 1, .down = false, .window = {0.5f, 1, 1, 1, 1, 1, 1, 1, 0.5f}},
    {.taps = SIDE + 1, .step = 1, .down = true, .window = {0.5f, 1, 1, 1, 1, 1, 1, 1, 0.5f}},
    {.taps = 3, .step = SIDE / 2, .down = false, .window = {1, 2, 1}},
    {.taps = 3, .step = SIDE / 2, .down = true, .window = {1, 2, 1}},
};

// Place `k` of a pass around a point. False if it is outside.
static bool neighbour(const struct lf_pixel_clues *p, const struct pass *pass, uint32_t x, uint32_t y,
                      uint32_t k, size_t *out)
{
    uint32_t way = (k - pass->taps / 2) * pass->step; // wraps, as what is left or above of the picture does
    uint32_t column = x + (pass->down ? 0 : way), row = y + (pass->down ? way : 0);
    *out = (size_t)row * p->grid_width + column;
    return column < p->grid_width && row < p->grid_height;
}

static float *weights_of(const struct lf_pixel_clues *p, uint32_t pass, size_t point)
{
    return p->around.weights.items + (pass * lf_grid_points(p) + point) * LF_AROUND_REACH;
}

static void weigh(struct lf_pixel_clues *p, uint32_t pass, uint32_t x, uint32_t y)
{
    size_t at = (size_t)y * p->grid_width + x, other;
    float *weight = weights_of(p, pass, at), sum = 0;
    for (uint32_t k = 0; k < passes[pass].taps; k++) {
        weight[k] = 0;
        if (!neighbour(p, &passes[pass], x, y, k, &other))
            continue;
        size_t pixel = p->around.ends.items[other].pixel;
        weight[k] = passes[pass].window[k] * lf_pixel_likeness(p, p->around.ends.items[at].pixel, pixel);
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
            for (uint32_t pass = 0; pass < LF_AROUND_PASSES; pass++)
                weigh(job->pixels, pass, x, y);
}

ng_result lf_around_cast(const struct lf_encode_scene *scene, struct lf_pixel_clues *out)
{
    struct casting job = {.scene = scene, .pixels = out};
    size_t points = lf_grid_points(out);
    if (!lf_encode_wants(scene, LF_INPUT_VIEW_GATHERED))
        return NG_OK;
    if (!ng_array_resize(&out->around.ends, LF_AROUND_RAYS * points) ||
        !ng_array_resize(&out->around.weights, LF_AROUND_PASSES * LF_AROUND_REACH * points))
        return ng_out_of_memory("the surroundings of a picture");
    lf_lobe_wind(DIRECTIONS, job.spiral);
    ng_jobs_for(scene->jobs, out->grid_height, 1, cast_rows, &job);
    ng_jobs_for(scene->jobs, out->grid_height, 1, weigh_rows, &job);
    return NG_OK;
}

// ---- lights ----------------------------------------------------------------------------------------------

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

// Direct light and bounce, the mean of the rays of each point.
static void add_channels(const float *ends, size_t points, float *out)
{
    for (size_t i = 0; i < points; i++)
        for (size_t c = 0; c < 3; c++) {
            float sum = 0;
            for (size_t ray = 0; ray < LF_AROUND_RAYS; ray++) {
                const float *seen = ends + (ray * points + i) * LF_END_CHANNELS;
                sum += seen[c] + seen[3 + c];
            }
            out[c * points + i] = lf_finite(sum / LF_AROUND_RAYS);
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
        float like = p->mask[other] > 0 ? lf_pixel_likeness(p, pixel, other) : -0.5f;
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

ng_result lf_around_light(const struct lf_encode_scene *scene, const struct lf_pixel_clues *pixels,
                          struct lf_light_clues *light, float *const out[3])
{
    size_t points = lf_grid_points(pixels);
    if (!ng_array_resize(&light->around.list, (LF_AROUND_RAYS * LF_END_CHANNELS + 6) * points))
        return ng_out_of_memory("the view of a light");
    float *seen = light->around.list.items, *first = seen + LF_AROUND_RAYS * LF_END_CHANNELS * points,
          *second = first + 3 * points;
    lf_rays_light(scene, light, pixels->around.ends.items, (uint32_t)(LF_AROUND_RAYS * points), 0, seen);
    add_channels(seen, points, first);
    for (uint32_t pass = 0; pass < LF_AROUND_PASSES; pass++) {
        bool back = pass % 2; // to the first, after an even number of passes
        struct averaging job = {pixels, back ? second : first, back ? first : second, pass};
        ng_jobs_for(scene->jobs, pixels->grid_height, 8, average_rows, &job);
    }
    lf_grid_spread(scene, pixels, first, out);
    fill_alone(pixels, first, out);
    return NG_OK;
}

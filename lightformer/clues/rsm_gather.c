// Light of RSM texels varies slowly: it is summed at every fourth pixel each way and spread to the others by
// weights that pixels.c has found once for all lights. Pixels that no neighbour speaks for are summed alone.
#include "lightformer/clues/clues_internal.h"

struct sum {
    const struct lf_pixel_clues *pixels;
    struct lf_light_clues *light;
    const struct lf_rsm_source *sources;
    uint32_t source_count;
    float *const *out;
};

static void sum_lanes(const struct sum *s, const size_t pixels[LF_LANES], float value[3][LF_LANES])
{
    struct lf_shading_points points;
    for (int i = 0; i < LF_LANES; i++)
        lf_shading_points_set_pixel(s->pixels, pixels[i], i, &points);
    lf_kernels_of(0)->rsm_gather(s->sources, s->source_count, &points, value);
}

static void sum_grid(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct sum *s = user;
    const struct lf_pixel_clues *p = s->pixels;
    float *grid = s->light->grid.items;
    size_t n = lf_grid_points(p);
    for (size_t y = begin; y < end; y++)
        for (size_t x = 0; x < p->grid_width; x += LF_LANES) {
            size_t at[LF_LANES];
            float value[3][LF_LANES];
            for (size_t i = 0; i < LF_LANES; i++) {
                size_t column = x + i < p->grid_width ? x + i : p->grid_width - 1;
                at[i] = lf_grid_pixel(p, column, y);
            }
            sum_lanes(s, at, value);
            for (size_t c = 0; c < 3; c++)
                for (size_t i = 0; i < LF_LANES && x + i < p->grid_width; i++)
                    grid[c * n + y * p->grid_width + x + i] = p->mask[at[i]] > 0 ? lf_finite(value[c][i]) : 0;
        }
}

struct spreading {
    const struct lf_pixel_clues *pixels;
    const float *grid;
    uint32_t channels;
    float *const *out;
};

static void spread(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct spreading *s = user;
    const struct lf_pixel_clues *p = s->pixels;
    const float *grid = s->grid;
    size_t n = lf_grid_points(p);
    for (size_t y = begin; y < end; y++) {
        size_t row = y / LF_GRID_STEP, below = row + (row + 1 < p->grid_height);
        for (size_t x = 0; x < p->width; x++) {
            size_t column = x / LF_GRID_STEP, right = column + (column + 1 < p->grid_width);
            const float *w = p->grid_taps.items[y * p->width + x].weight;
            for (size_t c = 0; c < s->channels; c++) {
                const float *from = grid + c * n;
                s->out[c][y * p->width + x] =
                    w[0] * from[row * p->grid_width + column] + w[1] * from[row * p->grid_width + right] +
                    w[2] * from[below * p->grid_width + column] + w[3] * from[below * p->grid_width + right];
            }
        }
    }
}

void lf_grid_spread(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                    const float *grid, uint32_t channels, float *const out[])
{
    struct spreading s = {pixels, grid, channels, out};
    ng_jobs_for(scene->jobs, pixels->height, 8, spread, &s);
}

static void sum_alone(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct sum *s = user;
    size_t count = s->pixels->alone.count;
    for (size_t block = begin; block < end; block++) {
        size_t at[LF_LANES], first = block * LF_LANES;
        float value[3][LF_LANES];
        for (size_t i = 0; i < LF_LANES; i++)
            at[i] = s->pixels->alone.items[first + i < count ? first + i : count - 1];
        sum_lanes(s, at, value);
        for (size_t c = 0; c < 3; c++)
            for (size_t i = 0; i < LF_LANES && first + i < count; i++)
                s->out[c][at[i]] = lf_finite(value[c][i]);
    }
}

ng_result lf_rsm_gather(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                        struct lf_light_clues *light, float *const out[3])
{
    bool few = lf_questions_of(lf_tracer_snapshot(scene->tracer)->light_count) >= LF_ASK_FEW;
    struct sum sum = {.pixels = pixels,
                      .light = light,
                      .sources = few ? light->sources_of_hits.items : light->sources.items,
                      .source_count = (uint32_t)(few ? light->sources_of_hits.count : light->sources.count),
                      .out = out};
    if (!lf_take(&light->memory[LF_LIGHT_VIEW], &light->grid, 3 * lf_grid_points(pixels)))
        return ng_out_of_memory("the view of a light");
    ng_jobs_for(scene->jobs, pixels->grid_height, 1, sum_grid, &sum);
    lf_grid_spread(scene, pixels, light->grid.items, 3, out);
    ng_jobs_for(scene->jobs, (uint32_t)((pixels->alone.count + LF_LANES - 1) / LF_LANES), 4, sum_alone, &sum);
    return NG_OK;
}

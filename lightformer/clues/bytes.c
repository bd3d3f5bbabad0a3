// What a picture takes at most, by the sizes of what the other files keep of it. Most of it are reflections,
// of pictures all of metal.
#include "lightformer/clues/clues_internal.h"

struct picture {
    uint64_t pixels, points, rays, hits; // points: of the grid; hits: every ray may go on once
};

static struct picture measure(uint64_t width, uint64_t height, uint32_t reflection_rays)
{
    struct picture p = {.pixels = width * height};
    uint64_t budget = lf_reflection_budget(p.pixels, reflection_rays);
    budget += lf_reflection_edge_budget(budget);
    p.points = ((width + LF_GRID_STEP - 1) / LF_GRID_STEP) * ((height + LF_GRID_STEP - 1) / LF_GRID_STEP);
    p.rays = budget < p.pixels ? budget + 1 : p.pixels; // parts of it are rounded up
    p.hits = 2 * p.rays;
    return p;
}

static uint64_t larger(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

// What hits show, then averages of pixels in its place; channels as in reflections.c.
static uint64_t bytes_shown(const struct picture *p)
{
    return larger(8 * p->hits, 5 * p->pixels) * sizeof(float);
}

// Sums of what hits show, of either kind of rays, and averages on the way to the pixels.
static uint64_t bytes_arriving(const struct picture *p)
{
    uint64_t hits = LF_HIT_CHANNELS * larger(p->hits, 2 * LF_HEMISPHERE_RAYS * p->points);
    return (hits + larger(3 * p->pixels, 9 * p->points)) * sizeof(float);
}

static uint64_t bytes_of_reflections(const struct picture *p)
{
    const uint64_t lattices = LF_REFLECTION_KINDS * sizeof(uint32_t);
    uint64_t pixel = sizeof(unsigned char) + lattices + sizeof(struct lf_reflection_taps) + sizeof(uint32_t) +
                     sizeof(struct lf_sight) + sizeof(struct lf_reflection_filter_taps);
    return p->pixels * pixel + p->hits * sizeof(struct lf_secondary_hit) +
           p->rays * sizeof(struct lf_reflection_ray);
}

static uint64_t bytes_of_hemisphere(const struct picture *p)
{
    uint64_t floats =
        LF_HEMISPHERE_PASSES * LF_HEMISPHERE_TAPS + 2 + LF_HEMISPHERE_SCRATCH; // 2: `open`, `more`
    return p->points * (2 * LF_HEMISPHERE_RAYS * sizeof(struct lf_secondary_hit) + floats * sizeof(float));
}

// Parts of memory are rounded up; there are fewer of them in any.
#define ROUNDING (16 * LF_MEMORY_ALIGNMENT)

static uint64_t plane_bytes(const struct picture *p)
{
    return (p->pixels + LF_PLANE_GAP) * sizeof(float);
}

uint64_t lf_reflection_rays_at_most(const struct lf_pixel_clues *p)
{
    return measure(p->width, p->height, p->reflection_rays).rays;
}

struct lf_clues_bytes lf_clues_bytes(uint32_t width, uint32_t height, uint32_t reflection_rays)
{
    const struct picture p = measure(width, height, reflection_rays);
    const uint64_t grid = p.pixels * (sizeof(struct lf_grid_taps) + sizeof(uint32_t)); // and pixels alone
    return (struct lf_clues_bytes){{
        [LF_PIXEL_PLANES_PART] = LF_PIXEL_PLANES * plane_bytes(&p) + 2 * p.pixels + ROUNDING,
        [LF_PIXEL_GRID] = grid + bytes_of_hemisphere(&p) + bytes_shown(&p) + ROUNDING,
        [LF_PIXEL_REFLECTIONS] = bytes_of_reflections(&p) + ROUNDING,
        [LF_PIXEL_ARRIVING] = 6 * plane_bytes(&p) + bytes_arriving(&p) + ROUNDING,
    }};
}

uint64_t lf_clues_view_bytes(uint32_t width, uint32_t height)
{
    const struct picture p = measure(width, height, 0);
    return LF_VIEW_PLANES * plane_bytes(&p) + 3 * p.points * sizeof(float) + ROUNDING; // points: RSM gather
}

uint64_t lf_clues_hits_bytes(uint32_t width, uint32_t height, uint32_t reflection_rays)
{
    const struct picture p = measure(width, height, reflection_rays);
    return LF_HIT_CHANNELS * (p.hits + 2 * LF_HEMISPHERE_RAYS * p.points) * sizeof(float) + ROUNDING;
}

uint64_t lf_clues_kept_bytes(uint32_t width, uint32_t height, uint64_t set)
{
    uint64_t bytes = 0;
    for (int i = 0; i < LF_INPUT_COUNT; i++)
        if (lf_net_inputs[i].domain == LF_DOMAIN_VIEW && set >> i & 1)
            bytes += lf_memory_part((uint64_t)width * height * lf_net_inputs[i].channels * sizeof(float));
    return bytes;
}

uint64_t lf_clues_rsm_bytes(uint32_t vpl_count, uint32_t views)
{
    const uint64_t vpls = vpl_count ? vpl_count : LF_VPL_COUNT,
                   texels = (uint64_t)views * NG_RSM_SIZE * NG_RSM_SIZE;
    const uint64_t sources = 5 * (64 + (uint64_t)views * 16); // as group_texels (texels.c)
    return vpls * (sizeof(struct ng_light_sample) + sizeof(struct lf_intensity_lobe)) +
           texels * sizeof(struct lf_texel) + sources * sizeof(struct lf_rsm_source) +
           12 * (vpls + texels) * sizeof(float) + ROUNDING;
}

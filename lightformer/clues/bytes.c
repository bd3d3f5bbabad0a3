// What a picture takes at most, by the sizes of what the other files keep of it. Most of it are reflections,
// of pictures all of metal.
#include "lightformer/clues/clues_internal.h"

struct picture {
    uint64_t pixels, points, rays, hits; // points: of the grid; hits: every ray may go on once
};

static struct picture measure(uint64_t width, uint64_t height, uint32_t mirror_rays)
{
    struct picture p = {.pixels = width * height};
    uint64_t budget = lf_mirror_budget(p.pixels, mirror_rays);
    p.points = ((width + LF_GRID_STEP - 1) / LF_GRID_STEP) * ((height + LF_GRID_STEP - 1) / LF_GRID_STEP);
    p.rays = budget < p.pixels ? budget + 1 : p.pixels; // parts of it are rounded up
    p.hits = 2 * p.rays;
    return p;
}

// What hits show, then averages of pixels in its place.
static uint64_t bytes_shown(const struct picture *p, uint64_t channels)
{
    uint64_t hits = LF_END_CHANNELS * p->hits, averages = channels * p->pixels;
    return (hits > averages ? hits : averages) * sizeof(float);
}

static uint64_t bytes_of_mirror(const struct picture *p)
{
    const uint64_t lattices = LF_MIRROR_KINDS * sizeof(uint32_t);
    uint64_t pixel = sizeof(unsigned char) + lattices + sizeof(struct lf_mirror_taps) +
                     sizeof(struct lf_sight) + sizeof(struct lf_wide_taps);
    return p->pixels * pixel + p->hits * sizeof(struct lf_ray_end) + p->rays * sizeof(struct lf_mirror_ray) +
           bytes_shown(p, LF_END_CHANNELS);
}

static uint64_t bytes_of_around(const struct picture *p)
{
    return p->points * (LF_AROUND_RAYS * sizeof(struct lf_ray_end) +
                        (uint64_t)LF_AROUND_PASSES * LF_AROUND_REACH * sizeof(float));
}

struct lf_encode_bytes lf_encode_bytes(uint32_t width, uint32_t height, uint32_t mirror_rays)
{
    const struct picture p = measure(width, height, mirror_rays);
    const uint64_t plane = (p.pixels + LF_PLANE_GAP) * sizeof(float);
    const uint64_t grid = p.pixels * (sizeof(struct lf_grid_taps) + sizeof(uint32_t)); // and pixels alone
    const uint64_t channels =
        3 + LF_AROUND_RAYS * LF_END_CHANNELS + 6; // bounce; rays around, and two averages
    return (struct lf_encode_bytes){
        .pixels = LF_PIXEL_PLANES * plane + grid + bytes_of_mirror(&p) + bytes_of_around(&p),
        .view = LF_VIEW_PLANES * plane,
        .light = p.points * channels * sizeof(float) + bytes_shown(&p, LF_END_USED),
    };
}

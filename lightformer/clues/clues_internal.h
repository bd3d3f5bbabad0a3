// What the files of this folder share: the objects behind clues.h, and a function for each part of them.
#ifndef LF_CLUES_CLUES_INTERNAL_H
#define LF_CLUES_CLUES_INTERNAL_H

#include "base/jobs.h"
#include "base/log.h"
#include "lightformer/clues/brdf_samples.h"
#include "lightformer/clues/clues.h"
#include "lightformer/clues/interleaved.h"
#include "lightformer/clues/kernels.h"
#include "lightformer/clues/secondary_hit.h"
#include "lightformer/net/memory.h"
#include "lightformer/trace/surface.h"
#include "lightformer/trace/tracer.h"
#include "render/camera.h"
#include "render/frame.h"

#include <math.h>

// Lengths are in radii of the scene's sphere, relative to its centre, wherever it is not said otherwise.
struct lf_space {
    float center[3], radius; // metres; a scene without extent has radius 1
};

#define LF_GRID_STEP 4    // pixels from one point of the coarse grid to the next
#define LF_SMOOTH    0.5f // roughness below which the BRDF chooses directions: of rays, too

// Part of the way that shadow rays go to a pixel: what they would meet beyond is its own surface.
#define LF_SHADOW_RAY_PART 0.999f
// The same of rays to a point off a light's surface: less, as the light may lie close behind something.
#define LF_LIGHT_RAY_PART  0.999999f

// A pixel's four neighbours on the grid of every LF_GRID_STEP-th pixel: weights that sum to 1, or all 0
// where none of them is on the same surface.
struct lf_grid_taps {
    float weight[4];
};

// A ray of a reflection as pixels nearby see it.
struct lf_reflection_ray {
    float from[3], normal[3]; // where it began
    float to[3];              // what it met, or its direction
    float density;
    bool met;
};

// What a pixel takes of the rays of a block around it, row by row: weights of 65535 in all, or none.
struct lf_reflection_taps {
    uint32_t pixel;
    uint16_t weight[LF_INTERLEAVE_TAPS * LF_INTERLEAVE_TAPS];
};

// What a pixel sees in the middle of its lobe, and what it takes of pixels a block apart that see the same;
// weights sum to 1.
struct lf_sight {
    float direction[3], distance;
};
#define LF_REFLECTION_FILTER_TAPS 9
struct lf_reflection_filter_taps {
    uint32_t pixel;
    float weight[LF_REFLECTION_FILTER_TAPS];
};

// Of what metals reflect all is seen, of what others do little: each has a density of rays of its own. But
// where two surfaces meet, a ray a few pixels away says nothing, and at the rim of a round one all is
// reflected. Pixels of LF_REFLECTION_NONE reflect nothing.
enum lf_reflection_kind {
    LF_REFLECTION_METAL,
    LF_REFLECTION_EDGE, // of others than metals
    LF_REFLECTION_GLOSS,
    LF_REFLECTION_KINDS,
    LF_REFLECTION_NONE = LF_REFLECTION_KINDS,
    LF_REFLECTION_BETWEEN, // a flat one that shows the mean of LF_REFLECTION_GLOSS beside it
};

// Rays start at every `spacing`-th pixel each way, where the surface is of that kind.
struct lf_reflection_lattice {
    uint32_t spacing, width, height;
    LF_PART(uint32_t) hit_at; // by point of the lattice: index of its hit + 1; 0: none
};

// Rays from the pixels of a picture at most, of all kinds, but for rounding. `wanted` of 0: a quarter.
static inline uint64_t lf_reflection_budget(uint64_t pixels, uint32_t wanted)
{
    return wanted ? wanted : pixels / 4 + 1;
}
// As many more at edges of others than metals.
static inline uint64_t lf_reflection_edge_budget(uint64_t budget)
{
    return budget / 2 + 1;
}

struct lf_reflections {
    LF_PART(unsigned char) kinds; // enum lf_reflection_kind of each pixel
    struct lf_reflection_lattice lattices[LF_REFLECTION_KINDS];
    uint32_t first;                        // hits of rays from pixels, which come before those of reflections
    LF_PART(struct lf_secondary_hit) hits; // of a kind in the order of pixels
    LF_PART(struct lf_reflection_ray) rays;             // of the first hits
    LF_PART(struct lf_reflection_taps) taps;            // of all pixels that reflect
    LF_PART(uint32_t) tap_at;                           // by pixel: index of its taps, if it reflects
    LF_PART(struct lf_sight) sights;                    // by pixel; only of those that reflect
    LF_PART(struct lf_reflection_filter_taps) filtered; // of those that see what others see
    LF_PART(float) seen;                                // what hits show but for light; then scratch
};

// Rays over the hemisphere of every point of the grid, and what is taken of those of its neighbours, pass by
// pass.
#define LF_HEMISPHERE_RAYS    2 // of a point at first; as many more where these meet something near by
#define LF_HEMISPHERE_TAPS    5
#define LF_HEMISPHERE_PASSES  4
#define LF_HEMISPHERE_SCRATCH (8 * LF_HEMISPHERE_RAYS + 12) // floats for a point
struct lf_hemisphere {
    // [grid points + more][rays]; where is no surface nothing was met.
    LF_PART(struct lf_secondary_hit) hits;
    LF_PART(uint32_t) more; // points with more rays, in order
    LF_PART(float) weights; // [LF_HEMISPHERE_PASSES][grid points][LF_HEMISPHERE_TAPS]; sums are 1
    LF_PART(float) open;    // by point: the part of the wide mean
};

#define LF_PIXEL_PLANES 30 // of all inputs but those that depend on powers, and what is kept beside them
#define LF_VIEW_PLANES  19 // of all inputs of a light's view, and scratch
// Floats between the planes of one input and the next. Without, the same pixel of all planes of a picture of
// 512 x 512 would compete for one set of a cache.
#define LF_PLANE_GAP    208

// What the four pixels beside a pixel say of its surface, a bit each.
enum lf_relief {
    LF_EDGE = 1, // one of them is of another surface, or none
    LF_BENT = 2, // one of them is not in its plane, or has another normal
};

#define LF_BETWEEN_BENT 1 // of the lattice of every second pixel, on a surface that bends

struct lf_pixel_clues {
    uint32_t width, height, reflection_rays; // as lf_clues_pixels was told
    struct lf_space space;
    struct ng_camera_eye eye;
    float radiance, mean_power; // frame.*
    uint32_t surfaces;          // pixels that show one
    struct lf_memory memory[LF_PIXEL_PARTS];
    float *planes[LF_PIXEL_PLANES]; // all of them:
    // Planes [width * height], by axis or channel.
    float *mask, *position[3], *normal[3], *flat[3], *view[3], *distance;
    float *diffuse[3], *specular[3], *roughness;
    float *reflection_nearness, *reflection_missed, *reflection_albedo[3];
    float *gathered_albedo[3], *gathered_missed;
    bool misses;                   // some reflection ray met nothing
    LF_PART(unsigned char) relief; // by pixel: enum lf_relief
    // By pixel: the lattice of pixels whose mean it may show (lf_pixel_corners), LF_BETWEEN_BENT, or 0.
    LF_PART(unsigned char) between;
    uint32_t grid_width, grid_height;       // of every LF_GRID_STEP-th pixel
    LF_PART(struct lf_grid_taps) grid_taps; // of each pixel
    LF_PART(uint32_t) alone;                // pixels that no neighbour on the grid speaks for
    struct lf_reflections reflections;
    struct lf_hemisphere hemisphere;
    struct lf_net_values values;
    double ms[LF_CLUES_STAGES];
};

// A texel of the RSM.
struct lf_texel {
    float position[3], normal[3];
    float flux[3]; // share of the light's power; 0: nothing is reflected, and the texel is no row
    float area;    // of the surface behind it, in squared radii
};

// Directions in which a light sends the same share: intensity toward d is the sum of weight * max(n.d, 0).
struct lf_intensity_lobe {
    float normal[3], weight[3];
};

struct lf_light_clues {
    uint32_t light;
    struct ng_light_source unit; // ng_light_unit of the snapshot's
    enum lf_questions questions; // how much it asks, as lf_clues_light found it
    float phi;                   // power of `unit`, W
    struct lf_space space;
    struct ng_light_data data;                           // proxy, axes, kind; metres
    struct ng_light_view_data views[NG_LIGHT_MAX_VIEWS]; // of the RSM
    uint32_t view_count;
    const struct lf_captured_light *maps;
    float skin; // metres: how far off the surface that emits rays begin and end
    struct lf_emitter emitter;
    struct lf_emitter far_emitter; // of fewer samples, which are enough from far away
    bool needs_brdf_rays; // smooth surfaces need directions of the BRDF that the kernels do not choose
    LF_PART(struct ng_light_sample) vpls;
    LF_PART(struct lf_intensity_lobe) intensity;
    LF_PART(struct lf_texel) texels;                        // all of the views
    LF_PART(struct lf_rsm_source) sources, sources_of_hits; // for pixels, and for where rays end
    uint32_t vpl_count, texel_count;
    float share, power[3], color[3], kind[3];
    float reaching; // mean that diffuse lobes reflect of what reaches them, at unit power; below 0: not known
    LF_PART(float) rows;       // vpl and texel inputs
    size_t pixel_count;        // of a plane of view inputs
    LF_PART(float) grid;       // sums of RSM texels at the grid
    LF_PART(float) reflected;  // what hits of reflections show of the light: [hits][LF_HIT_CHANNELS]
    LF_PART(float) hemisphere; // the same of hits of rays over hemispheres
    struct lf_memory memory[LF_LIGHT_PARTS];
    struct lf_net_values values, kept; // kept: view inputs that lf_light_clues_keep has copied
    double ms[LF_CLUES_STAGES];
};

// Of the grid of every LF_GRID_STEP-th pixel.
static inline size_t lf_grid_points(const struct lf_pixel_clues *p)
{
    return (size_t)p->grid_width * p->grid_height;
}

static inline size_t lf_grid_pixel(const struct lf_pixel_clues *p, size_t x, size_t y)
{
    return y * LF_GRID_STEP * p->width + x * LF_GRID_STEP;
}

static inline bool lf_clues_wants(const struct lf_clues_scene *scene, enum lf_net_input input)
{
    return !scene->reads || (scene->reads >> input & 1);
}

static inline void lf_count_rays(const struct lf_clues_scene *scene, uint32_t rays)
{
    if (scene->count_rays)
        scene->count_rays(scene->count_user, rays);
}

static inline void lf_count_packet(const struct lf_clues_scene *scene, const struct lf_packet *packet)
{
    uint32_t rays = 0;
    for (int i = 0; scene->count_rays && i < LF_PACKET; i++)
        rays += packet->far[i] > 0;
    lf_count_rays(scene, rays);
}

static inline struct lf_space lf_space_of(const struct ng_snapshot *s)
{
    bool sized = s->scene_radius > 0 && isfinite(s->scene_radius);
    struct lf_space space = {.radius = sized ? s->scene_radius : 1};
    for (int c = 0; c < 3; c++)
        space.center[c] = s->scene_center[c];
    return space;
}

static inline void lf_to_scene(const struct lf_space *s, const float world[3], float out[3])
{
    for (int c = 0; c < 3; c++)
        out[c] = (world[c] - s->center[c]) / s->radius;
}

static inline void lf_to_world(const struct lf_space *s, const float scaled[3], float out[3])
{
    for (int c = 0; c < 3; c++)
        out[c] = scaled[c] * s->radius + s->center[c];
}

#define LF_LEAST_SLANT 0.05f // cosine from which on the skin along a ray no longer grows

// What is not a finite number becomes 0.
static inline float lf_finite(float x)
{
    return x - x == 0 ? x : 0;
}

// What a ray in a unit direction to a direct VPL leaves out of its end, so that what coincides with the
// light's surface does not hide it, metres. 0 for lights without a surface.
static inline float lf_skin_along(const struct lf_light_clues *light, const struct ng_light_sample *vpl,
                                  const float direction[3])
{
    float cosine = -lf_dot(vpl->normal, direction);
    return light->unit.type->surface ? light->skin / lf_max(cosine, LF_LEAST_SLANT) : 0;
}

// bytes.c: rays of reflections from pixels, however much reflects.
uint64_t lf_reflection_rays_at_most(const struct lf_pixel_clues *pixels);

// arriving.c: the mean over a picture's surfaces, and channels, of what three planes hold, as far as it is
// `seen` (null: all of it). `rows`: [height], overwritten.
float lf_mean_shown(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                    float *const planes[3], const float *seen, float *rows);

// clues.c: frame.radiance, and light.share by it.
void lf_clues_set_unit(struct lf_pixel_clues *pixels, float unit, struct lf_light_clues *const *lights,
                       uint32_t light_count);

// Milliseconds since `*begin`, which becomes now.
double lf_clues_lap(uint64_t *begin);

// pixels.c: planes of the G-buffer, and what connects pixels to the grid.
NG_NODISCARD ng_result lf_pixels_read(const struct lf_clues_scene *scene,
                                      const struct lf_clues_pixels_params *params,
                                      struct lf_pixel_clues *out);
void lf_pixel_position(const struct lf_pixel_clues *pixels, size_t pixel, float out[3]);
void lf_pixel_shading_point(const struct lf_pixel_clues *pixels, size_t pixel, struct lf_shading_point *out);
// The two or four pixels of every `lattice`-th each way around one that lies in the middle of them.
static inline void lf_pixel_corners(const struct lf_pixel_clues *p, uint32_t x, uint32_t y, uint32_t lattice,
                                    size_t out[4])
{
    size_t pixel = (size_t)y * p->width + x, across = x % lattice, down = y % lattice * (size_t)p->width;
    out[0] = pixel - across - down;
    out[1] = pixel + across - down;
    out[2] = pixel - across + down;
    out[3] = pixel + across + down;
}
// How much a pixel says of another, by plane and normal: a weight from 0 to 1.
float lf_bilateral_weight(const struct lf_pixel_clues *pixels, size_t pixel, size_t other);
void lf_shading_points_set_pixel(const struct lf_pixel_clues *pixels, size_t pixel, int lane,
                                 struct lf_shading_points *out);

// reflections.c
static inline void lf_mirror_direction(const float view[3], const float normal[3], float out[3])
{
    lf_scale(normal, 2 * lf_dot(normal, view), out);
    lf_mad(out, view, -1, out);
    lf_normalize(out);
}
NG_NODISCARD ng_result lf_reflections_cast(const struct lf_clues_scene *scene, float focal, uint32_t budget,
                                           struct lf_pixel_clues *out);
NG_NODISCARD ng_result lf_reflections_light(const struct lf_clues_scene *scene,
                                            const struct lf_pixel_clues *pixels,
                                            struct lf_light_clues *light);
// From hits ([hits][LF_HIT_CHANNELS], overwritten) to the pixels; `scratch`: [pixels][3].
void lf_reflections_spread(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                           float *seen, float *scratch, float *const out[3]);

// reflection_filter.c: reflections averaged over several blocks, for wide lobes: who takes what of whom, by
// what their rays met; and the averages. `scratch`: [pixels that are averaged][channels].
NG_NODISCARD ng_result lf_reflection_filter_find(const struct lf_clues_scene *scene,
                                                 struct lf_pixel_clues *out);
void lf_reflection_filter_apply(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                                uint32_t channels, float *scratch, float *const planes[]);

// emitter.c: the light as the kernels take it.
void lf_emitter_make(struct lf_light_clues *light);

// texels.c: the RSM, by rays or from the maps, and the sources of its gather.
NG_NODISCARD ng_result lf_texels_find(const struct lf_clues_scene *scene, struct lf_light_clues *light);

// shadow_distance.c. `out`: direction (3 planes), distance, shadow distance; null: not wanted.
void lf_shadow_distance_find(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                             const struct lf_light_clues *light, float *const out[5]);

// direct.c: unshadowed direct light at pixels, and at points with a light's help beyond the kernels.
enum lf_sampling {
    LF_SAMPLE_LOBE,  // the light, and the lobe, where this is narrow beside the light
    LF_SAMPLE_LIGHT, // the light alone
    LF_SAMPLE_FAR,   // a few points of it
};
// Whether these are enough at a point with such a normal.
bool lf_direct_is_far(const struct lf_light_clues *light, const float position[3], const float normal[3]);
void lf_direct_at(const struct lf_clues_scene *scene, const struct lf_light_clues *light,
                  const struct lf_shading_points *points, uint32_t count, enum lf_sampling sampling,
                  struct lf_lit *out);
void lf_direct_view(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                    const struct lf_light_clues *light, float *const diffuse[3], float *const glossy[3]);

// visibility.c: how much of the light pixels see. `shadow` as lf_shadow_distance_find leaves it; `rays`:
// planes that are overwritten.
void lf_visibility_find(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                        const struct lf_light_clues *light, float *const shadow[5],
                        const struct lf_interleaved *rays, float *visibility);

// specular_visibility.c: the part of `glossy` that is lit.
void lf_specular_visibility_find(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                                 const struct lf_light_clues *light, float *const glossy[3],
                                 const float *visibility, const struct lf_interleaved *rays, float *out);

// rsm_gather.c: light of RSM texels on the grid, then everywhere.
NG_NODISCARD ng_result lf_rsm_gather(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                                     struct lf_light_clues *light, float *const out[3]);
// From the grid ([channels][grid points]) to the pixels; those that no point speaks for get nothing.
void lf_grid_spread(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                    const float *grid, uint32_t channels, float *const out[]);

// hemisphere_gather.c: irradiance by rays over the hemisphere.
// `focal`: pixels that a tangent of 1 covers.
NG_NODISCARD ng_result lf_hemisphere_cast(const struct lf_clues_scene *scene, float focal,
                                          struct lf_pixel_clues *out);
NG_NODISCARD ng_result lf_hemisphere_light(const struct lf_clues_scene *scene,
                                           const struct lf_pixel_clues *pixels, struct lf_light_clues *light);
// From hits ([hits][LF_HIT_CHANNELS]) to the pixels; `scratch`: [3][3][grid points].
void lf_hemisphere_spread(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                          const float *seen, float *scratch, float *const out[3]);

#endif

// What the files of this folder share: the objects behind clues.h, and a function for each part of them.
#ifndef LF_CLUES_CLUES_INTERNAL_H
#define LF_CLUES_CLUES_INTERNAL_H

#include "base/array.h"
#include "base/jobs.h"
#include "base/log.h"
#include "lightformer/clues/brdf_samples.h"
#include "lightformer/clues/clues.h"
#include "lightformer/clues/interleaved.h"
#include "lightformer/clues/kernels.h"
#include "lightformer/clues/secondary_hit.h"
#include "lightformer/trace/surface.h"
#include "lightformer/trace/tracer.h"
#include "render/frame.h"

#include <math.h>

struct lf_floats {
    NG_ARRAY(float) list;
};

// Lengths are in radii of the scene's sphere, relative to its centre, wherever it is not said otherwise.
struct lf_space {
    float center[3], radius; // metres; a scene without extent has radius 1
};

#define LF_GRID_STEP 4    // pixels from one point of the coarse grid to the next
#define LF_SMOOTH    0.5f // roughness below which the BRDF chooses directions: of rays, too

// Part of the way that shadow rays go to a pixel: what they would meet beyond is its own surface.
#define LF_SHADOW_REACH 0.999f
// The same of rays to a point off a light's surface: less, as the light may lie close behind something.
#define LF_LIGHT_REACH  0.999999f

// A pixel's four neighbours on the grid of every LF_GRID_STEP-th pixel: weights that sum to 1, or all 0
// where none of them is on the same surface.
struct lf_grid_taps {
    float weight[4];
};

// A ray of a reflection as pixels nearby see it.
struct lf_mirror_ray {
    float from[3], normal[3]; // where it began
    float to[3];              // what it met, or its direction
    float density;
    bool met;
};

// What a pixel takes of the rays of a block around it, row by row: weights of 65535 in all, or none.
struct lf_mirror_taps {
    uint32_t pixel;
    uint16_t weight[LF_BLOCK_REACH * LF_BLOCK_REACH];
};

// What a pixel sees in the middle of its lobe, and what it takes of pixels a block apart that see the same;
// weights sum to 1.
struct lf_sight {
    float direction[3], distance;
};
#define LF_WIDE_TAPS 9
struct lf_wide_taps {
    uint32_t pixel;
    float weight[LF_WIDE_TAPS];
};

// Of what metals reflect all is seen, of what others do little: each has a density of rays of its own. Pixels
// of LF_MIRROR_NONE reflect nothing.
enum lf_mirror_kind { LF_MIRROR_METAL, LF_MIRROR_GLOSS, LF_MIRROR_KINDS, LF_MIRROR_NONE = LF_MIRROR_KINDS };

// Rays start at every `spacing`-th pixel each way, where the surface is of that kind.
struct lf_mirror_lattice {
    uint32_t spacing, width, height;
    NG_ARRAY(uint32_t) hit_at; // by place on the lattice: index of its hit + 1; 0: none
};

// Rays from the pixels of a picture at most, of all kinds, but for rounding. `wanted` of 0: a quarter.
static inline uint64_t lf_mirror_budget(uint64_t pixels, uint32_t wanted)
{
    return wanted ? wanted : pixels / 4 + 1;
}

struct lf_mirror {
    NG_ARRAY(unsigned char) kinds; // enum lf_mirror_kind of each pixel
    struct lf_mirror_lattice lattices[LF_MIRROR_KINDS];
    uint32_t first;                       // hits of rays from pixels, which come before those of reflections
    NG_ARRAY(struct lf_ray_end) hits;     // of a kind in the order of pixels
    NG_ARRAY(struct lf_mirror_ray) rays;  // of the first hits
    NG_ARRAY(struct lf_mirror_taps) taps; // of all pixels that reflect
    NG_ARRAY(struct lf_sight) sights;     // by pixel; only of those that reflect
    NG_ARRAY(struct lf_wide_taps) wide;   // of those that see what others see
    struct lf_floats seen;                // what hits show; then scratch
};

// Rays over the hemisphere of every point of the grid, and what is taken of those of its neighbours, pass by
// pass.
#define LF_AROUND_RAYS   2 // of a point
#define LF_AROUND_REACH  9
#define LF_AROUND_PASSES 4
struct lf_around {
    NG_ARRAY(struct lf_ray_end) ends; // [rays][grid points]; where is no surface nothing was met
    NG_ARRAY(float) weights;          // [LF_AROUND_PASSES][grid points][LF_AROUND_REACH]; sums are 1
};

#define LF_PIXEL_PLANES 32 // of all inputs, and what is kept beside them
#define LF_VIEW_PLANES  28 // of all inputs of a light's view, and scratch
// Floats between the planes of one input and the next. Without, the same pixel of all planes of a picture of
// 512 x 512 would compete for one set of a cache.
#define LF_PLANE_GAP    208

struct lf_pixel_clues {
    uint32_t width, height;
    struct lf_space space;
    float eye[3];                   // metres
    float radiance, mean_power;     // frame.*
    struct lf_floats memory;        // of the planes
    float *planes[LF_PIXEL_PLANES]; // all of them:
    // Planes [width * height], by axis or channel.
    float *mask, *position[3], *normal[3], *flat[3], *view[3], *distance;
    float *diffuse[3], *specular[3], *roughness;
    float *mirror, *mirror_missed, *mirror_albedo[3], *mirror_emission[3],
        *emission[3];                        // emission: not yet scaled
    bool emits, misses;                      // some mirror ray met emission, met nothing
    uint32_t grid_width, grid_height;        // of every LF_GRID_STEP-th pixel
    NG_ARRAY(struct lf_grid_taps) grid_taps; // of each pixel
    NG_ARRAY(uint32_t) alone;                // pixels that no neighbour on the grid speaks for
    struct lf_mirror reflections;
    struct lf_around around;
    struct lf_net_values values;
    double ms[LF_ENCODE_STAGES];
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
    float phi;                   // power of `unit`, W
    struct lf_space space;
    struct ng_light_data data;                           // proxy, axes, kind; metres
    struct ng_light_view_data views[NG_LIGHT_MAX_VIEWS]; // of the RSM
    uint32_t view_count;
    const struct lf_light_observation *maps;
    float skin; // metres: how far off the surface that emits rays begin and end
    struct lf_light_shape shape;
    bool lobes_by_hand; // smooth surfaces need directions of the BRDF that the kernels do not choose
    NG_ARRAY(struct ng_light_sample) vpls;
    NG_ARRAY(struct lf_intensity_lobe) intensity;
    NG_ARRAY(struct lf_texel) texels; // all of the views
    NG_ARRAY(struct lf_bounce_source) sources;
    uint32_t vpl_count, texel_count;
    float share, power[3], color[3], kind[3];
    struct lf_floats rows;      // vpl and texel inputs
    struct lf_floats view;      // view inputs, or those that were kept of them
    size_t pixel_count;         // of a plane of them
    struct lf_floats grid;      // sums of RSM texels at the grid
    struct lf_floats reflected; // what hits show of the light; then scratch
    struct lf_floats around;    // what rays over hemispheres show of it
    struct lf_net_values values;
    double ms[LF_ENCODE_STAGES];
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

static inline bool lf_encode_wants(const struct lf_encode_scene *scene, enum lf_net_input input)
{
    return !scene->reads || (scene->reads >> input & 1);
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

// Milliseconds since `*begin`, which becomes now.
double lf_encode_lap(uint64_t *begin);

// pixels.c: planes of the G-buffer, and what connects pixels to the grid.
NG_NODISCARD ng_result lf_pixels_read(const struct lf_encode_scene *scene,
                                      const struct lf_encode_pixels_params *params,
                                      struct lf_pixel_clues *out);
void lf_pixel_position(const struct lf_pixel_clues *pixels, size_t pixel, float out[3]);
void lf_pixel_lobe(const struct lf_pixel_clues *pixels, size_t pixel, struct lf_lobe *out);
// How much a pixel says of another: by plane and normal, from 0 to 1.
float lf_pixel_likeness(const struct lf_pixel_clues *pixels, size_t pixel, size_t other);
void lf_points_set_pixel(const struct lf_pixel_clues *pixels, size_t pixel, int lane, struct lf_points *out);

// reflections.c
static inline void lf_mirror_direction(const float view[3], const float normal[3], float out[3])
{
    lf_scale(normal, 2 * lf_dot(normal, view), out);
    lf_mad(out, view, -1, out);
    lf_normalize(out);
}
NG_NODISCARD ng_result lf_mirror_cast(const struct lf_encode_scene *scene, uint32_t budget,
                                      struct lf_pixel_clues *out);
NG_NODISCARD ng_result lf_mirror_light(const struct lf_encode_scene *scene,
                                       const struct lf_pixel_clues *pixels, struct lf_light_clues *light,
                                       float *const direct[3], float *const bounce[3]);

// reflection_filter.c: reflections averaged over several blocks, for wide lobes: who takes what of whom, by
// what their rays met; and the averages. `scratch`: [pixels that are averaged][channels].
NG_NODISCARD ng_result lf_wide_find(const struct lf_encode_scene *scene, struct lf_pixel_clues *out);
void lf_wide_average(const struct lf_encode_scene *scene, const struct lf_pixel_clues *pixels,
                     uint32_t channels, float *scratch, float *const planes[]);

// emitter.c: the light as the kernels take it.
void lf_shape_make(struct lf_light_clues *light);

// texels.c: the RSM, by rays or from the maps, and what stands for it in the second bounce.
NG_NODISCARD ng_result lf_texels_find(const struct lf_encode_scene *scene, struct lf_light_clues *light);

// shadow_distance.c. `out`: direction (3 planes), distance, occluder; null: not wanted.
void lf_occluders_find(const struct lf_encode_scene *scene, const struct lf_pixel_clues *pixels,
                       const struct lf_light_clues *light, float *const out[5]);

// direct.c: unshadowed direct light at pixels, and at points with a light's help beyond the kernels.
void lf_direct_at(const struct lf_encode_scene *scene, const struct lf_light_clues *light,
                  const struct lf_points *points, uint32_t count, bool smooth, struct lf_lit *out);
void lf_direct_view(const struct lf_encode_scene *scene, const struct lf_pixel_clues *pixels,
                    const struct lf_light_clues *light, float *const diffuse[3], float *const glossy[3]);

// visibility.c: how much of the light reaches pixels. `way` as lf_occluders_find leaves it; `rays`: planes
// that are overwritten.
void lf_reach_find(const struct lf_encode_scene *scene, const struct lf_pixel_clues *pixels,
                   const struct lf_light_clues *light, float *const way[5], const struct lf_block_rays *rays,
                   float *reached);

// specular_visibility.c: the part of `glossy` that is lit.
void lf_highlights_find(const struct lf_encode_scene *scene, const struct lf_pixel_clues *pixels,
                        const struct lf_light_clues *light, float *const glossy[3], const float *reached,
                        const struct lf_block_rays *rays, float *out);

// rsm_gather.c: light of RSM texels on the grid, then everywhere.
NG_NODISCARD ng_result lf_bounce_view(const struct lf_encode_scene *scene,
                                      const struct lf_pixel_clues *pixels, struct lf_light_clues *light,
                                      float *const out[3]);
// From the grid ([3][grid points]) to the pixels; those that no point speaks for get nothing.
void lf_grid_spread(const struct lf_encode_scene *scene, const struct lf_pixel_clues *pixels,
                    const float *grid, float *const out[3]);

// hemisphere_gather.c: irradiance by rays over the hemisphere.
NG_NODISCARD ng_result lf_around_cast(const struct lf_encode_scene *scene, struct lf_pixel_clues *out);
NG_NODISCARD ng_result lf_around_light(const struct lf_encode_scene *scene,
                                       const struct lf_pixel_clues *pixels, struct lf_light_clues *light,
                                       float *const out[3]);

#endif

// What takes the time: unshadowed direct light of one light, light of RSM texels, and rays to a light, at
// sixteen surfaces at once; and what a surface reflects of the rays around it. Plain C that the compiler
// vectorizes, built for several instruction sets; all give the same bytes.
//
// Lengths are in radii of the scene's sphere, relative to its centre; powers are shares of the light's power.
// So radiance comes out at unit power with 1 / R^2 taken out, as lightformer/net/inputs.inc wants it.
#ifndef LF_CLUES_KERNELS_H
#define LF_CLUES_KERNELS_H

#include "base/extern_c.h"
#include "lightformer/clues/brdf_samples.h"
#include "lightformer/clues/interleaved.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

#define LF_LANES 16

// Surfaces that light falls on, by lane. Lanes that are not in use hold any finite numbers.
struct lf_shading_points {
    float position[3][LF_LANES];
    float normal[3][LF_LANES]; // shading, unit
    float flat[3][LF_LANES];   // geometric, unit, towards the viewer
    float view[3][LF_LANES];   // unit, to the viewer
    float albedo[3][LF_LANES], f0[3][LF_LANES], roughness[LF_LANES];
};

struct lf_lit {
    float diffuse[3][LF_LANES], glossy[3][LF_LANES];
    // Near an emitter its samples show one by one; there directions around the normal share its light with
    // them: this part of each counts. 0 elsewhere.
    float share[LF_LANES];
};

#define LF_COSINE_SAMPLES 64

enum lf_emitter_kind {
    LF_EMITTER_POINT,     // samples are points with a cone
    LF_EMITTER_DIRECTION, // samples are directions at infinity
    LF_EMITTER_SURFACE,   // samples are points of any surface
    LF_EMITTER_RECTANGLE, // samples are points of a uniform rectangle (or parallelogram)
    LF_EMITTER_DISK,      // ... of a uniform disk (or ellipse)
    LF_EMITTER_SPHERE,    // a uniform sphere: no samples, it is sampled as it is seen
};

struct lf_light_sample {
    float position[3];
    float normal[3]; // of a surface: unit; direction: where the light travels; point: axis
    float weight[3]; // of a surface: radiance * area; point: intensity on the axis; direction: irradiance
    float density;   // samples per area (direction: per solid angle), for multiple importance sampling
};

#define LF_LIGHT_SAMPLES 64

// A light as the kernels take it.
struct lf_emitter {
    enum lf_emitter_kind kind;
    uint32_t sample_count;
    struct lf_light_sample samples[LF_LIGHT_SAMPLES];
    float cone_scale, cone_offset; // of points: falloff = clamp(cos * scale + offset)^2
    // Rectangle, disk, sphere.
    float center[3], normal[3]; // normal: the side that emits
    float u[3], v[3];           // local coordinates of x: (x - center) . u, .v; from -1 to 1 on the surface
    float area, radius;         // radius: of a sphere, or around the others
    float skin;                 // rays end so far off the surface
    // Half the width that four samples in a row cover: from nearer than that they show one by one. Of any
    // surface, whose samples lie within `radius` around `center`: where they are sparsest.
    float coarseness;
    float radiance[3];
};

// A direct VPL of the RSM gather: a group of RSM texels.
struct lf_rsm_source {
    float position[3], normal[3];
    float flux[3]; // reflected
    float area;    // of the surface that it stands for
};

// Rays to a light, by lane.
struct lf_aim {
    float direction[3][LF_LANES], distance[LF_LANES]; // to a point of the light, or its skin off it
    float weight[LF_LANES];                           // what the ray counts
};

#define LF_RAY_TAPS    (LF_INTERLEAVE_TAPS * LF_INTERLEAVE_TAPS) // rays of a block
#define LF_RAY_COLUMNS (LF_LANES + LF_INTERLEAVE_TAPS - 1)

// Rays around LF_LANES pixels of a row that are as far apart as rays are: lane i looks at the columns from i
// to i + LF_INTERLEAVE_TAPS - 1. Lengths as of points.
struct lf_ray_window {
    float from[3][LF_INTERLEAVE_TAPS][LF_RAY_COLUMNS];   // where they began
    float normal[3][LF_INTERLEAVE_TAPS][LF_RAY_COLUMNS]; // there
    float to[3][LF_INTERLEAVE_TAPS][LF_RAY_COLUMNS];   // what they met, or a direction, where that is nothing
    float met[LF_INTERLEAVE_TAPS][LF_RAY_COLUMNS];     // 1 or 0
    float density[LF_INTERLEAVE_TAPS][LF_RAY_COLUMNS]; // per steradian, with which they were chosen
    float there[LF_INTERLEAVE_TAPS][LF_RAY_COLUMNS];   // 1; 0: no ray
    float across[LF_INTERLEAVE_TAPS], down[LF_INTERLEAVE_TAPS]; // how much columns and rows count
};

// How much a pixel says of another one, by its height over the other's plane, in grains, and the cosine
// between normals. Steep: light that falls on another pixel is right here only as far as normal and plane are
// the same. Rays of reflections are shared more freely (kernels.c, ray_weight).
static inline float lf_bilateral_falloff(float height, float cosine)
{
    float square = cosine > 0 ? cosine * cosine : 0, fourth = square * square;
    return fourth * fourth / (1 + height * height * height * height);
}

// Height that halves a weight, by distance to the eye.
static inline float lf_plane_grain(float distance)
{
    return 0.01f * distance + 1e-12f;
}

// Planes at the first of LF_LANES pixels in a row. LF_INTERLEAVE_HALF more on all four sides are read.
struct lf_neighbourhood {
    const float *position[3], *normal[3], *mask, *distance, *roughness;
    const float *part, *weight; // as struct lf_interleaved
    size_t stride;              // from a row to the next
};

struct lf_kernels {
    const char *name;
    // Radiance by parts. `brdf_samples`: the light's samples share the specular part with LF_BRDF_SAMPLES
    // directions chosen by the BRDF, for surfaces smooth enough that light samples alone would show. Where
    // the emitter is a rectangle, disk or sphere these are in the result, and so are directions around the
    // normal; for other extended lights the caller adds both.
    void (*direct)(const struct lf_emitter *light, const struct lf_shading_points *points, bool brdf_samples,
                   struct lf_lit *out);
    // Irradiance / pi.
    void (*rsm_gather)(const struct lf_rsm_source *sources, uint32_t count,
                       const struct lf_shading_points *points, float out[3][LF_LANES]);
    // To the parts of a light that directions of the BRDF, which `u` chooses (lf_brdf_samples), come nearest
    // to. Weight: BRDF times cosine there.
    void (*aim)(const struct lf_emitter *light, const struct lf_shading_points *points,
                const float u[3][LF_LANES], struct lf_aim *out);
    // To a sample of a surface or, if it is `infinite`, a direction (LF_EMITTER_DIRECTION). Weight:
    // irradiance, the mean of its channels, on surfaces that it lights; of the points only position and
    // normals are read.
    void (*arrive)(const struct lf_light_sample *sample, bool infinite,
                   const struct lf_shading_points *points, struct lf_aim *out);
    // What each ray counts: weight times BRDF and cosine, over the sum of both densities with which it could
    // have been chosen (balance heuristic), on surfaces like this one: `grain` is the distance from its plane
    // that halves a weight. A lobe that is so narrow that it ends between the rays is widened to the nearest
    // one.
    void (*reflect)(const struct lf_shading_points *at, const float grain[LF_LANES],
                    const struct lf_ray_window *rays, float weight[LF_RAY_TAPS][LF_LANES]);
    // Means of what pixels and their neighbours found, weighed by how alike they are (lf_interleaved_filter).
    void (*average)(const struct lf_neighbourhood *pixels, bool specular, float out[LF_LANES]);
};

// The sets that this CPU has, the fastest first; null past the end.
const struct lf_kernels *lf_kernels_of(uint32_t index);

NG_EXTERN_C_END

#endif

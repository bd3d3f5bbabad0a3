// Paths: what arrives along a camera ray, split as equation 7 of the paper wants it.
//
// At every surface one light is sampled and one direction is chosen by the BRDF; both estimate the same
// direct light, weighted against each other by the power heuristic (Veach 1997, 9.2). At the first surface
// the same light sample, with and without its shadow ray, serves T_d and T_l, and so does the same direction:
// T_l takes from it what every light would send if nothing else were there.
#ifndef LF_REFERENCE_PATH_H
#define LF_REFERENCE_PATH_H

#include "base/extern_c.h"
#include "lightformer/reference/wave.h"
#include "lightformer/trace/surface.h"

NG_EXTERN_C_BEGIN

// What was traced, and how long it took; sums over threads.
struct lf_path_stats {
    uint64_t path_rays;    // to the closest surface, the camera's included
    uint64_t shadow_rays;  // to a light, whether anything is in between
    uint64_t emitter_rays; // through the emitters alone, for T_l: not counted among the rays of a picture
    // Where the scene asks for it (timed), nanoseconds: of all paths, and of their rays alone.
    uint64_t total_ns, path_ns, shadow_ns;
};

struct lf_path_scene {
    const struct lf_tracer *tracer;
    const struct lf_light_choice *lights;
    uint32_t depth; // segments of a path, the camera's included (Mitsuba's max_depth); 0: no limit
    bool timed;
    const struct lf_wave_kernels *kernels; // wave.h; null: the fastest. All give the same bytes
    struct lf_path_stats *stats;           // added to; needed
};

// The split; all W/(sr m2).
struct lf_radiance {
    float direct[3];     // T_d: light of light components, after one bounce
    float unshadowed[3]; // T_l: the same as if each light were alone with the receiver
    float indirect[3];   // T_i: after more bounces, and what emitters without a light component send
    float emission[3];   // seen directly
};

// What the camera's ray meets: the same for all samples of a pixel without antialiasing.
struct lf_primary {
    struct lf_ray ray;
    bool met;
    struct lf_hit hit;
    struct lf_surface surface;
    float emission[3]; // of the surface, or of the environment where nothing is met
};

// `pixel` (x, y): whose ray it is; null: no pixel's (lf_trace_pixel).
void lf_path_begin(const struct lf_path_scene *scene, const struct lf_ray *ray, const uint32_t pixel[2],
                   struct lf_primary *out);
#define LF_PATHS LF_WAVE_LANES // traced at a time

struct lf_path {
    const struct lf_primary *primary; // borrowed; may be that of other paths, too
    struct lf_sampler sampler;
    struct lf_radiance radiance; // the result
};
// At most LF_PATHS, whose samplers are of one kind and have drawn equally often. What a path brings does not
// depend on its company.
void lf_paths_trace(const struct lf_path_scene *scene, struct lf_path *paths, uint32_t count);

NG_EXTERN_C_END

#endif

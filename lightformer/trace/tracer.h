// Rays against a snapshot: the one user of Embree.
//
//     struct lf_tracer *tracer;
//     NG_TRY(lf_tracer_create(&tracer));
//     NG_TRY(lf_tracer_update(tracer, snapshot));     // again for every frame: only what moved is touched
//     if (lf_trace_closest(tracer, &ray, LF_RAY_ALL, &hit)) ...
//
// Triangles are kept in world space, as long as there is memory for that. The surfaces of sphere and disk
// lights are exact spheres and ellipses here, not the triangles of the snapshot, so that a ray meets exactly
// the points that the light's sampling (light/light.h) chooses from. Alpha masks let rays through, and of
// surfaces that blend each ray meets or passes one.
//
// Sides (engine/README.md, "Radiometry"): every surface blocks light from both sides. A camera ray
// (LF_RAY_CAMERA) passes through the backs of one-sided surfaces, as the G-buffer does, so that a camera
// looks into a closed room from outside. All other rays meet backs; what they meet there is black.
//
// A tracer borrows the snapshot until the next update; the extractor must not run in between while rays are
// traced. Queries are thread-safe, updates are not. Results do not depend on the number of threads.
#ifndef LF_TRACE_TRACER_H
#define LF_TRACE_TRACER_H

#include "base/extern_c.h"
#include "base/result.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

struct ng_snapshot;
struct lf_tracer;

// What an update had to do, for tests and benchmarks.
struct lf_tracer_stats {
    uint32_t instances; // in the scene
    uint32_t updated;   // whose vertices or shape were written by the last update
    uint32_t built;     // whose acceleration structure was built anew rather than refitted
    uint32_t shared;    // that are placed copies of a mesh which they share
    uint32_t ids;       // that Embree goes through in a commit: a few for an instance, up to 64 where
                        // entities without surfaces lie between
    uint64_t triangles; // of all instances
    uint64_t bytes;     // that Embree holds
    double update_ms;   // of the last update
};

// Errors, logged: those of ng_cpu_check, which Embree obeys too; NG_ERROR_MEMORY.
NG_NODISCARD ng_result lf_tracer_create(struct lf_tracer **out);
void lf_tracer_destroy(struct lf_tracer **tracer);
// Bytes that scenes may take from the next build on; 0, the default: what the system has left then. Of a
// scene that would take more than half of it flattened, meshes that instances share are kept once: slower,
// and equal but for rounding, 1e-5 of a hit's distance.
void lf_tracer_limit_memory(struct lf_tracer *tracer, uint64_t bytes);

// Follows a snapshot. What has the same entity, mesh and version as before is left alone; what moved or
// deformed is refitted; what comes is built, what goes is dropped. Rays meet the same, byte for byte, as in a
// new tracer of the same snapshot. Errors, logged with the size: NG_ERROR_MEMORY; the tracer is then empty.
NG_NODISCARD ng_result lf_tracer_update(struct lf_tracer *tracer, const struct ng_snapshot *snapshot);
const struct ng_snapshot *lf_tracer_snapshot(const struct lf_tracer *tracer); // borrowed; null before
struct lf_tracer_stats lf_tracer_stats_of(const struct lf_tracer *tracer);

// Coordinates of rays and of what they meet, metres. What is no ray meets nothing: numbers beyond this or no
// numbers at all, a negative `near`, `far` below `near`. Vertices beyond are moved to the edge.
//
// Embree takes up to 1.8e18, and transforms rays into shared meshes, which stretches them by up to 1e6.
#define LF_TRACE_FARTHEST 1e11f

struct lf_ray {
    float origin[3], direction[3]; // world; direction unit
    float near, far;               // metres along the direction; far may be INFINITY
    uint32_t sample; // tells rays apart that are alike: what blends may stop one and not another
};

struct lf_hit {
    uint32_t instance;    // of the snapshot
    uint32_t triangle;    // of the instance's mesh; 0 for exact shapes
    float barycentric[2]; // weights of vertices 1 and 2; zero for exact shapes
    float distance;
    float position[3];
    float normal[3]; // geometric, unit, of the front (mirrored placements considered)
    bool front;      // the ray meets the front
};

// LF_RAY_PAST_LAMPS: like LF_RAY_ALL, but that it passes lamps (render/snapshot.h). What is met does not
// follow lamps that move, as long as snapshot.surface_version stays.
enum lf_ray_kind { LF_RAY_ALL, LF_RAY_CAMERA, LF_RAY_PAST_LAMPS };

// False if nothing is met.
bool lf_trace_closest(const struct lf_tracer *tracer, const struct lf_ray *ray, enum lf_ray_kind kind,
                      struct lf_hit *out);
// The same of the ray of a pixel (x, y): of surfaces that cover a part of what is behind them it meets those
// that the G-buffer shows in that pixel. Others meet each by chance: a hash of the ray. Null: no pixel's.
bool lf_trace_pixel(const struct lf_tracer *tracer, const struct lf_ray *ray, enum lf_ray_kind kind,
                    const uint32_t pixel[2], struct lf_hit *out);
bool lf_trace_occluded(const struct lf_tracer *tracer, const struct lf_ray *ray);
// The same of a ray toward a light: emitters in the place of that light, and lamps beside it
// (ng_lamp_is_beside), are passed as if they were not there.
bool lf_trace_shadowed(const struct lf_tracer *tracer, const struct lf_ray *ray, uint32_t light);
// The same of many rays of LF_RAY_ALL, in any directions: a little faster than one by one. `hits` are set
// where `met` says so.
void lf_trace_closest_many(const struct lf_tracer *tracer, const struct lf_ray *rays, uint32_t count,
                           bool *met, struct lf_hit *hits);
void lf_trace_occluded_many(const struct lf_tracer *tracer, const struct lf_ray *rays, uint32_t count,
                            bool *met);
// Visits every meeting of the ray with the surface of a light, as if there were nothing else: in no
// particular, but always the same, order. False if it was plain without a ray that there are none.
typedef void (*lf_trace_fn)(void *user, const struct lf_hit *hit);
bool lf_trace_emitters(const struct lf_tracer *tracer, const struct lf_ray *ray, lf_trace_fn visit,
                       void *user);
// The emitters that a hit of the ray coincides with, as far as rounding can tell: itself, if it is one, among
// them.
void lf_trace_coinciding(const struct lf_tracer *tracer, const struct lf_ray *ray, const struct lf_hit *hit,
                         lf_trace_fn visit, void *user);
// False if it is plain without a ray that no surface along it gives light.
bool lf_trace_may_shine(const struct lf_tracer *tracer, const struct lf_ray *ray);

// Rays that run side by side, traced together: several times as fast as one by one where they do (from one
// origin, or in parallel).
#define LF_PACKET 16
struct lf_packet {
    float origin[3][LF_PACKET], direction[3][LF_PACKET]; // by axis
    float far[LF_PACKET];                                // in; 0: no ray. Out: distance of the hit, if any
    bool met[LF_PACKET];                                 // out
    uint32_t passes; // a light: emitters in its place and lamps beside it are not there; NG_NONE: none
};
// Closest hits of LF_RAY_ALL. `hits`[LF_PACKET] may be null, where the distances are enough.
void lf_trace_packet(const struct lf_tracer *tracer, struct lf_packet *packet, struct lf_hit *hits);
// Whether they meet anything: sets `met` alone, and sooner.
void lf_trace_packet_occluded(const struct lf_tracer *tracer, struct lf_packet *packet);

// Closest hits without anything around them: what the speed of a renderer is compared with. Returns how many
// rays met something.
uint32_t lf_trace_bare(const struct lf_tracer *tracer, const struct lf_ray *rays, uint32_t count);

// How far off a surface at a position rays begin, so that they do not meet the surface they start on: a part
// of the scene's radius R; and where it lies far from the origin, some of the steps that numbers have there.
// Of the largest coordinate m: 1e-5 R up to m = R, 1e-5 m up to 2 R, 2e-5 R up to 20 R, then 1e-6 m.
static inline float lf_trace_offset(float scene_radius, float x, float y, float z)
{
    float m = fabsf(x);
    m = fabsf(y) > m ? fabsf(y) : m;
    m = fabsf(z) > m ? fabsf(z) : m;
    float most = 2 * scene_radius > 0.1f * m ? 2 * scene_radius : 0.1f * m;
    float size = m < most ? m : most;
    return 1e-5f * (size > scene_radius ? size : scene_radius);
}

// An origin off a surface at `position` with geometric `normal`, by that much on the side of `direction`.
void lf_trace_origin(const struct lf_tracer *tracer, const float position[3], const float normal[3],
                     const float direction[3], float out[3]);

NG_EXTERN_C_END

#endif

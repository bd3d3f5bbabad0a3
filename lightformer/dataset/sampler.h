// A scene, sample by sample: seed -> the world and a snapshot of it, as a path tracer and a rasterizer take
// it.
//
//     NG_TRY(lf_scene_sampler_create(&params, &sampler));
//     NG_TRY(lf_scene_sampler_begin(sampler, seed, &sample));
//     ...
//     NG_TRY(lf_scene_sampler_end(sampler));      // the world is as before, by undo
//
// One thread, that of the world.
#ifndef LF_DATASET_SAMPLER_H
#define LF_DATASET_SAMPLER_H

#include "base/extern_c.h"
#include "base/result.h"

#include <stdbool.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

struct lf_scene_sampler;
struct lf_tracer;
struct ng_assets;
struct ng_jobs;
struct ng_snapshot;
struct ng_world;

struct lf_scene_sampler_params {
    struct ng_world *world;         // needed; borrowed, with the systems of render/scene_systems.h
    const struct ng_assets *assets; // needed; borrowed
    struct ng_jobs *jobs;           // borrowed; null: this thread
    double time;                    // of samples whose time does not vary, seconds
    const char *camera;             // name; null: the first. Borrowed
};

// Errors, logged: those of lf_variations_create; NG_ERROR_NOT_FOUND if nothing varies, or if the world has no
// camera.
NG_NODISCARD ng_result lf_scene_sampler_create(const struct lf_scene_sampler_params *params,
                                               struct lf_scene_sampler **out);
// Before the world.
void lf_scene_sampler_destroy(struct lf_scene_sampler **sampler);

struct lf_sample {
    uint64_t seed;
    double time;
    const struct ng_snapshot *snapshot; // valid until the next begin
    const struct lf_tracer *tracer;     // at the snapshot, likewise
};

// Errors, logged: those of lf_variations_apply; NG_ERROR_FORMAT (no light that shines, an emitter without
// area); the world is then as before.
NG_NODISCARD ng_result lf_scene_sampler_begin(struct lf_scene_sampler *sampler, uint64_t seed,
                                              struct lf_sample *out);
// Undoes the sample.
NG_NODISCARD ng_result lf_scene_sampler_end(struct lf_scene_sampler *sampler);

NG_EXTERN_C_END

#endif

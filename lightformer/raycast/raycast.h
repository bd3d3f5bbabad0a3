// The G-buffer by rays: what the camera sees, where the device that would rasterize it is a CPU.
//
//     struct lf_raycast *raycast;
//     NG_TRY(lf_raycast_create(&(struct lf_raycast_params){.jobs = jobs, .method = "neural"}, &raycast));
//     NG_TRY(lf_raycast_join(primary, ng_renderer_composer(renderer)));
//     ... frames ...
//     lf_raycast_leave(raycast);
//     lf_raycast_destroy(&raycast);
//
// A provider that stands before the rasterizer's (render/gbuffer.h) and publishes what that would: the same
// images under the same names, but for the depth of the rasterizer. It traces through the ray scene of the
// composer (lightformer/trace/ray_scene.h). Belongs to the thread of the composer.
#ifndef LF_RAYCAST_RAYCAST_H
#define LF_RAYCAST_RAYCAST_H

#include "base/extern_c.h"
#include "graph/provider.h"

NG_EXTERN_C_BEGIN

struct ng_jobs;
struct lf_raycast;

enum lf_raycast_use {
    LF_RAYCAST_AUTO,   // by rays where the device draws on the CPU
    LF_RAYCAST_RAYS,   // always
    LF_RAYCAST_RASTER, // never
};

struct lf_raycast_params {
    struct ng_jobs *jobs; // borrowed; null: the caller's thread alone
    const char *method; // borrowed: frames that want this one, which has a ray scene anyway; null: all frames
    enum lf_raycast_use use;
};

// Errors, logged: NG_ERROR_MEMORY.
NG_NODISCARD ng_result lf_raycast_create(const struct lf_raycast_params *params, struct lf_raycast **out);
// Leaves its composer, if it is in one, which must still exist.
void lf_raycast_destroy(struct lf_raycast **raycast);

// Once; the composer is borrowed until lf_raycast_leave. Errors, logged: those of lf_ray_scene_register.
NG_NODISCARD ng_result lf_raycast_join(struct lf_raycast *raycast, struct ng_composer *composer);
void lf_raycast_leave(struct lf_raycast *raycast);

NG_EXTERN_C_END

#endif

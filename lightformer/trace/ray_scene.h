// The ray scene of a renderer: one tracer for all methods that trace, and a pass that brings it to the
// frame's snapshot. Comes with the first such method and goes with the last.
//
//     NG_TRY(lf_ray_scene_register(composer, &provider, 0)); // instead of ng_composer_register
//     ... in the provider:
//     const struct lf_ray_scene *rays = ng_composer_get(composer, &lf_ray_scene_item, 0);
//     ng_pass_read(pass, rays->updated, NG_USE_HOST_READ);
//     ... in that pass:
//     const struct ng_snapshot *snapshot = lf_tracer_snapshot(rays->tracer);
//     if (!snapshot)
//         return NG_ERROR_MEMORY;
//     ... rays through rays->tracer ...
//     lf_ray_scene_unregister(composer, provider.name);
//
// Belongs to the thread of the composer.
#ifndef LF_TRACE_RAY_SCENE_H
#define LF_TRACE_RAY_SCENE_H

#include "base/extern_c.h"
#include "graph/provider.h"
#include "lightformer/trace/tracer.h"

NG_EXTERN_C_BEGIN

// One a frame, published before those who trace produce theirs.
struct lf_ray_scene {
    // At the frame's snapshot, for passes that read `updated`; without one where the update failed, which has
    // been logged.
    const struct lf_tracer *tracer;
    struct ng_graph_ref updated; // token: "trace:update", which runs in frames in which somebody reads it
};
extern const struct ng_item_type lf_ray_scene_item;

// Registers a provider that traces. `memory_limit`: as lf_tracer_limit_memory takes it; of several limits the
// least counts. Errors, logged: those of ng_composer_register and lf_tracer_create.
NG_NODISCARD ng_result lf_ray_scene_register(struct ng_composer *composer, const struct ng_provider *provider,
                                             uint64_t memory_limit);
void lf_ray_scene_unregister(struct ng_composer *composer, const char *name);

NG_EXTERN_C_END

#endif

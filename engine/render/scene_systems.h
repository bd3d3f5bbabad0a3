// The systems that every scene needs: animation (NG_PHASE_ANIMATE), clips from the asset store, and
// placements (NG_PHASE_PLACE). After ng_world_run(world, time) the world is as it is at that time.
#ifndef NG_RENDER_SCENE_SYSTEMS_H
#define NG_RENDER_SCENE_SYSTEMS_H

#include "base/extern_c.h"
#include "base/result.h"

NG_EXTERN_C_BEGIN

struct ng_assets;
struct ng_jobs;
struct ng_world;

// Once a world, whose engine components are registered. Its transactions record what is done to assets.
// `assets` and `jobs` (null: the calling thread only) are borrowed for the world's life.
NG_NODISCARD ng_result ng_scene_systems_add(struct ng_world *world, struct ng_assets *assets,
                                            struct ng_jobs *jobs);

NG_EXTERN_C_END

#endif

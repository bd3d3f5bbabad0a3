#include "render/scene_systems.h"

#include "anim/animate.h"
#include "asset/assets.h"
#include "components/placement_system.h"

static const struct ng_clip *clip_of(const void *assets, ng_asset clip)
{
    return ng_assets_clip(assets, clip);
}

ng_result ng_scene_systems_add(struct ng_world *world, struct ng_assets *assets, struct ng_jobs *jobs)
{
    NG_REQUIRE(world && assets, "ng_scene_systems_add needs a world and an asset store");
    ng_assets_set_history(assets, world);
    NG_TRY(ng_animation_system_add(
        &(struct ng_animate_params){.world = world, .lookup = clip_of, .user = assets, .jobs = jobs}));
    return ng_placement_system_add(world);
}

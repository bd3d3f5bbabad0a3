#include "readers.h"

#include "test.h"

#include "asset/assets.h"
#include "asset/gltf.h"
#include "components/components.h"
#include "lightformer/dataset/variations.h"
#include "render/extract.h"
#include "render/scene_systems.h"
#include "scene/system.h"
#include "scene/world.h"

// Animated to some times, also beyond all keys, and extracted at each.
static ng_result extract(struct ng_world *world, struct ng_assets *assets)
{
    static const double times[] = {0, 0.3, 1e9};
    struct ng_extractor *extractor;
    NG_TRY(ng_scene_systems_add(world, assets, NULL));
    NG_TRY(ng_extractor_create(&extractor));
    ng_result r = NG_OK;
    for (size_t i = 0; i < NG_COUNT(times) && r == NG_OK; i++) {
        const struct ng_snapshot *snapshot;
        r = ng_world_run(world, times[i]);
        if (r == NG_OK)
            r = ng_extract(extractor,
                           &(struct ng_extract_params){.world = world, .assets = assets, .time = times[i]},
                           &snapshot);
    }
    ng_extractor_destroy(&extractor);
    return r;
}

static ng_result use_scene(struct ng_world *world, struct ng_assets *assets,
                           const struct ng_gltf_scene *scene)
{
    struct lf_variations *variations;
    if (scene->triangle_count > 2000) // what takes long under a sanitizer is the refining
        return NG_OK;
    NG_TRY(extract(world, assets));
    ng_result r = lf_variations_create(world, &variations);
    lf_variations_destroy(&variations);
    return r;
}

ng_result fuzz_read_scene(const char *path)
{
    struct ng_world *world;
    struct ng_assets *assets;
    struct ng_gltf_scene scene;
    assert_int_equal(ng_world_create(NULL, &world), NG_OK);
    assert_int_equal(ng_components_register(world), NG_OK);
    assert_int_equal(ng_assets_create(&assets), NG_OK);
    ng_result r = ng_gltf_load(path, world, assets, &(struct ng_gltf_params){.max_memory = 1 << 23}, &scene);
    if (r == NG_OK) {
        r = use_scene(world, assets, &scene);
    } else {
        assert_int_equal(ng_world_entity_count(world), 0);
        assert_int_equal(ng_assets_memory(assets), 0);
    }
    ng_world_destroy(&world);
    ng_assets_destroy(&assets);
    return r;
}

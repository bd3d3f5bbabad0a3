// Saving: what a glTF file was loaded as is written anew, without looking at the file, and with it. Both load
// again, with as many entities.
#include "target.h"

#include "asset/assets.h"
#include "asset/gltf.h"
#include "asset/gltf_save.h"
#include "components/components.h"
#include "scene/world.h"

#include <stdlib.h>

struct scene {
    struct ng_world *world;
    struct ng_assets *assets;
    struct ng_gltf_scene loaded;
};

static void finish(struct scene *s)
{
    ng_gltf_origin_destroy(&s->loaded.origin);
    ng_world_destroy(&s->world);
    ng_assets_destroy(&s->assets);
}

static ng_result load(const char *path, struct scene *out)
{
    *out = (struct scene){0};
    NG_TRY(ng_world_create(NULL, &out->world));
    NG_TRY(ng_components_register(out->world));
    NG_TRY(ng_assets_create(&out->assets));
    return ng_gltf_load(path, out->world, out->assets,
                        &(struct ng_gltf_params){.max_memory = 1 << 23, .keep = true}, &out->loaded);
}

static void save(const struct scene *s, const char *path, const struct ng_gltf_origin *origin)
{
    struct scene again;
    struct ng_gltf_save_params params = {s->world, s->assets, s->loaded.root, origin};
    target_begin();
    ng_result result = ng_gltf_save(path, &params);
    target_end(result);
    if (result == NG_ERROR_MEMORY)
        return;
    if (result != NG_OK)
        abort();
    target_begin();
    result = load(path, &again);
    target_end(result);
    if (result != NG_ERROR_MEMORY && again.loaded.entity_count != s->loaded.entity_count)
        abort();
    finish(&again);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct scene scene;
    const char *path = target_file("scene.gltf", data, size);
    target_begin();
    ng_result result = load(path, &scene);
    target_end(result);
    if (result == NG_OK) {
        save(&scene, target_file("made.glb", "", 0), NULL);
        save(&scene, target_file("kept.glb", "", 0), scene.loaded.origin);
    }
    finish(&scene);
    return 0;
}

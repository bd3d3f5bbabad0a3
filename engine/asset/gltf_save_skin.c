// Skeletons into skins. They never change, so one that was loaded is its skin still.
#include "asset/gltf_save_internal.h"

#include <cjson/cJSON.h>

static int find_kept(const struct gltf_saver *s, ng_asset skeleton)
{
    for (uint32_t i = 0; s->origin && i < s->origin->doc->skin_count; i++)
        if (s->origin->skins[i].id == skeleton.id)
            return (int)i;
    return -1;
}

int ng_gltf_save_skin(struct gltf_saver *s, ng_asset id)
{
    const struct ng_skeleton *skeleton = ng_assets_skeleton(s->assets, id);
    for (size_t i = 0; i < s->skins.count; i++)
        if (s->skins.items[i].asset.id == id.id)
            return s->skins.items[i].index;
    struct gltf_index_of found = {id, find_kept(s, id)};
    if (found.index >= 0 || !skeleton)
        return found.index;
    cJSON *skin;
    found.index = ng_gltf_append(&s->w, NG_GLTF_SKINS, &skin);
    const char *name = ng_assets_name(s->assets, id);
    if (name && name[0])
        ng_gltf_json_text(&s->w, skin, "name", name);
    ng_gltf_json_number(&s->w, skin, "inverseBindMatrices",
                        ng_gltf_add_floats(&s->w, skeleton->inverse_bind, skeleton->joint_count, 16,
                                           NG_GLTF_NO_TARGET, false));
    cJSON *joints = ng_gltf_json_list(&s->w, skin, "joints");
    for (uint32_t i = 0; joints && i < skeleton->joint_count; i++) {
        const struct gltf_saved *p = ng_gltf_saved(s, skeleton->joints[i]);
        cJSON *joint = cJSON_CreateNumber(p && p->role == GLTF_NODE ? p->index : 0);
        s->w.failed |= !joint;
        if (joint)
            cJSON_AddItemToArray(joints, joint);
    }
    s->w.failed |= !ng_array_push(&s->skins, found);
    return found.index;
}

// Skins into skeletons.
#include "asset/gltf_loader_internal.h"
#include "base/log.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static ng_result read_joints(const struct gltf_loader *l, uint32_t index, const struct gltf_skin *skin,
                             ng_entity *out)
{
    for (uint32_t i = 0; i < skin->joint_count; i++) {
        int node = skin->joints[i];
        if (node < 0 || (uint32_t)node >= l->doc->node_count)
            return ng_gltf_error(l, "skin %u: joint %u: node %d is not one of %u", index, i, node,
                                 l->doc->node_count);
        out[i] = l->nodes[node];
        if (ng_entity_is_null(out[i]))
            return ng_gltf_error(l, "skin %u: joint %u: node %d is not in the scene", index, i, node);
        if (l->joint_of[node] == index + 1)
            return ng_gltf_error(l, "skin %u: joint %u: node %d is listed twice", index, i, node);
        l->joint_of[node] = index + 1;
    }
    return NG_OK;
}

static ng_result read_inverse_bind(struct gltf_loader *l, uint32_t index, const struct gltf_skin *skin,
                                   float **out)
{
    const struct gltf_want want = {"inverseBindMatrices", GLTF_FLOATS, 1u << 16, 0, false};
    if (skin->inverse_bind >= 0) {
        uint32_t count;
        NG_TRY(ng_gltf_read(l, skin->inverse_bind, &want, out, &count));
        if (count < skin->joint_count)
            return ng_gltf_error(l, "skin %u: %u inverse bind matrices for %u joints", index, count,
                                 skin->joint_count);
        char where[32];
        snprintf(where, sizeof where, "skin %u", index);
        ng_gltf_keep_within(l, where, want.what, *out, (size_t)count * 16);
        return NG_OK;
    }
    if (skin->inverse_bind < -1)
        return ng_gltf_error(l, "skin %u: accessor %d is not one of %u", index, skin->inverse_bind,
                             l->doc->accessor_count);
    *out = calloc(skin->joint_count, 16 * sizeof(float));
    if (!*out)
        return ng_out_of_memory(l->path);
    for (size_t i = 0; i < skin->joint_count * (size_t)16; i++)
        (*out)[i] = i % 16 % 5 == 0 ? 1.0f : 0.0f;
    return NG_OK;
}

static ng_result make_skeleton(struct gltf_loader *l, uint32_t index, const struct gltf_skin *skin,
                               struct ng_skeleton *s)
{
    if (skin->joint_count > l->limits.max_joints) {
        ng_log_error("%s: skin %u: %u joints, more than the limit of %u", l->path, index, skin->joint_count,
                     l->limits.max_joints);
        return NG_ERROR_MEMORY;
    }
    if (skin->joint_count == 0)
        return ng_gltf_error(l, "skin %u: has no joints", index);
    if (skin->skeleton < -1 || (skin->skeleton >= 0 && (uint32_t)skin->skeleton >= l->doc->node_count))
        return ng_gltf_error(l, "skin %u: skeleton: node %d is not one of %u", index, skin->skeleton,
                             l->doc->node_count);
    NG_TRY(ng_gltf_budget(l, skin->joint_count * (sizeof(ng_entity) + 64), "a skin"));
    s->joint_count = skin->joint_count;
    s->joints = calloc(skin->joint_count, sizeof *s->joints);
    if (!s->joints)
        return ng_out_of_memory(l->path);
    NG_TRY(read_joints(l, index, skin, s->joints));
    return read_inverse_bind(l, index, skin, &s->inverse_bind);
}

ng_result ng_gltf_skin(struct gltf_loader *l, int index, ng_asset *out)
{
    *out = (ng_asset){0};
    if (index < 0 || (uint32_t)index >= l->doc->skin_count)
        return ng_gltf_error(l, "skin %d is not one of %u", index, l->doc->skin_count);
    if (!l->skins[index].id) {
        const struct gltf_skin *skin = &l->doc->skins[index];
        struct ng_skeleton s = {0};
        ng_result r = make_skeleton(l, (uint32_t)index, skin, &s);
        if (r == NG_OK && !ng_array_reserve(&l->added, l->added.count + 1))
            r = ng_out_of_memory(l->path);
        if (r != NG_OK) {
            free(s.joints);
            free(s.inverse_bind);
            return r;
        }
        NG_TRY(ng_assets_take_skeleton(l->assets, skin->name, &s, &l->skins[index]));
        ng_array_push(&l->added, l->skins[index]);
        l->out.skin_count++;
    }
    *out = l->skins[index];
    return NG_OK;
}

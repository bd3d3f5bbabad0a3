// Skins into skeletons.
#include "asset/gltf_loader_internal.h"
#include "base/log.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static ng_result read_joints(struct gltf_loader *l, uint32_t index, const struct gltf_skin *skin,
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
            NG_TRY(ng_gltf_fault(&l->faults, "it counts as both",
                                 "skin %u: joint %u: node %d is listed twice", index, i, node));
        l->joint_of[node] = index + 1;
    }
    return NG_OK;
}

// [joint_count][16]
static float *identities(uint32_t joint_count)
{
    float *m = calloc(joint_count, 16 * sizeof(float));
    for (size_t i = 0; m && i < joint_count * (size_t)16; i++)
        m[i] = i % 16 % 5 == 0 ? 1.0f : 0.0f;
    return m;
}

// Copies the matrices that the file has; of one that is no number the identity stays.
static ng_result copy_inverse_bind(struct gltf_loader *l, uint32_t index, const float *in, uint32_t count,
                                   float *out)
{
    for (uint32_t i = 0; i < count; i++) {
        bool finite = true;
        for (size_t k = 0; k < 16; k++)
            finite &= !isnan(in[i * (size_t)16 + k]);
        if (finite)
            memcpy(out + i * (size_t)16, in + i * (size_t)16, 16 * sizeof(float));
        else
            NG_TRY(ng_gltf_fault(&l->faults, "the identity is used",
                                 "skin %u: inverse bind matrix %u holds what is no finite number", index, i));
    }
    return NG_OK;
}

static ng_result read_inverse_bind(struct gltf_loader *l, uint32_t index, const struct gltf_skin *skin,
                                   float *out)
{
    const struct gltf_want want = {"inverseBindMatrices", GLTF_FLOATS | GLTF_ANY_NUMBER, 1u << 16, 0, false};
    char where[32];
    float *in = NULL;
    uint32_t count = 0;
    NG_TRY(ng_gltf_read(l, skin->inverse_bind, &want, &in, &count));
    snprintf(where, sizeof where, "skin %u", index);
    ng_gltf_keep_within(l, where, want.what, in, (size_t)count * 16);
    ng_result r = NG_OK;
    if (count < skin->joint_count)
        r = ng_gltf_fault(&l->faults, "the others are the identity",
                          "skin %u: %u inverse bind matrices for %u joints", index, count, skin->joint_count);
    if (r == NG_OK)
        r = copy_inverse_bind(l, index, in, count < skin->joint_count ? count : skin->joint_count, out);
    free(in);
    return r;
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
    if (skin->skeleton >= 0 && (uint32_t)skin->skeleton >= l->doc->node_count)
        NG_TRY(ng_gltf_fault(&l->faults, "it is ignored", "skin %u: skeleton: node %d is not one of %u",
                             index, skin->skeleton, l->doc->node_count));
    NG_TRY(ng_gltf_budget(l, skin->joint_count * (sizeof(ng_entity) + 64), "a skin"));
    s->joint_count = skin->joint_count;
    s->joints = calloc(skin->joint_count, sizeof *s->joints);
    s->inverse_bind = identities(skin->joint_count);
    if (!s->joints || !s->inverse_bind)
        return ng_out_of_memory(l->path);
    NG_TRY(read_joints(l, index, skin, s->joints));
    if (skin->inverse_bind < 0)
        return NG_OK;
    struct gltf_part part;
    ng_gltf_part_begin(&part, "the identity is used");
    return ng_gltf_part_end(&l->faults, &part, read_inverse_bind(l, index, skin, s->inverse_bind));
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

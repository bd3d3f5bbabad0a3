// Where the nodes of a scene are when it is first seen: at time 0, with the clips that play. What the world
// holds stays as the file has it.
#include "anim/sample.h"
#include "asset/gltf_loader_internal.h"
#include "components/components.h"
#include "components/transform.h"

#include <cglm/cglm.h>

#include <stdlib.h>
#include <string.h>

// A node by its entity.
struct node_of {
    uint64_t entity;
    uint32_t node;
};

static int compare_entities(const void *a, const void *b)
{
    const struct node_of *x = a, *y = b;
    return (x->entity > y->entity) - (x->entity < y->entity);
}

// Lets a channel that drives a transform drive the copy in `locals`.
static void pose_channel(const struct gltf_loader *l, const struct node_of *nodes, const struct ng_channel *c,
                         float clip_time, struct ng_transform *locals)
{
    const struct node_of key = {.entity = c->target.id};
    if (c->component != NG_TRANSFORM || !c->key_count)
        return;
    const struct node_of *found = bsearch(&key, nodes, l->order_count, sizeof *nodes, compare_entities);
    float value[4];
    if (!found)
        return;
    ng_channel_sample(c, clip_time, value);
    memcpy((char *)&locals[found->node] + c->field_offset, value, c->width * sizeof *value);
}

// Of several clips that are blended the last counts, which is near enough for a box.
static void pose_clips(const struct gltf_loader *l, const struct node_of *nodes, struct ng_transform *locals)
{
    for (size_t i = 0; i < l->clips.count; i++) {
        const struct ng_animation *a = ng_world_get(l->world, l->clips.items[i].entity, NG_ANIMATION);
        const struct ng_clip *clip = l->clips.items[i].clip;
        if (!a || !clip || !a->playing || !(a->weight > 0))
            continue;
        for (uint32_t k = 0; k < clip->channel_count; k++)
            pose_channel(l, nodes, &clip->channels[k], ng_clip_time(a, clip->duration, 0), locals);
    }
}

void ng_gltf_local_matrix(const struct ng_transform *t, float out[16])
{
    mat4 m, rotation;
    versor q;
    memcpy(q, t->rotation, sizeof q);
    glm_quat_mat4(q, rotation);
    glm_translate_make(m, (float *)t->translation);
    glm_mat4_mul(m, rotation, m);
    glm_scale(m, (float *)t->scale);
    memcpy(out, m, sizeof m);
}

static bool pose(const struct gltf_loader *l, struct ng_transform *locals)
{
    struct node_of *nodes = malloc((l->order_count + (size_t)1) * sizeof *nodes);
    if (!nodes)
        return false;
    for (uint32_t i = 0; i < l->order_count; i++) {
        uint32_t node = l->order[i];
        nodes[i] = (struct node_of){l->nodes[node].id, node};
        memcpy(&locals[node], ng_world_get(l->world, l->nodes[node], NG_TRANSFORM), sizeof *locals);
    }
    qsort(nodes, l->order_count, sizeof *nodes, compare_entities);
    pose_clips(l, nodes, locals);
    free(nodes);
    return true;
}

float (*ng_gltf_pose(const struct gltf_loader *l))[16]
{
    struct ng_transform *locals = calloc(l->doc->node_count + (size_t)1, sizeof *locals);
    float(*world)[16] = calloc(l->doc->node_count + (size_t)1, sizeof *world);
    bool posed = locals && world && pose(l, locals);
    for (uint32_t i = 0; posed && i < l->order_count; i++) {
        uint32_t node = l->order[i], parent = l->parents[node];
        mat4 m, above;
        ng_gltf_local_matrix(&locals[node], (float *)m);
        if (parent != NG_GLTF_NO_NODE) {
            memcpy(above, world[parent], sizeof above);
            glm_mat4_mul(above, m, m);
        }
        memcpy(world[node], m, sizeof m);
    }
    free(locals);
    if (posed)
        return world;
    free(world);
    return NULL;
}

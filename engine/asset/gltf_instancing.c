// EXT_mesh_gpu_instancing: where the copies of a node's mesh stand, below the node.
#include "asset/gltf_loader_internal.h"
#include "asset/gltf_unit.h"
#include "base/log.h"
#include "components/components.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct places {
    float *translation, *rotation, *scale; // or null
    uint32_t count;
};

static ng_result read_attribute(struct gltf_loader *l, const struct gltf_value *attributes, const char *name,
                                uint32_t types, uint32_t width, struct places *p, float **out)
{
    int accessor = ng_gltf_index(attributes, name, -1);
    if (!ng_gltf_member(attributes, name))
        return NG_OK;
    struct gltf_want want = {name, types, 1u << width, p->count, false};
    return ng_gltf_read(l, accessor, &want, out, &p->count);
}

static ng_result read_places(struct gltf_loader *l, const char *where, const struct gltf_value *attributes,
                             struct places *p)
{
    const uint32_t quaternions = GLTF_FLOATS | GLTF_TYPE(GLTF_I8) | GLTF_TYPE(GLTF_I16);
    NG_TRY(read_attribute(l, attributes, "TRANSLATION", GLTF_FLOATS, 3, p, &p->translation));
    NG_TRY(read_attribute(l, attributes, "ROTATION", quaternions, 4, p, &p->rotation));
    NG_TRY(read_attribute(l, attributes, "SCALE", GLTF_FLOATS, 3, p, &p->scale));
    if (p->count == 0)
        return ng_gltf_error(l, "%s: EXT_mesh_gpu_instancing has none of TRANSLATION, ROTATION and SCALE",
                             where);
    return NG_OK;
}

// A rotation of no length is none.
static void normalize4(float q[4])
{
    bool usable = ng_gltf_normalize_rotation(q);
    for (int i = 0; i < 4 && !usable; i++)
        q[i] = (float)(i == 3);
}

static void fill(struct gltf_loader *l, const char *where, struct places *p, struct ng_transform *out)
{
    if (p->translation)
        ng_gltf_keep_within(l, where, "TRANSLATION", p->translation, (size_t)p->count * 3);
    if (p->scale)
        ng_gltf_keep_within(l, where, "SCALE", p->scale, (size_t)p->count * 3);
    for (size_t i = 0; i < p->count; i++) {
        memcpy(&out[i], ng_transform_component.defaults, sizeof out[i]);
        if (p->translation)
            memcpy(out[i].translation, p->translation + i * 3, sizeof out[i].translation);
        if (p->rotation)
            memcpy(out[i].rotation, p->rotation + i * 4, sizeof out[i].rotation);
        if (p->scale)
            memcpy(out[i].scale, p->scale + i * 3, sizeof out[i].scale);
        normalize4(out[i].rotation);
    }
}

static ng_result make(struct gltf_loader *l, const char *where, const struct gltf_value *attributes,
                      struct places *p, struct ng_transform **out)
{
    NG_TRY(read_places(l, where, attributes, p));
    NG_TRY(ng_gltf_budget(l, p->count * sizeof **out, where));
    *out = malloc(p->count * sizeof **out);
    if (!*out)
        return ng_out_of_memory(l->path);
    fill(l, where, p, *out);
    return NG_OK;
}

ng_result ng_gltf_copies(struct gltf_loader *l, const char *where, const struct gltf_node *node,
                         struct ng_transform **out, uint32_t *count)
{
    const struct gltf_value *extension = ng_gltf_member(node->extensions, "EXT_mesh_gpu_instancing");
    struct places p = {0};
    struct gltf_part part;
    *out = NULL;
    *count = 0;
    if (!extension)
        return NG_OK;
    if (node->skin != -1) // whose joints say where the mesh is
        return ng_gltf_fault(&l->faults, "it is drawn once", "%s: EXT_mesh_gpu_instancing of a skinned mesh",
                             where);
    ng_gltf_part_begin(&part, "its mesh is drawn once");
    ng_result r = make(l, where, ng_gltf_member(extension, "attributes"), &p, out);
    free(p.translation);
    free(p.rotation);
    free(p.scale);
    *count = r == NG_OK ? p.count : 0;
    return ng_gltf_part_end(&l->faults, &part, r);
}

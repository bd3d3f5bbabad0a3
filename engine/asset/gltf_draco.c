// KHR_draco_mesh_compression: a primitive's vertices and indices come from one compressed mesh, and its
// accessors say what becomes of them. What is decoded stands in for the accessors' bytes while the primitive
// is made.
#include "asset/draco_internal.h"
#include "asset/gltf_loader_internal.h"
#include "base/log.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static ng_result stand_in(struct gltf_loader *l, uint32_t accessor, void *bytes, size_t size)
{
    struct gltf_stand_in item = {accessor, {bytes, size}};
    if (ng_array_push(&l->stand_ins, item))
        return NG_OK;
    free(bytes);
    return ng_out_of_memory(l->path);
}

void ng_gltf_draco_end(struct gltf_loader *l)
{
    for (size_t i = 0; i < l->stand_ins.count; i++)
        free(l->stand_ins.items[i].bytes.data);
    l->stand_ins.count = 0;
}

static size_t component_size(int type)
{
    return type == GLTF_I8 || type == GLTF_U8 ? 1 : type == GLTF_I16 || type == GLTF_U16 ? 2 : 4;
}

static ng_result take_attribute(struct gltf_loader *l, const char *where, const struct ng_draco *mesh,
                                const struct gltf_primitive *p, const struct gltf_value *id)
{
    int accessor = -1;
    for (uint32_t i = 0; i < p->attribute_count; i++)
        if (strcmp(p->attributes[i].name, id->key) == 0)
            accessor = p->attributes[i].accessor;
    if (accessor < 0 || (uint32_t)accessor >= l->doc->accessor_count || id->kind != GLTF_NUMBER ||
        !(id->number >= 0) || id->number > INT32_MAX)
        return ng_gltf_error(l, "%s: KHR_draco_mesh_compression: %.40s is not an attribute of the primitive",
                             where, id->key);
    const struct gltf_accessor *a = &l->doc->accessors[accessor];
    uint32_t vertices = ng_draco_vertex_count(mesh);
    size_t size = vertices * (size_t)a->components * component_size(a->component_type);
    if (a->count != vertices || a->components == 0)
        return ng_gltf_error(l,
                             "%s: KHR_draco_mesh_compression: %u vertices where accessor %d of %.40s has %zu",
                             where, vertices, accessor, id->key, a->count);
    NG_TRY(ng_gltf_budget(l, size, where));
    void *bytes = malloc(size);
    if (!bytes)
        return ng_out_of_memory(l->path);
    if (!ng_draco_attribute(mesh, (uint32_t)id->number, a->component_type, a->components, bytes)) {
        free(bytes);
        return ng_gltf_error(
            l, "%s: KHR_draco_mesh_compression: attribute %.0f does not fit accessor %d of %.40s", where,
            id->number, accessor, id->key);
    }
    return stand_in(l, (uint32_t)accessor, bytes, size);
}

static ng_result take_indices(struct gltf_loader *l, const char *where, const struct ng_draco *mesh,
                              const struct gltf_primitive *p)
{
    uint32_t count = ng_draco_index_count(mesh);
    if (p->indices < 0 || (uint32_t)p->indices >= l->doc->accessor_count)
        return ng_gltf_error(l, "%s: KHR_draco_mesh_compression: the primitive has no indices", where);
    const struct gltf_accessor *a = &l->doc->accessors[p->indices];
    if (a->count != count || a->components != 1)
        return ng_gltf_error(l, "%s: KHR_draco_mesh_compression: %u indices where accessor %d has %zu", where,
                             count, p->indices, a->count);
    NG_TRY(ng_gltf_budget(l, count * (uint64_t)4, where));
    uint32_t *indices = malloc(count * sizeof *indices);
    if (!indices)
        return ng_out_of_memory(l->path);
    ng_draco_indices(mesh, indices);
    // Narrowed in place: an index is never written where one is still to be read.
    size_t width = component_size(a->component_type);
    for (size_t i = 0; i < count; i++) {
        if (width < 4 && indices[i] >> (8 * width)) {
            free(indices);
            return ng_gltf_error(l, "%s: KHR_draco_mesh_compression: indices do not fit accessor %d", where,
                                 p->indices);
        }
        float real = (float)indices[i]; // the accessor of a careless writer
        memcpy((unsigned char *)indices + i * width,
               a->component_type == GLTF_F32 ? (void *)&real : &indices[i], width);
    }
    return stand_in(l, (uint32_t)p->indices, indices, count * width);
}

static ng_result take_mesh(struct gltf_loader *l, const char *where, const struct gltf_value *extension,
                           const struct gltf_primitive *p, const struct ng_draco *mesh)
{
    const struct gltf_value *attributes = ng_gltf_member(extension, "attributes");
    if (!attributes || attributes->kind != GLTF_OBJECT)
        return ng_gltf_error(l, "%s: KHR_draco_mesh_compression: there are no attributes", where);
    for (uint32_t i = 0; i < attributes->count; i++)
        NG_TRY(take_attribute(l, where, mesh, p, &attributes->items[i]));
    return take_indices(l, where, mesh, p);
}

ng_result ng_gltf_draco_begin(struct gltf_loader *l, const char *where, const struct gltf_primitive *p)
{
    const struct gltf_value *extension = ng_gltf_member(p->extensions, "KHR_draco_mesh_compression");
    const unsigned char *data;
    size_t size;
    char why[NG_REASON_SIZE];
    struct ng_draco *mesh;
    if (!extension)
        return NG_OK;
    NG_TRY(ng_gltf_view_bytes(l, ng_gltf_index(extension, "bufferView", -1), &data, &size));
    ng_result r = ng_draco_decode(data, size, l->limits.max_memory - l->memory, why, &mesh);
    if (r != NG_OK)
        return ng_gltf_log_error(l, "%s: KHR_draco_mesh_compression: %s", where, why), r;
    r = take_mesh(l, where, extension, p, mesh);
    ng_draco_destroy(&mesh);
    if (r != NG_OK)
        ng_gltf_draco_end(l);
    return r;
}

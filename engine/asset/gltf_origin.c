#define _POSIX_C_SOURCE 200809L // strdup
#include "asset/gltf_origin_internal.h"

#include "base/file.h"
#include "base/log.h"
#include "components/components.h"

#include <cjson/cJSON.h>

#include <stdlib.h>
#include <string.h>

#define VALUE_ALIGN 16

void ng_gltf_origin_destroy(struct ng_gltf_origin **origin)
{
    struct ng_gltf_origin *o = *origin;
    if (!o)
        return;
    for (size_t i = 0; i < o->pictures.count; i++) {
        free(o->pictures.items[i].uri);
        free(o->pictures.items[i].data);
    }
    ng_gltf_document_destroy(&o->doc);
    cJSON_Delete(o->json);
    free(o->path);
    ng_array_finish(&o->entities);
    ng_array_finish(&o->assets);
    ng_array_finish(&o->values);
    ng_array_finish(&o->pictures);
    free(o->shapes);
    free(o->first_primitive);
    ng_array_finish(&o->images);
    free(o->skins);
    free(o);
    *origin = NULL;
}

// ---- entities and assets ---------------------------------------------------------------------------------

static int compare_kept(const void *a, const void *b)
{
    uint64_t x = ((const struct gltf_kept *)a)->entity.id, y = ((const struct gltf_kept *)b)->entity.id;
    return (x > y) - (x < y);
}

static int compare_assets(const void *a, const void *b)
{
    uint32_t x = ((const struct gltf_kept_asset *)a)->asset.id;
    uint32_t y = ((const struct gltf_kept_asset *)b)->asset.id;
    return (x > y) - (x < y);
}

const struct gltf_kept *ng_gltf_kept(const struct ng_gltf_origin *o, ng_entity e)
{
    struct gltf_kept key = {.entity = e};
    return o && o->entities.count
               ? bsearch(&key, o->entities.items, o->entities.count, sizeof key, compare_kept)
               : NULL;
}

bool ng_gltf_kept_asset(const struct ng_gltf_origin *o, const struct ng_assets *assets, ng_asset asset)
{
    struct gltf_kept_asset key = {.asset = asset};
    const struct gltf_kept_asset *found =
        o && o->assets.count ? bsearch(&key, o->assets.items, o->assets.count, sizeof key, compare_assets)
                             : NULL;
    return found && found->revision == ng_assets_revision(assets, asset).content;
}

static size_t padded(size_t size)
{
    return (size + VALUE_ALIGN - 1) / VALUE_ALIGN * VALUE_ALIGN;
}

const void *ng_gltf_kept_value(const struct ng_gltf_origin *o, const struct ng_world *world,
                               const struct gltf_kept *kept, ng_component component)
{
    static const unsigned char tag[1];
    if (!kept || !(kept->components >> component & 1))
        return NULL;
    size_t at = kept->values;
    for (ng_component c = 0; c < component; c++)
        if (kept->components >> c & 1)
            at += padded(ng_world_component(world, c)->size);
    return ng_world_component(world, component)->size ? o->values.items + at : tag;
}

static bool keep_values(struct ng_gltf_origin *o, const struct ng_world *world, struct gltf_kept *kept)
{
    kept->values = o->values.count;
    for (ng_component c = 0; c < ng_world_component_count(world); c++) {
        const struct ng_component_desc *desc = ng_world_component(world, c);
        if (desc->flags & NG_COMPONENT_DERIVED || !ng_world_has(world, kept->entity, c))
            continue;
        size_t at = o->values.count;
        if (!ng_array_resize(&o->values, at + padded(desc->size)))
            return false;
        if (desc->size)
            memcpy(o->values.items + at, ng_world_get(world, kept->entity, c), desc->size);
        kept->components |= (uint64_t)1 << c;
    }
    return true;
}

// At once, so that arrays do not grow, which of many entities takes as much again.
static ng_result reserve_entities(const struct gltf_loader *l, struct ng_gltf_origin *o)
{
    size_t count = 0, size = 0;
    for (ng_entity e = l->out.root; !ng_entity_is_null(e);
         e = ng_world_next_below(l->world, l->out.root, e), count++)
        for (ng_component c = 0; c < ng_world_component_count(l->world); c++)
            if (!(ng_world_component(l->world, c)->flags & NG_COMPONENT_DERIVED) &&
                ng_world_has(l->world, e, c))
                size += padded(ng_world_component(l->world, c)->size);
    const uint64_t most = ((uint64_t)64 << 20) + 16 * l->doc->bytes;
    if (size + count * sizeof *o->entities.items > most) {
        ng_log_error("%s: %zu entities in a file of %llu bytes are more than can be kept for saving", l->path,
                     count, (unsigned long long)l->doc->bytes);
        return NG_ERROR_MEMORY;
    }
    return ng_array_reserve(&o->entities, count) && ng_array_reserve(&o->values, size)
               ? NG_OK
               : ng_out_of_memory(l->path);
}

static void set_role(struct ng_gltf_origin *o, ng_entity e, enum gltf_role role, int index,
                     uint32_t primitive)
{
    struct gltf_kept *kept = (struct gltf_kept *)ng_gltf_kept(o, e);
    if (!kept)
        return;
    kept->role = role;
    kept->index = index;
    kept->primitive = primitive;
}

static bool keep_entities(struct gltf_loader *l, struct ng_gltf_origin *o)
{
    for (ng_entity e = l->out.root; !ng_entity_is_null(e);
         e = ng_world_next_below(l->world, l->out.root, e)) {
        struct gltf_kept kept = {.entity = e,
                                 .parent = ng_world_parent(l->world, e),
                                 .first_child = ng_world_first_child(l->world, e),
                                 .next_sibling = ng_world_next_sibling(l->world, e)};
        if (!keep_values(o, l->world, &kept) || !ng_array_push(&o->entities, kept))
            return false;
    }
    if (o->entities.count)
        qsort(o->entities.items, o->entities.count, sizeof *o->entities.items, compare_kept);
    set_role(o, l->out.root, GLTF_ROOT, 0, 0);
    for (uint32_t i = 0; i < l->doc->node_count; i++)
        set_role(o, l->nodes[i], GLTF_NODE, (int)i, 0);
    for (uint32_t i = 0; i < l->doc->material_count; i++)
        set_role(o, l->materials[i], GLTF_MATERIAL, (int)i, 0);
    for (uint32_t i = 0; i < l->doc->animation_count; i++)
        set_role(o, l->animations[i], GLTF_ANIMATION, (int)i, 0);
    for (size_t i = 0; i < l->instances.count; i++) {
        const struct gltf_instance *instance = &l->instances.items[i];
        ng_entity node = l->nodes[instance->node], e = instance->entity,
                  parent = ng_world_parent(l->world, e);
        bool several = l->doc->meshes[l->doc->nodes[instance->node].mesh].primitive_count > 1;
        if (ng_entity_same(e, node))
            continue;
        if (several && ng_entity_same(parent, node)) {
            set_role(o, e, GLTF_PRIMITIVE, (int)instance->node, instance->primitive);
            continue;
        }
        set_role(o, e, GLTF_COPY, (int)instance->node, instance->primitive);
        if (several)
            set_role(o, parent, GLTF_COPY, (int)instance->node, 0);
    }
    return true;
}

static bool keep_assets(struct gltf_loader *l, struct ng_gltf_origin *o)
{
    for (size_t i = 0; i < l->added.count; i++) {
        struct gltf_kept_asset asset = {l->added.items[i],
                                        ng_assets_revision(l->assets, l->added.items[i]).content};
        if (!ng_array_push(&o->assets, asset))
            return false;
    }
    if (o->assets.count)
        qsort(o->assets.items, o->assets.count, sizeof *o->assets.items, compare_assets);
    size_t primitives = 0;
    o->first_primitive = calloc(l->doc->mesh_count + (size_t)1, sizeof *o->first_primitive);
    for (uint32_t i = 0; o->first_primitive && i < l->doc->mesh_count; i++) {
        o->first_primitive[i] = (uint32_t)primitives;
        primitives += l->doc->meshes[i].primitive_count;
    }
    o->shapes = calloc(primitives + 1, sizeof *o->shapes);
    for (size_t i = 0; o->shapes && l->made && i < primitives; i++)
        if (l->made[i])
            o->shapes[i] = *l->made[i];
    o->images = l->images;
    o->skins = l->skins;
    l->images = (struct gltf_images){0};
    l->skins = NULL;
    return o->first_primitive && o->shapes;
}

// ---- pictures --------------------------------------------------------------------------------------------

const struct gltf_kept_picture *ng_gltf_kept_picture(const struct ng_gltf_origin *o, const char *uri)
{
    for (size_t i = 0; o && uri && i < o->pictures.count; i++)
        if (strcmp(o->pictures.items[i].uri, uri) == 0)
            return &o->pictures.items[i];
    return NULL;
}

// One that cannot be read was warned of when it was loaded, or is not used: its name stays as it is.
static bool keep_picture(const struct gltf_loader *l, struct ng_gltf_origin *o, const cJSON *uri)
{
    char path[4096];
    const char *why;
    struct gltf_kept_picture picture = {0};
    if (!cJSON_IsString(uri) || ng_gltf_kept_picture(o, uri->valuestring) ||
        !ng_gltf_uri_path(l->path, uri->valuestring, path, sizeof path, &why) || !ng_file_exists(path))
        return true;
    if (ng_file_read_named(path, path, l->limits.max_file_size, NG_GLTF_RAISE, &picture.data,
                           &picture.size) != NG_OK)
        return true;
    picture.uri = strdup(uri->valuestring);
    if (picture.uri && ng_array_push(&o->pictures, picture))
        return true;
    free(picture.uri);
    free(picture.data);
    return false;
}

// The pictures that NG_scene names are anywhere below it.
static bool keep_pictures_below(const struct gltf_loader *l, struct ng_gltf_origin *o, const cJSON *value,
                                bool ours)
{
    const cJSON *item;
    cJSON_ArrayForEach(item, value)
    {
        bool inside = ours || (item->string && strcmp(item->string, "NG_scene") == 0);
        if (inside && item->string && strcmp(item->string, "uri") == 0 && !keep_picture(l, o, item))
            return false;
        if (!keep_pictures_below(l, o, item, inside))
            return false;
    }
    return true;
}

static bool keep_pictures(const struct gltf_loader *l, struct ng_gltf_origin *o)
{
    const cJSON *image;
    cJSON_ArrayForEach(image, cJSON_GetObjectItemCaseSensitive(o->json, "images"))
    {
        if (!keep_picture(l, o, cJSON_GetObjectItemCaseSensitive(image, "uri")))
            return false;
    }
    return keep_pictures_below(l, o, o->json, false);
}

// A value as a tree takes 80 bytes, and there are two trees while saving.
static ng_result keep_json(struct gltf_loader *l, struct ng_gltf_origin *o)
{
    const struct gltf_document *d = o->doc;
    const uint64_t value = 160, any = (uint64_t)160 << 20, times = 16;
    size_t most = (size_t)((any + times * d->file_size) / value), size;
    char *text = ng_gltf_plain_json((const char *)d->files.items[0] + d->json_offset, d->json_size, &size);
    if (!text)
        return ng_out_of_memory(l->path);
    o->json = ng_gltf_origin_json(text, size, most);
    free(text);
    if (o->json)
        return NG_OK;
    ng_log_error("%s: its JSON cannot be kept for saving: it is no JSON, or has over %zu values", l->path,
                 most);
    return NG_ERROR_FORMAT;
}

static ng_result fill(struct gltf_loader *l, struct ng_gltf_origin *o)
{
    o->path = strdup(l->path);
    o->foreign = l->out.foreign;
    NG_TRY(keep_json(l, o));
    NG_TRY(reserve_entities(l, o));
    if (!o->path || !keep_entities(l, o) || !keep_assets(l, o) || !keep_pictures(l, o))
        return ng_out_of_memory(l->path);
    return NG_OK;
}

ng_result ng_gltf_keep(struct gltf_loader *l, struct gltf_document **doc)
{
    struct ng_gltf_origin *o = calloc(1, sizeof *o);
    if (!o)
        return ng_out_of_memory(l->path);
    o->doc = *doc;
    *doc = NULL;
    ng_result r = fill(l, o);
    if (r == NG_OK)
        l->out.origin = o;
    else
        ng_gltf_origin_destroy(&o);
    return r;
}

// A file into the tables of a document: what is asked of it first, and what is added to what tinygltf reads.
// Whether indices and numbers make sense is for those to see who use them.
#include "asset/catalogue_internal.h"
#include "asset/gltf_internal.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/log.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- what is asked of a file first -----------------------------------------------------------------------

// glTF 2.0, 5.9 (asset): minVersion, if it is there, says what is needed, else the major part of version.
static ng_result check_version(struct gltf_faults *faults, const struct gltf_value *root)
{
    const char *path = faults->path;
    const struct gltf_value *asset = ng_gltf_member(root, "asset");
    const char *version = ng_gltf_text(asset, "version", ""), *min = ng_gltf_text(asset, "minVersion", "");
    if (!version[0]) {
        ng_log_error("%s: asset.version: is missing; glTF 2.0 requires it", path);
        return NG_ERROR_FORMAT;
    }
    const char *needed = min[0] ? min : version;
    unsigned major = 0, minor = 0;
    char rest = 0;
    int parts = sscanf(needed, "%4u.%4u%c", &major, &minor, &rest);
    bool is_2 = major == 2 && (needed[1] == '.' || !needed[1]) && (!min[0] || minor == 0);
    if (is_2 && parts != 2) {
        ng_result r = ng_gltf_fault(faults, "it is taken for 2.0",
                                    "asset.version: \"%.60s\" is not two numbers", needed);
        return r == NG_ERROR_FORMAT ? NG_OK : r; // a strict load ends with the faults of the JSON
    }
    if (is_2)
        return NG_OK;
    ng_log_error("%s: asset.%s: \"%.60s\" is not supported, glTF 2.0 is; convert the file", path,
                 min[0] ? "minVersion" : "version", needed);
    return NG_ERROR_UNSUPPORTED;
}

bool ng_gltf_knows_extension(const char *extension)
{
    static const char *const known[] = {"EXT_mesh_gpu_instancing", "EXT_meshopt_compression",
                                        "EXT_texture_webp",        "KHR_draco_mesh_compression",
                                        "KHR_lights_punctual",     "KHR_materials_emissive_strength",
                                        "KHR_materials_ior",       "KHR_materials_pbrSpecularGlossiness",
                                        "KHR_materials_specular",  "KHR_materials_unlit",
                                        "KHR_mesh_quantization",   "KHR_meshopt_compression",
                                        "KHR_texture_transform",   "NG_scene"};
    for (size_t i = 0; i < NG_COUNT(known); i++)
        if (strcmp(extension, known[i]) == 0)
            return true;
    return false;
}

static ng_result check_required(const char *path, const struct gltf_value *root)
{
    const struct gltf_value *required = ng_gltf_array(root, "extensionsRequired");
    char names[300] = "";
    for (uint32_t i = 0; required && i < required->count; i++) {
        const struct gltf_value *name = &required->items[i];
        size_t n = strlen(names);
        if (name->kind == GLTF_STRING && !ng_gltf_knows_extension(name->string) &&
            !strstr(names, name->string))
            snprintf(names + n, sizeof names - n, "%s\"%.100s\"", n ? ", " : "", name->string);
    }
    if (!names[0])
        return NG_OK;
    ng_log_error("%s: extensionsRequired: %s is not supported; export without it", path, names);
    return NG_ERROR_UNSUPPORTED;
}

// ---- extensions that are not followed --------------------------------------------------------------------
struct ignored {
    struct {
        const char *name;
        uint32_t count;
    } items[16];
    uint32_t count;
};

static void note_ignored(struct ignored *ignored, const char *name)
{
    uint32_t i = 0;
    while (i < ignored->count && strcmp(ignored->items[i].name, name) != 0)
        i++;
    if (ng_gltf_knows_extension(name) || i == NG_COUNT(ignored->items))
        return;
    ignored->count += i == ignored->count;
    ignored->items[i].name = name;
    ignored->items[i].count++;
}

// The JSON has a depth that is bounded.
static void find_ignored(const struct gltf_value *v, struct ignored *ignored)
{
    for (uint32_t i = 0; (v->kind == GLTF_OBJECT || v->kind == GLTF_ARRAY) && i < v->count; i++) {
        const struct gltf_value *item = &v->items[i];
        const char *key = v->kind == GLTF_OBJECT ? item->key : "";
        if (strcmp(key, "extras") == 0)
            continue;
        for (uint32_t k = 0; strcmp(key, "extensions") == 0 && item->kind == GLTF_OBJECT && k < item->count;
             k++)
            note_ignored(ignored, item->items[k].key);
        find_ignored(item, ignored);
    }
}

// One warning for all.
static void warn_ignored(const char *path, const struct gltf_value *root)
{
    struct ignored ignored = {0};
    char names[1024] = "";
    find_ignored(root, &ignored);
    for (uint32_t i = 0; i < ignored.count; i++) {
        size_t n = strlen(names);
        snprintf(names + n, sizeof names - n, "%s%.60s (%u)", n ? ", " : "", ignored.items[i].name,
                 ignored.items[i].count);
    }
    if (ignored.count)
        ng_log_warn("%s: extensions that are not followed, and how often they are used: %s", path, names);
}

// ---- tables ----------------------------------------------------------------------------------------------
// tinygltf has filled them. What the value `v` of an item says beyond that is added to it here: extensions,
// and what tinygltf does not take.
struct maker {
    struct gltf_document *doc;
    struct gltf_faults *faults;
    ng_result result; // the first that failed
};

static const struct gltf_value *extensions_of(const struct gltf_value *v)
{
    const struct gltf_value *extensions = ng_gltf_member(v, "extensions");
    return extensions && extensions->kind == GLTF_OBJECT ? extensions : NULL;
}

static const struct gltf_value *scene_extension(const struct gltf_value *v)
{
    const struct gltf_value *extension = ng_gltf_member(extensions_of(v), "NG_scene");
    return extension && extension->kind == GLTF_OBJECT ? extension : NULL;
}

// Adds to one item of a table what an item of the document says.
typedef void make_fn(struct maker *m, const struct gltf_value *v, void *item);

// `items` is the document's own, which are constant only for those who use them later.
static void make_all(struct maker *m, const struct gltf_value *list, size_t size, make_fn *make,
                     const void *items, uint32_t count)
{
    for (uint32_t i = 0; list && i < count && i < list->count; i++)
        make(m, &list->items[i], (char *)items + i * size);
}

// Strides that tinygltf refuses are reported with the accessor whose elements they do not fit.
static void make_view(struct maker *m, const struct gltf_value *v, void *item)
{
    struct gltf_view *view = item;
    NG_UNUSED(m);
    if (!view->stride)
        view->stride = (size_t)ng_gltf_number(v, "byteStride", 0);
    view->extensions = extensions_of(v);
}

static void make_accessor(struct maker *m, const struct gltf_value *v, void *item)
{
    struct gltf_accessor *a = item;
    NG_UNUSED(m);
    if (a->component_type == GLTF_F64)
        a->component_type = ng_gltf_index(v, "componentType", 0);
    if (!ng_gltf_type_width(ng_gltf_text(v, "type", "")))
        a->components = 0;
}

static void make_primitive(struct maker *m, const struct gltf_value *v, void *item)
{
    struct gltf_primitive *p = item;
    NG_UNUSED(m);
    p->indices = ng_gltf_index(v, "indices", -1);
    p->targets = ng_gltf_array(v, "targets");
    p->target_count = p->targets ? p->targets->count : 0;
    p->extension = scene_extension(v);
    p->extensions = extensions_of(v);
}

static void make_mesh(struct maker *m, const struct gltf_value *v, void *item)
{
    struct gltf_mesh *mesh = item;
    make_all(m, ng_gltf_array(v, "primitives"), sizeof *mesh->primitives, make_primitive, mesh->primitives,
             mesh->primitive_count);
}

static void make_node(struct maker *m, const struct gltf_value *v, void *item)
{
    struct gltf_node *n = item;
    NG_UNUSED(m);
    n->light = ng_gltf_index(ng_gltf_member(extensions_of(v), "KHR_lights_punctual"), "light", -1);
    n->extension = scene_extension(v);
    n->extensions = extensions_of(v);
}

// Of a factor of another count tinygltf has seen nothing.
static void check_factor(struct maker *m, const struct gltf_value *v, const char *key, uint32_t count)
{
    uint32_t given = ng_gltf_number_count(ng_gltf_array(v, key));
    if (given && given != count && m->result == NG_OK)
        m->result =
            ng_gltf_fault(m->faults, "the default is used", "%s: has %u numbers, not %u", key, given, count);
}

// Of an extension; those of the core are tinygltf's.
struct gltf_texture_use ng_gltf_texture_use(const struct gltf_value *v, const char *key)
{
    const struct gltf_value *use = ng_gltf_member(v, key);
    return (struct gltf_texture_use){
        .texture = ng_gltf_index(use, "index", -1),
        .uv_set = ng_gltf_index(use, "texCoord", 0),
        .extensions = extensions_of(use),
    };
}

static void make_texture_use(const struct gltf_value *v, const char *key, struct gltf_texture_use *use)
{
    use->extensions = extensions_of(ng_gltf_member(v, key));
}

static void make_material(struct maker *m, const struct gltf_value *v, void *item)
{
    struct gltf_material *out = item;
    const struct gltf_value *pbr = ng_gltf_member(v, "pbrMetallicRoughness");
    const struct gltf_value *strength = ng_gltf_member(extensions_of(v), "KHR_materials_emissive_strength");
    check_factor(m, pbr, "baseColorFactor", 4);
    check_factor(m, v, "emissiveFactor", 3);
    out->emissive_strength = ng_gltf_number(strength, "emissiveStrength", 1);
    make_texture_use(pbr, "baseColorTexture", &out->base_color_texture);
    make_texture_use(pbr, "metallicRoughnessTexture", &out->metallic_roughness_texture);
    make_texture_use(v, "normalTexture", &out->normal_texture);
    make_texture_use(v, "emissiveTexture", &out->emissive_texture);
    out->occlusion = ng_gltf_index(ng_gltf_member(v, "occlusionTexture"), "index", -1) >= 0;
    out->extension = scene_extension(v);
    out->extensions = extensions_of(v);
}

static void make_texture(struct maker *m, const struct gltf_value *v, void *item)
{
    struct gltf_texture *t = item;
    NG_UNUSED(m);
    t->webp = ng_gltf_index(ng_gltf_member(extensions_of(v), "EXT_texture_webp"), "source", -1);
    t->extensions = extensions_of(v);
}

// Their bytes are not tinygltf's to find, so it is told of none.
static void make_image(struct maker *m, const struct gltf_value *v, void *item)
{
    NG_UNUSED(m);
    const char *uri = ng_gltf_text(v, "uri", ""), *name_end = strrchr(uri, '.');
    *(struct gltf_image *)item = (struct gltf_image){
        .name = ng_gltf_text(v, "name", ""),
        .uri = uri,
        .view = ng_gltf_index(v, "bufferView", -1),
        .webp = strcmp(ng_gltf_text(v, "mimeType", ""), "image/webp") == 0 ||
                strncmp(uri, "data:image/webp", 15) == 0 || (name_end && strcmp(name_end, ".webp") == 0),
    };
}

// tinygltf has only cameras of one of its two types.
static void make_camera(struct maker *m, const struct gltf_value *v, void *item)
{
    struct gltf_camera *c = item;
    const char *type = ng_gltf_text(v, "type", "");
    const struct gltf_value *perspective = ng_gltf_member(v, "perspective");
    c->perspective = c->perspective && strcmp(type, "perspective") == 0;
    c->orthographic = c->orthographic && strcmp(type, "orthographic") == 0;
    if (c->perspective || c->orthographic || !perspective || m->result != NG_OK)
        return;
    m->result = ng_gltf_fault(m->faults, "it is perspective, since it has that",
                              "a camera's type \"%.40s\" is neither perspective nor orthographic", type);
    c->perspective = true;
    c->fov_y = ng_gltf_number(perspective, "yfov", 0);
    c->near_plane = ng_gltf_number(perspective, "znear", 0);
}

static void make_animation(struct maker *m, const struct gltf_value *v, void *item)
{
    struct gltf_animation *a = item;
    NG_UNUSED(m);
    a->extension = scene_extension(v);
}

static void make_scene(struct maker *m, const struct gltf_value *v, void *item)
{
    struct gltf_scene *scene = item;
    NG_UNUSED(m);
    scene->extension = scene_extension(v);
}

static bool allocate_images(struct gltf_document *d)
{
    const struct gltf_value *list = ng_gltf_array(d->root, "images");
    d->image_count = list ? list->count : 0;
    d->images = ng_arena_array(&d->arena, d->image_count, sizeof *d->images);
    return d->images != NULL;
}

// Each of these becomes an entity.
static ng_result check_entities(const char *path, const struct ng_gltf_params *params,
                                const struct gltf_value *root)
{
    size_t count = ng_gltf_list_count(root, GLTF_MATERIALS) + ng_gltf_list_count(root, GLTF_ANIMATIONS);
    if (count < params->max_entities)
        return NG_OK;
    ng_log_error("%s: more than the limit of %u entities", path, params->max_entities);
    return NG_ERROR_MEMORY;
}

// So much that no file of items that say something comes near it.
static uint64_t tables_limit(const struct ng_gltf_params *params, const struct gltf_document *d)
{
    const uint64_t any = (uint64_t)64 << 20, times = 12;
    uint64_t limit = any + times * d->file_size;
    return limit < params->max_file_size ? limit : params->max_file_size;
}

static ng_result make_document(struct gltf_faults *faults, const struct ng_gltf_params *params,
                               struct gltf_document *d)
{
    struct maker m = {.doc = d, .faults = faults};
    NG_TRY(check_entities(faults->path, params, d->root));
    NG_TRY(ng_gltf_tables(faults->path, tables_limit(params, d), d));
    if (!allocate_images(d))
        return ng_out_of_memory(faults->path);
#define TABLE(member, make, counter, list)                                                                   \
    make_all(&m, ng_gltf_array(d->root, (list)), sizeof *d->member, (make), d->member, d->counter)
    TABLE(views, make_view, view_count, "bufferViews");
    TABLE(accessors, make_accessor, accessor_count, "accessors");
    TABLE(meshes, make_mesh, mesh_count, "meshes");
    TABLE(nodes, make_node, node_count, "nodes");
    TABLE(materials, make_material, material_count, "materials");
    TABLE(textures, make_texture, texture_count, "textures");
    TABLE(images, make_image, image_count, "images");
    TABLE(cameras, make_camera, camera_count, "cameras");
    TABLE(animations, make_animation, animation_count, "animations");
    TABLE(scenes, make_scene, scene_count, "scenes");
#undef TABLE
    d->extensions = extensions_of(d->root);
    return m.result;
}

// ---- the file --------------------------------------------------------------------------------------------
// Whether a file is neither JSON of an object (or of what may have been meant as one) nor a GLB.
static bool is_no_gltf(const struct gltf_container *c)
{
    size_t i = c->json_size >= 3 && memcmp(c->json, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
    while (i < c->json_size && strchr(" \t\r\n", c->json[i]) && c->json[i])
        i++;
    return i == c->json_size || (c->json[i] != '{' && c->json[i] != '[');
}

static ng_result read_document(struct gltf_faults *faults, const struct ng_gltf_params *params, size_t size,
                               struct gltf_document *doc)
{
    const unsigned char *data = doc->files.items[0];
    struct gltf_container container;
    NG_TRY(ng_gltf_open(faults, data, size, &container));
    if (is_no_gltf(&container)) {
        ng_log_error("%s: is not a glTF file, nor OBJ, nor a furniture catalogue", faults->path);
        return NG_ERROR_FORMAT;
    }
    doc->file_size = size;
    doc->json_offset = (size_t)(container.json - (const char *)data);
    doc->json_size = container.json_size;
    NG_TRY(ng_gltf_json(faults, container.json, container.json_size, &doc->arena, &doc->root));
    ng_result r = check_version(faults, doc->root);
    r = r == NG_OK ? check_required(faults->path, doc->root) : r;
    if (r != NG_OK) { // whatever else is wrong
        ng_gltf_faults_finish(faults);
        return r;
    }
    warn_ignored(faults->path, doc->root);
    if (faults->strict && faults->list.count) // of the JSON
        return NG_ERROR_FORMAT;
    doc->hash = ng_hash_bytes(0, data, size);
    doc->bytes = size;
    NG_TRY(ng_gltf_buffers(faults, params, &container, doc));
    return make_document(faults, params, doc);
}

ng_result ng_gltf_parse(const char *path, const struct ng_gltf_params *params, struct gltf_faults *faults,
                        struct gltf_document **out)
{
    void *data;
    size_t size;
    *out = NULL;
    NG_TRY(ng_format_read(path, params, faults, &data, &size));
    struct gltf_document *doc = calloc(1, sizeof *doc);
    if (!doc || !ng_array_push(&doc->files, data)) {
        free(doc);
        free(data);
        return ng_out_of_memory(path);
    }
    ng_result r = read_document(faults, params, size, doc);
    if (r != NG_OK)
        ng_gltf_document_destroy(&doc);
    *out = doc;
    return r;
}

void ng_gltf_document_destroy(struct gltf_document **document)
{
    struct gltf_document *doc = *document;
    if (!doc)
        return;
    *document = NULL;
    for (size_t i = 0; i < doc->files.count; i++)
        free(doc->files.items[i]);
    ng_array_finish(&doc->files);
    ng_arena_finish(&doc->arena);
    free(doc);
}

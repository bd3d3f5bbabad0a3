// The values of a file into the tables of a document. What is missing has the standard's default here;
// whether indices and numbers make sense is for those to see who use them.
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
static ng_result check_version(const char *path, const struct gltf_value *root)
{
    const struct gltf_value *asset = ng_gltf_member(root, "asset");
    const char *version = ng_gltf_text(asset, "version", ""), *min = ng_gltf_text(asset, "minVersion", "");
    if (!version[0]) {
        ng_log_error("%s: asset.version: is missing; glTF 2.0 requires it", path);
        return NG_ERROR_FORMAT;
    }
    const char *needed = min[0] ? min : version;
    unsigned major = 0, minor = 0;
    char rest = 0;
    if (sscanf(needed, "%4u.%4u%c", &major, &minor, &rest) == 2 && major == 2 && (!min[0] || minor == 0))
        return NG_OK;
    ng_log_error("%s: asset.%s: \"%.60s\" is not supported, glTF 2.0 is; convert the file", path,
                 min[0] ? "minVersion" : "version", needed);
    return NG_ERROR_UNSUPPORTED;
}

// Extensions of the standard that this loader follows, or may ignore since others only refine them.
static bool is_known(const char *extension)
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
        if (name->kind == GLTF_STRING && !is_known(name->string) && !strstr(names, name->string))
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
    if (is_known(name) || i == NG_COUNT(ignored->items))
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
struct maker {
    struct gltf_document *doc;
    struct gltf_faults *faults;
    ng_result result; // the first that failed
};

// Zeroed; null with a `count` of 0 where memory is short.
static void *table(struct maker *m, const struct gltf_value *list, size_t size, uint32_t *count)
{
    *count = list ? list->count : 0;
    void *items = ng_arena_array(&m->doc->arena, *count, size);
    if (!items) {
        m->result = ng_out_of_memory(m->faults->path);
        *count = 0;
    }
    return items;
}

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

// None if one of them is no number.
static struct gltf_numbers numbers(struct maker *m, const struct gltf_value *v, const char *key)
{
    struct gltf_numbers out;
    const struct gltf_value *list = ng_gltf_array(v, key);
    double *items = table(m, list, sizeof *items, &out.count);
    out.items = items;
    for (uint32_t i = 0; i < out.count; i++) {
        if (list->items[i].kind != GLTF_NUMBER)
            return (struct gltf_numbers){items, 0};
        items[i] = list->items[i].number;
    }
    return out;
}

// A factor of `count` numbers, all `missing` where the file has none or another count.
static struct gltf_numbers factor(struct maker *m, const struct gltf_value *v, const char *key,
                                  uint32_t count, double missing)
{
    struct gltf_numbers given = numbers(m, v, key);
    if (given.count == count)
        return given;
    if (given.count && m->result == NG_OK)
        m->result = ng_gltf_fault(m->faults, "the default is used", "%s: has %u numbers, not %u", key,
                                  given.count, count);
    double *items = ng_arena_array(&m->doc->arena, count, sizeof *items);
    for (uint32_t i = 0; items && i < count; i++)
        items[i] = missing;
    if (!items)
        m->result = ng_out_of_memory(m->faults->path);
    return (struct gltf_numbers){items, items ? count : 0};
}

// Indices; what is none is -1.
static const int *indices(struct maker *m, const struct gltf_value *v, const char *key, uint32_t *count)
{
    const struct gltf_value *list = ng_gltf_array(v, key);
    int *items = table(m, list, sizeof *items, count);
    for (uint32_t i = 0; i < *count; i++)
        items[i] = list->items[i].kind == GLTF_NUMBER ? (int)list->items[i].number : -1;
    return items;
}

static void make_view(struct maker *m, const struct gltf_value *v, void *out)
{
    NG_UNUSED(m);
    *(struct gltf_view *)out = (struct gltf_view){
        .buffer = ng_gltf_index(v, "buffer", -1),
        .offset = (size_t)ng_gltf_number(v, "byteOffset", 0),
        .length = (size_t)ng_gltf_number(v, "byteLength", 0),
        .stride = (size_t)ng_gltf_number(v, "byteStride", 0),
        .extensions = extensions_of(v),
    };
}

static uint32_t components_of(const char *type)
{
    static const struct {
        const char *name;
        uint32_t components;
    } types[] = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4},
                 {"MAT2", 4},   {"MAT3", 9}, {"MAT4", 16}};
    for (size_t i = 0; i < NG_COUNT(types); i++)
        if (strcmp(type, types[i].name) == 0)
            return types[i].components;
    return 0;
}

static void make_accessor(struct maker *m, const struct gltf_value *v, void *out)
{
    NG_UNUSED(m);
    const struct gltf_value *sparse = ng_gltf_member(v, "sparse");
    const struct gltf_value *at = ng_gltf_member(sparse, "indices"),
                            *values = ng_gltf_member(sparse, "values");
    *(struct gltf_accessor *)out = (struct gltf_accessor){
        .view = ng_gltf_index(v, "bufferView", -1),
        .offset = (size_t)ng_gltf_number(v, "byteOffset", 0),
        .count = (size_t)ng_gltf_number(v, "count", 0),
        .component_type = ng_gltf_index(v, "componentType", 0),
        .components = components_of(ng_gltf_text(v, "type", "")),
        .normalized = ng_gltf_bool(v, "normalized", false),
        .sparse = sparse && sparse->kind == GLTF_OBJECT,
        .sparse_count = (size_t)ng_gltf_number(sparse, "count", 0),
        .sparse_index_type = ng_gltf_index(at, "componentType", 0),
        .sparse_index_view = ng_gltf_index(at, "bufferView", -1),
        .sparse_index_offset = (size_t)ng_gltf_number(at, "byteOffset", 0),
        .sparse_value_view = ng_gltf_index(values, "bufferView", -1),
        .sparse_value_offset = (size_t)ng_gltf_number(values, "byteOffset", 0),
    };
}

static void make_primitive(struct maker *m, const struct gltf_value *v, void *out)
{
    const struct gltf_value *list = ng_gltf_member(v, "attributes");
    struct gltf_primitive p = {
        .indices = ng_gltf_index(v, "indices", -1),
        .material = ng_gltf_index(v, "material", -1),
        .mode = ng_gltf_index(v, "mode", GLTF_TRIANGLES),
        .targets = ng_gltf_array(v, "targets"),
        .extension = scene_extension(v),
        .extensions = extensions_of(v),
    };
    struct gltf_attribute *attributes =
        table(m, list && list->kind == GLTF_OBJECT ? list : NULL, sizeof *attributes, &p.attribute_count);
    uint32_t count = p.attribute_count;
    p.attribute_count = 0;
    for (uint32_t i = 0; i < count; i++)
        if (list->items[i].kind == GLTF_NUMBER)
            attributes[p.attribute_count++] =
                (struct gltf_attribute){list->items[i].key, (int)list->items[i].number};
    p.attributes = attributes;
    p.target_count = p.targets ? p.targets->count : 0;
    *(struct gltf_primitive *)out = p;
}

// One item of an array of the document into one of a table.
typedef void make_fn(struct maker *m, const struct gltf_value *v, void *out);

static const void *make_all(struct maker *m, const struct gltf_value *list, size_t size, make_fn *make,
                            uint32_t *count)
{
    char *items = table(m, list, size, count);
    for (uint32_t i = 0; i < *count; i++)
        make(m, &list->items[i], items + i * size);
    return items;
}

static void make_mesh(struct maker *m, const struct gltf_value *v, void *out)
{
    struct gltf_mesh *mesh = out;
    mesh->name = ng_gltf_text(v, "name", "");
    mesh->weights = numbers(m, v, "weights");
    mesh->primitives = make_all(m, ng_gltf_array(v, "primitives"), sizeof *mesh->primitives, make_primitive,
                                &mesh->primitive_count);
}

static void make_node(struct maker *m, const struct gltf_value *v, void *out)
{
    struct gltf_node *n = out;
    *n = (struct gltf_node){
        .name = ng_gltf_text(v, "name", ""),
        .mesh = ng_gltf_index(v, "mesh", -1),
        .skin = ng_gltf_index(v, "skin", -1),
        .camera = ng_gltf_index(v, "camera", -1),
        .light = ng_gltf_index(ng_gltf_member(extensions_of(v), "KHR_lights_punctual"), "light", -1),
        .matrix = numbers(m, v, "matrix"),
        .translation = numbers(m, v, "translation"),
        .rotation = numbers(m, v, "rotation"),
        .scale = numbers(m, v, "scale"),
        .weights = numbers(m, v, "weights"),
        .extension = scene_extension(v),
        .extensions = extensions_of(v),
    };
    n->children = indices(m, v, "children", &n->child_count);
}

struct gltf_texture_use ng_gltf_texture_use(const struct gltf_value *v, const char *key)
{
    const struct gltf_value *use = ng_gltf_member(v, key);
    return (struct gltf_texture_use){
        .texture = ng_gltf_index(use, "index", -1),
        .uv_set = ng_gltf_index(use, "texCoord", 0),
        .extensions = extensions_of(use),
    };
}

static void make_material(struct maker *m, const struct gltf_value *v, void *out)
{
    const struct gltf_value *pbr = ng_gltf_member(v, "pbrMetallicRoughness");
    const struct gltf_value *normal = ng_gltf_member(v, "normalTexture");
    const struct gltf_value *strength = ng_gltf_member(extensions_of(v), "KHR_materials_emissive_strength");
    *(struct gltf_material *)out = (struct gltf_material){
        .name = ng_gltf_text(v, "name", ""),
        .alpha_mode = ng_gltf_text(v, "alphaMode", "OPAQUE"),
        .base_color = factor(m, pbr, "baseColorFactor", 4, 1),
        .emissive = factor(m, v, "emissiveFactor", 3, 0),
        .metallic = ng_gltf_number(pbr, "metallicFactor", 1),
        .roughness = ng_gltf_number(pbr, "roughnessFactor", 1),
        .alpha_cutoff = ng_gltf_number(v, "alphaCutoff", 0.5),
        .normal_scale = ng_gltf_number(normal, "scale", 1),
        .emissive_strength = ng_gltf_number(strength, "emissiveStrength", 1),
        .double_sided = ng_gltf_bool(v, "doubleSided", false),
        .base_color_texture = ng_gltf_texture_use(pbr, "baseColorTexture"),
        .metallic_roughness_texture = ng_gltf_texture_use(pbr, "metallicRoughnessTexture"),
        .normal_texture = ng_gltf_texture_use(v, "normalTexture"),
        .emissive_texture = ng_gltf_texture_use(v, "emissiveTexture"),
        .extension = scene_extension(v),
        .extensions = extensions_of(v),
    };
}

static void make_texture(struct maker *m, const struct gltf_value *v, void *out)
{
    NG_UNUSED(m);
    *(struct gltf_texture *)out = (struct gltf_texture){
        .image = ng_gltf_index(v, "source", -1),
        .webp = ng_gltf_index(ng_gltf_member(extensions_of(v), "EXT_texture_webp"), "source", -1),
        .sampler = ng_gltf_index(v, "sampler", -1),
        .extensions = extensions_of(v),
    };
}

static void make_sampler(struct maker *m, const struct gltf_value *v, void *out)
{
    const int repeat = 10497;
    NG_UNUSED(m);
    *(struct gltf_sampler *)out = (struct gltf_sampler){
        .wrap_s = ng_gltf_index(v, "wrapS", repeat),
        .wrap_t = ng_gltf_index(v, "wrapT", repeat),
        .mag_filter = ng_gltf_index(v, "magFilter", 0),
        .min_filter = ng_gltf_index(v, "minFilter", 0),
    };
}

static void make_image(struct maker *m, const struct gltf_value *v, void *out)
{
    NG_UNUSED(m);
    const char *uri = ng_gltf_text(v, "uri", ""), *name_end = strrchr(uri, '.');
    *(struct gltf_image *)out = (struct gltf_image){
        .name = ng_gltf_text(v, "name", ""),
        .uri = uri,
        .view = ng_gltf_index(v, "bufferView", -1),
        .webp = strcmp(ng_gltf_text(v, "mimeType", ""), "image/webp") == 0 ||
                strncmp(uri, "data:image/webp", 15) == 0 || (name_end && strcmp(name_end, ".webp") == 0),
    };
}

static void make_camera(struct maker *m, const struct gltf_value *v, void *out)
{
    const char *type = ng_gltf_text(v, "type", "");
    const struct gltf_value *perspective = ng_gltf_member(v, "perspective");
    const struct gltf_value *orthographic = ng_gltf_member(v, "orthographic");
    NG_UNUSED(m);
    *(struct gltf_camera *)out = (struct gltf_camera){
        .perspective = strcmp(type, "perspective") == 0,
        .orthographic = strcmp(type, "orthographic") == 0,
        .fov_y = ng_gltf_number(perspective, "yfov", 0),
        .near_plane = ng_gltf_number(perspective ? perspective : orthographic, "znear", 0),
        .x_mag = ng_gltf_number(orthographic, "xmag", 0),
        .y_mag = ng_gltf_number(orthographic, "ymag", 0),
    };
}

static void make_light(struct maker *m, const struct gltf_value *v, void *out)
{
    const double quarter_pi = 0.78539816339744830962;
    const struct gltf_value *spot = ng_gltf_member(v, "spot");
    *(struct gltf_light *)out = (struct gltf_light){
        .name = ng_gltf_text(v, "name", ""),
        .type = ng_gltf_text(v, "type", ""),
        .color = numbers(m, v, "color"),
        .intensity = ng_gltf_number(v, "intensity", 1),
        .inner_angle = ng_gltf_number(spot, "innerConeAngle", 0),
        .outer_angle = ng_gltf_number(spot, "outerConeAngle", quarter_pi),
    };
}

static void make_skin(struct maker *m, const struct gltf_value *v, void *out)
{
    struct gltf_skin *skin = out;
    skin->name = ng_gltf_text(v, "name", "");
    skin->inverse_bind = ng_gltf_index(v, "inverseBindMatrices", -1);
    skin->skeleton = ng_gltf_index(v, "skeleton", -1);
    skin->joints = indices(m, v, "joints", &skin->joint_count);
}

static void make_channel(struct maker *m, const struct gltf_value *v, void *out)
{
    const struct gltf_value *target = ng_gltf_member(v, "target");
    NG_UNUSED(m);
    *(struct gltf_channel *)out = (struct gltf_channel){
        .sampler = ng_gltf_index(v, "sampler", -1),
        .node = ng_gltf_index(target, "node", -1),
        .path = ng_gltf_text(target, "path", ""),
    };
}

static void make_keys(struct maker *m, const struct gltf_value *v, void *out)
{
    NG_UNUSED(m);
    *(struct gltf_keys *)out = (struct gltf_keys){
        .input = ng_gltf_index(v, "input", -1),
        .output = ng_gltf_index(v, "output", -1),
        .interpolation = ng_gltf_text(v, "interpolation", "LINEAR"),
    };
}

static void make_animation(struct maker *m, const struct gltf_value *v, void *out)
{
    struct gltf_animation *a = out;
    a->name = ng_gltf_text(v, "name", "");
    a->channels =
        make_all(m, ng_gltf_array(v, "channels"), sizeof *a->channels, make_channel, &a->channel_count);
    a->samplers =
        make_all(m, ng_gltf_array(v, "samplers"), sizeof *a->samplers, make_keys, &a->sampler_count);
    a->extension = scene_extension(v);
}

static void make_scene(struct maker *m, const struct gltf_value *v, void *out)
{
    struct gltf_scene *scene = out;
    scene->name = ng_gltf_text(v, "name", "");
    scene->nodes = indices(m, v, "nodes", &scene->node_count);
    scene->extension = scene_extension(v);
}

static ng_result make_document(struct gltf_faults *faults, struct gltf_document *d)
{
    struct maker m = {.doc = d, .faults = faults};
    const struct gltf_value *root = d->root;
    const struct gltf_value *lights = ng_gltf_member(extensions_of(root), "KHR_lights_punctual");
#define TABLE(member, make, counter, list)                                                                   \
    d->member = make_all(&m, (list), sizeof *d->member, (make), &d->counter)
    TABLE(views, make_view, view_count, ng_gltf_array(root, "bufferViews"));
    TABLE(accessors, make_accessor, accessor_count, ng_gltf_array(root, "accessors"));
    TABLE(meshes, make_mesh, mesh_count, ng_gltf_array(root, "meshes"));
    TABLE(nodes, make_node, node_count, ng_gltf_array(root, "nodes"));
    TABLE(materials, make_material, material_count, ng_gltf_array(root, "materials"));
    TABLE(textures, make_texture, texture_count, ng_gltf_array(root, "textures"));
    TABLE(samplers, make_sampler, sampler_count, ng_gltf_array(root, "samplers"));
    TABLE(images, make_image, image_count, ng_gltf_array(root, "images"));
    TABLE(cameras, make_camera, camera_count, ng_gltf_array(root, "cameras"));
    TABLE(lights, make_light, light_count, ng_gltf_array(lights, "lights"));
    TABLE(skins, make_skin, skin_count, ng_gltf_array(root, "skins"));
    TABLE(animations, make_animation, animation_count, ng_gltf_array(root, "animations"));
    TABLE(scenes, make_scene, scene_count, ng_gltf_array(root, "scenes"));
#undef TABLE
    d->scene = ng_gltf_index(root, "scene", -1);
    d->extensions = extensions_of(root);
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
    ng_result r = check_version(faults->path, doc->root);
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
    return make_document(faults, doc);
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

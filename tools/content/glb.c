// The JSON part is a cJSON tree that grows with each call; the binary part is one buffer, each accessor with
// a buffer view of its own. Source: glTF 2.0 specification (Khronos), sections 3.6 (data) and 4 (GLB).
#include "glb.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum component_type { U8 = 5121, U16 = 5123, U32 = 5125, F32 = 5126 };

// ---- JSON ----

static double six_decimals(double v)
{
    double r = round(v * 1e6) / 1e6;
    return r == 0.0 ? 0.0 : r; // no negative zero
}

static cJSON *keep(struct glb *g, cJSON *item)
{
    if (!item)
        g->failed = true;
    return item;
}

static cJSON *member(struct glb *g, cJSON *object, const char *key, cJSON *(*create)(void))
{
    cJSON *item = object ? cJSON_GetObjectItemCaseSensitive(object, key) : NULL;
    if (item || !object)
        return item;
    item = keep(g, create());
    if (item && !cJSON_AddItemToObject(object, key, item)) {
        cJSON_Delete(item);
        g->failed = true;
        return NULL;
    }
    return item;
}

// Appends an object to a top-level array; its index.
static int append(struct glb *g, const char *collection, cJSON **out)
{
    cJSON *array = member(g, g->root, collection, cJSON_CreateArray);
    *out = array ? keep(g, cJSON_CreateObject()) : NULL;
    if (*out)
        cJSON_AddItemToArray(array, *out);
    return array ? cJSON_GetArraySize(array) - 1 : 0;
}

void glb_set_text(struct glb *g, cJSON *object, const char *key, const char *value)
{
    if (object && value)
        keep(g, cJSON_AddStringToObject(object, key, value));
}

void glb_set(struct glb *g, cJSON *object, const char *key, double value)
{
    if (object)
        keep(g, cJSON_AddNumberToObject(object, key, six_decimals(value)));
}

void glb_set_bool(struct glb *g, cJSON *object, const char *key, bool value)
{
    if (object)
        keep(g, cJSON_AddBoolToObject(object, key, value));
}

void glb_set_list(struct glb *g, cJSON *object, const char *key, const double *values, int count)
{
    cJSON *list = member(g, object, key, cJSON_CreateArray);
    for (int i = 0; list && i < count; i++)
        cJSON_AddItemToArray(list, keep(g, cJSON_CreateNumber(six_decimals(values[i]))));
}

void glb_set_texture(struct glb *g, cJSON *object, const char *key, int texture)
{
    glb_set(g, member(g, object, key, cJSON_CreateObject), "texture", texture);
}

void glb_set_entity(struct glb *g, cJSON *object, const char *key, const char *kind, int index)
{
    glb_set(g, member(g, object, key, cJSON_CreateObject), kind, index);
}

void glb_set_picture(struct glb *g, cJSON *object, const char *key, const char *uri)
{
    glb_set_text(g, member(g, object, key, cJSON_CreateObject), "uri", uri);
}

static void use_extension(struct glb *g, const char *name)
{
    cJSON *used = member(g, g->root, "extensionsUsed", cJSON_CreateArray), *item;
    cJSON_ArrayForEach(item, used)
    {
        if (!strcmp(item->valuestring, name))
            return;
    }
    if (used)
        cJSON_AddItemToArray(used, keep(g, cJSON_CreateString(name)));
}

static cJSON *extension(struct glb *g, cJSON *object, const char *name)
{
    use_extension(g, name);
    return member(g, member(g, object, "extensions", cJSON_CreateObject), name, cJSON_CreateObject);
}

static cJSON *component(struct glb *g, cJSON *object, const char *name)
{
    cJSON *components = member(g, extension(g, object, "NG_scene"), "components", cJSON_CreateObject);
    return member(g, components, name, cJSON_CreateObject);
}

cJSON *glb_component(struct glb *g, const char *collection, int index, const char *name)
{
    cJSON *array = member(g, g->root, collection, cJSON_CreateArray);
    return component(g, cJSON_GetArrayItem(array, index), name);
}

// ---- the file ----

void glb_init(struct glb *g)
{
    *g = (struct glb){0};
    g->root = keep(g, cJSON_CreateObject());
    cJSON *asset = member(g, g->root, "asset", cJSON_CreateObject), *scene;
    glb_set_text(g, asset, "version", "2.0");
    glb_set_text(g, asset, "generator", "lightformer tools/content");
    glb_set_text(g, asset, "copyright", "MIT license");
    glb_set(g, g->root, "scene", 0);
    append(g, "scenes", &scene);
}

static void put32(unsigned char *p, size_t v)
{
    for (int i = 0; i < 4; i++)
        p[i] = (unsigned char)(v >> (8 * i) & 255);
}

static bool put_chunk(struct bytes *out, const char type[4], const void *data, size_t size, char pad)
{
    unsigned char head[8];
    size_t padded = (size + 3) / 4 * 4;
    put32(head, padded);
    memcpy(head + 4, type, 4);
    const char padding[3] = {pad, pad, pad};
    return bytes_append(out, head, 8) && bytes_append(out, data, size) &&
           bytes_append(out, padding, padded - size);
}

ng_result glb_finish(struct glb *g, struct bytes *out)
{
    cJSON *buffer;
    append(g, "buffers", &buffer);
    glb_set(g, buffer, "byteLength", (double)g->bin.count);
    char *json = g->failed ? NULL : cJSON_PrintUnformatted(g->root);
    unsigned char head[12] = "glTF\2\0\0";
    bool ok = json && bytes_append(out, head, sizeof head) &&
              put_chunk(out, "JSON", json, strlen(json), ' ') &&
              put_chunk(out, "BIN", g->bin.items, g->bin.count, 0);
    if (ok)
        put32(out->items + 8, out->count);
    cJSON_free(json);
    cJSON_Delete(g->root);
    bytes_finish(&g->bin);
    *g = (struct glb){0};
    return ok ? NG_OK : NG_ERROR_MEMORY;
}

// ---- data ----

static int add_view(struct glb *g, const void *data, size_t size)
{
    static const char zeros[4] = {0};
    size_t at = g->bin.count;
    g->failed |= !bytes_append(&g->bin, data, size) || !bytes_append(&g->bin, zeros, (4 - size % 4) % 4);
    cJSON *view;
    int index = append(g, "bufferViews", &view);
    glb_set(g, view, "buffer", 0);
    glb_set(g, view, "byteOffset", (double)at);
    glb_set(g, view, "byteLength", (double)size);
    return index;
}

static int add_accessor(struct glb *g, const void *data, size_t size, enum component_type type, size_t count,
                        unsigned width, cJSON **out)
{
    static const char *const shapes[17] = {
        [1] = "SCALAR", [2] = "VEC2", [3] = "VEC3", [4] = "VEC4", [16] = "MAT4"};
    int view = add_view(g, data, size);
    int index = append(g, "accessors", out);
    glb_set(g, *out, "bufferView", view);
    glb_set(g, *out, "componentType", type);
    glb_set(g, *out, "count", (double)count);
    glb_set_text(g, *out, "type", shapes[width]);
    return index;
}

static void set_bounds(struct glb *g, cJSON *accessor, const float *values, size_t count, unsigned width)
{
    double low[16], high[16];
    for (unsigned k = 0; k < width; k++) {
        low[k] = high[k] = (double)values[k];
        for (size_t i = 1; i < count; i++) {
            low[k] = fmin(low[k], (double)values[i * width + k]);
            high[k] = fmax(high[k], (double)values[i * width + k]);
        }
    }
    // Bounds are exact: values on the grid of 2^-20 print in full, unlike those of glb_set_list.
    for (int side = 0; side < 2; side++) {
        cJSON *list = member(g, accessor, side ? "max" : "min", cJSON_CreateArray);
        for (unsigned k = 0; list && k < width; k++)
            cJSON_AddItemToArray(list, keep(g, cJSON_CreateNumber((side ? high : low)[k])));
    }
}

static float on_grid(double v)
{
    double r = round(v * 0x1p20) * 0x1p-20;
    return r == 0.0 ? 0.0f : (float)r;
}

int glb_doubles(struct glb *g, const double *values, size_t count, unsigned width, bool bounds)
{
    float *data = calloc(count * width, sizeof *data);
    if (!data) {
        g->failed = true;
        return 0;
    }
    for (size_t i = 0; i < count * width; i++)
        data[i] = on_grid(values[i]);
    cJSON *accessor;
    int index = add_accessor(g, data, count * width * sizeof *data, F32, count, width, &accessor);
    if (bounds)
        set_bounds(g, accessor, data, count, width);
    free(data);
    return index;
}

// Stores integers with `bytes` little-endian bytes each.
static int add_integers(struct glb *g, const uint32_t *values, size_t count, unsigned width, unsigned bytes,
                        cJSON **accessor)
{
    unsigned char *data = malloc(count * width * bytes + 1);
    if (!data) {
        g->failed = true;
        *accessor = NULL;
        return 0;
    }
    for (size_t i = 0; i < count * width; i++)
        for (unsigned k = 0; k < bytes; k++)
            data[i * bytes + k] = (unsigned char)(values[i] >> (8 * k) & 255);
    enum component_type type = bytes == 1 ? U8 : bytes == 2 ? U16 : U32;
    int index = add_accessor(g, data, count * width * bytes, type, count, width, accessor);
    free(data);
    return index;
}

int glb_integers(struct glb *g, const uint32_t *values, size_t count, unsigned width)
{
    uint32_t most = 0;
    for (size_t i = 0; i < count * width; i++)
        most = values[i] > most ? values[i] : most;
    cJSON *accessor;
    return add_integers(g, values, count, width, most < 255 ? 1 : most < 65535 ? 2 : 4, &accessor);
}

int glb_normalized(struct glb *g, const double *values, size_t count, unsigned width, unsigned bits)
{
    uint32_t *steps = calloc(count * width, sizeof *steps);
    if (!steps) {
        g->failed = true;
        return 0;
    }
    for (size_t i = 0; i < count * width; i++)
        steps[i] = (uint32_t)lround(values[i] * ((1u << bits) - 1));
    cJSON *accessor;
    int index = add_integers(g, steps, count, width, bits / 8, &accessor);
    glb_set_bool(g, accessor, "normalized", true);
    free(steps);
    return index;
}

int glb_sparse(struct glb *g, int base, const uint32_t *at, const double *values, size_t count,
               const double bounds[6])
{
    cJSON *from = cJSON_GetArrayItem(member(g, g->root, "accessors", cJSON_CreateArray), base), *accessor;
    cJSON *copy = keep(g, cJSON_Duplicate(from, true));
    int index = append(g, "accessors", &accessor);
    if (!copy || !accessor)
        return 0;
    static const char *const kept[] = {"bufferView", "componentType", "count", "type"};
    for (size_t i = 0; i < NG_COUNT(kept); i++)
        cJSON_AddItemToObject(accessor, kept[i], cJSON_DetachItemFromObject(copy, kept[i]));
    cJSON_Delete(copy);
    glb_set_list(g, accessor, "min", bounds, 3);
    glb_set_list(g, accessor, "max", bounds + 3, 3);
    cJSON *sparse = member(g, accessor, "sparse", cJSON_CreateObject);
    glb_set(g, sparse, "count", (double)count);
    cJSON *part = member(g, sparse, "indices", cJSON_CreateObject);
    glb_set(g, part, "bufferView", add_view(g, at, count * sizeof *at));
    glb_set(g, part, "componentType", U32);
    float *data = calloc(count * 3, sizeof *data);
    if (!data) {
        g->failed = true;
        return index;
    }
    for (size_t i = 0; i < count * 3; i++)
        data[i] = on_grid(values[i]);
    glb_set(g, member(g, sparse, "values", cJSON_CreateObject), "bufferView",
            add_view(g, data, count * 3 * sizeof *data));
    free(data);
    return index;
}

// ---- materials ----

int glb_texture(struct glb *g, const char *name, ng_result (*make)(struct bytes *png), enum glb_wrap wrap)
{
    struct bytes png = {0};
    if (make(&png) != NG_OK)
        g->failed = true;
    cJSON *image, *sampler, *texture;
    int image_index = append(g, "images", &image);
    glb_set_text(g, image, "name", name);
    glb_set_text(g, image, "mimeType", "image/png");
    glb_set(g, image, "bufferView", add_view(g, png.items, png.count));
    bytes_finish(&png);
    int sampler_index = append(g, "samplers", &sampler);
    glb_set(g, sampler, "magFilter", 9729);
    glb_set(g, sampler, "minFilter", 9987);
    glb_set(g, sampler, "wrapS", wrap == GLB_REPEAT ? 10497 : 33071);
    glb_set(g, sampler, "wrapT", wrap == GLB_REPEAT ? 10497 : 33071);
    int index = append(g, "textures", &texture);
    glb_set(g, texture, "sampler", sampler_index);
    glb_set(g, texture, "source", image_index);
    return index;
}

static void set_texture(struct glb *g, cJSON *object, const char *key, int texture)
{
    if (texture)
        glb_set(g, member(g, object, key, cJSON_CreateObject), "index", texture - 1);
}

// Colour with its largest channel 1, times a strength (KHR_materials_emissive_strength) where above 1.
static void set_emission(struct glb *g, cJSON *material, const double radiance[3])
{
    double most = fmax(radiance[0], fmax(radiance[1], radiance[2]));
    if (most <= 0.0)
        return;
    double strength = fmax(most, 1.0);
    double factor[3] = {radiance[0] / strength, radiance[1] / strength, radiance[2] / strength};
    glb_set_list(g, material, "emissiveFactor", factor, 3);
    if (strength > 1.0)
        glb_set(g, extension(g, material, "KHR_materials_emissive_strength"), "emissiveStrength", strength);
}

int glb_add_material(struct glb *g, const struct glb_material *m)
{
    cJSON *material;
    int index = append(g, "materials", &material);
    glb_set_text(g, material, "name", m->name);
    cJSON *pbr = member(g, material, "pbrMetallicRoughness", cJSON_CreateObject);
    const double color[4] = {m->base_color[0], m->base_color[1], m->base_color[2], 1.0};
    glb_set_list(g, pbr, "baseColorFactor", color, 4);
    glb_set(g, pbr, "metallicFactor", m->metallic);
    glb_set(g, pbr, "roughnessFactor", m->roughness);
    set_texture(g, pbr, "baseColorTexture", m->base_color_texture);
    set_texture(g, pbr, "metallicRoughnessTexture", m->metallic_roughness_texture);
    set_texture(g, material, "normalTexture", m->normal_texture);
    set_texture(g, material, "emissiveTexture", m->emissive_texture);
    set_emission(g, material, m->emissive);
    if (m->alpha_cutoff > 0.0) {
        glb_set_text(g, material, "alphaMode", "MASK");
        glb_set(g, material, "alphaCutoff", m->alpha_cutoff);
    }
    if (m->double_sided)
        glb_set_bool(g, material, "doubleSided", true);
    return index;
}

// ---- meshes ----

static void set_accessor(struct glb *g, cJSON *object, const char *key, int accessor)
{
    if (accessor)
        glb_set(g, object, key, accessor - 1);
}

static void set_creases(struct glb *g, cJSON *cage, const struct cage *c)
{
    if (!c->creases.count)
        return;
    uint32_t *edges = calloc(c->creases.count * 2, sizeof *edges);
    double *sharpness = calloc(c->creases.count, sizeof *sharpness);
    g->failed |= !edges || !sharpness;
    for (size_t i = 0; i < c->creases.count && !g->failed; i++) {
        edges[2 * i] = c->creases.items[i].a;
        edges[2 * i + 1] = c->creases.items[i].b;
        sharpness[i] = c->creases.items[i].sharpness;
    }
    if (!g->failed) {
        glb_set(g, cage, "creaseEdges", glb_integers(g, edges, c->creases.count * 2, 1));
        glb_set(g, cage, "creaseSharpness", glb_doubles(g, sharpness, c->creases.count, 1, false));
    }
    free(edges);
    free(sharpness);
}

static void set_corners(struct glb *g, cJSON *cage, const struct cage *c)
{
    if (!c->corners.count)
        return;
    uint32_t *points = calloc(c->corners.count, sizeof *points);
    double *sharpness = calloc(c->corners.count, sizeof *sharpness);
    g->failed |= !points || !sharpness;
    for (size_t i = 0; i < c->corners.count && !g->failed; i++) {
        points[i] = c->corners.items[i].point;
        sharpness[i] = c->corners.items[i].sharpness;
    }
    if (!g->failed) {
        glb_set(g, cage, "corners", glb_integers(g, points, c->corners.count, 1));
        glb_set(g, cage, "cornerSharpness", glb_doubles(g, sharpness, c->corners.count, 1, false));
    }
    free(points);
    free(sharpness);
}

static void set_vertex_map(struct glb *g, cJSON *cage, const struct cage *c)
{
    uint32_t *map = calloc(c->points.count, sizeof *map);
    g->failed |= !map;
    for (uint32_t i = 0; i < c->points.count && !g->failed; i++)
        map[i] = i;
    if (!g->failed)
        glb_set(g, cage, "vertexMap", glb_integers(g, map, c->points.count, 1));
    free(map);
}

static void set_cage(struct glb *g, cJSON *primitive, const struct glb_mesh *m)
{
    const struct cage *c = m->cage;
    cJSON *subdivision = component(g, primitive, "subdivision");
    glb_set(g, subdivision, "level", m->level);
    glb_set_text(g, subdivision, "boundary", m->boundary);
    cJSON *cage = member(g, extension(g, primitive, "NG_scene"), "cage", cJSON_CreateObject);
    glb_set(g, cage, "positions", m->positions - 1);
    glb_set(g, cage, "faceSizes", glb_integers(g, c->sizes.items, c->sizes.count, 1));
    glb_set(g, cage, "faceIndices", glb_integers(g, c->indices.items, c->indices.count, 1));
    set_creases(g, cage, c);
    set_corners(g, cage, c);
    if (m->joints)
        set_vertex_map(g, cage, c);
}

int glb_add_mesh(struct glb *g, const struct glb_mesh *m)
{
    cJSON *mesh;
    int index = append(g, "meshes", &mesh);
    glb_set_text(g, mesh, "name", m->name);
    cJSON *primitives = member(g, mesh, "primitives", cJSON_CreateArray);
    cJSON *primitive = primitives ? keep(g, cJSON_CreateObject()) : NULL;
    if (!primitive)
        return index;
    cJSON_AddItemToArray(primitives, primitive);
    cJSON *attributes = member(g, primitive, "attributes", cJSON_CreateObject);
    set_accessor(g, attributes, "POSITION", m->positions);
    set_accessor(g, attributes, "NORMAL", m->normals);
    set_accessor(g, attributes, "TEXCOORD_0", m->uvs);
    set_accessor(g, attributes, "JOINTS_0", m->joints);
    set_accessor(g, attributes, "WEIGHTS_0", m->weights);
    set_accessor(g, primitive, "indices", m->indices);
    glb_set(g, primitive, "material", m->material);
    if (m->cage)
        set_cage(g, primitive, m);
    return index;
}

int glb_cage_mesh(struct glb *g, const char *name, const struct cage *c, int material, unsigned level)
{
    return glb_cage_mesh_bounded(g, name, c, material, level, NULL);
}

int glb_cage_mesh_bounded(struct glb *g, const char *name, const struct cage *c, int material, unsigned level,
                          const char *boundary)
{
    uint32_t count = cage_triangle_count(c) * 3;
    struct vec3 *normals = calloc(c->points.count, sizeof *normals);
    uint32_t *indices = calloc(count, sizeof *indices);
    int mesh = 0;
    g->failed |= c->failed || !normals || !indices;
    if (!g->failed) {
        cage_normals(c, normals);
        cage_triangles(c, indices);
        size_t n = c->points.count;
        mesh = glb_add_mesh(g, &(struct glb_mesh){
                                   .name = name,
                                   .positions = glb_doubles(g, &c->points.items[0].x, n, 3, true) + 1,
                                   .normals = glb_doubles(g, &normals[0].x, n, 3, false) + 1,
                                   .indices = glb_integers(g, indices, count, 1) + 1,
                                   .material = material,
                                   .cage = level ? c : NULL,
                                   .level = level,
                                   .boundary = boundary,
                               });
    }
    free(normals);
    free(indices);
    return mesh;
}

// ---- nodes ----

static void set_transform(struct glb *g, cJSON *node, const struct glb_node *n)
{
    const double *t = n->translation, *r = n->rotation, *s = n->scale;
    if (t[0] != 0.0 || t[1] != 0.0 || t[2] != 0.0)
        glb_set_list(g, node, "translation", t, 3);
    if (r[0] != 0.0 || r[1] != 0.0 || r[2] != 0.0 || r[3] != 0.0)
        glb_set_list(g, node, "rotation", r, 4);
    if (s[0] != 0.0 || s[1] != 0.0 || s[2] != 0.0)
        glb_set_list(g, node, "scale", s, 3);
}

int glb_add_node(struct glb *g, const struct glb_node *n)
{
    cJSON *node;
    int index = append(g, "nodes", &node);
    glb_set_text(g, node, "name", n->name);
    set_transform(g, node, n);
    set_accessor(g, node, "mesh", n->mesh);
    set_accessor(g, node, "camera", n->camera);
    set_accessor(g, node, "skin", n->skin);
    if (n->light)
        glb_set(g, extension(g, node, "KHR_lights_punctual"), "light", n->light - 1);
    cJSON *scene = cJSON_GetArrayItem(member(g, g->root, "scenes", cJSON_CreateArray), 0);
    cJSON *owner =
        n->parent ? cJSON_GetArrayItem(member(g, g->root, "nodes", cJSON_CreateArray), n->parent - 1) : scene;
    cJSON *list = member(g, owner, n->parent ? "children" : "nodes", cJSON_CreateArray);
    if (list)
        cJSON_AddItemToArray(list, keep(g, cJSON_CreateNumber(index)));
    return index;
}

int glb_add_camera(struct glb *g, double fov_y, double near_plane)
{
    cJSON *camera;
    int index = append(g, "cameras", &camera);
    glb_set_text(g, camera, "type", "perspective");
    cJSON *perspective = member(g, camera, "perspective", cJSON_CreateObject);
    glb_set(g, perspective, "yfov", fov_y);
    glb_set(g, perspective, "znear", near_plane);
    return index;
}

int glb_add_light(struct glb *g, const char *name, const char *type, const double color[3], double intensity,
                  double inner_angle, double outer_angle)
{
    cJSON *lights = member(g, extension(g, g->root, "KHR_lights_punctual"), "lights", cJSON_CreateArray);
    cJSON *light = lights ? keep(g, cJSON_CreateObject()) : NULL;
    if (!light)
        return 0;
    cJSON_AddItemToArray(lights, light);
    glb_set_text(g, light, "name", name);
    glb_set_text(g, light, "type", type);
    glb_set_list(g, light, "color", color, 3);
    glb_set(g, light, "intensity", intensity);
    if (outer_angle > 0.0) {
        cJSON *spot = member(g, light, "spot", cJSON_CreateObject);
        glb_set(g, spot, "innerConeAngle", inner_angle);
        glb_set(g, spot, "outerConeAngle", outer_angle);
    }
    return cJSON_GetArraySize(lights) - 1;
}

int glb_add_skin(struct glb *g, const char *name, const int *joints, int count, int inverse_bind)
{
    cJSON *skin;
    int index = append(g, "skins", &skin);
    glb_set_text(g, skin, "name", name);
    glb_set(g, skin, "inverseBindMatrices", inverse_bind);
    cJSON *list = member(g, skin, "joints", cJSON_CreateArray);
    for (int i = 0; list && i < count; i++)
        cJSON_AddItemToArray(list, keep(g, cJSON_CreateNumber(joints[i])));
    return index;
}

// ---- animations ----

int glb_add_animation(struct glb *g, const char *name)
{
    cJSON *animation;
    int index = append(g, "animations", &animation);
    glb_set_text(g, animation, "name", name);
    member(g, animation, "channels", cJSON_CreateArray);
    member(g, animation, "samplers", cJSON_CreateArray);
    return index;
}

static int add_sampler(struct glb *g, cJSON *animation, const struct glb_channel *c)
{
    unsigned width = c->width ? c->width : strcmp(c->path, "rotation") == 0 ? 4 : 3;
    size_t values = strcmp(c->interpolation, "CUBICSPLINE") == 0 ? c->keys * 3 : c->keys;
    cJSON *samplers = member(g, animation, "samplers", cJSON_CreateArray);
    cJSON *sampler = samplers ? keep(g, cJSON_CreateObject()) : NULL;
    if (!sampler)
        return 0;
    cJSON_AddItemToArray(samplers, sampler);
    glb_set(g, sampler, "input", glb_doubles(g, c->times, c->keys, 1, true));
    glb_set(g, sampler, "output", glb_doubles(g, c->values, values, width, false));
    glb_set_text(g, sampler, "interpolation", c->interpolation);
    return cJSON_GetArraySize(samplers) - 1;
}

void glb_add_channel(struct glb *g, int animation_index, const struct glb_channel *c)
{
    cJSON *animation =
        cJSON_GetArrayItem(member(g, g->root, "animations", cJSON_CreateArray), animation_index);
    cJSON *owner = c->component ? extension(g, animation, "NG_scene") : animation;
    cJSON *channels = member(g, owner, "channels", cJSON_CreateArray);
    int sampler = add_sampler(g, animation, c);
    cJSON *channel = channels ? keep(g, cJSON_CreateObject()) : NULL;
    if (!channel)
        return;
    cJSON_AddItemToArray(channels, channel);
    glb_set(g, channel, "sampler", sampler);
    cJSON *target = c->component ? channel : member(g, channel, "target", cJSON_CreateObject);
    glb_set(g, target, "node", c->node);
    glb_set_text(g, target, "component", c->component);
    glb_set_text(g, target, c->component ? "field" : "path", c->path);
}

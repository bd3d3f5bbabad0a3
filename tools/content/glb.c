// Scenes in the terms of their builders, on the engine's writer.
#include "glb.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- JSON ----

static double six_decimals(double v)
{
    double r = round(v * 1e6) / 1e6;
    return r == 0.0 ? 0.0 : r; // no negative zero
}

void glb_set_text(struct glb *g, cJSON *object, const char *key, const char *value)
{
    ng_gltf_json_text(&g->w, object, key, value);
}

void glb_set(struct glb *g, cJSON *object, const char *key, double value)
{
    ng_gltf_json_number(&g->w, object, key, six_decimals(value));
}

void glb_set_bool(struct glb *g, cJSON *object, const char *key, bool value)
{
    ng_gltf_json_bool(&g->w, object, key, value);
}

void glb_set_list(struct glb *g, cJSON *object, const char *key, const double *values, int count)
{
    double rounded[24] = {0};
    for (int i = 0; i < count; i++)
        rounded[i] = six_decimals(values[i]);
    ng_gltf_json_numbers(&g->w, object, key, rounded, (size_t)count);
}

// The members that an index stands in.
static cJSON *inner(struct glb *g, cJSON *object, const char *key)
{
    return ng_gltf_json_object(&g->w, object, key);
}

void glb_set_texture(struct glb *g, cJSON *object, const char *key, int texture)
{
    glb_set(g, inner(g, object, key), "texture", texture);
}

void glb_set_entity(struct glb *g, cJSON *object, const char *key, const char *kind, int index)
{
    glb_set(g, inner(g, object, key), kind, index);
}

void glb_set_picture(struct glb *g, cJSON *object, const char *key, const char *uri)
{
    glb_set_text(g, inner(g, object, key), "uri", uri);
}

cJSON *glb_component(struct glb *g, enum ng_gltf_list list, int index, const char *name)
{
    return ng_gltf_json_component(&g->w, ng_gltf_at(&g->w, list, index), name);
}

// ---- the file ----

void glb_init(struct glb *g)
{
    ng_gltf_writer_init(&g->w, NULL);
    cJSON *asset = inner(g, g->w.root, "asset"), *scene;
    glb_set_text(g, asset, "version", "2.0");
    glb_set_text(g, asset, "generator", "lightformer tools/content");
    glb_set_text(g, asset, "copyright", "MIT license");
    glb_set(g, g->w.root, "scene", 0);
    ng_gltf_append(&g->w, NG_GLTF_SCENES, &scene);
}

ng_result glb_finish(struct glb *g, struct bytes *out)
{
    struct ng_gltf_bytes file = {0};
    bool ok = ng_gltf_writer_glb(&g->w, &file);
    ng_gltf_writer_finish(&g->w);
    *out = (struct bytes){file.items, file.count, file.capacity};
    return ok ? NG_OK : NG_ERROR_MEMORY;
}

// ---- data ----

static float on_grid(double v)
{
    double r = round(v * 0x1p20) * 0x1p-20;
    return r == 0.0 ? 0.0f : (float)r;
}

int glb_doubles(struct glb *g, const double *values, size_t count, unsigned width, bool bounds)
{
    float *data = calloc(count * width, sizeof *data);
    if (!data) {
        g->w.failed = true;
        return 0;
    }
    for (size_t i = 0; i < count * width; i++)
        data[i] = on_grid(values[i]);
    int index = ng_gltf_add_floats(&g->w, data, count, width, NG_GLTF_NO_TARGET, bounds);
    free(data);
    return index;
}

int glb_integers(struct glb *g, const uint32_t *values, size_t count, unsigned width)
{
    return ng_gltf_add_integers(&g->w, values, count, width, 0, NG_GLTF_NO_TARGET, NULL);
}

int glb_normalized(struct glb *g, const double *values, size_t count, unsigned width, unsigned bits)
{
    uint32_t *steps = calloc(count * width, sizeof *steps);
    if (!steps) {
        g->w.failed = true;
        return 0;
    }
    for (size_t i = 0; i < count * width; i++)
        steps[i] = (uint32_t)lround(values[i] * ((1u << bits) - 1));
    cJSON *accessor;
    int index = ng_gltf_add_integers(&g->w, steps, count, width, bits / 8, NG_GLTF_NO_TARGET, &accessor);
    glb_set_bool(g, accessor, "normalized", true);
    free(steps);
    return index;
}

int glb_sparse(struct glb *g, int base, const uint32_t *at, const double *values, size_t count,
               const double bounds[6])
{
    cJSON *from = ng_gltf_at(&g->w, NG_GLTF_ACCESSORS, base), *accessor;
    cJSON *copy = cJSON_Duplicate(from, true);
    int index = ng_gltf_append(&g->w, NG_GLTF_ACCESSORS, &accessor);
    g->w.failed |= !copy;
    if (!copy || !accessor)
        return 0;
    static const char *const kept[] = {"bufferView", "componentType", "count", "type"};
    for (size_t i = 0; i < NG_COUNT(kept); i++)
        cJSON_AddItemToObject(accessor, kept[i], cJSON_DetachItemFromObject(copy, kept[i]));
    cJSON_Delete(copy);
    glb_set_list(g, accessor, "min", bounds, 3);
    glb_set_list(g, accessor, "max", bounds + 3, 3);
    cJSON *sparse = inner(g, accessor, "sparse");
    glb_set(g, sparse, "count", (double)count);
    cJSON *part = inner(g, sparse, "indices");
    glb_set(g, part, "bufferView", ng_gltf_add_view(&g->w, at, count * sizeof *at, NG_GLTF_NO_TARGET));
    glb_set(g, part, "componentType", NG_GLTF_U32);
    float *data = calloc(count * 3, sizeof *data);
    if (!data) {
        g->w.failed = true;
        return index;
    }
    for (size_t i = 0; i < count * 3; i++)
        data[i] = on_grid(values[i]);
    glb_set(g, inner(g, sparse, "values"), "bufferView",
            ng_gltf_add_view(&g->w, data, count * 3 * sizeof *data, NG_GLTF_NO_TARGET));
    free(data);
    return index;
}

// ---- materials ----

int glb_texture(struct glb *g, const char *name, ng_result (*make)(struct bytes *png), enum glb_wrap wrap)
{
    struct bytes png = {0};
    if (make(&png) != NG_OK)
        g->w.failed = true;
    cJSON *image, *sampler, *texture;
    int image_index = ng_gltf_append(&g->w, NG_GLTF_IMAGES, &image);
    glb_set_text(g, image, "name", name);
    glb_set_text(g, image, "mimeType", "image/png");
    glb_set(g, image, "bufferView", ng_gltf_add_view(&g->w, png.items, png.count, NG_GLTF_NO_TARGET));
    bytes_finish(&png);
    int sampler_index = ng_gltf_append(&g->w, NG_GLTF_SAMPLERS, &sampler);
    glb_set(g, sampler, "magFilter", 9729);
    glb_set(g, sampler, "minFilter", 9987);
    glb_set(g, sampler, "wrapS", wrap == GLB_REPEAT ? 10497 : 33071);
    glb_set(g, sampler, "wrapT", wrap == GLB_REPEAT ? 10497 : 33071);
    int index = ng_gltf_append(&g->w, NG_GLTF_TEXTURES, &texture);
    glb_set(g, texture, "sampler", sampler_index);
    glb_set(g, texture, "source", image_index);
    return index;
}

static void set_texture(struct glb *g, cJSON *object, const char *key, int texture)
{
    if (texture)
        glb_set(g, inner(g, object, key), "index", texture - 1);
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
        glb_set(g, ng_gltf_json_extension(&g->w, material, "KHR_materials_emissive_strength"),
                "emissiveStrength", strength);
}

int glb_add_material(struct glb *g, const struct glb_material *m)
{
    cJSON *material;
    int index = ng_gltf_append(&g->w, NG_GLTF_MATERIALS, &material);
    glb_set_text(g, material, "name", m->name);
    cJSON *pbr = inner(g, material, "pbrMetallicRoughness");
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
    g->w.failed |= !edges || !sharpness;
    for (size_t i = 0; i < c->creases.count && !g->w.failed; i++) {
        edges[2 * i] = c->creases.items[i].a;
        edges[2 * i + 1] = c->creases.items[i].b;
        sharpness[i] = c->creases.items[i].sharpness;
    }
    if (!g->w.failed) {
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
    g->w.failed |= !points || !sharpness;
    for (size_t i = 0; i < c->corners.count && !g->w.failed; i++) {
        points[i] = c->corners.items[i].point;
        sharpness[i] = c->corners.items[i].sharpness;
    }
    if (!g->w.failed) {
        glb_set(g, cage, "corners", glb_integers(g, points, c->corners.count, 1));
        glb_set(g, cage, "cornerSharpness", glb_doubles(g, sharpness, c->corners.count, 1, false));
    }
    free(points);
    free(sharpness);
}

static void set_vertex_map(struct glb *g, cJSON *cage, const struct cage *c)
{
    uint32_t *map = calloc(c->points.count, sizeof *map);
    g->w.failed |= !map;
    for (uint32_t i = 0; i < c->points.count && !g->w.failed; i++)
        map[i] = i;
    if (!g->w.failed)
        glb_set(g, cage, "vertexMap", glb_integers(g, map, c->points.count, 1));
    free(map);
}

static void set_cage(struct glb *g, cJSON *primitive, const struct glb_mesh *m)
{
    const struct cage *c = m->cage;
    cJSON *subdivision = ng_gltf_json_component(&g->w, primitive, "subdivision");
    glb_set(g, subdivision, "level", m->level);
    glb_set_text(g, subdivision, "boundary", m->boundary);
    cJSON *cage = inner(g, ng_gltf_json_extension(&g->w, primitive, "NG_scene"), "cage");
    glb_set(g, cage, "positions", (m->cage_positions ? m->cage_positions : m->positions) - 1);
    glb_set(g, cage, "faceSizes", glb_integers(g, c->sizes.items, c->sizes.count, 1));
    glb_set(g, cage, "faceIndices", glb_integers(g, c->indices.items, c->indices.count, 1));
    if (c->uvs.count)
        glb_set(g, cage, "faceUVs", glb_doubles(g, &c->uvs.items[0].u, c->uvs.count, 2, false));
    set_creases(g, cage, c);
    set_corners(g, cage, c);
    if (m->joints)
        set_vertex_map(g, cage, c);
}

int glb_add_mesh(struct glb *g, const struct glb_mesh *m)
{
    cJSON *mesh;
    int index = ng_gltf_append(&g->w, NG_GLTF_MESHES, &mesh);
    glb_set_text(g, mesh, "name", m->name);
    cJSON *primitives = ng_gltf_json_list(&g->w, mesh, "primitives");
    cJSON *primitive = ng_gltf_json_append(&g->w, primitives);
    if (!primitive)
        return index;
    cJSON *attributes = inner(g, primitive, "attributes");
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

// The cage's faces as triangles of vertices that are equal in point and texture coordinates.
struct fallback {
    NG_ARRAY(uint32_t) points; // of each vertex
    NG_ARRAY(struct cage_uv) uvs;
    NG_ARRAY(uint32_t) next;    // the next vertex of its point
    NG_ARRAY(uint32_t) corners; // the vertex of each of the cage's indices
    NG_ARRAY(uint32_t) triangles;
    NG_ARRAY(struct vec3) positions;
    NG_ARRAY(struct vec3) normals;
};

static uint32_t fallback_vertex(struct fallback *f, uint32_t *first, uint32_t point, struct cage_uv uv,
                                bool *ok)
{
    for (uint32_t i = *first; i != UINT32_MAX; i = f->next.items[i])
        if (f->uvs.items[i].u == uv.u && f->uvs.items[i].v == uv.v)
            return i;
    *ok = *ok && ng_array_push(&f->points, point) && ng_array_push(&f->uvs, uv) &&
          ng_array_push(&f->next, *first);
    if (*ok)
        *first = (uint32_t)f->points.count - 1;
    return *first;
}

static bool fallback_build(struct fallback *f, const struct cage *c)
{
    NG_ARRAY(uint32_t) first = {0};
    NG_ARRAY(struct vec3) normals = {0};
    bool ok = ng_array_resize(&first, c->points.count) && ng_array_resize(&normals, c->points.count);
    for (size_t i = 0; ok && i < c->points.count; i++)
        first.items[i] = UINT32_MAX;
    for (size_t i = 0; ok && i < c->indices.count; i++) {
        uint32_t point = c->indices.items[i];
        struct cage_uv uv = c->uvs.count ? c->uvs.items[i] : (struct cage_uv){0};
        uint32_t vertex = fallback_vertex(f, &first.items[point], point, uv, &ok);
        ok = ok && ng_array_push(&f->corners, vertex);
    }
    const uint32_t *face = f->corners.items;
    for (size_t k = 0; ok && k < c->sizes.count; face += c->sizes.items[k++])
        for (uint32_t i = 2; ok && i < c->sizes.items[k]; i++)
            ok = ng_array_push(&f->triangles, face[0]) && ng_array_push(&f->triangles, face[i - 1]) &&
                 ng_array_push(&f->triangles, face[i]);
    if (ok)
        cage_normals(c, normals.items);
    for (size_t i = 0; ok && i < f->points.count; i++)
        ok = ng_array_push(&f->positions, c->points.items[f->points.items[i]]) &&
             ng_array_push(&f->normals, normals.items[f->points.items[i]]);
    ng_array_finish(&first);
    ng_array_finish(&normals);
    return ok;
}

static void fallback_finish(struct fallback *f)
{
    ng_array_finish(&f->points);
    ng_array_finish(&f->uvs);
    ng_array_finish(&f->next);
    ng_array_finish(&f->corners);
    ng_array_finish(&f->triangles);
    ng_array_finish(&f->positions);
    ng_array_finish(&f->normals);
}

// With texture coordinates of its faces.
static int textured_cage_mesh(struct glb *g, const char *name, const struct cage *c, int material,
                              unsigned level, const char *boundary)
{
    struct fallback f = {0};
    int mesh = 0;
    g->w.failed |= c->failed || !fallback_build(&f, c);
    if (!g->w.failed)
        mesh = glb_add_mesh(
            g, &(struct glb_mesh){
                   .name = name,
                   .positions = glb_doubles(g, &f.positions.items[0].x, f.positions.count, 3, true) + 1,
                   .normals = glb_doubles(g, &f.normals.items[0].x, f.normals.count, 3, false) + 1,
                   .uvs = glb_doubles(g, &f.uvs.items[0].u, f.uvs.count, 2, false) + 1,
                   .indices = glb_integers(g, f.triangles.items, f.triangles.count, 1) + 1,
                   .material = material,
                   .cage = level ? c : NULL,
                   .cage_positions = glb_doubles(g, &c->points.items[0].x, c->points.count, 3, false) + 1,
                   .level = level,
                   .boundary = boundary,
               });
    fallback_finish(&f);
    return mesh;
}

int glb_cage_mesh_bounded(struct glb *g, const char *name, const struct cage *c, int material, unsigned level,
                          const char *boundary)
{
    if (c->uvs.count)
        return textured_cage_mesh(g, name, c, material, level, boundary);
    uint32_t count = cage_triangle_count(c) * 3;
    struct vec3 *normals = calloc(c->points.count, sizeof *normals);
    uint32_t *indices = calloc(count, sizeof *indices);
    int mesh = 0;
    g->w.failed |= c->failed || !normals || !indices;
    if (!g->w.failed) {
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
    int index = ng_gltf_append(&g->w, NG_GLTF_NODES, &node);
    glb_set_text(g, node, "name", n->name);
    set_transform(g, node, n);
    set_accessor(g, node, "mesh", n->mesh);
    set_accessor(g, node, "camera", n->camera);
    set_accessor(g, node, "skin", n->skin);
    if (n->light)
        glb_set(g, ng_gltf_json_extension(&g->w, node, "KHR_lights_punctual"), "light", n->light - 1);
    cJSON *scene = ng_gltf_at(&g->w, NG_GLTF_SCENES, 0);
    cJSON *owner = n->parent ? ng_gltf_at(&g->w, NG_GLTF_NODES, n->parent - 1) : scene;
    cJSON *list = ng_gltf_json_list(&g->w, owner, n->parent ? "children" : "nodes");
    if (list)
        cJSON_AddItemToArray(list, cJSON_CreateNumber(index));
    return index;
}

int glb_add_camera(struct glb *g, double fov_y, double near_plane)
{
    cJSON *camera;
    int index = ng_gltf_append(&g->w, NG_GLTF_CAMERAS, &camera);
    glb_set_text(g, camera, "type", "perspective");
    cJSON *perspective = inner(g, camera, "perspective");
    glb_set(g, perspective, "yfov", fov_y);
    glb_set(g, perspective, "znear", near_plane);
    return index;
}

int glb_add_light(struct glb *g, const char *name, const char *type, const double color[3], double intensity,
                  double inner_angle, double outer_angle)
{
    cJSON *light;
    int index = ng_gltf_append(&g->w, NG_GLTF_LIGHTS, &light);
    glb_set_text(g, light, "name", name);
    glb_set_text(g, light, "type", type);
    glb_set_list(g, light, "color", color, 3);
    glb_set(g, light, "intensity", intensity);
    if (outer_angle > 0.0) {
        cJSON *spot = inner(g, light, "spot");
        glb_set(g, spot, "innerConeAngle", inner_angle);
        glb_set(g, spot, "outerConeAngle", outer_angle);
    }
    return index;
}

int glb_add_skin(struct glb *g, const char *name, const int *joints, int count, int inverse_bind)
{
    cJSON *skin;
    int index = ng_gltf_append(&g->w, NG_GLTF_SKINS, &skin);
    glb_set_text(g, skin, "name", name);
    glb_set(g, skin, "inverseBindMatrices", inverse_bind);
    cJSON *list = ng_gltf_json_list(&g->w, skin, "joints");
    for (int i = 0; list && i < count; i++)
        cJSON_AddItemToArray(list, cJSON_CreateNumber(joints[i]));
    return index;
}

// ---- animations ----

int glb_add_animation(struct glb *g, const char *name)
{
    cJSON *animation;
    int index = ng_gltf_append(&g->w, NG_GLTF_ANIMATIONS, &animation);
    glb_set_text(g, animation, "name", name);
    ng_gltf_json_list(&g->w, animation, "channels");
    ng_gltf_json_list(&g->w, animation, "samplers");
    return index;
}

static int add_sampler(struct glb *g, cJSON *animation, const struct glb_channel *c)
{
    unsigned width = c->width ? c->width : strcmp(c->path, "rotation") == 0 ? 4 : 3;
    size_t values = strcmp(c->interpolation, "CUBICSPLINE") == 0 ? c->keys * 3 : c->keys;
    cJSON *samplers = ng_gltf_json_list(&g->w, animation, "samplers");
    cJSON *sampler = ng_gltf_json_append(&g->w, samplers);
    if (!sampler)
        return 0;
    glb_set(g, sampler, "input", glb_doubles(g, c->times, c->keys, 1, true));
    glb_set(g, sampler, "output", glb_doubles(g, c->values, values, width, false));
    glb_set_text(g, sampler, "interpolation", c->interpolation);
    return cJSON_GetArraySize(samplers) - 1;
}

void glb_add_channel(struct glb *g, int animation_index, const struct glb_channel *c)
{
    cJSON *animation = ng_gltf_at(&g->w, NG_GLTF_ANIMATIONS, animation_index);
    cJSON *owner = c->component ? ng_gltf_json_extension(&g->w, animation, "NG_scene") : animation;
    cJSON *channels = ng_gltf_json_list(&g->w, owner, "channels");
    int sampler = add_sampler(g, animation, c);
    cJSON *channel = ng_gltf_json_append(&g->w, channels);
    if (!channel)
        return;
    glb_set(g, channel, "sampler", sampler);
    cJSON *target = c->component ? channel : inner(g, channel, "target");
    glb_set(g, target, "node", c->node);
    glb_set_text(g, target, "component", c->component);
    glb_set_text(g, target, c->component ? "field" : "path", c->path);
}

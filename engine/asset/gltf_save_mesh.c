// Geometries and cages into primitives, and the mesh that a node has.
#include "asset/geometry.h"
#include "asset/gltf_save_internal.h"
#include "asset/gltf_unit.h"
#include "components/components.h"
#include "components/mesh.h"
#include "components/skin.h"
#include "components/subdivision.h"

#include <cjson/cJSON.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---- arrays ----------------------------------------------------------------------------------------------

static void normalize3(float *v)
{
    float length = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int i = 0; i < 3; i++)
        v[i] /= length;
}

static void normalize_sum(float *w)
{
    float sum = 0;
    for (int i = 0; i < 4; i++)
        sum += w[i];
    for (int i = 0; i < 4 && !ng_gltf_is_sum_one(sum); i++)
        w[i] /= sum;
}

// Directions or weights, in a form from which loading makes these very ones. False if there is none for some:
// those stand as they are.
static bool normalizable(const float *values, uint32_t count, unsigned width, unsigned normalized,
                         void (*normalize)(float *), float *stored)
{
    bool all = true;
    memcpy(stored, values, (size_t)count * width * sizeof *stored);
    for (size_t i = 0; i < count; i++)
        all &= ng_gltf_before_normalizing(normalize, normalized, values + i * width, stored + i * width);
    return all;
}

static void put_vertices(struct gltf_saver *s, cJSON *attributes, const char *key, const float *values,
                         uint32_t count, unsigned width)
{
    ng_gltf_json_number(&s->w, attributes, key,
                        ng_gltf_add_floats(&s->w, values, count, width, NG_GLTF_VERTICES, false));
}

// Four whole numbers a vertex, of 8 bits if that is enough and `may_shrink`.
static cJSON *put_words(struct gltf_saver *s, cJSON *attributes, const char *key, const uint16_t *values,
                        uint32_t count, bool may_shrink)
{
    uint32_t *words = malloc((size_t)count * 16 + 1), most = may_shrink ? 0 : UINT16_MAX;
    cJSON *accessor = NULL;
    if (!words) {
        s->w.failed = true;
        return NULL;
    }
    for (size_t i = 0; i < (size_t)count * 4; i++) {
        words[i] = values[i];
        most = words[i] > most ? words[i] : most;
    }
    ng_gltf_json_number(
        &s->w, attributes, key,
        ng_gltf_add_integers(&s->w, words, count, 4, most <= UINT8_MAX ? 1 : 2, NG_GLTF_VERTICES, &accessor));
    free(words);
    return accessor;
}

static bool all_zero(const float *values, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (values[i] != 0 || signbit(values[i]))
            return false;
    return true;
}

static int count_of(const struct gltf_saver *s, int accessor)
{
    return ng_gltf_json_index(ng_gltf_at(&s->w, NG_GLTF_ACCESSORS, accessor), "count");
}

// Attributes of vertices that are as many as before are still theirs.
static void drop_others(const struct gltf_saver *s, cJSON *attributes, uint32_t vertex_count)
{
    static const char *const ours[] = {"POSITION", "NORMAL",   "TANGENT",  "TEXCOORD_0", "TEXCOORD_1",
                                       "COLOR_0",  "JOINTS_0", "JOINTS_1", "WEIGHTS_0",  "WEIGHTS_1"};
    for (size_t i = 0; i < NG_COUNT(ours); i++)
        ng_gltf_json_remove(attributes, ours[i]);
    cJSON *item = attributes ? attributes->child : NULL, *after;
    for (; item; item = after) {
        after = item->next;
        if (!cJSON_IsNumber(item) || count_of(s, item->valueint) != (int)vertex_count)
            cJSON_Delete(cJSON_DetachItemViaPointer(attributes, item));
    }
}

// Whether loading would find these tangents itself.
static bool tangents_follow(struct gltf_saver *s, const struct ng_geometry *g)
{
    struct ng_geometry found = *g; // borrows all else
    found.tangents = NULL;
    s->w.failed |= ng_geometry_complete(&found) != NG_OK;
    bool same = found.tangents && memcmp(found.tangents, g->tangents, (size_t)g->vertex_count * 16) == 0;
    free(found.tangents);
    return same;
}

// Normals and tangents; "exact" says that they are to be taken as they are.
static void put_directions(struct gltf_saver *s, cJSON *primitive, cJSON *attributes,
                           const struct ng_geometry *g)
{
    uint32_t n = g->vertex_count;
    bool tangents = !tangents_follow(s, g);
    float *normals = malloc((size_t)n * 12 + 1), *turned = malloc((size_t)n * 16 + 1);
    s->w.failed |= !normals || !turned;
    if (!s->w.failed) {
        bool plain = normalizable(g->normals, n, 3, 3, normalize3, normals);
        if (tangents)
            plain &= normalizable(g->tangents, n, 4, 3, normalize3, turned);
        put_vertices(s, attributes, "NORMAL", plain ? normals : g->normals, n, 3);
        if (tangents)
            put_vertices(s, attributes, "TANGENT", plain ? turned : g->tangents, n, 4);
        if (!plain)
            ng_gltf_json_bool(&s->w, ng_gltf_json_extension(&s->w, primitive, "NG_scene"), "exact", true);
    }
    free(normals);
    free(turned);
}

static void put_influences(struct gltf_saver *s, cJSON *attributes, const struct ng_geometry *g)
{
    float *weights = malloc((size_t)g->vertex_count * 16 + 1);
    s->w.failed |= !weights;
    put_words(s, attributes, "JOINTS_0", g->joints, g->vertex_count, true);
    if (weights) {
        normalizable(g->weights, g->vertex_count, 4, 4, normalize_sum, weights);
        put_vertices(s, attributes, "WEIGHTS_0", weights, g->vertex_count, 4);
    }
    free(weights);
}

static void normalize_eight(float *w)
{
    float sum = 0;
    for (int i = 0; i < 8; i++)
        sum += w[i];
    for (int i = 0; i < 8 && !ng_gltf_is_sum_one(sum); i++)
        w[i] /= sum;
}

// The weights of both sets, side by side, are made of sum 1 together.
static void put_eight_influences(struct gltf_saver *s, cJSON *attributes, const struct ng_geometry *g)
{
    size_t n = g->vertex_count;
    float *is = malloc(n * 32 + 1), *before = malloc(n * 32 + 1), *set = malloc(n * 16 + 1);
    bool room = is && before && set;
    s->w.failed |= !room;
    put_words(s, attributes, "JOINTS_0", g->joints, g->vertex_count, true);
    put_words(s, attributes, "JOINTS_1", g->joints1, g->vertex_count, true);
    for (size_t i = 0; room && i < n; i++) {
        memcpy(is + i * 8, g->weights + i * 4, 16);
        memcpy(is + i * 8 + 4, g->weights1 + i * 4, 16);
    }
    if (room)
        normalizable(is, g->vertex_count, 8, 8, normalize_eight, before);
    for (int k = 0; room && k < 2; k++) {
        for (size_t i = 0; i < n; i++)
            memcpy(set + i * 4, before + i * 8 + k * 4, 16);
        put_vertices(s, attributes, k ? "WEIGHTS_1" : "WEIGHTS_0", set, g->vertex_count, 4);
    }
    free(is);
    free(before);
    free(set);
}

// What a target adds, [vertex_count][3], from the vertices that it moves.
static void put_deltas(struct gltf_saver *s, cJSON *target, const char *key, const struct ng_geometry *g,
                       uint32_t t, const float *deltas)
{
    float *dense = deltas ? calloc(g->vertex_count, 12) : NULL;
    s->w.failed |= deltas && !dense;
    if (!dense)
        return;
    for (uint32_t i = t ? g->target_ends[t - 1] : 0; i < g->target_ends[t]; i++)
        memcpy(dense + (size_t)g->delta_vertices[i] * 3, deltas + (size_t)i * 3, 12);
    ng_gltf_json_number(
        &s->w, target, key,
        ng_gltf_add_floats(&s->w, dense, g->vertex_count, 3, NG_GLTF_VERTICES, strcmp(key, "POSITION") == 0));
    free(dense);
}

static void put_targets(struct gltf_saver *s, cJSON *primitive, const struct ng_geometry *g)
{
    ng_gltf_json_remove(primitive, "targets");
    cJSON *targets = g->target_count ? ng_gltf_json_list(&s->w, primitive, "targets") : NULL;
    for (uint32_t t = 0; targets && t < g->target_count; t++) {
        cJSON *target = ng_gltf_json_append(&s->w, targets);
        put_deltas(s, target, "POSITION", g, t, g->delta_positions);
        put_deltas(s, target, "NORMAL", g, t, g->delta_normals);
        put_deltas(s, target, "TANGENT", g, t, g->delta_tangents);
    }
}

static void put_geometry(struct gltf_saver *s, cJSON *primitive, const struct ng_geometry *g)
{
    struct ng_gltf_writer *w = &s->w;
    cJSON *attributes = ng_gltf_json_object(w, primitive, "attributes");
    uint32_t n = g->vertex_count;
    cJSON *extensions = cJSON_GetObjectItemCaseSensitive(primitive, "extensions");
    ng_gltf_json_remove(cJSON_GetObjectItemCaseSensitive(extensions, "NG_scene"), "exact");
    drop_others(s, attributes, n);
    ng_gltf_json_number(w, attributes, "POSITION",
                        ng_gltf_add_floats(w, g->positions, n, 3, NG_GLTF_VERTICES, true));
    put_directions(s, primitive, attributes, g);
    bool textured = ng_assets_next(s->assets, NG_ASSET_IMAGE, (ng_asset){0}).id;
    if (textured || !all_zero(g->uvs, (size_t)n * 2)) // a texture needs coordinates
        put_vertices(s, attributes, "TEXCOORD_0", g->uvs, n, 2);
    if (g->uvs1)
        put_vertices(s, attributes, "TEXCOORD_1", g->uvs1, n, 2);
    if (g->colors)
        ng_gltf_json_bool(w, put_words(s, attributes, "COLOR_0", g->colors, n, false), "normalized", true);
    if (g->joints1)
        put_eight_influences(s, attributes, g);
    else if (g->joints)
        put_influences(s, attributes, g);
    put_targets(s, primitive, g);
    ng_gltf_json_number(w, primitive, "indices",
                        ng_gltf_add_integers(w, g->indices, g->index_count, 1, n <= UINT16_MAX ? 2 : 4,
                                             NG_GLTF_INDICES, NULL));
    ng_gltf_json_remove(primitive, "mode");
    ng_gltf_json_remove_extension(primitive, "KHR_draco_mesh_compression");
}

static void put_integers(struct gltf_saver *s, cJSON *object, const char *key, const uint32_t *values,
                         size_t count)
{
    if (values && count)
        ng_gltf_json_number(&s->w, object, key,
                            ng_gltf_add_integers(&s->w, values, count, 1, 0, NG_GLTF_NO_TARGET, NULL));
}

static void put_floats(struct gltf_saver *s, cJSON *object, const char *key, const float *values,
                       size_t count, unsigned width)
{
    if (values && count)
        ng_gltf_json_number(&s->w, object, key,
                            ng_gltf_add_floats(&s->w, values, count, width, NG_GLTF_NO_TARGET, false));
}

static void put_cage(struct gltf_saver *s, cJSON *primitive, const struct ng_cage *c)
{
    cJSON *scene = ng_gltf_json_extension(&s->w, primitive, "NG_scene");
    ng_gltf_json_remove(scene, "cage");
    cJSON *cage = ng_gltf_json_object(&s->w, scene, "cage");
    put_floats(s, cage, "positions", c->positions, c->vertex_count, 3);
    put_integers(s, cage, "faceSizes", c->face_sizes, c->face_count);
    put_integers(s, cage, "faceIndices", c->face_indices, c->index_count);
    put_floats(s, cage, "faceUVs", c->face_uvs, c->index_count, 2);
    put_integers(s, cage, "creaseEdges", c->crease_edges, (size_t)c->crease_count * 2);
    put_floats(s, cage, "creaseSharpness", c->crease_sharpness, c->crease_count, 1);
    put_integers(s, cage, "corners", c->corners, c->corner_count);
    put_floats(s, cage, "cornerSharpness", c->corner_sharpness, c->corner_count, 1);
    put_integers(s, cage, "vertexMap", c->vertex_map, c->vertex_count);
}

// ---- primitives ------------------------------------------------------------------------------------------

// The primitive of the origin that has a shape as it still is; null if none has.
static const cJSON *find_kept(const struct gltf_saver *s, ng_asset geometry, ng_asset cage)
{
    const struct ng_gltf_origin *o = s->origin;
    if (!ng_gltf_kept_asset(o, s->assets, geometry) || (cage.id && !ng_gltf_kept_asset(o, s->assets, cage)))
        return NULL;
    const cJSON *mesh = ng_gltf_json_get(o->json, "meshes")->child;
    for (uint32_t m = 0; mesh && m < o->doc->mesh_count; m++, mesh = mesh->next)
        for (uint32_t i = 0; i < o->doc->meshes[m].primitive_count; i++) {
            const struct gltf_shape *shape = &o->shapes[o->first_primitive[m] + i];
            if (shape->geometry.id == geometry.id && shape->cage.id == cage.id)
                return cJSON_GetArrayItem(ng_gltf_json_get(mesh, "primitives"), (int)i);
        }
    return NULL;
}

static void copy_member(struct gltf_saver *s, const cJSON *from, cJSON *to, const char *key)
{
    const cJSON *item = ng_gltf_json_get(from, key);
    ng_gltf_json_remove(to, key);
    cJSON *copy = item ? cJSON_Duplicate(item, true) : NULL;
    s->w.failed |= item && (!copy || !cJSON_AddItemToObject(to, key, copy));
}

// What a primitive says of its shape.
static void copy_shape(struct gltf_saver *s, const cJSON *from, cJSON *to)
{
    static const char *const keys[] = {"attributes", "indices", "mode", "targets"};
    for (size_t i = 0; i < NG_COUNT(keys); i++)
        copy_member(s, from, to, keys[i]);
    const cJSON *extensions = ng_gltf_json_get(from, "extensions");
    const cJSON *ours = ng_gltf_json_get(extensions, "NG_scene");
    static const char *const own[] = {"cage", "exact"};
    for (size_t i = 0; i < NG_COUNT(own); i++)
        if (ng_gltf_json_get(ours, own[i]))
            copy_member(s, ours, ng_gltf_json_extension(&s->w, to, "NG_scene"), own[i]);
    const cJSON *packed = ng_gltf_json_get(extensions, "KHR_draco_mesh_compression");
    ng_gltf_json_remove_extension(to, "KHR_draco_mesh_compression");
    if (packed)
        copy_member(s, extensions, ng_gltf_json_object(&s->w, to, "extensions"),
                    "KHR_draco_mesh_compression");
}

static void put_shape(struct gltf_saver *s, cJSON *primitive, ng_asset geometry, ng_asset cage)
{
    const struct ng_geometry *g = ng_assets_geometry(s->assets, geometry);
    const struct ng_cage *c = ng_assets_cage(s->assets, cage);
    for (size_t i = 0; i < s->written.count; i++) {
        const struct gltf_written *written = &s->written.items[i];
        if (written->geometry.id == geometry.id && written->cage.id == cage.id) {
            copy_shape(s, written->primitive, primitive);
            return;
        }
    }
    const cJSON *kept = find_kept(s, geometry, cage);
    if (kept)
        copy_shape(s, kept, primitive);
    else if (g)
        put_geometry(s, primitive, g);
    if (!kept && c)
        put_cage(s, primitive, c);
    struct gltf_written written = {geometry, cage, cJSON_Duplicate(primitive, true)};
    if (!written.primitive || !ng_array_push(&s->written, written)) {
        cJSON_Delete(written.primitive);
        s->w.failed = true;
    }
}

static bool is_edited(const struct gltf_saver *s, const struct gltf_shape *shape)
{
    const struct ng_gltf_origin *o = s->origin;
    return ng_assets_geometry(s->assets, shape->geometry) &&
           (!ng_gltf_kept_asset(o, s->assets, shape->geometry) ||
            (ng_assets_cage(s->assets, shape->cage) && !ng_gltf_kept_asset(o, s->assets, shape->cage)));
}

static void put_edited(struct gltf_saver *s, cJSON *primitive, const struct gltf_shape *shape)
{
    put_shape(s, primitive, shape->geometry, shape->cage);
}

static void release(struct gltf_saver *s, cJSON *primitive, const struct gltf_shape *shape)
{
    NG_UNUSED(shape);
    ng_gltf_release_primitive(s, primitive);
}

static void each_edited(struct gltf_saver *s,
                        void (*fn)(struct gltf_saver *s, cJSON *primitive, const struct gltf_shape *shape))
{
    const struct ng_gltf_origin *o = s->origin;
    for (uint32_t m = 0; m < o->doc->mesh_count; m++)
        for (uint32_t i = 0; i < o->doc->meshes[m].primitive_count; i++) {
            const struct gltf_shape *shape = &o->shapes[o->first_primitive[m] + i];
            cJSON *primitive = is_edited(s, shape)
                                   ? ng_gltf_primitive_at(s, ng_gltf_at(&s->w, NG_GLTF_MESHES, (int)m), i)
                                   : NULL;
            if (primitive)
                fn(s, primitive, shape);
        }
}

void ng_gltf_save_edited_shapes(struct gltf_saver *s)
{
    if (!s->origin)
        return;
    each_edited(s, release);
    each_edited(s, put_edited);
}

// ---- meshes of nodes -------------------------------------------------------------------------------------

static int material_index(const struct gltf_saver *s, const struct ng_mesh *mesh)
{
    const struct gltf_saved *p = ng_gltf_saved(s, mesh->material);
    return p && p->role == GLTF_MATERIAL ? p->index : -1;
}

static void set_material(struct gltf_saver *s, cJSON *primitive, int material)
{
    if (material < 0)
        ng_gltf_json_remove(primitive, "material");
    else
        ng_gltf_json_number(&s->w, primitive, "material", material);
}

static ng_asset cage_of(const struct gltf_saver *s, ng_entity e)
{
    const struct ng_subdivision *subdivision = ng_world_get(s->world, e, NG_SUBDIVISION);
    return subdivision ? subdivision->cage : (ng_asset){0};
}

static ng_asset kept_cage(const struct gltf_saver *s, const struct gltf_saved *p)
{
    const struct ng_subdivision *was = ng_gltf_kept_value(s->origin, s->world, p->kept, NG_SUBDIVISION);
    return was ? was->cage : (ng_asset){0};
}

// A mesh of one primitive, for nodes that had none; those that look the same share it.
static int new_mesh(struct gltf_saver *s, ng_entity e, const struct ng_mesh *mesh)
{
    struct gltf_made_mesh made = {mesh->geometry, cage_of(s, e), material_index(s, mesh), 0};
    for (size_t i = 0; i < s->meshes.count; i++) {
        const struct gltf_made_mesh *m = &s->meshes.items[i];
        if (m->geometry.id == made.geometry.id && m->cage.id == made.cage.id && m->material == made.material)
            return m->mesh;
    }
    cJSON *json;
    made.mesh = ng_gltf_append(&s->w, NG_GLTF_MESHES, &json);
    const char *name = ng_assets_name(s->assets, mesh->geometry);
    if (name && name[0])
        ng_gltf_json_text(&s->w, json, "name", name);
    cJSON *primitive = ng_gltf_json_append(&s->w, ng_gltf_json_list(&s->w, json, "primitives"));
    if (primitive) {
        put_shape(s, primitive, made.geometry, made.cage);
        set_material(s, primitive, made.material);
    }
    s->w.failed |= !ng_array_push(&s->meshes, made);
    return made.mesh;
}

static bool count_users(struct gltf_saver *s)
{
    size_t meshes = s->w.lists[NG_GLTF_MESHES].count, known = s->mesh_users.count;
    if (known < meshes && !ng_array_resize(&s->mesh_users, meshes))
        return false;
    if (known)
        return true;
    for (size_t i = 0; i < s->w.lists[NG_GLTF_NODES].count; i++) {
        int mesh = ng_gltf_json_index(s->w.lists[NG_GLTF_NODES].items[i], "mesh");
        if (mesh >= 0 && (size_t)mesh < meshes)
            s->mesh_users.items[mesh]++;
    }
    return true;
}

// A node's mesh, as a copy if others have it too.
static cJSON *own_mesh(struct gltf_saver *s, cJSON *node)
{
    int index = ng_gltf_json_index(node, "mesh");
    cJSON *mesh = ng_gltf_at(&s->w, NG_GLTF_MESHES, index), *copy;
    if (!mesh || !count_users(s) || s->mesh_users.items[index] < 2)
        return mesh;
    s->mesh_users.items[index]--;
    ng_gltf_json_number(&s->w, node, "mesh", ng_gltf_append(&s->w, NG_GLTF_MESHES, &copy));
    for (const cJSON *item = mesh->child; item && copy; item = item->next)
        copy_member(s, mesh, copy, item->string);
    s->w.failed |= !ng_array_push(&s->mesh_users, 1);
    return copy;
}

// One primitive of a node that has a mesh already; `p` is of the entity that it became.
static void save_primitive(struct gltf_saver *s, const struct gltf_saved *p, cJSON *node)
{
    const struct ng_mesh *now = ng_world_get(s->world, p->entity, NG_MESH);
    const struct ng_mesh *was = ng_gltf_kept_value(s->origin, s->world, p->kept, NG_MESH);
    ng_asset cage = cage_of(s, p->entity);
    bool shape = now->geometry.id != was->geometry.id || (cage.id != kept_cage(s, p).id && cage.id);
    bool material = !ng_entity_same(now->material, was->material);
    if (!shape && !material)
        return;
    cJSON *primitive = ng_gltf_primitive_at(s, own_mesh(s, node), p->primitive);
    if (primitive && shape)
        put_shape(s, primitive, now->geometry, cage);
    if (primitive && material)
        set_material(s, primitive, material_index(s, now));
}

static bool changed(struct gltf_saver *s, const struct gltf_saved *p, ng_component component)
{
    const struct ng_component_desc *desc = ng_world_component(s->world, component);
    if (ng_world_has(s->world, p->entity, component) != (p->kept->components >> component & 1))
        return true;
    for (uint32_t i = 0; i < desc->field_count; i++)
        if (desc->fields[i].type != NG_FIELD_ASSET &&
            ng_gltf_field_changed(s, p, component, &desc->fields[i]))
            return true;
    return false;
}

// What NG_scene says of a primitive among several.
static void save_primitive_components(struct gltf_saver *s, const struct gltf_saved *p, cJSON *node)
{
    for (ng_component c = 0; c < ng_world_component_count(s->world); c++) {
        bool elsewhere = c == NG_NAME || c == NG_TRANSFORM || c == NG_SKIN;
        if (elsewhere || ng_world_component(s->world, c)->flags & NG_COMPONENT_DERIVED ||
            !(changed(s, p, c) || (s->explicit && c != NG_MESH && ng_world_has(s->world, p->entity, c))))
            continue;
        cJSON *primitive = ng_gltf_primitive_at(s, own_mesh(s, node), p->primitive);
        uint64_t standard = c == NG_MESH ? ng_gltf_field_bit(s, NG_MESH, "material") : 0;
        if (primitive)
            ng_gltf_save_component(s, p, primitive, c, standard);
    }
}

static void save_skin(struct gltf_saver *s, const struct gltf_saved *p, cJSON *node)
{
    const struct ng_skin *now = ng_world_get(s->world, p->entity, NG_SKIN);
    const struct ng_skin *was = ng_gltf_kept_value(s->origin, s->world, p->kept, NG_SKIN);
    if (now && (!was || was->skin.id != now->skin.id))
        ng_gltf_json_number(&s->w, node, "skin", ng_gltf_save_skin(s, now->skin));
    else if (!now && was)
        ng_gltf_json_remove(node, "skin");
}

// The entities of a node's primitives, if it had several and they still stand in its mesh.
static bool save_primitives(struct gltf_saver *s, const struct gltf_saved *p, cJSON *node)
{
    bool any = false, lost = false;
    ng_entity e = p->kept ? p->kept->first_child : (ng_entity){0};
    while (!ng_entity_is_null(e)) {
        const struct gltf_kept *kept = ng_gltf_kept(s->origin, e);
        const struct gltf_saved *part = ng_gltf_saved(s, e);
        bool there = part && part->role == GLTF_PRIMITIVE;
        if (kept->role == GLTF_PRIMITIVE && there) {
            if (!any)
                save_skin(s, part, node);
            save_primitive(s, part, node);
            save_primitive_components(s, part, node);
        }
        any |= there;
        lost |= kept->role == GLTF_PRIMITIVE && !there;
        bool stays = !part && ng_entity_same(ng_world_parent(s->world, e), p->entity);
        lost |= kept->role == GLTF_COPY && !stays;
        any |= kept->role == GLTF_COPY && stays;
        e = kept->next_sibling;
    }
    if (lost && !any) {
        ng_gltf_json_remove(node, "mesh");
        ng_gltf_json_remove(node, "skin");
        ng_gltf_json_remove_extension(node, "EXT_mesh_gpu_instancing");
    }
    return any;
}

void ng_gltf_save_mesh(struct gltf_saver *s, const struct gltf_saved *p)
{
    cJSON *node = ng_gltf_saved_json(s, p);
    const struct ng_mesh *now = ng_world_get(s->world, p->entity, NG_MESH);
    const struct ng_mesh *was = ng_gltf_kept_value(s->origin, s->world, p->kept, NG_MESH);
    if (save_primitives(s, p, node))
        return;
    if (now && was)
        save_primitive(s, p, node);
    else if (now)
        ng_gltf_json_number(&s->w, node, "mesh", new_mesh(s, p->entity, now));
    else if (was)
        ng_gltf_json_remove(node, "mesh");
    save_skin(s, p, node);
}

#include "asset/gltf_save_internal.h"

#include "base/file.h"
#include "base/log.h"
#include "components/animation.h"
#include "components/components.h"
#include "components/name.h"

#include <cjson/cJSON.h>

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

static bool ends_in(const char *path, const char *extension)
{
    const char *end = ng_path_extension(path);
    for (; *end && tolower((unsigned char)*end) == *extension; end++)
        extension++;
    return *end == *extension;
}

bool ng_gltf_save_knows(const char *path)
{
    return ends_in(path, "glb") || ends_in(path, "gltf");
}

// ---- places ----------------------------------------------------------------------------------------------

const struct gltf_saved *ng_gltf_saved(const struct gltf_saver *s, ng_entity e)
{
    uint32_t i = ng_entity_index(e);
    bool known = i < s->places.count && ng_entity_same(s->places.items[i].entity, e) &&
                 s->places.items[i].role != GLTF_MADE;
    return known ? &s->places.items[i] : NULL;
}

// The scene that is loaded.
static cJSON *scene_json(struct gltf_saver *s)
{
    int index = ng_gltf_json_index(s->w.root, "scene");
    return ng_gltf_at(&s->w, NG_GLTF_SCENES, index < 0 ? 0 : index);
}

// Lists of cJSON are walked: asked for in order, each is one step.
cJSON *ng_gltf_primitive_at(struct gltf_saver *s, const cJSON *mesh, uint32_t index)
{
    const cJSON *list = ng_gltf_json_get(mesh, "primitives");
    if (!list || list != s->primitives || index < s->primitive_index || !s->primitive) {
        s->primitives = list;
        s->primitive_index = 0;
        s->primitive = list ? list->child : NULL;
    }
    for (; s->primitive && s->primitive_index < index; s->primitive_index++)
        s->primitive = s->primitive->next;
    return s->primitive;
}

cJSON *ng_gltf_saved_json(struct gltf_saver *s, const struct gltf_saved *p)
{
    static const enum ng_gltf_list lists[] = {[GLTF_NODE] = NG_GLTF_NODES,
                                              [GLTF_MATERIAL] = NG_GLTF_MATERIALS,
                                              [GLTF_ANIMATION] = NG_GLTF_ANIMATIONS};
    if (p->role == GLTF_ROOT)
        return scene_json(s);
    if (p->role != GLTF_PRIMITIVE)
        return p->role == GLTF_MADE ? NULL : ng_gltf_at(&s->w, lists[p->role], p->index);
    const cJSON *node = ng_gltf_at(&s->w, NG_GLTF_NODES, p->index);
    const cJSON *mesh = ng_gltf_at(&s->w, NG_GLTF_MESHES, ng_gltf_json_index(node, "mesh"));
    return ng_gltf_primitive_at(s, mesh, p->primitive);
}

// Whether all that is known of an entity is as it was loaded.
static bool is_untouched(struct gltf_saver *s, const struct gltf_kept *kept)
{
    const struct gltf_saved p = {.entity = kept->entity, .kept = kept};
    for (ng_component c = 0; c < ng_world_component_count(s->world); c++) {
        const struct ng_component_desc *desc = ng_world_component(s->world, c);
        if (desc->flags & NG_COMPONENT_DERIVED)
            continue;
        if (ng_world_has(s->world, kept->entity, c) != (kept->components >> c & 1))
            return false;
        for (uint32_t i = 0; i < desc->field_count; i++)
            if (ng_gltf_field_changed(s, &p, c, &desc->fields[i]))
                return false;
    }
    return true;
}

static bool has(const struct gltf_saver *s, ng_entity e, ng_component component)
{
    return ng_world_has(s->world, e, component);
}

// Loading puts materials and clips below an entity of their own.
static bool is_group(const struct gltf_saver *s, ng_entity e)
{
    ng_entity child = ng_world_first_child(s->world, e);
    bool group = !ng_entity_is_null(child) && !has(s, e, NG_TRANSFORM);
    for (; group && !ng_entity_is_null(child); child = ng_world_next_sibling(s->world, child))
        group = has(s, child, NG_MATERIAL) || has(s, child, NG_ANIMATION);
    return group;
}

// Whether a primitive has nothing that a primitive has no place for.
static bool is_plain(struct gltf_saver *s, const struct gltf_kept *kept)
{
    static const ng_component fixed[] = {NG_NAME, NG_TRANSFORM};
    const struct gltf_saved p = {.entity = kept->entity, .kept = kept};
    if (!has(s, kept->entity, NG_MESH) ||
        !ng_entity_same(ng_world_parent(s->world, kept->entity), kept->parent) ||
        !ng_entity_is_null(ng_world_first_child(s->world, kept->entity)))
        return false;
    for (size_t i = 0; i < NG_COUNT(fixed); i++) {
        const struct ng_component_desc *desc = ng_world_component(s->world, fixed[i]);
        for (uint32_t k = 0; k < desc->field_count; k++)
            if (ng_gltf_field_changed(s, &p, fixed[i], &desc->fields[k]))
                return false;
    }
    return true;
}

static bool are_plain(struct gltf_saver *s, const struct gltf_saved *node)
{
    ng_entity e = node->kept->first_child;
    while (!ng_entity_is_null(e)) {
        const struct gltf_kept *part = ng_gltf_kept(s->origin, e);
        if (part->role == GLTF_PRIMITIVE && !is_plain(s, part))
            return false;
        e = part->next_sibling;
    }
    return true;
}

// Primitives stand in their node's mesh as long as all of them can.
static bool is_primitive(struct gltf_saver *s, const struct gltf_kept *kept)
{
    const struct gltf_saved *node = ng_gltf_saved(s, kept->parent);
    if (!node || node->role != GLTF_NODE || !node->kept)
        return false;
    if (!ng_entity_same(s->plain_of, node->entity)) {
        s->plain_of = node->entity;
        s->plain = are_plain(s, node);
    }
    return s->plain;
}

// Whether the same children follow each other as when the file was loaded.
static bool same_children(const struct gltf_saver *s, ng_entity parent)
{
    const struct gltf_kept *kept = ng_gltf_kept(s->origin, parent);
    ng_entity expected = kept ? kept->first_child : (ng_entity){0};
    ng_entity child = ng_world_first_child(s->world, parent);
    while (kept && ng_entity_same(child, expected) && !ng_entity_is_null(child)) {
        expected = ng_gltf_kept(s->origin, child)->next_sibling;
        child = ng_world_next_sibling(s->world, child);
    }
    return kept && ng_entity_is_null(child) && ng_entity_is_null(expected);
}

// Whether all below an entity is as it was loaded.
static bool is_untouched_below(struct gltf_saver *s, ng_entity top)
{
    for (ng_entity e = top; !ng_entity_is_null(e); e = ng_world_next_below(s->world, top, e)) {
        const struct gltf_kept *kept = ng_gltf_kept(s->origin, e);
        if (!kept || !ng_entity_same(ng_world_parent(s->world, e), kept->parent) || !is_untouched(s, kept) ||
            !same_children(s, e))
            return false;
    }
    return true;
}

// Copies of a node's mesh stay copies as long as nobody touched any.
static bool are_copies(struct gltf_saver *s, const struct gltf_kept *copy)
{
    if (s->copies_known && s->copies_of == copy->index)
        return s->copies_stay;
    const struct gltf_saved *node = NULL;
    for (ng_entity e = copy->parent; !node && !ng_entity_is_null(e); e = ng_world_parent(s->world, e)) {
        const struct gltf_saved *p = ng_gltf_saved(s, e);
        node = p && p->role == GLTF_NODE && p->kept && p->index == copy->index ? p : NULL;
    }
    bool stay = node;
    ng_entity e = node ? node->kept->first_child : (ng_entity){0};
    for (; stay && !ng_entity_is_null(e); e = ng_gltf_kept(s->origin, e)->next_sibling)
        if (ng_gltf_kept(s->origin, e)->role == GLTF_COPY)
            stay = ng_entity_same(ng_world_parent(s->world, e), node->entity) && is_untouched_below(s, e);
    s->copies_known = true;
    s->copies_of = copy->index;
    s->copies_stay = stay;
    return stay;
}

static enum gltf_role find_role(struct gltf_saver *s, ng_entity e, const struct gltf_kept *kept)
{
    enum gltf_role was = kept ? kept->role : GLTF_MADE;
    if (ng_entity_same(e, s->root))
        return GLTF_ROOT;
    if (has(s, e, NG_MATERIAL))
        return GLTF_MATERIAL;
    if (has(s, e, NG_ANIMATION))
        return GLTF_ANIMATION;
    if (was == GLTF_PRIMITIVE && is_primitive(s, kept))
        return GLTF_PRIMITIVE;
    if (was == GLTF_COPY)
        return are_copies(s, kept) ? GLTF_MADE : GLTF_NODE;
    if (is_group(s, e) || (kept && was == GLTF_MADE && is_untouched(s, kept) &&
                           ng_entity_is_null(ng_world_first_child(s->world, e))))
        return GLTF_MADE;
    return GLTF_NODE;
}

// Parents come first.
static ng_result give_place(struct gltf_saver *s, ng_entity e)
{
    const struct gltf_kept *kept = ng_gltf_kept(s->origin, e);
    struct gltf_saved p = {.entity = e, .role = find_role(s, e, kept)};
    if (kept && kept->role == p.role) {
        p.kept = kept;
        p.index = kept->index;
        p.primitive = kept->primitive;
    } else if (p.role != GLTF_MADE) {
        static const enum ng_gltf_list lists[] = {[GLTF_ROOT] = NG_GLTF_SCENES,
                                                  [GLTF_NODE] = NG_GLTF_NODES,
                                                  [GLTF_PRIMITIVE] = NG_GLTF_NODES,
                                                  [GLTF_MATERIAL] = NG_GLTF_MATERIALS,
                                                  [GLTF_ANIMATION] = NG_GLTF_ANIMATIONS};
        cJSON *json;
        if (p.role != GLTF_ROOT || !scene_json(s))
            p.index = ng_gltf_append(&s->w, lists[p.role], &json);
    }
    uint32_t slot = ng_entity_index(e);
    if (slot >= s->places.count && !ng_array_resize(&s->places, (size_t)slot + 1))
        return ng_out_of_memory(s->path);
    s->places.items[slot] = p;
    return NG_OK;
}

// What playing clips write to.
static ng_result find_driven(struct gltf_saver *s, ng_entity e)
{
    const struct ng_animation *a = ng_world_get(s->world, e, NG_ANIMATION);
    const struct ng_clip *clip = a && a->playing && a->weight > 0 ? ng_assets_clip(s->assets, a->clip) : NULL;
    for (uint32_t i = 0; clip && i < clip->channel_count; i++) {
        const struct ng_channel *c = &clip->channels[i];
        if (!ng_array_push(&s->driven, (struct gltf_driven){c->target, c->component, c->field_offset}))
            return ng_out_of_memory(s->path);
    }
    return NG_OK;
}

static ng_entity next(const struct gltf_saver *s, ng_entity e)
{
    return ng_world_next_below(s->world, s->root, e);
}

static ng_result give_places(struct gltf_saver *s)
{
    for (ng_entity e = s->root; !ng_entity_is_null(e); e = next(s, e))
        NG_TRY(find_driven(s, e));
    for (ng_entity e = s->root; !ng_entity_is_null(e); e = next(s, e))
        NG_TRY(give_place(s, e));
    return NG_OK;
}

// ---- hierarchy -------------------------------------------------------------------------------------------

// Nodes that became others, or that others became, move a list too.
static bool same_roles(const struct gltf_saver *s, ng_entity parent)
{
    for (ng_entity e = ng_world_first_child(s->world, parent); !ng_entity_is_null(e);
         e = ng_world_next_sibling(s->world, e)) {
        const struct gltf_saved *p = ng_gltf_saved(s, e);
        if (p && p->role == GLTF_NODE && !p->kept)
            return false;
    }
    return true;
}

static void list_children(struct gltf_saver *s, ng_entity parent, cJSON *json, const char *key);

// A document without scenes means that all roots are in it; one is made where something is to be said of it.
static cJSON *need_scene(struct gltf_saver *s)
{
    cJSON *scene = scene_json(s);
    if (scene)
        return scene;
    ng_gltf_append(&s->w, NG_GLTF_SCENES, &scene);
    ng_gltf_json_number(&s->w, s->w.root, "scene", 0);
    list_children(s, s->root, scene, "nodes");
    return scene;
}

static void list_children(struct gltf_saver *s, ng_entity parent, cJSON *json, const char *key)
{
    cJSON *list = NULL;
    ng_gltf_json_remove(json, key);
    for (ng_entity e = ng_world_first_child(s->world, parent); !ng_entity_is_null(e);
         e = ng_world_next_sibling(s->world, e)) {
        const struct gltf_saved *child = ng_gltf_saved(s, e);
        if (!child || child->role != GLTF_NODE)
            continue;
        list = list ? list : ng_gltf_json_list(&s->w, json, key);
        cJSON *index = list ? cJSON_CreateNumber(child->index) : NULL;
        s->w.failed |= !index;
        if (index)
            cJSON_AddItemToArray(list, index);
    }
}

static void write_children(struct gltf_saver *s, const struct gltf_saved *p)
{
    if (p->kept && same_children(s, p->entity) && same_roles(s, p->entity))
        return;
    cJSON *json = ng_gltf_saved_json(s, p);
    if (p->role != GLTF_ROOT)
        list_children(s, p->entity, json, "children");
    else if (json)
        list_children(s, p->entity, json, "nodes");
    else
        need_scene(s);
}

// ---- what is gone ----------------------------------------------------------------------------------------

static bool is_gone(const struct gltf_saver *s, const struct gltf_kept *kept)
{
    const struct gltf_saved *p = ng_gltf_saved(s, kept->entity);
    return !p || p->kept != kept;
}

static void empty(cJSON *object)
{
    while (object && object->child)
        cJSON_Delete(cJSON_DetachItemViaPointer(object, object->child));
}

// Whether a skin that a node has is moved by another node.
static bool is_joint(const struct gltf_saver *s, int node)
{
    for (size_t i = 0; i < s->w.lists[NG_GLTF_NODES].count; i++) {
        const cJSON *joint, *user = s->w.lists[NG_GLTF_NODES].items[i];
        const cJSON *skin = ng_gltf_at(&s->w, NG_GLTF_SKINS, ng_gltf_json_index(user, "skin"));
        cJSON_ArrayForEach(joint, ng_gltf_json_get(skin, "joints"))
        {
            if (cJSON_IsNumber(joint) && joint->valuedouble == node)
                return true;
        }
    }
    return false;
}

// A node that is gone leaves an empty one outside of the scene: no index moves. A joint must be in the scene.
static void keep_joint(struct gltf_saver *s, int index)
{
    cJSON *number = cJSON_CreateNumber(index), *list = ng_gltf_json_list(&s->w, need_scene(s), "nodes");
    s->w.failed |= !number;
    if (number && list)
        cJSON_AddItemToArray(list, number);
}

// What has no name is called by its index when it is loaded: one that moves gets what it was called.
static void name_moved(struct gltf_saver *s, enum ng_gltf_list list, enum gltf_role role, const int *moved)
{
    for (size_t i = 0; i < s->origin->entities.count; i++) {
        const struct gltf_kept *kept = &s->origin->entities.items[i];
        if (kept->role != role || moved[kept->index] < 0 || moved[kept->index] == kept->index)
            continue;
        cJSON *object = ng_gltf_at(&s->w, list, moved[kept->index]);
        const struct ng_name *name = ng_world_get(s->world, kept->entity, NG_NAME);
        if (name && !ng_gltf_json_get(object, "name"))
            ng_gltf_json_text(&s->w, object, "name", name->text);
    }
}

// Loading makes an entity of every material and clip, so these leave no place. `moved`: old index -> new one.
static int *leave_places(struct gltf_saver *s, enum ng_gltf_list list, enum gltf_role role)
{
    size_t count = s->w.lists[list].count, left = 0;
    int *moved = calloc(count + 1, sizeof *moved);
    s->w.failed |= !moved;
    for (size_t i = 0; moved && s->origin && i < s->origin->entities.count; i++) {
        const struct gltf_kept *kept = &s->origin->entities.items[i];
        if (kept->role == role && is_gone(s, kept))
            moved[kept->index] = -1;
    }
    for (size_t i = 0; moved && i < count; i++) {
        cJSON *item = s->w.lists[list].items[i];
        if (moved[i] < 0) {
            cJSON *array = cJSON_GetObjectItemCaseSensitive(
                s->w.root, list == NG_GLTF_MATERIALS ? "materials" : "animations");
            cJSON_Delete(cJSON_DetachItemViaPointer(array, item));
            continue;
        }
        moved[i] = (int)left;
        s->w.lists[list].items[left++] = item;
    }
    s->w.lists[list].count = moved ? left : count;
    if (moved && left < count)
        name_moved(s, list, role, moved);
    if (moved && count && !left)
        ng_gltf_json_remove(s->w.root, list == NG_GLTF_MATERIALS ? "materials" : "animations");
    return moved;
}

// Indices of materials within primitives and the extensions that name them.
static void move_materials(cJSON *value, const int *moved, size_t count, bool inside)
{
    cJSON *item = value->child, *after;
    for (; item; item = after) {
        after = item->next;
        bool here = inside;
        if (item->string)
            here |= strcmp(item->string, "primitives") == 0 || strcmp(item->string, "NG_scene") == 0 ||
                    strcmp(item->string, "KHR_materials_variants") == 0;
        if (!inside || !cJSON_IsNumber(item) || !item->string || strcmp(item->string, "material") != 0) {
            move_materials(item, moved, count, here);
            continue;
        }
        if (item->valuedouble < 0 || item->valuedouble >= (double)count)
            continue;
        int index = moved[(size_t)item->valuedouble];
        if (index < 0)
            cJSON_Delete(cJSON_DetachItemViaPointer(value, item));
        else
            cJSON_SetNumberValue(item, index);
    }
}

static void leave_gone(struct gltf_saver *s)
{
    for (size_t i = 0; s->origin && i < s->origin->entities.count; i++) {
        const struct gltf_kept *kept = &s->origin->entities.items[i];
        if (kept->role == GLTF_NODE && is_gone(s, kept))
            empty(ng_gltf_at(&s->w, NG_GLTF_NODES, kept->index));
    }
    for (size_t i = 0; s->origin && i < s->origin->entities.count; i++) {
        const struct gltf_kept *kept = &s->origin->entities.items[i];
        if (kept->role == GLTF_NODE && is_gone(s, kept) && is_joint(s, kept->index))
            keep_joint(s, kept->index);
    }
    size_t count = s->w.lists[NG_GLTF_MATERIALS].count;
    int *moved = leave_places(s, NG_GLTF_MATERIALS, GLTF_MATERIAL);
    if (moved && s->w.lists[NG_GLTF_MATERIALS].count != count)
        move_materials(s->w.root, moved, count, false);
    free(moved);
    free(leave_places(s, NG_GLTF_ANIMATIONS, GLTF_ANIMATION));
}

// ---- the whole -------------------------------------------------------------------------------------------

static void save_scene(struct gltf_saver *s, const struct gltf_saved *p)
{
    cJSON *scene = p->kept && is_untouched(s, p->kept) && !s->explicit ? scene_json(s) : need_scene(s);
    ng_gltf_save_name(s, p, scene);
    ng_gltf_save_component(s, p, scene, NG_TRANSFORM, NG_GLTF_IMPLIED);
    ng_gltf_save_others(s, p, scene, (uint64_t)1 << NG_TRANSFORM);
}

// A scale that loading computed would be another one for another scene: it is then written down.
static void keep_scale(struct gltf_saver *s, const struct gltf_saved *root)
{
    const cJSON *scenes = ng_gltf_json_get(s->origin->json, "scenes");
    int index = ng_gltf_json_index(s->origin->json, "scene");
    const cJSON *scene = cJSON_GetArrayItem(scenes, index < 0 ? 0 : index);
    const cJSON *ours = ng_gltf_json_get(ng_gltf_json_get(scene, "extensions"), "NG_scene");
    bool given = ng_gltf_json_get(ng_gltf_json_get(ours, "components"), "scene_scale");
    struct gltf_saved fresh = *root;
    fresh.kept = NULL;
    if (!given && has(s, s->root, NG_SCENE_SCALE) &&
        (s->explicit || !ng_gltf_json_same(s->w.root, s->origin->json)))
        ng_gltf_save_component(s, &fresh, need_scene(s), NG_SCENE_SCALE, 0);
}

static ng_result save_entities(struct gltf_saver *s)
{
    NG_TRY(give_places(s));
    ng_gltf_save_edited_shapes(s);
    for (ng_entity e = s->root; !ng_entity_is_null(e); e = next(s, e)) {
        const struct gltf_saved *p = ng_gltf_saved(s, e);
        if (p && p->role == GLTF_MATERIAL)
            ng_gltf_save_material(s, p);
        if (p && p->role == GLTF_NODE)
            ng_gltf_save_node(s, p);
        if (p && (p->role == GLTF_NODE || p->role == GLTF_ROOT))
            write_children(s, p);
    }
    for (ng_entity e = s->root; !ng_entity_is_null(e); e = next(s, e)) {
        const struct gltf_saved *p = ng_gltf_saved(s, e);
        if (p && p->role == GLTF_ANIMATION)
            ng_gltf_save_animation(s, p);
    }
    const struct gltf_saved *root = ng_gltf_saved(s, s->root);
    save_scene(s, root);
    leave_gone(s);
    if (s->origin)
        keep_scale(s, root);
    return s->w.failed ? ng_out_of_memory(s->path) : NG_OK;
}

static ng_result start(struct gltf_saver *s)
{
    cJSON *root = s->origin ? cJSON_Duplicate(s->origin->json, true) : NULL;
    if (s->origin && !root)
        return ng_out_of_memory(s->path);
    ng_gltf_writer_init(&s->w, root);
    if (!s->origin) {
        cJSON *asset = ng_gltf_json_object(&s->w, s->w.root, "asset");
        ng_gltf_json_text(&s->w, asset, "version", "2.0");
        ng_gltf_json_text(&s->w, asset, "generator", "LightFormer");
        ng_gltf_json_number(&s->w, s->w.root, "scene", 0);
    }
    ng_gltf_save_choose_buffer(s);
    return s->w.failed ? ng_out_of_memory(s->path) : NG_OK;
}

static void finish(struct gltf_saver *s)
{
    ng_gltf_writer_finish(&s->w);
    for (size_t i = 0; i < s->beside.count; i++)
        free(s->beside.items[i].path);
    for (size_t i = 0; i < s->owned.count; i++)
        free(s->owned.items[i]);
    for (size_t i = 0; i < s->written.count; i++)
        cJSON_Delete(s->written.items[i].primitive);
    ng_array_finish(&s->places);
    ng_array_finish(&s->driven);
    ng_array_finish(&s->written);
    ng_array_finish(&s->meshes);
    ng_array_finish(&s->textures);
    ng_array_finish(&s->skins);
    ng_array_finish(&s->accessor_uses);
    ng_array_finish(&s->view_uses);
    ng_array_finish(&s->mesh_users);
    ng_array_finish(&s->beside);
    ng_array_finish(&s->owned);
}

static ng_result make(struct gltf_saver *s)
{
    NG_TRY(start(s));
    return save_entities(s);
}

static bool uses_scene(const struct gltf_saver *s)
{
    const cJSON *name;
    cJSON_ArrayForEach(name, ng_gltf_json_get(s->w.root, "extensionsUsed"))
    {
        if (cJSON_IsString(name) && strcmp(name->valuestring, "NG_scene") == 0)
            return true;
    }
    return false;
}

ng_result ng_gltf_save(const char *path, const struct ng_gltf_save_params *p)
{
    NG_REQUIRE(path && p->world && p->assets, "path, world and assets must be given");
    NG_REQUIRE(ng_entity_alive(p->world, p->root), "the root of what is saved must be there");
    const struct gltf_saver fresh = {.path = path,
                                     .binary = ends_in(path, "glb"),
                                     .world = p->world,
                                     .assets = p->assets,
                                     .root = p->root,
                                     .origin = p->origin};
    struct gltf_saver s = fresh;
    if (!ng_gltf_save_knows(path)) {
        ng_log_error("%s: a scene is saved as .glb or .gltf", path);
        return NG_ERROR_USAGE;
    }
    ng_result r = make(&s);
    if (r == NG_OK && p->origin && p->origin->foreign && (uses_scene(&s) || s.lost_made)) {
        finish(&s);
        s = fresh;
        s.explicit = true;
        r = make(&s);
    }
    if (r == NG_OK)
        r = ng_gltf_save_write(&s);
    finish(&s);
    return r;
}

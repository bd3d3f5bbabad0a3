// Scenes written back: loaded again they are the same, and nothing that the engine does not follow is lost.
#define _POSIX_C_SOURCE 200809L
#include "scene_equal.h"

#include "asset/gltf_save.h"
#include "base/array.h"
#include "base/file.h"
#include "components/animation.h"
#include "components/camera.h"
#include "components/light_point.h"
#include "components/light_spot.h"
#include "components/material.h"
#include "components/mesh.h"
#include "components/scene_scale.h"
#include "components/transform.h"

#include <cjson/cJSON.h>

#include <math.h>

// ---- files -----------------------------------------------------------------------------------------------

// The scenes of content/, and those of tests/files that can be loaded.
struct names {
    const char *folder;
    NG_ARRAY(char *) paths;
};

static int compare_paths(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

static void add_name(void *user, const char *name)
{
    struct names *names = user;
    char path[512];
    if (!ng_gltf_save_knows(name))
        return;
    snprintf(path, sizeof path, "%s/%s", names->folder, name);
    assert_true(ng_array_push(&names->paths, strdup(path)));
}

static void add_folder(void *user, const char *name)
{
    struct names *names = user;
    const char *top = names->folder;
    char path[512];
    snprintf(path, sizeof path, "%s/%s", top, name);
    if (name[0] == '.' || strchr(name, '.') || strcmp(name, "bad") == 0)
        return;
    names->folder = path;
    assert_int_equal(ng_file_list(path, add_name, names), NG_OK);
    names->folder = top;
}

static bool can_be_loaded(const char *path)
{
    struct scene s;
    struct test_log log;
    test_log_begin(&log);
    ng_result r = scene_load(&s, path, false);
    test_log_end(&log);
    scene_finish(&s);
    return r == NG_OK;
}

static void names_find(struct names *names)
{
    static const char *const tops[] = {"content", "tests/files"};
    size_t count = 0;
    *names = (struct names){0};
    for (size_t i = 0; i < NG_COUNT(tops); i++) {
        names->folder = tops[i];
        assert_int_equal(ng_file_list(tops[i], add_folder, names), NG_OK);
    }
    for (size_t i = 0; i < names->paths.count; i++)
        if (can_be_loaded(names->paths.items[i]))
            names->paths.items[count++] = names->paths.items[i];
        else
            free(names->paths.items[i]);
    names->paths.count = count;
    assert_true(names->paths.count > 30);
    qsort(names->paths.items, names->paths.count, sizeof *names->paths.items, compare_paths);
}

static void names_finish(struct names *names)
{
    for (size_t i = 0; i < names->paths.count; i++)
        free(names->paths.items[i]);
    ng_array_finish(&names->paths);
}

// The path of a file in a folder of the scratch directory.
static void set_ending(char *path, const char *ending)
{
    memcpy(strrchr(path, '.'), ending, strlen(ending) + 1);
}

static void place(char out[512], const char *folder, const char *name)
{
    test_path(out, 512, folder);
    assert_int_equal(ng_file_make_directory(out), NG_OK);
    size_t n = strlen(out);
    snprintf(out + n, 512 - n, "/%s", name);
}

static void save(const struct scene *s, const char *path)
{
    const struct ng_gltf_save_params params = {s->world, s->assets, s->loaded.root, s->loaded.origin};
    if (ng_gltf_save(path, &params) != NG_OK)
        fail_msg("%s was not saved", path);
}

static void load(struct scene *s, const char *path, bool keep)
{
    struct test_log log; // of what these files are known to warn of
    test_log_begin(&log);
    ng_result r = scene_load(s, path, keep);
    test_log_end(&log);
    if (r != NG_OK)
        fail_msg("%s was not loaded: %s", path, log.text);
}

static void assert_same_file(const char *a, const char *b)
{
    void *x, *y;
    size_t n, m;
    assert_int_equal(ng_file_read(a, 0, &x, &n), NG_OK);
    assert_int_equal(ng_file_read(b, 0, &y, &m), NG_OK);
    if (n != m || memcmp(x, y, n) != 0)
        fail_msg("%s is not %s", b, a);
    free(x);
    free(y);
}

// A camera that loading made comes after all else, one of the file does not.
static void drop_camera(struct scene *s)
{
    if (s->loaded.camera_made)
        assert_int_equal(ng_entity_destroy(s->world, s->loaded.camera), NG_OK);
}

// ---- whole files -----------------------------------------------------------------------------------------

static void an_unchanged_file_keeps_its_bytes(void **state)
{
    NG_UNUSED(state);
    struct names names;
    names_find(&names);
    for (size_t i = 0; i < names.paths.count; i++) {
        char out[512];
        struct scene s;
        place(out, "same", ng_path_name(names.paths.items[i]));
        load(&s, names.paths.items[i], true);
        save(&s, out);
        assert_same_file(names.paths.items[i], out);
        scene_finish(&s);
    }
    names_finish(&names);
}

static void the_other_kind_of_file_holds_the_same_scene(void **state)
{
    NG_UNUSED(state);
    struct names names;
    names_find(&names);
    for (size_t i = 0; i < names.paths.count; i++) {
        const char *from = names.paths.items[i];
        bool binary = strcmp(ng_path_extension(from), "glb") == 0;
        char there[512], back[512];
        struct scene a, b, c;
        place(there, "there", ng_path_name(from));
        place(back, "back", ng_path_name(from));
        set_ending(there, binary ? ".gltf" : ".glb");
        load(&a, from, true);
        save(&a, there);
        load(&b, there, true);
        scene_assert_equal(&a, &b, there);
        save(&b, back);
        load(&c, back, false);
        scene_assert_equal(&a, &c, back);
        scene_finish(&a);
        scene_finish(&b);
        scene_finish(&c);
    }
    names_finish(&names);
}

// Without what the file was all is written anew.
static void a_world_alone_is_written_whole(void **state)
{
    NG_UNUSED(state);
    static const char *const endings[] = {".glb", ".gltf"};
    struct names names;
    names_find(&names);
    for (size_t i = 0; i < names.paths.count; i++)
        for (size_t k = 0; k < NG_COUNT(endings); k++) {
            char out[512];
            struct scene a, b;
            place(out, "alone", ng_path_name(names.paths.items[i]));
            set_ending(out, endings[k]);
            load(&a, names.paths.items[i], false);
            drop_camera(&a);
            save(&a, out);
            load(&b, out, false);
            drop_camera(&b);
            scene_assert_equal(&a, &b, out);
            scene_finish(&a);
            scene_finish(&b);
        }
    names_finish(&names);
}

// ---- edits -----------------------------------------------------------------------------------------------

// The first entity with a component; null if there is none.
static ng_entity first_with(const struct scene *s, ng_component c)
{
    ng_entity e = s->loaded.root;
    while (!ng_entity_is_null(e) && !ng_world_has(s->world, e, c))
        e = ng_world_next_below(s->world, s->loaded.root, e);
    return e;
}

static void *edit(const struct scene *s, ng_component c)
{
    ng_entity e = first_with(s, c);
    return ng_entity_is_null(e) ? NULL : ng_world_edit(s->world, e, c);
}

// A node below the first one, before its other children.
static ng_entity add_node(struct scene *s, const char *text)
{
    struct ng_name name = {0};
    ng_entity e = ng_entity_create(s->world), parent = ng_world_first_child(s->world, s->loaded.root);
    snprintf(name.text, sizeof name.text, "%s", text);
    assert_int_equal(ng_world_add(s->world, e, NG_NAME, &name), NG_OK);
    assert_int_equal(ng_world_add(s->world, e, NG_TRANSFORM, NULL), NG_OK);
    assert_int_equal(ng_world_set_parent(s->world, e, parent, ng_world_first_child(s->world, parent)), NG_OK);
    return e;
}

static bool edit_name(struct scene *s)
{
    struct ng_name *name = ng_world_edit(s->world, ng_world_first_child(s->world, s->loaded.root), NG_NAME);
    snprintf(name->text, sizeof name->text, "h\u00e9 \"quoted\" \\ name");
    return true;
}

static bool edit_transform(struct scene *s)
{
    struct ng_transform *t =
        ng_world_edit(s->world, ng_world_first_child(s->world, s->loaded.root), NG_TRANSFORM);
    const float q[4] = {0.1f, 0.7f, -0.3f, 0.6f};
    float length = sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (ng_entity_is_null(first_with(s, NG_ANIMATION))) // what a clip drives is of the moment
        t->translation[1] += 0.1f;
    t->scale[2] *= 1.3f;
    for (int i = 0; i < 4; i++)
        t->rotation[i] = q[i] / length;
    return true;
}

static bool edit_material(struct scene *s)
{
    struct ng_material *m = edit(s, NG_MATERIAL);
    if (!m)
        return false;
    if (ng_entity_is_null(first_with(s, NG_ANIMATION))) // what a clip drives is of the moment
        m->base_color[1] = 0.123456f;
    m->roughness = 0.3f;
    m->metallic = 0.7f;
    m->emissive[2] = 0.25f;
    m->emissive_strength = 3;
    m->normal_scale = 0.5f;
    if (!m->base_color_texture.id) { // whose smaller pictures were made for these
        m->alpha = 0.5f;
        m->alpha_cutoff = 0.25f;
        m->alpha_mode = (m->alpha_mode + 1) % 3;
    }
    m->double_sided = !m->double_sided;
    return true;
}

static bool drop_texture(struct scene *s)
{
    for (ng_entity e = s->loaded.root; !ng_entity_is_null(e);
         e = ng_world_next_below(s->world, s->loaded.root, e)) {
        const struct ng_material *m = ng_world_get(s->world, e, NG_MATERIAL);
        if (!m || !m->base_color_texture.id || m->alpha_mode) // whose smaller pictures keep coverage
            continue;
        struct ng_material *edited = ng_world_edit(s->world, e, NG_MATERIAL);
        edited->emissive_texture = edited->base_color_texture;
        edited->base_color_texture = (ng_asset){0};
        return true;
    }
    return false;
}

static bool edit_camera(struct scene *s)
{
    struct ng_camera *c = edit(s, NG_CAMERA);
    c->fov_y = 0.5f;
    c->near_plane = 0.02f;
    c->exposure = 2;
    return !s->loaded.camera_made;
}

static bool edit_light(struct scene *s)
{
    struct ng_light_point *point = edit(s, NG_LIGHT_POINT);
    struct ng_light_spot *spot = edit(s, NG_LIGHT_SPOT);
    if (point) {
        point->intensity *= 1.7f;
        point->color[0] = 2;
        point->on = false;
    }
    if (spot) {
        spot->inner_angle = 0.1f;
        spot->outer_angle = 1.5707964f;
    }
    return point || spot;
}

static bool add_lights(struct scene *s)
{
    const struct ng_light_spot spot = {
        .on = true, .color = {1, 0.5f, 0.25f}, .intensity = 3, .inner_angle = 0.2f, .outer_angle = 0.4f};
    const struct ng_light_point point = {.on = false, .color = {1, 1, 1}, .intensity = 0.1f};
    ng_entity e = add_node(s, "lamp"), f = add_node(s, "area");
    assert_int_equal(ng_world_add(s->world, e, NG_LIGHT_SPOT, &spot), NG_OK);
    assert_int_equal(ng_world_add(s->world, e, NG_LIGHT_POINT, &point), NG_OK);
    assert_int_equal(ng_world_add(s->world, f, NG_LIGHT_RECTANGLE, NULL), NG_OK);
    return true;
}

static bool add_mesh(struct scene *s)
{
    ng_entity old = first_with(s, NG_MESH);
    if (ng_entity_is_null(old) || ng_world_has(s->world, old, NG_SKIN))
        return false;
    struct ng_mesh mesh;
    memcpy(&mesh, ng_world_get(s->world, old, NG_MESH), sizeof mesh);
    ng_entity e = add_node(s, "another");
    mesh.material = (ng_entity){0};
    assert_int_equal(ng_world_add(s->world, e, NG_MESH, &mesh), NG_OK);
    return true;
}

static bool hide_mesh(struct scene *s)
{
    struct ng_mesh *mesh = edit(s, NG_MESH);
    if (!mesh)
        return false;
    mesh->visible = false;
    mesh->material = (ng_entity){0};
    return true;
}

static bool edit_points(struct scene *s)
{
    ng_asset g = ng_assets_next(s->assets, NG_ASSET_GEOMETRY, (ng_asset){0});
    if (!g.id)
        return false;
    float *points = ng_assets_edit_points(s->assets, g);
    points[0] += 0.01f;
    points[4] -= 0.02f;
    assert_int_equal(ng_assets_changed(s->assets, g), NG_OK);
    return true;
}

static bool edit_cage(struct scene *s)
{
    ng_asset cage = ng_assets_next(s->assets, NG_ASSET_CAGE, (ng_asset){0});
    if (!cage.id)
        return false;
    float *points = ng_assets_edit_points(s->assets, cage);
    points[0] += 0.01f;
    assert_int_equal(ng_assets_changed(s->assets, cage), NG_OK);
    return true;
}

static bool edit_texels(struct scene *s)
{
    ng_asset image = ng_assets_next(s->assets, NG_ASSET_IMAGE, (ng_asset){0});
    if (!image.id)
        return false;
    unsigned char *texels = ng_assets_edit_texels(s->assets, image);
    texels[1] = (unsigned char)~texels[1];
    assert_int_equal(ng_assets_changed(s->assets, image), NG_OK);
    return true;
}

static bool edit_keys(struct scene *s)
{
    ng_asset id = ng_assets_next(s->assets, NG_ASSET_CLIP, (ng_asset){0});
    struct ng_clip *clip = id.id ? ng_assets_edit_clip(s->assets, id) : NULL;
    if (!clip || !clip->channel_count)
        return false;
    struct ng_channel *c = &clip->channels[0];
    c->times[c->key_count - 1] += 0.5f;
    assert_int_equal(ng_assets_changed(s->assets, id), NG_OK);
    struct ng_animation *a = edit(s, NG_ANIMATION);
    a->speed = 0.5f;
    return true;
}

static bool remove_first(struct scene *s, ng_component c)
{
    ng_entity e = first_with(s, c);
    if (ng_entity_is_null(e) || ng_entity_same(e, s->loaded.camera))
        return false;
    ng_entity group = ng_world_parent(s->world, e);
    assert_int_equal(ng_entity_destroy(s->world, e), NG_OK);
    // What loading groups materials and clips below goes with the last of them.
    if (!ng_world_has(s->world, group, NG_TRANSFORM) &&
        ng_entity_is_null(ng_world_first_child(s->world, group)))
        assert_int_equal(ng_entity_destroy(s->world, group), NG_OK);
    return true;
}

static bool remove_material(struct scene *s)
{
    return ng_entity_is_null(first_with(s, NG_ANIMATION)) && remove_first(s, NG_MATERIAL);
}

static bool remove_animation(struct scene *s)
{
    return remove_first(s, NG_ANIMATION);
}

static bool remove_mesh(struct scene *s)
{
    ng_entity e = first_with(s, NG_MESH);
    bool alone = ng_entity_is_null(first_with(s, NG_ANIMATION)); // channels would be lost with it
    return alone && !ng_entity_is_null(e) && remove_first(s, NG_MESH);
}

static bool remove_light(struct scene *s)
{
    if (!ng_entity_is_null(first_with(s, NG_ANIMATION))) // whose channels would be lost with it
        return false;
    ng_component lights[] = {NG_LIGHT_POINT, NG_LIGHT_SPOT, NG_LIGHT_DIRECTIONAL, NG_LIGHT_RECTANGLE,
                             NG_LIGHT_MESH};
    bool any = false;
    for (size_t i = 0; i < NG_COUNT(lights); i++) {
        ng_entity e = first_with(s, lights[i]);
        if (ng_entity_is_null(e))
            continue;
        assert_int_equal(ng_world_remove(s->world, e, lights[i]), NG_OK);
        any = true;
    }
    return any;
}

// The last node becomes the first one's first child.
static bool move_node(struct scene *s)
{
    ng_entity first = ng_world_first_child(s->world, s->loaded.root), last = {0};
    for (ng_entity e = first; !ng_entity_is_null(e); e = ng_world_next_sibling(s->world, e))
        if (ng_world_has(s->world, e, NG_TRANSFORM) && !ng_entity_same(e, first) &&
            !ng_entity_same(e, s->loaded.camera))
            last = e;
    if (ng_entity_is_null(last))
        return false;
    assert_int_equal(ng_world_set_parent(s->world, last, first, ng_world_first_child(s->world, first)),
                     NG_OK);
    return true;
}

static bool edit_scene(struct scene *s)
{
    struct ng_scene_scale *scale = ng_world_edit(s->world, s->loaded.root, NG_SCENE_SCALE);
    struct ng_transform *t = ng_world_edit(s->world, s->loaded.root, NG_TRANSFORM);
    scale->radius *= 1.5f;
    t->translation[0] = 0.1f;
    return true;
}

static const struct {
    const char *name;
    bool (*make)(struct scene *s); // false: there is nothing to edit
} edits[] = {
    {"name", edit_name},
    {"transform", edit_transform},
    {"material", edit_material},
    {"texture", drop_texture},
    {"camera", edit_camera},
    {"light", edit_light},
    {"lights", add_lights},
    {"mesh", add_mesh},
    {"hidden", hide_mesh},
    {"points", edit_points},
    {"cage", edit_cage},
    {"texels", edit_texels},
    {"keys", edit_keys},
    {"no_material", remove_material},
    {"no_animation", remove_animation},
    {"no_mesh", remove_mesh},
    {"no_light", remove_light},
    {"moved", move_node},
    {"scene", edit_scene},
};

// Entities that nobody names any more are no difference: references to them are null from then on.
static void an_edited_scene_comes_back(void **state)
{
    NG_UNUSED(state);
    static const char *const endings[] = {".glb", ".gltf"};
    struct names names;
    unsigned made = 0;
    names_find(&names);
    for (size_t i = 0; i < names.paths.count; i++)
        for (size_t k = 0; k < NG_COUNT(edits); k++) {
            char out[512], what[640];
            struct scene a, b;
            if (strstr(names.paths.items[i], "chess") || strstr(names.paths.items[i], "unseen"))
                continue; // large, and nothing that others have not
            load(&a, names.paths.items[i], true);
            bool nodes = ng_world_has(a.world, ng_world_first_child(a.world, a.loaded.root), NG_TRANSFORM);
            if (nodes && edits[k].make(&a)) {
                place(out, edits[k].name, ng_path_name(names.paths.items[i]));
                set_ending(out, endings[(i + k) % 2]);
                save(&a, out);
                load(&b, out, false);
                drop_camera(&a);
                drop_camera(&b);
                snprintf(what, sizeof what, "%s (%s)", out, edits[k].name);
                scene_assert_equal(&a, &b, what);
                scene_finish(&b);
                made++;
            }
            scene_finish(&a);
        }
    assert_true(made > 300);
    names_finish(&names);
}

// ---- what the engine does not follow ---------------------------------------------------------------------

static cJSON *read_json(const char *path)
{
    void *data;
    size_t size, at = 0;
    assert_int_equal(ng_file_read(path, 0, &data, &size), NG_OK);
    if (memcmp(data, "glTF", 4) == 0)
        at = 20;
    cJSON *json = cJSON_ParseWithLength((char *)data + at, size - at);
    assert_non_null(json);
    free(data);
    return json;
}

// Whether all of `a` is in `b`, but for what an edit may have changed: members that are no objects or lists.
static void assert_within(const cJSON *a, const cJSON *b, const char *path)
{
    const cJSON *item;
    int i = 0;
    cJSON_ArrayForEach(item, a)
    {
        char below[512];
        snprintf(below, sizeof below, "%.400s/%s%d", path, item->string ? item->string : "",
                 item->string ? 0 : i);
        const cJSON *other =
            item->string ? cJSON_GetObjectItemCaseSensitive(b, item->string) : cJSON_GetArrayItem(b, i);
        if (!other)
            fail_msg("%s is lost", below);
        bool whole =
            item->string && (strcmp(item->string, "extras") == 0 ||
                             strncmp(item->string, "FOREIGN_", 8) == 0 || strcmp(item->string, "asset") == 0);
        if (whole && !cJSON_Compare(item, other, true))
            fail_msg("%s is another one", below);
        assert_within(item, other, below);
        i++;
    }
}

// Every object and list of a file has something that nobody here knows.
static void foreign_parts_survive(void **state)
{
    NG_UNUSED(state);
    static const char *const from = "tests/files/saving/foreign.gltf";
    static const char *const endings[] = {".gltf", ".glb"};
    cJSON *before = read_json(from);
    for (size_t k = 0; k < NG_COUNT(edits); k++)
        for (size_t i = 0; i < NG_COUNT(endings); i++) {
            char out[512];
            struct scene s;
            bool removes = strncmp(edits[k].name, "no_", 3) == 0 || strcmp(edits[k].name, "moved") == 0 ||
                           strcmp(edits[k].name, "texture") == 0 || strcmp(edits[k].name, "texels") == 0 ||
                           strcmp(edits[k].name, "points") == 0 || strcmp(edits[k].name, "keys") == 0;
            load(&s, from, true);
            if (!removes && edits[k].make(&s)) {
                place(out, edits[k].name, "foreign.gltf");
                set_ending(out, endings[i]);
                save(&s, out);
                cJSON *after = read_json(out);
                if (i == 1) { // buffers and pictures are within
                    cJSON_DeleteItemFromObject(cJSON_GetObjectItem(after, "buffers")->child, "byteLength");
                    cJSON_AddStringToObject(cJSON_GetObjectItem(after, "images")->child, "uri", "");
                    cJSON_AddStringToObject(cJSON_GetObjectItem(after, "buffers")->child, "uri", "");
                    cJSON_AddNumberToObject(cJSON_GetObjectItem(after, "buffers")->child, "byteLength", 0);
                }
                assert_within(before, after, out);
                cJSON_Delete(after);
            }
            scene_finish(&s);
        }
    cJSON_Delete(before);
}

// Pictures are not encoded anew: their bytes are in the file.
static void pictures_keep_their_bytes(void **state)
{
    NG_UNUSED(state);
    char out[512];
    struct scene s;
    void *picture, *file;
    size_t picture_size, size;
    bool found = false;
    place(out, "pictures", "foreign.glb");
    load(&s, "tests/files/saving/foreign.gltf", true);
    assert_true(edit_transform(&s));
    save(&s, out);
    assert_int_equal(ng_file_read("tests/files/saving/picture.png", 0, &picture, &picture_size), NG_OK);
    assert_int_equal(ng_file_read(out, 0, &file, &size), NG_OK);
    for (size_t at = 0; !found && at + picture_size <= size; at++)
        found = memcmp((char *)file + at, picture, picture_size) == 0;
    assert_true(found);
    free(picture);
    free(file);
    scene_finish(&s);
}

// Names beside the document that others have are left to them.
static void files_beside_are_not_replaced(void **state)
{
    NG_UNUSED(state);
    char out[512], taken[512], moved[512], text[8] = "mine";
    struct scene s, again;
    void *data;
    size_t size;
    place(out, "beside", "foreign.gltf");
    place(moved, "beside", "data.1.bin");
    place(taken, "beside", "data.bin");
    assert_int_equal(ng_file_write(taken, text, 4), NG_OK);
    load(&s, "tests/files/saving/foreign.gltf", true);
    for (int i = 0; i < 3; i++) // what is there already is used
        save(&s, out);
    assert_int_equal(ng_file_read(taken, 0, &data, &size), NG_OK);
    assert_true(size == 4 && memcmp(data, text, 4) == 0);
    free(data);
    assert_same_file("tests/files/saving/data.bin", moved);
    place(moved, "beside", "data.2.bin");
    assert_false(ng_file_exists(moved));
    load(&again, out, false);
    scene_assert_equal(&s, &again, out);
    scene_finish(&s);
    scene_finish(&again);
}

// Saved again and again after edits, a file does not grow.
static void a_file_does_not_grow(void **state)
{
    NG_UNUSED(state);
    char out[512];
    size_t first = 0, size;
    void *data;
    place(out, "growth", "subdivision.glb");
    for (int i = 0; i < 6; i++) {
        struct scene s;
        load(&s, i ? out : "content/unit/subdivision.glb", true);
        assert_true(edit_points(&s) && edit_cage(&s));
        save(&s, out);
        scene_finish(&s);
        assert_int_equal(ng_file_read(out, 0, &data, &size), NG_OK);
        free(data);
        first = i == 1 ? size : first;
        if (i > 1 && size > first + 256)
            fail_msg("the file grows from %zu to %zu bytes", first, size);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_unchanged_file_keeps_its_bytes),
        cmocka_unit_test(a_world_alone_is_written_whole),
        cmocka_unit_test(an_edited_scene_comes_back),
        cmocka_unit_test(foreign_parts_survive),
        cmocka_unit_test(pictures_keep_their_bytes),
        cmocka_unit_test(files_beside_are_not_replaced),
        cmocka_unit_test(a_file_does_not_grow),
        cmocka_unit_test(the_other_kind_of_file_holds_the_same_scene),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

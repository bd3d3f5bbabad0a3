// Scenes written back: loaded again they are the same, and nothing that the engine does not follow is lost.
#define _POSIX_C_SOURCE 200809L
#include "scene_equal.h"

#include "asset/gltf_save.h"
#include "base/array.h"
#include "base/file.h"

#include <cjson/cJSON.h>

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

// A place of its own for each file of the scratch directory: beside `name` nothing else is.
static void place(char out[512], const char *folder, const char *name)
{
    test_path(out, 512, folder);
    assert_int_equal(ng_file_make_directory(out), NG_OK);
    size_t n = strlen(out);
    snprintf(out + n, 512 - n, "/%s", name);
    remove(out);
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
        strcpy(strrchr(there, '.'), binary ? ".gltf" : ".glb");
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
            strcpy(strrchr(out, '.'), endings[k]);
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_unchanged_file_keeps_its_bytes),
        cmocka_unit_test(a_world_alone_is_written_whole),
        cmocka_unit_test(the_other_kind_of_file_holds_the_same_scene),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

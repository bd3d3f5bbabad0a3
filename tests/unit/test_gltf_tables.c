// What stands between a file and tinygltf changes nothing of a file that is right, and lets tinygltf read
// what is wrong.
#define _POSIX_C_SOURCE 200809L // readdir
#include "test.h"

#include "asset/gltf_internal.h"
#include "asset/gltf_writer.h"
#include "base/file.h"
#include "tinygltf_text.h"

#include <cjson/cJSON.h>
#include <dirent.h>

// ---- files that are right --------------------------------------------------------------------------------
static const struct ng_gltf_params params = {
    .max_memory = 1 << 30, .max_file_size = 1 << 30, .max_entities = 1 << 18};

// True: tinygltf takes the file as it is, and reads the same.
static bool compare(const char *path)
{
    char *original = tinygltf_text_of_file(path);
    if (!original)
        return false;
    struct gltf_faults faults = {.path = path};
    struct gltf_document *doc;
    assert_int_equal(ng_gltf_parse(path, &params, &faults, &doc), NG_OK);
    char *ours = tinygltf_text_of_document(doc);
    if (strcmp(ours, original) != 0)
        fprintf(stderr, "%s:\n--- tinygltf\n%s--- the document\n%s", path, original, ours);
    assert_string_equal(ours, original);
    ng_gltf_document_destroy(&doc);
    ng_gltf_faults_finish(&faults);
    free(ours);
    free(original);
    return true;
}

static unsigned compare_folder(const char *folder)
{
    DIR *dir = opendir(folder);
    unsigned equal = 0;
    assert_non_null(dir);
    for (struct dirent *entry; (entry = readdir(dir));) {
        const char *end = strrchr(entry->d_name, '.');
        char path[512];
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        // tinygltf silently leaves out whole numbers of that form.
        if (!end || strncmp(end, ".gl", 3) != 0 || strcmp(entry->d_name, "whole_number_as_float.gltf") == 0)
            continue;
        equal += compare(path);
    }
    closedir(dir);
    return equal;
}

static void test_reads_the_same(void **state)
{
    NG_UNUSED(state);
    struct test_log log;
    test_log_begin(&log);
    assert_true(compare_folder("tests/files/good") >= 16);
    assert_true(compare_folder("tests/files/geometry") >= 11);
    assert_true(compare_folder("tests/files/materials") >= 8);
    assert_true(compare_folder("content/chess") >= 2);
    test_log_end(&log);
    assert_int_equal(log.errors, 0);
}

// ---- files that are wrong --------------------------------------------------------------------------------
// tinygltf is given what is left of a document when one of its values was replaced, and reads all of it.
static void read_damaged(const cJSON *root)
{
    char *text = cJSON_PrintUnformatted(root);
    struct gltf_faults faults = {.path = "damaged"};
    struct gltf_document doc = {0};
    assert_non_null(text);
    ng_result r = ng_gltf_json(&faults, text, strlen(text), &doc.arena, &doc.root);
    if (r == NG_OK) {
        r = ng_gltf_tables("damaged", 1 << 30, &doc);
        if (r != NG_OK)
            fprintf(stderr, "%s\n", text);
        assert_int_equal(r, NG_OK);
        const struct gltf_value *nodes = ng_gltf_array(doc.root, "nodes");
        assert_int_equal(doc.node_count, nodes ? nodes->count : 0);
    }
    ng_gltf_faults_finish(&faults);
    ng_arena_finish(&doc.arena);
    cJSON_free(text);
}

static void damage(const cJSON *root, cJSON *value);

// One value: in turn gone, of every other type, and numbers of every kind.
static void damage_one(const cJSON *root, cJSON *value)
{
    static char text[] = "x", gone[] = "gone";
    const cJSON kept = *value;
    const cJSON others[] = {
        {.type = cJSON_NULL},
        {.type = cJSON_True},
        {.type = cJSON_Array},
        {.type = cJSON_Object},
        {.type = cJSON_String, .valuestring = text},
        {.type = cJSON_Number, .valuedouble = -1},
        {.type = cJSON_Number, .valuedouble = -0.0},
        {.type = cJSON_Number, .valuedouble = 2.5},
        {.type = cJSON_Number, .valuedouble = 255},
        {.type = cJSON_Number, .valuedouble = 4294967295.0},
        {.type = cJSON_Number, .valuedouble = 1e300},
    };
    for (size_t i = 0; i < NG_COUNT(others); i++) {
        value->type = others[i].type;
        value->child = NULL;
        value->valuestring = others[i].valuestring;
        value->valuedouble = others[i].valuedouble;
        read_damaged(root);
        *value = kept;
    }
    if (value->string) {
        value->string = gone;
        read_damaged(root);
        *value = kept;
    }
    damage(root, value);
}

static void damage(const cJSON *root, cJSON *value)
{
    for (cJSON *item = value->child; item; item = item->next)
        damage_one(root, item);
}

static void damage_file(const char *path)
{
    void *data;
    size_t size;
    assert_int_equal(ng_file_read(path, 0, &data, &size), NG_OK);
    cJSON *root = cJSON_ParseWithLength(data, size);
    assert_non_null(root);
    cJSON_DeleteItemFromObject(root, "buffers"); // long, and not tinygltf's
    cJSON_DeleteItemFromObject(root, "images");
    damage(root, root);
    cJSON_Delete(root);
    free(data);
}

static void test_reads_what_is_damaged(void **state)
{
    NG_UNUSED(state);
    struct test_log log;
    test_log_begin(&log);
    damage_file("tests/files/good/everything.gltf");
    damage_file("tests/files/good/skin.gltf");
    damage_file("tests/files/geometry/morph_weight_1.gltf");
    test_log_end(&log);
}

// ---- many items ------------------------------------------------------------------------------------------
enum { MANY = 2500 }; // of each list: more than are read at a time

static void put_many(struct ng_gltf_writer *w, cJSON *root)
{
    cJSON *nodes = ng_gltf_json_list(w, root, "nodes"), *meshes = ng_gltf_json_list(w, root, "meshes"),
          *animations = ng_gltf_json_list(w, root, "animations");
    int primitive = 0, key = 0;
    for (int i = 0; i < MANY; i++) {
        ng_gltf_json_number(w, ng_gltf_json_append(w, nodes), "mesh", i);
        cJSON *mesh = ng_gltf_json_append(w, meshes), *animation = ng_gltf_json_append(w, animations);
        for (int k = 0; k < i % 4; k++)
            ng_gltf_json_number(w, ng_gltf_json_append(w, ng_gltf_json_list(w, mesh, "primitives")),
                                "material", primitive++);
        for (int k = 0; k < i % 3; k++)
            ng_gltf_json_number(w, ng_gltf_json_append(w, ng_gltf_json_list(w, animation, "samplers")),
                                "input", key++);
    }
}

// Items are read some at a time, and each is in its place.
static void test_reads_many(void **state)
{
    struct ng_gltf_writer w;
    struct gltf_faults faults = {.path = "many"};
    struct gltf_document doc = {0};
    int primitive = 0, key = 0;
    NG_UNUSED(state);
    ng_gltf_writer_init(&w, NULL);
    put_many(&w, w.root);
    char *text = cJSON_PrintUnformatted(w.root);
    assert_int_equal(ng_gltf_json(&faults, text, strlen(text), &doc.arena, &doc.root), NG_OK);
    assert_int_equal(ng_gltf_tables("many", 1 << 30, &doc), NG_OK);
    assert_int_equal(doc.mesh_count, MANY);
    for (int i = 0; i < MANY; i++) {
        assert_int_equal(doc.nodes[i].mesh, i);
        assert_int_equal(doc.meshes[i].primitive_count, i % 4);
        for (int k = 0; k < i % 4; k++)
            assert_int_equal(doc.meshes[i].primitives[k].material, primitive++);
        assert_int_equal(doc.animations[i].sampler_count, i % 3);
        for (int k = 0; k < i % 3; k++)
            assert_int_equal(doc.animations[i].samplers[k].input, key++);
    }
    ng_gltf_faults_finish(&faults);
    ng_arena_finish(&doc.arena);
    cJSON_free(text);
    ng_gltf_writer_finish(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_reads_the_same),
        cmocka_unit_test(test_reads_what_is_damaged),
        cmocka_unit_test(test_reads_many),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

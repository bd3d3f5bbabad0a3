// Furniture catalogues: what their properties say, models fitted to it, pieces placed in scenes, and zips
// that are not what they say. The zips are made here; one test looks at Debian's catalogues where they are
// installed.
#include "scene_maker.h"

#include "asset/catalogue.h"

#include <zip.h>

struct entry {
    const char *name, *text;
    size_t size; // 0: the text's
};

static void make_zip(const char *name, const struct entry *entries, size_t count, char path[256])
{
    test_path(path, 256, name);
    zip_t *zip = zip_open(path, ZIP_CREATE | ZIP_TRUNCATE, NULL);
    assert_non_null(zip);
    for (size_t i = 0; i < count; i++) {
        size_t size = entries[i].size ? entries[i].size : strlen(entries[i].text);
        zip_source_t *source = zip_source_buffer(zip, entries[i].text, size, 0);
        assert_true(zip_file_add(zip, entries[i].name, source, ZIP_FL_OVERWRITE) >= 0);
    }
    assert_int_equal(zip_close(zip), 0);
}
#define MAKE_ZIP(name, path, ...)                                                                            \
    make_zip(name, (const struct entry[]){__VA_ARGS__},                                                      \
             sizeof((const struct entry[]){__VA_ARGS__}) / sizeof(struct entry), path)

#define PROPERTIES "PluginFurnitureCatalog.properties"
// 2 x 4 x 6, not about the origin.
#define BOX                                                                                                  \
    "v 10 0 0\nv 12 0 0\nv 12 4 0\nv 10 4 0\nv 10 0 6\nv 12 0 6\nv 12 4 6\nv 10 4 6\no box\n"                \
    "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 4 1 5 8\n"
#define PIECE                                                                                                \
    "id#1=Test#crate\nname#1=Wooden crate\nmodel#1=/m/crate.obj\nwidth#1=100\ndepth#1=300\nheight#1=50\n"

static const char catalogue_text[] =
    "# a comment\n"
    "! another\n"
    "id=Test\n"
    "name = Things\\u0020of \\u00e9toffe\n"
    "license:CC0\n"
    "provider\\\n  =some\\\n    one\n" PIECE "creator#1=Ann \xc9\n"
    "id#2=Test#turned\nname#2=Turned\nmodel#2=m/crate.obj\nwidth#2=20\ndepth#2=40\nheight#2=60\n"
    "modelRotation#2=1 0 0 0 0 1 0 -1 0\nlicense#2=CC-BY "
    "\\ud83d\\ude00\nelevation#2=150\ndoorOrWindow#2=true\n"
    "id#3=Test#none\nname#3=No model\n"
    "id#70000=x\nmodel#70000=y\ndropOnTopElevation#-1=3\n";

static void make_catalogue(char path[256])
{
    MAKE_ZIP("things.sh3f", path, {PROPERTIES, catalogue_text, 0},
             {"m/crate.obj", "mtllib Crate.mtl\nusemtl wood\n" BOX, 0},
             {"m/crate.mtl", "newmtl wood\nKd 1 0 0\n", 0});
}

static void load_piece(struct loaded *l, const char *path, const char *piece)
{
    char whole[512];
    snprintf(whole, sizeof whole, "%s#%s", path, piece);
    if (load_path(l, whole, NULL) != NG_OK)
        fail_msg("%s", l->log.text);
}

static void test_properties(void **state)
{
    NG_UNUSED(state);
    char path[256];
    struct test_log log;
    struct ng_catalogue *c;
    make_catalogue(path);
    test_log_begin(&log);
    assert_int_equal(ng_catalogue_open(path, 0, &c), NG_OK);
    test_log_end(&log);
    assert_int_equal(log.warnings, 2); // number 3 has no model, 70000 is beyond
    assert_true(ng_catalogue_is(path));
    assert_string_equal(c->name, "Things of \xc3\xa9toffe");
    assert_string_equal(c->license, "CC0");
    assert_string_equal(c->provider, "someone");
    assert_int_equal(c->piece_count, 2);
    const struct ng_piece *p = &c->pieces[0];
    assert_string_equal(p->creator, "Ann \xc3\x89");
    assert_string_equal(p->license, "CC0");
    assert_string_equal(p->model, "m/crate.obj");
    assert_true(p->size[0] == 1 && p->size[1] == 0.5f && p->size[2] == 3);
    p = &c->pieces[1];
    assert_string_equal(p->license, "CC-BY \xf0\x9f\x98\x80");
    assert_true(p->elevation == 1.5f && p->door_or_window && !p->movable);
    assert_ptr_equal(ng_catalogue_find(c, "test#TURNED"), p);
    assert_ptr_equal(ng_catalogue_find(c, "turned"), p);
    assert_ptr_equal(ng_catalogue_find(c, "2"), p);
    assert_ptr_equal(ng_catalogue_find(c, "wooden crate"), &c->pieces[0]);
    assert_null(ng_catalogue_find(c, "3"));
    assert_null(ng_catalogue_find(c, ""));
    ng_catalogue_destroy(&c);
    ng_catalogue_destroy(&c);
}

static void test_fit(void **state)
{
    NG_UNUSED(state);
    // The second stands on what was its back: y along z, z along -y.
    static const struct {
        const char *name;
        float size[3];
    } pieces[] = {{"crate", {1, 0.5f, 3}}, {"Test#turned", {0.2f, 0.6f, 0.4f}}};
    for (size_t i = 0; i < NG_COUNT(pieces); i++) {
        char path[256];
        struct loaded l;
        make_catalogue(path);
        load_piece(&l, path, pieces[i].name);
        const float *size = pieces[i].size;
        for (int k = 0; k < 3; k++) {
            float low = k == 1 ? 0 : -size[k] / 2;
            assert_true(fabsf(l.scene.bounds_min[k] - low) < 1e-5f);
            assert_true(fabsf(l.scene.bounds_max[k] - low - size[k]) < 1e-5f);
        }
        const struct ng_material *m = material_of(&l, "wood");
        assert_true(m->base_color[0] == 1 && m->base_color[1] == 0); // whose library differs in case
        finish(&l);
    }
}

static void test_place(void **state)
{
    NG_UNUSED(state);
    char path[256];
    struct loaded l;
    struct ng_catalogue *c;
    struct test_log log;
    make_catalogue(path);
    test_log_begin(&log);
    assert_int_equal(ng_catalogue_open(path, 0, &c), NG_OK);
    test_log_end(&log);
    begin_world(&l);
    ng_entity room = ng_entity_create(l.world), first = ng_entity_create(l.world);
    assert_int_equal(ng_world_set_parent(l.world, first, room, (ng_entity){0}), NG_OK);
    size_t memory = ng_assets_memory(l.assets);
    for (int i = 0; i < 2; i++)
        assert_int_equal(ng_catalogue_place(c, &c->pieces[i], l.world, l.assets, room, NULL, &l.scene),
                         NG_OK);
    assert_true(ng_world_last_child(l.world, room).id == l.scene.root.id);
    assert_true(ng_world_first_child(l.world, room).id == first.id);
    assert_true(ng_world_has(l.world, l.scene.root, NG_TRANSFORM));
    assert_true(ng_entity_is_null(l.scene.camera) && ng_entity_is_null(l.scene.sky));
    for (ng_entity e = room; !ng_entity_is_null(e); e = ng_world_next_below(l.world, room, e))
        assert_false(ng_world_has(l.world, e, NG_SCENE_SCALE) || ng_world_has(l.world, e, NG_CAMERA));
    // One that fails leaves nothing.
    struct ng_piece bad = c->pieces[0];
    uint32_t entities = ng_world_entity_count(l.world);
    size_t used = ng_assets_memory(l.assets);
    bad.model = "m/none.obj";
    test_log_begin(&log);
    assert_int_equal(ng_catalogue_place(c, &bad, l.world, l.assets, room, NULL, &l.scene),
                     NG_ERROR_NOT_FOUND);
    test_log_end(&log);
    assert_int_equal(log.errors, 1);
    assert_int_equal(ng_world_entity_count(l.world), entities);
    assert_int_equal(ng_assets_memory(l.assets), used);
    assert_true(used > memory);
    ng_catalogue_destroy(&c);
    finish(&l);
}

// ---- what is refused -------------------------------------------------------------------------------------
static void refused(const char *path, ng_result result, const char *message)
{
    struct loaded l;
    assert_int_equal(load_path(&l, path, NULL), result);
    if (l.log.errors != 1 || !strstr(l.log.text, message))
        fail_msg("\"%s\" where \"%s\" was expected", l.log.text, message);
    assert_int_equal(ng_world_entity_count(l.world), 0);
    finish(&l);
}

static void test_refused(void **state)
{
    NG_UNUSED(state);
    char path[256], whole[300];
    make_catalogue(path);
    refused(path, NG_ERROR_NOT_FOUND, "is a catalogue of 2 pieces; name one");
    snprintf(whole, sizeof whole, "%s#sofa", path);
    refused(whole, NG_ERROR_NOT_FOUND, "has no piece \"sofa\"");
    MAKE_ZIP("a.zip", path, {"readme.txt", "hello", 0});
    refused(path, NG_ERROR_FORMAT, "is a zip file, but no furniture catalogue");
    MAKE_ZIP("b.sh3f", path, {PROPERTIES, PIECE, 0}, {"m/crate.obj", "PK no model", 0});
    refused(path, NG_ERROR_UNSUPPORTED, "is no OBJ file");
    MAKE_ZIP("c.sh3f", path, {PROPERTIES, PIECE "model#1=/m/../../../etc/passwd\n", 0});
    refused(path, NG_ERROR_FORMAT, "is not a file in its model's folder");
    MAKE_ZIP("d.sh3f", path, {PROPERTIES, "name=empty\n", 0});
    refused(path, NG_ERROR_NOT_FOUND, "is a catalogue of 0 pieces");
    MAKE_ZIP("e.sh3f", path, {PROPERTIES, PIECE "width#1=nan\n", 0});
    struct loaded l;
    assert_int_equal(load_path(&l, path, NULL), NG_ERROR_NOT_FOUND);
    finish(&l);
    put_file("f.gltf", "{}", 2, path);
    snprintf(whole, sizeof whole, "%s#x", path);
    refused(whole, NG_ERROR_FORMAT, "is no furniture catalogue, so it has no piece \"x\"");
}

// A name with "#" in it is a file first of all.
static void test_names(void **state)
{
    NG_UNUSED(state);
    char path[256], file[256], whole[300];
    const char *piece;
    put_file("a#b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", 32, path);
    struct loaded l;
    assert_int_equal(load_path(&l, path, NULL), NG_OK);
    finish(&l);
    assert_false(ng_catalogue_split(path, file, sizeof file, &piece));
    snprintf(whole, sizeof whole, "%s#c#d", path);
    assert_true(ng_catalogue_split(whole, file, sizeof file, &piece));
    assert_string_equal(file, path);
    assert_string_equal(piece, "c#d");
    assert_false(ng_catalogue_split("none#x", file, sizeof file, &piece));
    assert_false(ng_catalogue_split("#x", file, sizeof file, &piece));
}

static void test_bombs(void **state)
{
    NG_UNUSED(state);
    char path[256];
    size_t size = (size_t)64 << 20;
    char *zeros = calloc(1, size);
    assert_non_null(zeros);
    MAKE_ZIP("bomb.sh3f", path, {PROPERTIES, PIECE, 0}, {"m/crate.obj", zeros, size});
    refused(path, NG_ERROR_FORMAT, "that is no model");
    MAKE_ZIP("bomb2.sh3f", path, {PROPERTIES, zeros, size});
    refused(path, NG_ERROR_FORMAT, "that is no model");
    // A picture costs itself.
    MAKE_ZIP("bomb3.sh3f", path, {PROPERTIES, PIECE, 0}, {"m/crate.obj", "mtllib a.mtl\nusemtl a\n" BOX, 0},
             {"m/a.mtl", "newmtl a\nmap_Kd z.png\n", 0}, {"m/z.png", zeros, size});
    struct loaded l;
    assert_int_equal(load_path(&l, path, NULL), NG_OK);
    assert_non_null(strstr(l.log.text, "that is no model; it is drawn without"));
    finish(&l);
    free(zeros);
}

static uint32_t next_random(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

// Cut anywhere, or with some bytes changed: a scene, or one line.
static void test_damage(void **state)
{
    NG_UNUSED(state);
    char path[256], damaged[256];
    void *data;
    size_t size;
    uint32_t random = 1;
    make_catalogue(path);
    assert_int_equal(ng_file_read(path, 0, &data, &size), NG_OK);
    unsigned char *copy = malloc(size);
    assert_non_null(copy);
    for (size_t i = 0; i < size + 400; i++) {
        memcpy(copy, data, size);
        for (int k = 0; i >= size && k < 3; k++)
            copy[next_random(&random) % size] = (unsigned char)next_random(&random);
        struct loaded l;
        put_file("damaged.sh3f", copy, i < size ? i : size, damaged);
        char whole[300];
        snprintf(whole, sizeof whole, "%s#crate", damaged);
        ng_result r = load_path(&l, whole, NULL);
        if (l.log.errors != (r != NG_OK))
            fail_msg("%zu: %s", i, l.log.text);
        finish(&l);
    }
    free(copy);
    free(data);
}

// ---- Debian's --------------------------------------------------------------------------------------------
static void test_installed(void **state)
{
    static const char *const names[] = {"BlendSwap-CC-0", "BlendSwap-CC-BY", "KatorLegaz", "Reallusion",
                                        "Scopia"};
    NG_UNUSED(state);
    for (size_t i = 0; i < NG_COUNT(names); i++) {
        char path[256];
        struct ng_catalogue *c;
        snprintf(path, sizeof path, "/usr/share/sweethome3d/furniture/%s.sh3f", names[i]);
        if (!ng_file_exists(path))
            skip();
        assert_int_equal(ng_catalogue_open(path, 0, &c), NG_OK);
        for (uint32_t k = 0; k < c->piece_count; k += 20) {
            struct loaded l;
            begin_world(&l);
            test_log_begin(&l.log);
            ng_result r =
                ng_catalogue_place(c, &c->pieces[k], l.world, l.assets, (ng_entity){0}, NULL, &l.scene);
            test_log_end(&l.log);
            if (r != NG_OK || l.log.errors || !l.scene.triangle_count)
                fail_msg("%s: %s", c->pieces[k].name, l.log.text);
            finish(&l);
        }
        ng_catalogue_destroy(&c);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_properties), cmocka_unit_test(test_fit),   cmocka_unit_test(test_place),
        cmocka_unit_test(test_refused),    cmocka_unit_test(test_names), cmocka_unit_test(test_bombs),
        cmocka_unit_test(test_damage),
    };
    const struct CMUnitTest installed[] = {cmocka_unit_test(test_installed)};
    if (argc > 1 && strcmp(argv[1], "installed") == 0)
        return cmocka_run_group_tests(installed, NULL, NULL);
    return cmocka_run_group_tests(tests, NULL, NULL);
}

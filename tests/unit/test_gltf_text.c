// What the text of a file holds beyond what the engine knows: numbers that no double holds, characters that
// are none, names that stand twice. It is read as well as can be, and saved as it was.
#define _POSIX_C_SOURCE 200809L
#include "scene_equal.h"

#include "asset/gltf_save.h"
#include "base/file.h"
#include "components/name.h"

static void write_text(char path[512], const char *name, const void *text, size_t size)
{
    test_path(path, 512, name);
    assert_int_equal(ng_file_write(path, text, size), NG_OK);
}

// The name of the first child of the root.
static const char *first_name(const struct scene *s)
{
    ng_entity e = ng_world_first_child(s->world, s->loaded.root);
    const struct ng_name *name = ng_world_get(s->world, e, NG_NAME);
    return name->text;
}

// The text after the first node was renamed and the scene saved; freed by the caller.
static char *saved_text(const char *text, size_t text_size, const char *name)
{
    char path[512], out[512];
    struct scene s;
    void *data;
    size_t size;
    write_text(path, "in.gltf", text, text_size);
    test_path(out, sizeof out, "out.gltf");
    assert_int_equal(scene_load(&s, path, true), NG_OK);
    struct ng_name *edited = ng_world_edit(s.world, ng_world_first_child(s.world, s.loaded.root), NG_NAME);
    snprintf(edited->text, sizeof edited->text, "%s", name);
    const struct ng_gltf_save_params params = {s.world, s.assets, s.loaded.root, s.loaded.origin};
    assert_int_equal(ng_gltf_save(out, &params), NG_OK);
    scene_finish(&s);
    assert_int_equal(scene_load(&s, out, true), NG_OK);
    assert_string_equal(first_name(&s), name);
    scene_finish(&s);
    assert_int_equal(ng_file_read(out, 0, &data, &size), NG_OK);
    return data;
}

static void test_foreign_text_survives(void **state)
{
    static const char *const kept[] = {
        "{\"big\":12345678901234567890,\"neg\":-9007199254740993,\"huge\":1e400,\"tiny\":1e-400}",
        "[0.1, 0.10,1.0 ,-0,-0.0,1E5,1e+5,3.14159265358979323846,9007199254740993]",
        "{\"a\":1,\"a\":2,\"\":\"\",\"n\\u0000\":\"x\\u0000y\",\"lone\":\"\\udc00\",\"half\":\"\\ud800x\"}",
        "{\"id\":18446744073709551615, \"text\":\"\\u00e9\\/\\\"]}\",\"deep\":[[[{}]]]}",
        "1e400",
        "\"b\\u0000ad\"",
        "\"h\\ud800\"",
        "9007199254740993",
    };
    char text[2048];
    NG_UNUSED(state);
    int n = snprintf(text, sizeof text,
                     "\xef\xbb\xbf{\"asset\":{\"version\":\"2.0\",\"extras\":%s},\"extras\":%s,"
                     "\"nodes\":[{\"name\":\"a\",\"extras\":%s},{\"name\":%s},{\"name\":%s,\"extras\":%s}],"
                     "\"extensionsUsed\":[\"XYZ_one\"],\"extensions\":{\"XYZ_one\":%s},\"revision\":%s}",
                     kept[0], kept[1], kept[2], kept[5], kept[6], kept[4], kept[3], kept[7]);
    char *saved = saved_text(text, (size_t)n, "renamed");
    for (size_t i = 0; i < NG_COUNT(kept); i++) {
        if (!strstr(saved, kept[i]))
            fprintf(stderr, "%s is not in\n%s\n", kept[i], saved);
        assert_non_null(strstr(saved, kept[i]));
    }
    free(saved);
}

// The last counts, loaded and saved.
static void test_members_of_one_name(void **state)
{
    static const char text[] =
        "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"name\":\"first\",\"mesh\":7,\"name\":\"last\"}],"
        "\"nodes\":[{\"name\":\"x\",\"name\":\"y\",\"scale\":[1,1,1],\"name\":\"z\"}]}";
    char path[512];
    struct scene s;
    NG_UNUSED(state);
    write_text(path, "twice.gltf", text, strlen(text));
    assert_int_equal(scene_load(&s, path, true), NG_OK);
    assert_string_equal(first_name(&s), "z");
    scene_finish(&s);
    char *saved = saved_text(text, strlen(text), "edited");
    assert_null(strstr(saved, "first"));
    assert_null(strstr(saved, "\"x\""));
    assert_null(strstr(saved, "\"z\""));
    free(saved);
}

// The members of an object are found by sorting: of 100,000 too.
static void test_many_members(void **state)
{
    enum { COUNT = 100000 };
    char *text = malloc(COUNT * 16 + 256);
    NG_UNUSED(state);
    size_t n = (size_t)sprintf(text, "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{}]");
    for (int i = 0; i < COUNT; i++)
        n += (size_t)sprintf(text + n, ",\"k%d\":%d", i % (COUNT - 1), i);
    n += (size_t)sprintf(text + n, "}");
    char *saved = saved_text(text, n, "many");
    assert_non_null(strstr(saved, "\"k0\":\t99999"));
    assert_null(strstr(saved, "\"k0\":\t0,"));
    assert_non_null(strstr(saved, "\"k99998\":\t99998"));
    free(saved);
    free(text);
}

// What JSON does not have costs a warning, not the file; a strict load refuses it.
static void test_characters_that_are_none(void **state)
{
    static const struct {
        const char *name, *read;
    } cases[] = {
        {"Stra\xdf"
         "e",
         "Stra\xc3\x9f"
         "e"},
        {"a\tb\nc", "a\tb\nc"},
        {"C:\\oak.png", "C:\\oak.png"},
        {"half\\ud83d", "half\xef\xbf\xbd"},
        {"half\\ude00\\u0041", "half\xef\xbf\xbd"
                               "A"},
        {"cut\xe2\x82", "cut\xc3\xa2\xc2\x82"},
    };
    NG_UNUSED(state);
    for (size_t i = 0; i < NG_COUNT(cases); i++) {
        char path[512], text[256];
        struct scene s;
        struct test_log log;
        int n = snprintf(text, sizeof text, "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"name\":\"%s\"}]}",
                         cases[i].name);
        write_text(path, "characters.gltf", text, (size_t)n);
        test_log_begin(&log);
        ng_result r = scene_load(&s, path, true);
        test_log_end(&log);
        assert_int_equal(r, NG_OK);
        assert_string_equal(first_name(&s), cases[i].read);
        assert_int_equal(log.warnings, 1);
        assert_non_null(strstr(log.text, "they are replaced"));
        struct ng_gltf_scene scene;
        test_log_begin(&log);
        r = ng_gltf_load(path, s.world, s.assets, &(struct ng_gltf_params){.strict = true}, &scene);
        test_log_end(&log);
        assert_int_equal(r, NG_ERROR_FORMAT);
        assert_int_equal(log.errors, 1);
        scene_finish(&s);
    }
}

// Right to left, beyond the basic plane, escaped: all of UTF-8 is as it is.
static void test_characters_that_are_right(void **state)
{
    static const char text[] =
        "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"name\":\"\\ud83d\\ude00 \\u00e9 \xd7"
        "\x90 \xf0\x9f\x98\x80 \\\"\\\\\\/\\b\"}]}";
    char path[512];
    struct scene s;
    struct test_log log;
    NG_UNUSED(state);
    write_text(path, "right.gltf", text, strlen(text));
    test_log_begin(&log);
    assert_int_equal(scene_load(&s, path, true), NG_OK);
    test_log_end(&log);
    assert_int_equal(log.warnings, 0);
    assert_string_equal(first_name(&s), "\xf0\x9f\x98\x80 \xc3\xa9 \xd7\x90 \xf0\x9f\x98\x80 \"\\/\b");
    scene_finish(&s);
}

// A name that a zero cuts short is not the one before the zero.
static void test_keys_with_a_zero(void **state)
{
    static const char text[] = "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"name\":\"a\"}],"
                               "\"nodes\\u0000x\":[{\"name\":\"b\"},{\"name\":\"c\"}]}";
    char path[512];
    struct scene s;
    NG_UNUSED(state);
    write_text(path, "key.gltf", text, strlen(text));
    assert_int_equal(scene_load(&s, path, true), NG_OK);
    assert_string_equal(first_name(&s), "a");
    scene_finish(&s);
    free(saved_text(text, strlen(text), "edited"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_foreign_text_survives),
        cmocka_unit_test(test_members_of_one_name),
        cmocka_unit_test(test_many_members),
        cmocka_unit_test(test_characters_that_are_none),
        cmocka_unit_test(test_characters_that_are_right),
        cmocka_unit_test(test_keys_with_a_zero),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

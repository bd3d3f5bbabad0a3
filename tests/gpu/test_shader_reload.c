// Shaders from a folder of sources: what is drawn follows the files, images that are kept from frame to frame
// too, and nothing changes while a file has an error.
#include "gpu_test.h"

#include "app/shader_reload.h"
#include "app/stage.h"
#include "base/file.h"

#include <stdlib.h>
#include <threads.h>

#define SIZE    64u
#define SOURCES "engine/shaders"

struct rig {
    struct ng_stage *stage;
    struct ng_shader_reload *reload;
    char folder[512];
    uint8_t before[SIZE * SIZE * 4]; // the picture of the shaders that are built in
};

// ---- Files -----------------------------------------------------------------------------------------------

static void path_of(char *out, size_t size, const char *folder, const char *name)
{
    assert_true((size_t)snprintf(out, size, "%s/%s", folder, name) < size);
}

// Copies a source, with the first `from` of it replaced. Returns that one's line.
static unsigned put(const struct rig *r, const char *name, const char *from, const char *to)
{
    char path[1024];
    char *text;
    size_t size;
    path_of(path, sizeof path, SOURCES, name);
    assert_int_equal(ng_file_read(path, 0, (void **)&text, &size), NG_OK);
    const char *at = from ? strstr(text, from) : text;
    assert_non_null(at);
    size_t skipped = from ? strlen(from) : 0, head = (size_t)(at - text), added = to ? strlen(to) : 0;
    char *changed = malloc(size + added + 1);
    assert_non_null(changed);
    snprintf(changed, size + added + 1, "%.*s%s%s", (int)head, text, added ? to : "", at + skipped);
    path_of(path, sizeof path, r->folder, name);
    assert_int_equal(ng_file_write(path, changed, size - skipped + added), NG_OK);
    unsigned line = 1;
    for (size_t i = 0; i < head; i++)
        line += text[i] == '\n';
    free(changed);
    free(text);
    return line;
}

struct copying {
    const struct rig *rig;
    const char *below; // "shared/"
};

static void copy_entry(void *user, const char *name)
{
    const struct copying *c = user;
    const char *e = ng_path_extension(name);
    char path[256];
    assert_true((size_t)snprintf(path, sizeof path, "%s%s", c->below, name) < sizeof path);
    if (strcmp(e, "vert") == 0 || strcmp(e, "frag") == 0 || strcmp(e, "comp") == 0 ||
        strcmp(e, "glsl") == 0 || strcmp(e, "h") == 0)
        put(c->rig, path, NULL, NULL);
}

static void remove_entry(void *user, const char *name)
{
    char path[1024];
    path_of(path, sizeof path, user, name);
    (void)remove(path); // folders with files stay
}

// ---- Pictures --------------------------------------------------------------------------------------------

static const uint8_t *draw(struct rig *r)
{
    static const char *const layers[] = {"display"};
    const uint8_t *rgba;
    uint32_t width, height;
    struct ng_stage_frame frame = {
        .width = SIZE, .height = SIZE, .still = true, .layers = layers, .layer_count = 1};
    assert_int_equal(ng_stage_draw(r->stage, &frame), NG_OK);
    assert_int_equal(ng_renderer_display(r->stage->renderer, &rgba, &width, &height), NG_OK);
    assert_true(width == SIZE && height == SIZE);
    return rgba;
}

static bool is_as_before(struct rig *r)
{
    return memcmp(draw(r), r->before, sizeof r->before) == 0;
}

static bool update(struct rig *r)
{
    const struct timespec moment = {.tv_nsec = 20000000};
    thrd_sleep(&moment, NULL);
    ng_shader_reload_update(r->reload, r->stage->gpu);
    return true;
}

// Until other shaders are drawn with.
static void wait_for_shaders(struct rig *r)
{
    uint64_t before = r->stage->gpu->shaders;
    for (int i = 0; i < 6000 && update(r); i++) // two minutes, on a machine that does something else
        if (r->stage->gpu->shaders != before)
            return;
    fail_msg("the shaders do not change");
}

// Until an error is found, or mended. What is said about it is in `text`.
static void wait_for_error(struct rig *r, bool failed, const char *text)
{
    struct test_log log;
    test_log_begin(&log);
    for (int i = 0; i < 6000 && update(r); i++)
        if (ng_shader_reload_failed(r->reload) == failed)
            break;
    test_log_end(&log);
    assert_int_equal(ng_shader_reload_failed(r->reload), failed);
    assert_int_equal(log.errors, failed);
    if (failed && !strstr(log.text, text))
        fail_msg("'%s' is not in: %s", text, log.text);
}

// The folder begins with all the sources, or with two stages and what may be included.
static void begin(struct rig *r, bool all)
{
    char shared[600];
    *r = (struct rig){0};
    assert_int_equal(
        ng_stage_create(&(struct ng_stage_params){.scene = "content/unit/light_spot.glb"}, &r->stage), NG_OK);
    memcpy(r->before, draw(r), sizeof r->before);
    test_path(r->folder, sizeof r->folder, all ? "all" : "some");
    path_of(shared, sizeof shared, r->folder, "shared");
    assert_int_equal(ng_file_make_directory(r->folder), NG_OK);
    assert_int_equal(ng_file_list(r->folder, remove_entry, r->folder), NG_OK);
    assert_int_equal(ng_file_make_directory(shared), NG_OK);
    assert_int_equal(ng_file_list(SOURCES "/shared", copy_entry, &(struct copying){r, "shared/"}), NG_OK);
    if (all) {
        assert_int_equal(ng_file_list(SOURCES, copy_entry, &(struct copying){r, ""}), NG_OK);
    } else {
        put(r, "tonemap.frag", NULL, NULL);
        put(r, "depth_opaque.vert", NULL, NULL);
        put(r, "depth.vert.glsl", NULL, NULL);
    }
    assert_int_equal(ng_shader_reload_create(r->folder, &r->reload), NG_OK);
    wait_for_shaders(r);
}

static void end(struct rig *r)
{
    uint32_t messages = ng_gpu_validation_messages(r->stage->gpu);
    ng_shader_reload_destroy(&r->reload);
    ng_stage_destroy(&r->stage);
    assert_int_equal(messages, 0);
}

// ---- Tests -----------------------------------------------------------------------------------------------

// Text and code are those of the build, and each shader fits the slots that its pipelines declare.
static void the_sources_draw_what_is_built_in(void **state)
{
    NG_UNUSED(state);
    struct rig r;
    begin(&r, true);
    assert_true(is_as_before(&r));
    end(&r);
}

static void a_changed_shader_changes_the_picture(void **state)
{
    NG_UNUSED(state);
    struct rig r;
    begin(&r, false);
    assert_true(is_as_before(&r));
    put(&r, "tonemap.frag", "out_color.a = 1;", "out_color = out_color.bgra;");
    wait_for_shaders(&r);
    assert_false(is_as_before(&r));
    put(&r, "tonemap.frag", NULL, NULL);
    wait_for_shaders(&r);
    assert_true(is_as_before(&r));
    end(&r);
}

// Depth maps are kept from frame to frame, by their keys: of a scene that rests they are drawn once.
static void what_is_kept_follows_what_is_included(void **state)
{
    NG_UNUSED(state);
    struct rig r;
    begin(&r, false);
    put(&r, "depth.vert.glsl", "gl_Layer = int", "gl_Position.z = gl_Position.w;\n    gl_Layer = int");
    wait_for_shaders(&r);
    assert_false(is_as_before(&r)); // all is in the shadow of what is nearest to the light
    put(&r, "depth.vert.glsl", NULL, NULL);
    wait_for_shaders(&r);
    assert_true(is_as_before(&r));
    end(&r);
}

static void an_error_leaves_the_picture(void **state)
{
    NG_UNUSED(state);
    static const struct {
        const char *file, *from, *to, *said;
        bool in_line; // that is said
    } mistakes[] = {
        {"tonemap.frag", "out_color.a = 1;", "out_color.a = nothing;", "'nothing'", true},
        {"depth.vert.glsl", "vec4 m[3]", "vec5 m[3]", "'vec5'", true},
        {"shared/display.h", "#define", "none\n#define", "/shared/display.h:", false},
        {"tonemap.frag", "#include \"shared/display.h\"", "#include \"missing.glsl\"", "missing.glsl", false},
        {"tonemap.frag", "binding = 7) uniform", "binding = 9) uniform", "set 0, binding 9", false},
        {"tonemap.frag", "scalar) readonly buffer Exposure", "scalar) uniform Exposure", "set 0, binding 6",
         false},
    };
    struct rig r;
    begin(&r, false);
    for (size_t i = 0; i < NG_COUNT(mistakes); i++) {
        char said[128];
        unsigned line = put(&r, mistakes[i].file, mistakes[i].from, mistakes[i].to);
        snprintf(said, sizeof said, "/%s:%u: %s", mistakes[i].file, line, mistakes[i].said);
        wait_for_error(&r, true, mistakes[i].in_line ? said : mistakes[i].said);
        assert_true(is_as_before(&r));
        put(&r, mistakes[i].file, NULL, NULL);
        wait_for_error(&r, false, NULL);
        assert_true(is_as_before(&r));
    }
    end(&r);
}

static void a_file_that_is_included_may_come_later(void **state)
{
    NG_UNUSED(state);
    struct rig r;
    char path[600];
    const char *text = "const float made_later = 0.5;\n";
    begin(&r, false);
    put(&r, "tonemap.frag", "#include \"shared/tonemap.h\"",
        "#include \"shared/tonemap.h\"\n#include \"later.glsl\"\n#define position_map position_map");
    wait_for_error(&r, true, "later.glsl");
    path_of(path, sizeof path, r.folder, "later.glsl");
    assert_int_equal(ng_file_write(path, text, strlen(text)), NG_OK);
    wait_for_error(&r, false, NULL);
    assert_true(is_as_before(&r));
    assert_int_equal(remove(path), 0);
    wait_for_error(&r, true, "later.glsl");
    assert_true(is_as_before(&r));
    end(&r);
}

// A scene that is opened later is drawn with the shaders of the folder, too.
static void pipelines_to_come_are_of_the_same_shaders(void **state)
{
    NG_UNUSED(state);
    struct rig r;
    struct ng_stage *next;
    uint8_t picture[sizeof r.before];
    begin(&r, false);
    put(&r, "tonemap.frag", "out_color.a = 1;", "out_color = out_color.bgra;");
    wait_for_shaders(&r);
    memcpy(picture, draw(&r), sizeof picture);
    struct ng_stage_params params = {.scene = "content/unit/light_spot.glb", .no_device = true};
    assert_int_equal(ng_stage_create(&params, &next), NG_OK);
    assert_int_equal(ng_stage_adopt(r.stage, &next), NG_OK);
    assert_memory_equal(draw(&r), picture, sizeof picture);
    end(&r);
}

static void a_folder_without_shaders_is_refused(void **state)
{
    NG_UNUSED(state);
    struct ng_shader_reload *reload;
    struct test_log log;
    test_log_begin(&log);
    assert_int_equal(ng_shader_reload_create("content/unit", &reload), NG_ERROR_NOT_FOUND);
    assert_null(reload);
    assert_int_not_equal(ng_shader_reload_create("no/such/folder", &reload), NG_OK);
    assert_null(reload);
    test_log_end(&log);
    assert_int_equal(log.errors, 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_sources_draw_what_is_built_in),
        cmocka_unit_test(a_changed_shader_changes_the_picture),
        cmocka_unit_test(what_is_kept_follows_what_is_included),
        cmocka_unit_test(an_error_leaves_the_picture),
        cmocka_unit_test(a_file_that_is_included_may_come_later),
        cmocka_unit_test(pipelines_to_come_are_of_the_same_shaders),
        cmocka_unit_test(a_folder_without_shaders_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

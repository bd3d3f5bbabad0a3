// All methods of the table in one renderer.
#include "neural_test.h"

#include "lightformer/methods/methods.h"

static ng_result create(const struct room *r, const struct method *m, const char *name, bool optional,
                        const char *weights, struct lf_method **out)
{
    return lf_method_create(&(struct lf_method_params){.name = name,
                                                       .composer = ng_renderer_composer(m->renderer),
                                                       .jobs = r->scene.jobs,
                                                       .scene = "nowhere.glb",
                                                       .weights = weights,
                                                       .optional = optional,
                                                       .samples = 1},
                            out);
}

static void open_room(struct room *r, struct method *m)
{
    room_open(r, POINT);
    *m = (struct method){0};
    OK(ng_renderer_create(&(struct ng_renderer_params){.gpu = r->gpu, .jobs = r->scene.jobs}, &m->renderer));
    scene_frame(&r->scene, 0);
}

static void close_room(struct room *r, struct method *m)
{
    ng_renderer_destroy(&m->renderer);
    room_close(r);
}

// What a frame of a method says of a layer.
static ng_result draw(const struct room *r, struct method *m, const char *name, const char *layer)
{
    const struct ng_render_params params = {.snapshot = r->scene.snapshot,
                                            .width = r->width,
                                            .height = r->height,
                                            .method = name,
                                            .layers = &layer,
                                            .layer_count = 1};
    struct ng_cmd *cmd;
    OK(ng_frame_begin(r->gpu, &cmd));
    ng_result drawn = ng_renderer_frame(m->renderer, &cmd, &params);
    OK(ng_frame_end(r->gpu, &cmd));
    return drawn;
}

// A frame of the method, in which it makes the layer.
static void expect_layer(const struct room *r, struct method *m, const char *name, const char *layer)
{
    OK(draw(r, m, name, layer));
    free(room_layer(r, m, layer));
}

// Nobody makes anything, or the method not this.
static void expect_no_layer(const struct room *r, struct method *m, const char *name)
{
    struct ng_layer layer;
    struct test_log log;
    test_log_begin(&log);
    assert_true(draw(r, m, name, "indirect") != NG_OK ||
                ng_renderer_layer(m->renderer, "indirect", &layer) != NG_OK);
    test_log_end(&log);
    assert_int_equal(log.errors, 1);
    assert_non_null(strstr(log.text, name));
}

static void each_name_is_found(void **state)
{
    NG_UNUSED(state);
    for (uint32_t i = 0; i < LF_METHODS; i++) {
        assert_string_equal(lf_method_info(i)->name, lf_method_name(i));
        assert_int_equal(lf_method_find(lf_method_name(i)), i);
    }
    assert_null(lf_method_info(LF_METHODS));
    assert_null(lf_method_name(LF_METHODS));
    assert_int_equal(lf_method_find("nothing"), LF_METHOD_NONE);
}

// Beside each other, each until it is destroyed; then they may come again.
static void a_renderer_takes_all_and_lets_them_go(void **state)
{
    NG_UNUSED(state);
    struct room r;
    struct method m;
    open_room(&r, &m);
    for (int turn = 0; turn < 2; turn++) {
        struct lf_method *all[LF_METHODS];
        for (uint32_t i = 0; i < LF_METHODS; i++)
            OK(create(&r, &m, lf_method_name(i), false, r.weights, &all[i]));
        for (uint32_t i = 0; i < LF_METHODS; i++) {
            const struct lf_method_info *info = lf_method_info(i);
            expect_layer(&r, &m, info->name, info->indirect ? "indirect" : "direct");
            assert_int_equal(lf_method_neural(all[i]) != NULL, strcmp(info->name, "neural") == 0);
            assert_true(info->progressive || !lf_method_progress_of(all[i]).unfinished);
        }
        for (uint32_t i = 0; i < LF_METHODS; i++)
            lf_method_destroy(&all[i]);
        expect_no_layer(&r, &m, "neural");
        expect_no_layer(&r, &m, "reference");
    }
    close_room(&r, &m);
}

static void a_progressive_picture_gets_finished(void **state)
{
    NG_UNUSED(state);
    struct room r;
    struct method m;
    struct lf_method *reference;
    char text[128];
    open_room(&r, &m);
    OK(create(&r, &m, "reference", false, NULL, &reference));
    do
        OK(draw(&r, &m, "reference", "beauty"));
    while (lf_method_progress_of(reference).unfinished);
    assert_int_equal(lf_method_progress_of(reference).samples, 1);
    lf_method_describe(reference, text, sizeof text);
    assert_non_null(strstr(text, "1 spp"));
    lf_method_destroy(&reference);
    close_room(&r, &m);
}

// It joins, says so, and computes nothing, until a real one takes its place.
static void without_weights_neural_may_stand_by(void **state)
{
    NG_UNUSED(state);
    struct room r;
    struct method m;
    struct lf_method *neural;
    char text[128];
    open_room(&r, &m);
    OK(create(&r, &m, "neural", true, NULL, &neural));
    assert_null(lf_method_neural(neural));
    lf_method_describe(neural, text, sizeof text);
    assert_string_equal(text, "no weights");
    expect_no_layer(&r, &m, "neural");
    lf_method_destroy(&neural);
    OK(create(&r, &m, "neural", true, r.weights, &neural));
    expect_layer(&r, &m, "neural", "indirect");
    lf_method_destroy(&neural);
    close_room(&r, &m);
}

static void what_cannot_join_is_said(void **state)
{
    NG_UNUSED(state);
    struct room r;
    struct method m;
    struct test_log log;
    struct lf_method *method;
    open_room(&r, &m);
    test_log_begin(&log);
    assert_int_equal(create(&r, &m, "magic", true, NULL, &method), NG_ERROR_NOT_FOUND);
    assert_non_null(strstr(log.text, "\"magic\""));
    assert_null(method);
    assert_int_equal(create(&r, &m, "neural", false, NULL, &method), NG_ERROR_NOT_FOUND);
    assert_non_null(strstr(log.text, "nowhere.glb"));
    assert_null(method);
    assert_int_equal(create(&r, &m, "neural", true, "nowhere.safetensors", &method), NG_ERROR_NOT_FOUND);
    assert_null(method);
    test_log_end(&log);
    assert_int_equal(log.errors, 3);
    OK(create(&r, &m, "neural", false, r.weights, &method)); // nothing was left behind
    lf_method_destroy(&method);
    close_room(&r, &m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_name_is_found),
        cmocka_unit_test(a_renderer_takes_all_and_lets_them_go),
        cmocka_unit_test(a_progressive_picture_gets_finished),
        cmocka_unit_test(without_weights_neural_may_stand_by),
        cmocka_unit_test(what_cannot_join_is_said),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

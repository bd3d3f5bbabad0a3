// One ray scene for a renderer, whoever traces in it. The linker hands calls that make, update and free
// tracers to the functions below (CMakeLists.txt).
#include "neural_test.h"

#include "lightformer/progressive/progressive.h"
#include "lightformer/trace/ray_scene.h"
#include "scene/world.h"

#define REFERENCE "reference"

static int tracers, updates;

ng_result __real_lf_tracer_create(struct lf_tracer **out);
void __real_lf_tracer_destroy(struct lf_tracer **tracer);
ng_result __real_lf_tracer_update(struct lf_tracer *tracer, const struct ng_snapshot *snapshot);
ng_result __wrap_lf_tracer_create(struct lf_tracer **out);
void __wrap_lf_tracer_destroy(struct lf_tracer **tracer);
ng_result __wrap_lf_tracer_update(struct lf_tracer *tracer, const struct ng_snapshot *snapshot);

ng_result __wrap_lf_tracer_create(struct lf_tracer **out)
{
    ng_result result = __real_lf_tracer_create(out);
    tracers += result == NG_OK;
    return result;
}

void __wrap_lf_tracer_destroy(struct lf_tracer **tracer)
{
    tracers -= *tracer != NULL;
    __real_lf_tracer_destroy(tracer);
}

ng_result __wrap_lf_tracer_update(struct lf_tracer *tracer, const struct ng_snapshot *snapshot)
{
    updates++;
    return __real_lf_tracer_update(tracer, snapshot);
}

// ---- A window --------------------------------------------------------------------------------------------

// A renderer, and who is in it.
struct window {
    struct method method; // `neural` may be null
    struct lf_progressive *progressive;
};

static struct ng_composer *composer_of(const struct window *w)
{
    return ng_renderer_composer(w->method.renderer);
}

static void join_neural(const struct room *r, struct window *w)
{
    OK(lf_neural_create(&(struct lf_neural_params){.weights = r->weights, .jobs = r->scene.jobs},
                        &w->method.neural));
    OK(lf_neural_join(w->method.neural, composer_of(w)));
}

// With a picture of one sample, in slices of a region.
static void join_reference(const struct room *r, struct window *w)
{
    const struct lf_progressive_params params = {.jobs = r->scene.jobs, .samples = 1, .slice = 1e-9};
    OK(lf_progressive_create(&params, &w->progressive));
    OK(lf_progressive_join(w->progressive, composer_of(w)));
}

static void window_open(const struct room *r, struct window *w)
{
    *w = (struct window){0};
    OK(ng_renderer_create(&(struct ng_renderer_params){.gpu = r->gpu, .jobs = r->scene.jobs},
                          &w->method.renderer));
}

static void window_close(struct window *w)
{
    lf_progressive_destroy(&w->progressive);
    method_close(&w->method);
}

// `other`: on the right of a split; null: none.
static ng_result draw(const struct room *r, struct window *w, const char *method, const char *other)
{
    // Without the display nobody would look at the other side.
    static const char *const layers[] = {"unshadowed", "direct", "indirect", "display"};
    const struct ng_render_params params = {
        .snapshot = r->scene.snapshot,
        .width = r->width,
        .height = r->height,
        .method = method,
        .shown = {.comparison = other ? NG_COMPARE_SPLIT : NG_COMPARE_NOTHING,
                  .other_method = other,
                  .divider = 0.5f},
        .layers = layers,
        .layer_count = NG_COUNT(layers)};
    struct ng_cmd *cmd;
    OK(ng_frame_begin(r->gpu, &cmd));
    ng_result drawn = ng_renderer_frame(w->method.renderer, &cmd, &params);
    OK(ng_frame_end(r->gpu, &cmd));
    return drawn;
}

static void draw_reference(const struct room *r, struct window *w, const char *other)
{
    do
        OK(draw(r, w, REFERENCE, other));
    while (!lf_progressive_stats_of(w->progressive).resting);
}

// Compares with a renderer that has never seen anything else.
static void expect_neural(struct room *r, struct window *w, const char *other, const char *after)
{
    struct window alone;
    window_open(r, &alone);
    join_neural(r, &alone);
    OK(draw(r, &alone, LF_NEURAL_METHOD, NULL));
    OK(draw(r, w, LF_NEURAL_METHOD, other));
    assert_same_picture(r, &alone.method, &w->method, after);
    window_close(&alone);
}

static void expect_reference(struct room *r, struct window *w, const char *other, const char *after)
{
    struct window alone;
    window_open(r, &alone);
    join_reference(r, &alone);
    draw_reference(r, &alone, NULL);
    draw_reference(r, w, other);
    assert_same_picture(r, &alone.method, &w->method, after);
    window_close(&alone);
}

static void edit(struct room *r, float step)
{
    room_move(r, r->box, step, 0, 0);
    scene_frame(&r->scene, 0);
}

// ---- Tests -----------------------------------------------------------------------------------------------

static void a_split_view_holds_one_scene(void **state)
{
    NG_UNUSED(state);
    struct room r;
    struct window w;
    room_open(&r, POINT | PANEL);
    int others = tracers;
    window_open(&r, &w);
    assert_int_equal(tracers, others);
    join_neural(&r, &w);
    join_reference(&r, &w);
    assert_int_equal(tracers, others + 1);
    for (int i = 0; i < 3; i++) {
        edit(&r, 0.05f);
        int before = updates;
        OK(draw(&r, &w, LF_NEURAL_METHOD, REFERENCE));
        assert_int_equal(updates, before + 1);
        assert_int_equal(ng_composer_count(composer_of(&w), &lf_ray_scene_item), 1);
    }
    expect_neural(&r, &w, REFERENCE, "edits in a split view");
    expect_reference(&r, &w, LF_NEURAL_METHOD, "edits in a split view");
    int before = updates;
    OK(draw(&r, &w, REFERENCE, LF_NEURAL_METHOD)); // both rest, but the G-buffer is made of rays
    assert_int_equal(updates, before + 1);
    OK(draw(&r, &w, REFERENCE, NULL));
    OK(draw(&r, &w, "raster", NULL));
    assert_int_equal(updates, before + 1);
    window_close(&w);
    assert_int_equal(tracers, others);
    room_close(&r);
}

static void methods_come_and_go(void **state)
{
    NG_UNUSED(state);
    struct room r;
    struct window w;
    room_open(&r, POINT | PANEL);
    int others = tracers;
    window_open(&r, &w);
    scene_frame(&r.scene, 0);
    join_reference(&r, &w);
    expect_reference(&r, &w, NULL, "the start");
    join_neural(&r, &w); // finds a scene that is there
    expect_neural(&r, &w, REFERENCE, "the neural method's coming");
    edit(&r, 0.1f);
    lf_progressive_destroy(&w.progressive); // which came first
    expect_neural(&r, &w, NULL, "the reference's going");
    edit(&r, 0.1f);
    join_reference(&r, &w);
    assert_int_equal(tracers, others + 1);
    expect_reference(&r, &w, LF_NEURAL_METHOD, "the reference's return");
    lf_neural_destroy(&w.method.neural);
    assert_int_equal(tracers, others + 1);
    edit(&r, -0.1f);
    expect_reference(&r, &w, NULL, "the neural method's going");
    lf_progressive_leave(w.progressive);
    assert_int_equal(tracers, others);
    window_close(&w);
    room_close(&r);
}

// With the same scene in front of another renderer it traces in that one's, and begins anew.
static void a_method_may_move_to_another_renderer(void **state)
{
    NG_UNUSED(state);
    struct room r;
    struct window from, to;
    room_open(&r, POINT);
    scene_frame(&r.scene, 0);
    window_open(&r, &from);
    window_open(&r, &to);
    join_reference(&r, &from);
    draw_reference(&r, &from, NULL);
    uint64_t rays = lf_progressive_stats_of(from.progressive).rays;
    to.progressive = from.progressive;
    from.progressive = NULL;
    lf_progressive_leave(to.progressive);
    window_close(&from);
    OK(lf_progressive_join(to.progressive, composer_of(&to)));
    expect_reference(&r, &to, NULL, "a move");
    assert_int_equal(lf_progressive_stats_of(to.progressive).rays, rays);
    window_close(&to);
    room_close(&r);
}

static ng_result trace_nothing(struct ng_composer *composer, void *user)
{
    NG_UNUSED(composer);
    NG_UNUSED(user);
    return NG_OK;
}

// Neither traces through what was there before: one has no picture, the other's stays, and one line says why.
static void a_failed_update_is_seen_by_all(void **state)
{
    NG_UNUSED(state);
    const struct ng_provider miser = {.name = "miser", .produce = trace_nothing};
    struct room r;
    struct window w;
    struct test_log log;
    room_open(&r, POINT | PANEL);
    scene_frame(&r.scene, 0);
    window_open(&r, &w);
    join_neural(&r, &w);
    join_reference(&r, &w);
    draw_reference(&r, &w, LF_NEURAL_METHOD);
    float *good = room_layer(&r, &w.method, "direct");
    OK(lf_ray_scene_register(composer_of(&w), &miser, 10000));
    scene_quad(&r.scene, (const float[3]){-1, 0, 1}, (const float[3]){1, 0, 0}, (const float[3]){0, 1, 0},
               r.red);
    scene_frame(&r.scene, 0);
    test_log_begin(&log);
    assert_int_equal(draw(&r, &w, REFERENCE, LF_NEURAL_METHOD), NG_ERROR_MEMORY);
    test_log_end(&log);
    assert_int_equal(log.errors, 1);
    assert_non_null(strstr(log.text, "ray tracing"));
    assert_true(lf_progressive_stats_of(w.progressive).resting);
    assert_int_equal(lf_progressive_stats_of(w.progressive).rays, 0);
    float *kept = room_layer(&r, &w.method, "direct");
    assert_memory_equal(kept, good, (size_t)r.width * r.height * 3 * sizeof *good);
    OK(draw(&r, &w, REFERENCE, NULL)); // waits for a change
    const struct lf_ray_scene *rays = ng_composer_get(composer_of(&w), &lf_ray_scene_item, 0);
    assert_null(lf_tracer_snapshot(rays->tracer));
    lf_ray_scene_unregister(composer_of(&w), miser.name);
    expect_neural(&r, &w, NULL, "a failed update");
    edit(&r, 0.1f);
    expect_reference(&r, &w, LF_NEURAL_METHOD, "a failed update");
    free(kept);
    free(good);
    window_close(&w);
    room_close(&r);
}

// Of limits the least counts, while those who set it are there; 0 is none.
static void the_least_limit_counts(void **state)
{
    NG_UNUSED(state);
    static const uint64_t limits[] = {0, UINT64_MAX, 10000, 1u << 30};
    static const char *const names[] = {"a", "b", "c", "d"};
    struct room r;
    struct window w;
    room_open(&r, POINT);
    scene_frame(&r.scene, 0);
    for (uint32_t out = 0; out <= NG_COUNT(limits); out++) {
        window_open(&r, &w);
        join_neural(&r, &w);
        for (uint32_t i = 0; i < NG_COUNT(limits); i++) {
            const struct ng_provider p = {.name = names[i], .produce = trace_nothing};
            OK(lf_ray_scene_register(composer_of(&w), &p, limits[i]));
        }
        if (out < NG_COUNT(limits))
            lf_ray_scene_unregister(composer_of(&w), names[out]);
        struct test_log log;
        test_log_begin(&log);
        assert_int_equal(draw(&r, &w, LF_NEURAL_METHOD, NULL), out == 2 ? NG_OK : NG_ERROR_MEMORY);
        test_log_end(&log);
        for (uint32_t i = 0; i < NG_COUNT(limits); i++)
            lf_ray_scene_unregister(composer_of(&w), names[i]);
        window_close(&w);
    }
    room_close(&r);
}

static void a_refused_provider_leaves_nothing(void **state)
{
    NG_UNUSED(state);
    const struct ng_provider twice = {.name = "raster", .produce = trace_nothing};
    struct room r;
    struct window w;
    struct test_log log;
    room_open(&r, POINT);
    int others = tracers;
    window_open(&r, &w);
    test_log_begin(&log);
    assert_int_equal(lf_ray_scene_register(composer_of(&w), &twice, 0), NG_ERROR_USAGE);
    test_log_end(&log);
    assert_int_equal(log.errors, 1);
    assert_int_equal(tracers, others);
    assert_null(ng_composer_find(composer_of(&w), "trace"));
    assert_non_null(ng_composer_find(composer_of(&w), "raster"));
    window_close(&w);
    room_close(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_split_view_holds_one_scene),
        cmocka_unit_test(methods_come_and_go),
        cmocka_unit_test(a_method_may_move_to_another_renderer),
        cmocka_unit_test(a_failed_update_is_seen_by_all),
        cmocka_unit_test(the_least_limit_counts),
        cmocka_unit_test(a_refused_provider_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

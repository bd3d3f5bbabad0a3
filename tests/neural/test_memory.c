// Memory of a frame: one like those before allocates nothing; where an allocation fails, one line says so,
// and the next frame is right. The linker hands this program's own calls to the functions below
// (CMakeLists.txt); those of the driver and of Embree are theirs.
#include "neural_test.h"

#include <stdatomic.h>

static atomic_uint calls, fail_at; // fail_at: the number of the call that fails; 0: none
static atomic_bool watching;

static bool refused(void)
{
    return watching && ++calls == fail_at;
}

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *old, size_t size);
void *__real_aligned_alloc(size_t alignment, size_t size);
FILE *__real_fopen(const char *path, const char *mode);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *old, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);
FILE *__wrap_fopen(const char *path, const char *mode);

void *__wrap_malloc(size_t size)
{
    return refused() ? NULL : __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size)
{
    return refused() ? NULL : __real_calloc(count, size);
}

void *__wrap_realloc(void *old, size_t size)
{
    return refused() ? NULL : __real_realloc(old, size);
}

void *__wrap_aligned_alloc(size_t alignment, size_t size)
{
    return refused() ? NULL : __real_aligned_alloc(alignment, size);
}

// Counts as well: a frame reads no file.
FILE *__wrap_fopen(const char *path, const char *mode)
{
    return refused() ? NULL : __real_fopen(path, mode);
}

static void watch(unsigned fail)
{
    calls = 0;
    fail_at = fail;
    watching = true;
}

static unsigned end_watch(void)
{
    watching = false;
    return calls;
}

// Back and forth: what is needed is known after one round.
static void move_all(struct room *r, int frame)
{
    static const float steps[4] = {0.05f, 0.1f, -0.05f, -0.1f};
    float step = steps[frame % 4];
    room_move(r, r->box, step, 0, 0);
    room_move(r, r->ball, 0, step, 0);
    room_move(r, r->point, 0, 0, step);
    room_move(r, r->scene.camera, step, step, 0);
    room_set(r, r->panel, "light_rectangle.radiance", 9 + step);
}

static void expect_no_allocation(const struct lf_neural_params *params)
{
    enum { ROUND = 4 };
    struct room r;
    struct method m;
    room_open(&r, POINT | PANEL | SPOT);
    method_open(&r, params, &m);
    for (int i = 0; i < 4 * ROUND; i++) {
        if (i == 3 * ROUND)
            watch(0);
        move_all(&r, i);
        room_draw(&r, &m);
    }
    assert_int_equal(end_watch(), 0);
    method_close(&m);
    room_close(&r);
}

static void a_frame_allocates_nothing(void **state)
{
    NG_UNUSED(state);
    expect_no_allocation(NULL);
}

static void a_frame_with_maps_allocates_nothing(void **state)
{
    NG_UNUSED(state);
    expect_no_allocation(&(struct lf_neural_params){.rsm = LF_RSM_MAPS});
}

// Draws the first picture of a new method, in which the n-th allocation fails. Whether there were so many.
static bool fail_once(struct room *r, struct method *m, unsigned n)
{
    struct test_log log;
    OK(lf_neural_create(
        &(struct lf_neural_params){.weights = r->weights, .jobs = r->scene.jobs, .memory_limit = UINT64_MAX},
        &m->neural));
    OK(lf_neural_join(m->neural, ng_renderer_composer(m->renderer)));
    test_log_begin(&log);
    watch(n);
    ng_result result = room_draw_again(r, m);
    bool failed = end_watch() >= n;
    test_log_end(&log);
    if ((result != NG_OK) != failed || log.errors != failed)
        fail_msg("allocation %u: %s, %d lines: %s", n, ng_result_text(result), log.errors, log.text);
    OK(room_draw_again(r, m));
    return failed;
}

static void a_failed_allocation_costs_one_frame(void **state)
{
    NG_UNUSED(state);
    struct room r;
    struct method good, bad;
    room_open(&r, POINT | PANEL);
    method_open(&r, NULL, &good);
    method_open(&r, NULL, &bad);
    room_draw(&r, &good);
    OK(room_draw_again(&r, &bad)); // what the renderer needs, it has
    unsigned n = 1;
    for (bool failed = true; failed; n++) {
        lf_neural_destroy(&bad.neural);
        failed = fail_once(&r, &bad, n);
        assert_same_picture(&r, &good, &bad, "a failed allocation");
    }
    assert_true(n > 10);
    method_close(&bad);
    method_close(&good);
    room_close(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_frame_allocates_nothing),
        cmocka_unit_test(a_frame_with_maps_allocates_nothing),
        cmocka_unit_test(a_failed_allocation_costs_one_frame),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

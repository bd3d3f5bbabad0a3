// The render graph without a device: each mistake is told with pass and resource, culling, what plans
// contain, dumps, providers. Barriers and memory are checked by test_graph_hazards.c.
#include "test.h"

#include "gpu/buffer.h"
#include "gpu/image.h"
#include "graph/graph.h"
#include "graph/plan.h"
#include "graph/provider.h"

static ng_result nothing(const struct ng_pass_context *ctx)
{
    NG_UNUSED(ctx);
    return NG_OK;
}

static struct ng_graph *make_graph(void)
{
    struct ng_graph *g = NULL;
    assert_int_equal(ng_graph_create(NULL, &g), NG_OK);
    return g;
}

static struct ng_graph_ref color(struct ng_graph *g, const char *name)
{
    return ng_graph_add_image(g, name,
                              &(struct ng_graph_image_params){
                                  .format = VK_FORMAT_R8G8B8A8_UNORM, .width = 64, .height = 32, .mips = 3});
}

static struct ng_graph_ref depth(struct ng_graph *g, const char *name)
{
    return ng_graph_add_image(
        g, name, &(struct ng_graph_image_params){.format = VK_FORMAT_D32_SFLOAT, .width = 64, .height = 32});
}

static struct ng_graph_ref buffer(struct ng_graph *g, const char *name)
{
    return ng_graph_add_buffer(g, name, &(struct ng_graph_buffer_params){.size = 256});
}

static struct ng_pass *pass(struct ng_graph *g, const char *name, enum ng_pass_kind kind)
{
    return ng_graph_add_pass(
        g, &(struct ng_pass_params){.name = name, .kind = kind, .run = nothing, .width = 8, .height = 8});
}

// ---- Mistakes ------------------------------------------------------------------------------------------

static void stale_read(struct ng_graph *g)
{
    struct ng_graph_ref a = buffer(g, "points");
    a = ng_pass_write(pass(g, "first", NG_PASS_COMPUTE), a, NG_USE_STORAGE_WRITE);
    ng_pass_write(pass(g, "second", NG_PASS_COMPUTE), a, NG_USE_STORAGE_WRITE);
    ng_pass_read(pass(g, "late", NG_PASS_COMPUTE), a, NG_USE_STORAGE_READ);
}

static void two_writers(struct ng_graph *g)
{
    struct ng_graph_ref a = buffer(g, "points");
    ng_pass_write(pass(g, "first", NG_PASS_COMPUTE), a, NG_USE_STORAGE_WRITE);
    ng_pass_write(pass(g, "second", NG_PASS_COMPUTE), a, NG_USE_STORAGE_WRITE);
}

static void read_before_write(struct ng_graph *g)
{
    ng_pass_read(pass(g, "eager", NG_PASS_COMPUTE), buffer(g, "points"), NG_USE_UNIFORM);
}

static void update_before_write(struct ng_graph *g)
{
    ng_pass_write(pass(g, "count", NG_PASS_COMPUTE), buffer(g, "points"), NG_USE_STORAGE_READ_WRITE);
}

static void cycle_by_after(struct ng_graph *g)
{
    struct ng_pass *first = pass(g, "first", NG_PASS_COMPUTE);
    struct ng_graph_ref a = ng_pass_write(first, buffer(g, "points"), NG_USE_STORAGE_WRITE);
    ng_pass_read(pass(g, "second", NG_PASS_COMPUTE), a, NG_USE_STORAGE_READ);
    ng_pass_after(first, "second");
}

static void after_itself(struct ng_graph *g)
{
    ng_pass_after(pass(g, "first", NG_PASS_COMPUTE), "first");
}

static void after_nobody(struct ng_graph *g)
{
    ng_pass_after(pass(g, "first", NG_PASS_COMPUTE), "ghost");
}

static void color_to_depth_format(struct ng_graph *g)
{
    ng_pass_write(pass(g, "draw", NG_PASS_RASTER), depth(g, "z"), NG_USE_COLOR);
}

static void depth_to_color_format(struct ng_graph *g)
{
    ng_pass_write(pass(g, "draw", NG_PASS_RASTER), color(g, "picture"), NG_USE_DEPTH);
}

static void storage_of_depth(struct ng_graph *g)
{
    ng_pass_write(pass(g, "fill", NG_PASS_COMPUTE), depth(g, "z"), NG_USE_STORAGE_WRITE);
}

static void vertex_of_image(struct ng_graph *g)
{
    ng_pass_read(pass(g, "draw", NG_PASS_RASTER), color(g, "picture"), NG_USE_VERTEX);
}

static void sampled_buffer(struct ng_graph *g)
{
    ng_pass_read(pass(g, "draw", NG_PASS_RASTER), buffer(g, "points"), NG_USE_SAMPLED);
}

static void color_in_compute(struct ng_graph *g)
{
    ng_pass_write(pass(g, "fill", NG_PASS_COMPUTE), color(g, "picture"), NG_USE_COLOR);
}

static void host_in_raster(struct ng_graph *g)
{
    ng_pass_write(pass(g, "draw", NG_PASS_RASTER), buffer(g, "points"), NG_USE_HOST_WRITE);
}

static void sampled_on_cpu(struct ng_graph *g)
{
    ng_pass_read(pass(g, "think", NG_PASS_CPU), color(g, "picture"), NG_USE_SAMPLED);
}

static void present_by_pass(struct ng_graph *g)
{
    ng_pass_read(pass(g, "draw", NG_PASS_RASTER), color(g, "picture"), NG_USE_PRESENT);
}

static void read_by_write_word(struct ng_graph *g)
{
    ng_pass_read(pass(g, "fill", NG_PASS_COMPUTE), buffer(g, "points"), NG_USE_STORAGE_WRITE);
}

static void write_by_read_word(struct ng_graph *g)
{
    ng_pass_write(pass(g, "fill", NG_PASS_COMPUTE), buffer(g, "points"), NG_USE_UNIFORM);
}

static void unequal_attachments(struct ng_graph *g)
{
    struct ng_pass *p = pass(g, "draw", NG_PASS_RASTER);
    ng_pass_write(p, color(g, "picture"), NG_USE_COLOR);
    struct ng_graph_ref small = ng_graph_add_image(
        g, "small", &(struct ng_graph_image_params){.format = VK_FORMAT_D32_SFLOAT, .width = 8, .height = 8});
    ng_pass_write(p, small, NG_USE_DEPTH);
}

static void nine_colors(struct ng_graph *g)
{
    static const char *const names[] = {"c0", "c1", "c2", "c3", "c4", "c5", "c6", "c7", "c8"};
    struct ng_pass *p = pass(g, "draw", NG_PASS_RASTER);
    for (size_t i = 0; i < NG_COUNT(names); i++)
        ng_pass_write(p, color(g, names[i]), NG_USE_COLOR);
}

static void no_render_area(struct ng_graph *g)
{
    ng_graph_add_pass(
        g, &(struct ng_pass_params){.name = "draw", .kind = NG_PASS_RASTER, .run = nothing, .flags = 1});
}

static void zero_ref(struct ng_graph *g)
{
    ng_pass_read(pass(g, "draw", NG_PASS_RASTER), (struct ng_graph_ref){0}, NG_USE_SAMPLED);
}

static void ref_of_last_frame(struct ng_graph *g)
{
    struct ng_graph_ref old = buffer(g, "points");
    ng_graph_begin(g);
    buffer(g, "points");
    ng_pass_write(pass(g, "fill", NG_PASS_COMPUTE), old, NG_USE_STORAGE_WRITE);
}

static void read_and_write(struct ng_graph *g)
{
    struct ng_graph_ref a =
        ng_pass_write(pass(g, "fill", NG_PASS_COMPUTE), color(g, "picture"), NG_USE_STORAGE_WRITE);
    struct ng_pass *p = pass(g, "blur", NG_PASS_COMPUTE);
    ng_pass_read(p, a, NG_USE_SAMPLED);
    ng_pass_write(p, a, NG_USE_STORAGE_WRITE);
}

static void written_twice(struct ng_graph *g)
{
    struct ng_pass *p = pass(g, "blur", NG_PASS_COMPUTE);
    struct ng_graph_ref a = ng_pass_write(p, buffer(g, "points"), NG_USE_STORAGE_WRITE);
    ng_pass_write(p, a, NG_USE_STORAGE_WRITE);
}

static void two_layouts(struct ng_graph *g)
{
    struct ng_graph_ref a =
        ng_pass_write(pass(g, "fill", NG_PASS_COMPUTE), color(g, "picture"), NG_USE_STORAGE_WRITE);
    struct ng_pass *p = pass(g, "blur", NG_PASS_COMPUTE);
    ng_pass_read(p, a, NG_USE_SAMPLED);
    ng_pass_read(p, a, NG_USE_STORAGE_READ);
}

static void history_written(struct ng_graph *g)
{
    struct ng_graph_ref h =
        ng_graph_history_buffer(g, "points", &(struct ng_graph_buffer_params){.size = 256}, NULL);
    ng_pass_write(pass(g, "fill", NG_PASS_COMPUTE), h, NG_USE_STORAGE_WRITE);
}

static void history_differs(struct ng_graph *g)
{
    buffer(g, "points");
    ng_graph_history_buffer(g, "points", &(struct ng_graph_buffer_params){.size = 128}, NULL);
    pass(g, "fill", NG_PASS_COMPUTE);
}

static void history_of_persistent(struct ng_graph *g)
{
    const struct ng_graph_buffer_params params = {.size = 128};
    ng_graph_persistent_buffer(g, "points", &params, NULL);
    ng_graph_history_buffer(g, "points", &params, NULL);
}

static void exported_then_written(struct ng_graph *g)
{
    struct ng_graph_ref a =
        ng_pass_write(pass(g, "first", NG_PASS_COMPUTE), buffer(g, "points"), NG_USE_STORAGE_WRITE);
    ng_graph_export(g, a);
    ng_pass_write(pass(g, "second", NG_PASS_COMPUTE), a, NG_USE_STORAGE_WRITE);
}

static void part_out_of_range(struct ng_graph *g)
{
    ng_pass_write_part(pass(g, "draw", NG_PASS_RASTER), color(g, "picture"), NG_USE_COLOR,
                       &(struct ng_graph_part){.mip = 3});
}

static void layers_out_of_range(struct ng_graph *g)
{
    ng_pass_write_part(pass(g, "draw", NG_PASS_RASTER), color(g, "picture"), NG_USE_COLOR,
                       &(struct ng_graph_part){.layer_count = UINT32_MAX});
}

static void resource_twice(struct ng_graph *g)
{
    buffer(g, "points");
    color(g, "points");
}

static void pass_twice(struct ng_graph *g)
{
    pass(g, "draw", NG_PASS_RASTER);
    pass(g, "draw", NG_PASS_COMPUTE);
}

static void no_callback(struct ng_graph *g)
{
    ng_graph_add_pass(g, &(struct ng_pass_params){.name = "draw", .kind = NG_PASS_COMPUTE});
}

static void empty_image(struct ng_graph *g)
{
    ng_graph_add_image(g, "picture",
                       &(struct ng_graph_image_params){.format = VK_FORMAT_R8_UNORM, .width = 8});
}

static void too_many_mips(struct ng_graph *g)
{
    ng_graph_add_image(
        g, "picture",
        &(struct ng_graph_image_params){.format = VK_FORMAT_R8_UNORM, .width = 8, .height = 4, .mips = 5});
}

static void odd_cube(struct ng_graph *g)
{
    ng_graph_add_image(g, "sky",
                       &(struct ng_graph_image_params){
                           .format = VK_FORMAT_R8_UNORM, .width = 8, .height = 8, .layers = 4, .cube = true});
}

static void empty_buffer(struct ng_graph *g)
{
    ng_graph_add_buffer(g, "points", NULL);
}

static void null_import(struct ng_graph *g)
{
    ng_graph_import_image(g, "screen", NULL, NULL);
}

static void import_lacks_usage(struct ng_graph *g)
{
    static struct ng_gpu_image screen = {.width = 8,
                                         .height = 8,
                                         .layers = 1,
                                         .mips = 1,
                                         .format = VK_FORMAT_R8G8B8A8_UNORM,
                                         .usage = VK_IMAGE_USAGE_SAMPLED_BIT};
    ng_pass_write(pass(g, "draw", NG_PASS_RASTER), ng_graph_import_image(g, "screen", &screen, NULL),
                  NG_USE_COLOR);
}

static void readback_of_uncopyable(struct ng_graph *g)
{
    ng_graph_readback(g, "z");
    ng_graph_add_image(
        g, "z",
        &(struct ng_graph_image_params){.format = VK_FORMAT_D24_UNORM_S8_UINT, .width = 8, .height = 8});
}

static void host_use_of_unmapped_import(struct ng_graph *g)
{
    static struct ng_gpu_buffer far = {.size = 64, .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT};
    ng_pass_write(pass(g, "think", NG_PASS_CPU), ng_graph_import_buffer(g, "far", &far, NULL),
                  NG_USE_HOST_WRITE);
}

static void import_from_no_state(struct ng_graph *g)
{
    static struct ng_gpu_image screen = {
        .width = 8, .height = 8, .layers = 1, .mips = 1, .format = VK_FORMAT_R8G8B8A8_UNORM};
    ng_graph_import_image(g, "screen", &screen, &(struct ng_graph_import){NG_USE_HOST_WRITE, NG_USE_NONE});
}

static void import_to_unknown_word(struct ng_graph *g)
{
    static struct ng_gpu_buffer far = {.size = 64};
    ng_graph_import_buffer(g, "far", &far, &(struct ng_graph_import){NG_USE_NONE, (enum ng_use)250});
}

static void late_resource(struct ng_graph *g)
{
    assert_int_equal(ng_graph_compile(g), NG_OK);
    buffer(g, "points");
}

static void late_pass(struct ng_graph *g)
{
    assert_int_equal(ng_graph_compile(g), NG_OK);
    ng_pass_write(pass(g, "draw", NG_PASS_COMPUTE), (struct ng_graph_ref){0}, NG_USE_STORAGE_WRITE);
}

static void late_use(struct ng_graph *g)
{
    struct ng_pass *first = pass(g, "first", NG_PASS_COMPUTE);
    struct ng_graph_ref points = buffer(g, "points");
    assert_int_equal(ng_graph_compile(g), NG_OK);
    ng_pass_write(first, points, NG_USE_STORAGE_WRITE);
}

static void late_readback(struct ng_graph *g)
{
    assert_int_equal(ng_graph_compile(g), NG_OK);
    ng_graph_readback(g, "points");
}

static const struct mistake {
    void (*make)(struct ng_graph *g);
    const char *say[3];
} mistakes[] = {
    {stale_read, {"pass 'late'", "'points', which is stale", "pass 'second'"}},
    {two_writers, {"pass 'second'", "'points'", "two writers"}},
    {read_before_write, {"pass 'eager' reads 'points' before any pass has written it"}},
    {update_before_write, {"pass 'count' reads 'points' before any pass has written it"}},
    {cycle_by_after, {"cycle", "'first'", "'points'"}},
    {after_itself, {"cycle", "pass 'first'"}},
    {after_nobody, {"pass 'first'", "'ghost'"}},
    {color_to_depth_format, {"pass 'draw' uses 'z' as color", "format has depth"}},
    {depth_to_color_format, {"pass 'draw' uses 'picture' as depth", "no depth"}},
    {storage_of_depth, {"pass 'fill' uses 'z' as storage write"}},
    {vertex_of_image, {"pass 'draw' uses 'picture' as vertex", "no use of images"}},
    {sampled_buffer, {"pass 'draw' uses 'points' as sampled", "no use of buffers"}},
    {color_in_compute, {"pass 'fill' uses 'picture' as color", "compute pass"}},
    {host_in_raster, {"pass 'draw' uses 'points' as host write", "raster pass"}},
    {sampled_on_cpu, {"pass 'think' uses 'picture' as sampled", "CPU pass"}},
    {present_by_pass, {"pass 'draw' uses 'picture' as present"}},
    {read_by_write_word, {"pass 'fill'", "'storage write' of 'points' by ng_pass_read"}},
    {write_by_read_word, {"pass 'fill'", "'uniform' of 'points' by ng_pass_write"}},
    {unequal_attachments, {"pass 'draw'", "'picture' (64 x 32", "'small' (8 x 8"}},
    {nine_colors, {"pass 'draw'", "'c8'", "too many"}},
    {no_render_area, {"pass 'draw'", "neither attachments"}},
    {zero_ref, {"pass 'draw'", "unknown resource"}},
    {ref_of_last_frame, {"pass 'fill'", "unknown resource"}},
    {read_and_write, {"pass 'blur' reads and writes 'picture'"}},
    {written_twice, {"pass 'blur' writes 'points' twice"}},
    {two_layouts, {"pass 'blur'", "'picture'", "different layouts"}},
    {history_written, {"pass 'fill'", "history of 'points'", "read only"}},
    {history_differs, {"history of 'points'", "another description"}},
    {history_of_persistent, {"history of 'points'", "persistent"}},
    {exported_then_written, {"'points' is exported", "pass 'second'"}},
    {part_out_of_range, {"pass 'draw'", "'picture'", "mip 3"}},
    {layers_out_of_range, {"pass 'draw'", "'picture'", "layers"}},
    {resource_twice, {"'points' is declared twice"}},
    {pass_twice, {"pass 'draw' is declared twice"}},
    {no_callback, {"pass 'draw' has no callback"}},
    {empty_image, {"'picture'", "no size"}},
    {too_many_mips, {"'picture'", "5 mips"}},
    {odd_cube, {"'sky'", "6 n layers"}},
    {empty_buffer, {"'points' has no size"}},
    {null_import, {"'screen' is null"}},
    {import_lacks_usage, {"pass 'draw'", "'screen'", "without that usage"}},
    {readback_of_uncopyable, {"'z' is to be read back", "cannot be copied"}},
    {host_use_of_unmapped_import, {"'think'", "'far'", "not mapped"}},
    {import_from_no_state, {"image 'screen' is imported", "do not say its state"}},
    {import_to_unknown_word, {"buffer 'far' is imported", "word 250"}},
    {late_resource, {"resource 'points' is declared after the frame was compiled"}},
    {late_pass, {"pass 'draw' is declared after"}},
    {late_use, {"pass 'first' is declared after"}},
    {late_readback, {"'points' is declared after"}},
};

static void each_mistake_names_pass_and_resource(void **state)
{
    NG_UNUSED(state);
    for (size_t i = 0; i < NG_COUNT(mistakes); i++) {
        struct ng_graph *g = make_graph();
        struct test_log log;
        test_log_begin(&log);
        mistakes[i].make(g);
        assert_int_equal(ng_graph_compile(g), NG_ERROR_USAGE);
        test_log_end(&log);
        assert_null(ng_graph_plan(g));
        assert_int_equal(log.errors, 1);
        for (size_t k = 0; k < 3 && mistakes[i].say[k]; k++)
            if (!strstr(log.text, mistakes[i].say[k]))
                fail_msg("mistake %zu: expected \"%s\" in: %s", i, mistakes[i].say[k], log.text);
        assert_non_null(strstr(log.text, ng_graph_error(g)));
        ng_graph_destroy(&g);
        assert_null(g);
    }
}

static void a_mistake_of_every_frame_is_logged_once(void **state)
{
    NG_UNUSED(state);
    struct ng_graph *g = make_graph();
    struct test_log log;
    test_log_begin(&log);
    for (int frame = 0; frame < 5; frame++) {
        ng_graph_begin(g);
        read_before_write(g);
        assert_int_equal(ng_graph_compile(g), NG_ERROR_USAGE);
    }
    ng_graph_begin(g);
    two_writers(g);
    assert_int_equal(ng_graph_compile(g), NG_ERROR_USAGE);
    ng_graph_begin(g);
    pass(g, "draw", NG_PASS_RASTER);
    assert_int_equal(ng_graph_compile(g), NG_OK);
    test_log_end(&log);
    assert_int_equal(log.errors, 2);
    ng_graph_destroy(&g);
}

// ---- Plans ---------------------------------------------------------------------------------------------

static const struct ng_plan_step *step_of(const struct ng_plan *plan, const char *name)
{
    for (uint32_t i = 0; i < plan->step_count; i++)
        if (plan->steps[i].kind == NG_STEP_PASS && !strcmp(plan->steps[i].name, name))
            return &plan->steps[i];
    return NULL;
}

static uint32_t count_steps(const struct ng_plan *plan, enum ng_step_kind kind)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < plan->step_count; i++)
        n += plan->steps[i].kind == kind;
    return n;
}

static void what_nothing_needs_is_culled(void **state)
{
    NG_UNUSED(state);
    struct ng_graph *g = make_graph();
    struct ng_graph_ref a =
        ng_pass_write(pass(g, "a", NG_PASS_COMPUTE), buffer(g, "A"), NG_USE_STORAGE_WRITE);
    struct ng_pass *b = pass(g, "b", NG_PASS_COMPUTE);
    ng_pass_read(b, a, NG_USE_STORAGE_READ);
    struct ng_graph_ref out = ng_pass_write(b, buffer(g, "B"), NG_USE_STORAGE_WRITE);
    struct ng_pass *c = pass(g, "c", NG_PASS_COMPUTE);
    ng_pass_read(c, a, NG_USE_STORAGE_READ);
    ng_pass_write(c, buffer(g, "C"), NG_USE_STORAGE_WRITE);
    ng_graph_add_pass(
        g, &(struct ng_pass_params){
               .name = "d", .kind = NG_PASS_COMPUTE, .run = nothing, .flags = NG_PASS_SIDE_EFFECT});
    ng_graph_export(g, out);
    assert_int_equal(ng_graph_compile(g), NG_OK);
    const struct ng_plan *plan = ng_graph_plan(g);
    assert_non_null(step_of(plan, "a"));
    assert_non_null(step_of(plan, "b"));
    assert_null(step_of(plan, "c"));
    assert_non_null(step_of(plan, "d"));
    ng_graph_destroy(&g);
}

static void what_is_written_on_demand_runs_if_it_is_read(void **state)
{
    NG_UNUSED(state);
    struct ng_graph *g = make_graph();
    const struct ng_pass_params params = {
        .name = "k", .kind = NG_PASS_COMPUTE, .run = nothing, .flags = NG_PASS_ON_DEMAND};
    for (int read = 0; read < 2; read++) {
        ng_graph_begin(g);
        struct ng_graph_ref kept =
            ng_graph_persistent_buffer(g, "K", &(struct ng_graph_buffer_params){.size = 64}, NULL);
        kept = ng_pass_write(ng_graph_add_pass(g, &params), kept, NG_USE_STORAGE_WRITE);
        struct ng_pass *reader = pass(g, "reader", NG_PASS_COMPUTE);
        ng_pass_read(reader, kept, NG_USE_STORAGE_READ);
        struct ng_graph_ref out = ng_pass_write(reader, buffer(g, "B"), NG_USE_STORAGE_WRITE);
        if (read)
            ng_graph_export(g, out);
        assert_int_equal(ng_graph_compile(g), NG_OK);
        assert_int_equal(step_of(ng_graph_plan(g), "k") != NULL, read);
    }
    ng_graph_destroy(&g);
}

static void readback_and_persistent_are_sinks(void **state)
{
    NG_UNUSED(state);
    struct ng_graph *g = make_graph();
    ng_graph_readback(g, "A");
    ng_pass_write(pass(g, "a", NG_PASS_COMPUTE), buffer(g, "A"), NG_USE_STORAGE_WRITE);
    bool valid = true;
    struct ng_graph_ref kept =
        ng_graph_persistent_buffer(g, "K", &(struct ng_graph_buffer_params){.size = 64}, &valid);
    assert_false(valid);
    ng_pass_write(pass(g, "k", NG_PASS_COMPUTE), kept, NG_USE_STORAGE_WRITE);
    ng_graph_history_buffer(g, "H", &(struct ng_graph_buffer_params){.size = 256}, &valid);
    assert_false(valid);
    ng_pass_write(pass(g, "h", NG_PASS_COMPUTE), buffer(g, "H"), NG_USE_STORAGE_WRITE);
    assert_int_equal(ng_graph_compile(g), NG_OK);
    assert_non_null(step_of(ng_graph_plan(g), "a"));
    assert_non_null(step_of(ng_graph_plan(g), "k"));
    assert_non_null(step_of(ng_graph_plan(g), "h"));
    ng_graph_destroy(&g);
}

static void after_reorders(void **state)
{
    NG_UNUSED(state);
    struct ng_graph *g = make_graph();
    const char *const names[] = {"a", "b", "c"};
    for (int i = 0; i < 3; i++) {
        struct ng_pass *p = ng_graph_add_pass(
            g, &(struct ng_pass_params){
                   .name = names[i], .kind = NG_PASS_COMPUTE, .run = nothing, .flags = NG_PASS_SIDE_EFFECT});
        if (i == 0)
            ng_pass_after(p, "c");
    }
    assert_int_equal(ng_graph_compile(g), NG_OK);
    const struct ng_plan *plan = ng_graph_plan(g);
    assert_string_equal(plan->steps[0].name, "c");
    assert_string_equal(plan->steps[1].name, "a");
    assert_string_equal(plan->steps[2].name, "b");
    ng_graph_destroy(&g);
}

static void first_write_clears_if_asked(void **state)
{
    NG_UNUSED(state);
    struct ng_graph *g = make_graph();
    struct ng_graph_ref a =
        ng_graph_add_image(g, "a",
                           &(struct ng_graph_image_params){
                               .format = VK_FORMAT_R8_UNORM, .width = 8, .height = 8, .clear = true});
    struct ng_graph_ref b = color(g, "b");
    a = ng_pass_write(pass(g, "one", NG_PASS_RASTER), a, NG_USE_COLOR);
    a = ng_pass_write(pass(g, "two", NG_PASS_RASTER), a, NG_USE_COLOR);
    b = ng_pass_write(pass(g, "three", NG_PASS_RASTER), b, NG_USE_COLOR);
    ng_graph_export(g, a);
    ng_graph_export(g, b);
    assert_int_equal(ng_graph_compile(g), NG_OK);
    const struct ng_plan *plan = ng_graph_plan(g);
    assert_int_equal(plan->uses[step_of(plan, "one")->first_use].load, NG_LOAD_CLEAR);
    assert_int_equal(plan->uses[step_of(plan, "two")->first_use].load, NG_LOAD_KEEP);
    assert_int_equal(plan->uses[step_of(plan, "three")->first_use].load, NG_LOAD_UNDEFINED);
    assert_int_equal(count_steps(plan, NG_STEP_CLEAR), 0);
    ng_graph_destroy(&g);
}

// Faces drawn one by one are cleared one by one; those never drawn are cleared when the whole is read.
static void parts_are_cleared_once(void **state)
{
    NG_UNUSED(state);
    struct ng_graph *g = make_graph();
    struct ng_graph_ref cube =
        ng_graph_add_image(g, "cube",
                           &(struct ng_graph_image_params){.format = VK_FORMAT_D32_SFLOAT,
                                                           .width = 8,
                                                           .height = 8,
                                                           .layers = 6,
                                                           .cube = true,
                                                           .clear = true});
    cube = ng_pass_write_part(pass(g, "face0", NG_PASS_RASTER), cube, NG_USE_DEPTH,
                              &(struct ng_graph_part){.layer = 0, .layer_count = 1});
    cube = ng_pass_write_part(pass(g, "face2", NG_PASS_RASTER), cube, NG_USE_DEPTH,
                              &(struct ng_graph_part){.layer = 2, .layer_count = 1});
    cube = ng_pass_write_part(pass(g, "face2/again", NG_PASS_RASTER), cube, NG_USE_DEPTH,
                              &(struct ng_graph_part){.layer = 2, .layer_count = 1});
    struct ng_pass *look = pass(g, "look", NG_PASS_COMPUTE);
    ng_pass_read(look, cube, NG_USE_SAMPLED);
    ng_graph_export(g, ng_pass_write(look, buffer(g, "out"), NG_USE_STORAGE_WRITE));
    assert_int_equal(ng_graph_compile(g), NG_OK);
    const struct ng_plan *plan = ng_graph_plan(g);
    assert_int_equal(plan->uses[step_of(plan, "face0")->first_use].load, NG_LOAD_CLEAR);
    assert_int_equal(plan->uses[step_of(plan, "face2")->first_use].load, NG_LOAD_CLEAR);
    assert_int_equal(plan->uses[step_of(plan, "face2/again")->first_use].load, NG_LOAD_KEEP);
    assert_int_equal(count_steps(plan, NG_STEP_CLEAR), 1);
    const struct ng_plan_step *clear = step_of(plan, "look") - 1;
    assert_int_equal(clear->kind, NG_STEP_CLEAR);
    assert_int_equal(clear->use_count, 2); // layer 1; layers 3 to 5
    assert_int_equal(plan->uses[clear->first_use].part.layer, 1);
    assert_int_equal(plan->uses[clear->first_use].part.layer_count, 1);
    assert_int_equal(plan->uses[clear->first_use + 1].part.layer, 3);
    assert_int_equal(plan->uses[clear->first_use + 1].part.layer_count, 3);
    ng_graph_destroy(&g);
}

static void an_image_crosses_to_the_host_and_back_once(void **state)
{
    NG_UNUSED(state);
    struct ng_graph *g = make_graph();
    struct ng_graph_ref a = ng_pass_write(pass(g, "draw", NG_PASS_RASTER), color(g, "a"), NG_USE_COLOR);
    ng_graph_export(g, a);
    struct ng_graph_ref b = color(g, "b");
    for (int i = 0; i < 3; i++) {
        const char *const names[] = {"think0", "think1", "think2"};
        struct ng_pass *p = pass(g, names[i], NG_PASS_CPU);
        ng_pass_read(p, a, NG_USE_HOST_READ);
        b = ng_pass_write(p, b, i ? NG_USE_HOST_READ_WRITE : NG_USE_HOST_WRITE);
    }
    for (int i = 0; i < 2; i++) {
        struct ng_pass *p = pass(g, i ? "show1" : "show0", NG_PASS_COMPUTE);
        ng_pass_read(p, b, NG_USE_SAMPLED);
        ng_graph_export(g, ng_pass_write(p, buffer(g, i ? "out1" : "out0"), NG_USE_STORAGE_WRITE));
    }
    assert_int_equal(ng_graph_compile(g), NG_OK);
    const struct ng_plan *plan = ng_graph_plan(g);
    assert_int_equal(count_steps(plan, NG_STEP_DOWNLOAD), 1);
    assert_int_equal(count_steps(plan, NG_STEP_UPLOAD), 1);
    assert_int_equal(plan->batch_count, 2);
    ng_graph_destroy(&g);
}

// On unified memory a buffer needs no copy; a pass that only uploads needs no wait either.
static void buffers_are_used_in_place(void **state)
{
    NG_UNUSED(state);
    for (int copies = 0; copies < 2; copies++) {
        struct ng_graph *g = NULL;
        assert_int_equal(ng_graph_create(&(struct ng_graph_params){.no_unified = copies}, &g), NG_OK);
        struct ng_graph_ref a =
            ng_pass_write(pass(g, "upload", NG_PASS_CPU), buffer(g, "a"), NG_USE_HOST_WRITE);
        struct ng_pass *p = pass(g, "use", NG_PASS_COMPUTE);
        ng_pass_read(p, a, NG_USE_STORAGE_READ);
        struct ng_graph_ref b = ng_pass_write(p, buffer(g, "b"), NG_USE_STORAGE_WRITE);
        ng_graph_readback(g, "b");
        NG_UNUSED(b);
        assert_int_equal(ng_graph_compile(g), NG_OK);
        const struct ng_plan *plan = ng_graph_plan(g);
        assert_int_equal(count_steps(plan, NG_STEP_UPLOAD), copies);
        assert_int_equal(count_steps(plan, NG_STEP_DOWNLOAD), copies);
        assert_int_equal(step_of(plan, "upload")->wait_batch, NG_PLAN_NONE);
        assert_int_equal(plan->batch_count, 1);
        ng_graph_destroy(&g);
    }
}

static void chains_share_memory(void **state)
{
    NG_UNUSED(state);
    for (int off = 0; off < 2; off++) {
        struct ng_graph *g = NULL;
        assert_int_equal(ng_graph_create(&(struct ng_graph_params){.no_aliasing = off}, &g), NG_OK);
        struct ng_graph_ref last = ng_pass_write(pass(g, "p", NG_PASS_RASTER), color(g, "i"), NG_USE_COLOR);
        for (int i = 0; i < 10; i++) {
            char name[16];
            snprintf(name, sizeof name, "p%d", i);
            struct ng_pass *p = pass(g, name, NG_PASS_RASTER);
            ng_pass_read(p, last, NG_USE_SAMPLED);
            snprintf(name, sizeof name, "i%d", i);
            last = ng_pass_write(p, color(g, name), NG_USE_COLOR);
        }
        ng_graph_export(g, last);
        assert_int_equal(ng_graph_compile(g), NG_OK);
        const struct ng_plan *plan = ng_graph_plan(g);
        assert_int_equal(plan->block_count, 1);
        uint64_t one = plan->resources[0].size;
        assert_int_equal(plan->transient_bytes, 11 * one);
        assert_int_equal(plan->blocks[0].size, off ? 11 * one : 2 * one);
        ng_graph_destroy(&g);
    }
}

// ---- Dumps ---------------------------------------------------------------------------------------------

static void dumps_show_everything(void **state)
{
    NG_UNUSED(state);
    struct ng_graph *g = make_graph();
    struct ng_graph_ref a =
        ng_pass_write(pass(g, "encode:lamp \"2\"/rsm", NG_PASS_RASTER), color(g, "rsm"), NG_USE_COLOR);
    struct ng_pass *p = pass(g, "gather", NG_PASS_COMPUTE);
    ng_pass_read(p, a, NG_USE_SAMPLED);
    ng_graph_export(g, ng_pass_write(p, color(g, "out"), NG_USE_STORAGE_WRITE));
    ng_pass_write(pass(g, "unused", NG_PASS_COMPUTE), buffer(g, "waste"), NG_USE_STORAGE_WRITE);
    assert_null(ng_graph_dump(g, NG_DUMP_TEXT));
    assert_int_equal(ng_graph_compile(g), NG_OK);
    const char *const expected[3][6] = {
        {"encode:lamp \"2\"/rsm", "reads rsm v1 as sampled", "color -> sampled", "block 0 at ", "culled",
         "unused"},
        {"digraph", "subgraph", "encode:lamp \\\"2\\\"", "gather", "style=dashed", "unused"},
        {"\"encode:lamp \\\"2\\\"/rsm\"", "\"use\": \"sampled\"", "\"old_layout\": \"color\"",
         "\"offset\": ", "\"culled\": [\"unused\"]", "\"version\": 1"},
    };
    for (int format = 0; format < 3; format++) {
        char *text = ng_graph_dump(g, (enum ng_dump)format);
        assert_non_null(text);
        for (int k = 0; k < 6; k++)
            if (!strstr(text, expected[format][k]))
                fail_msg("expected \"%s\" in:\n%s", expected[format][k], text);
        free(text);
    }
    ng_graph_destroy(&g);
}

// ---- Providers -----------------------------------------------------------------------------------------

// A feature in one place: this is what the README shows. --8<--
struct glow {
    struct ng_graph_ref image;
};
static const struct ng_item_type glow_type = {"glow", sizeof(struct glow)};

static ng_result draw_glow(const struct ng_pass_context *ctx)
{
    NG_UNUSED(ctx); // vkCmdDraw(ctx->cmd->handle, ...)
    return NG_OK;
}

static ng_result produce_glow(struct ng_composer *composer, void *user)
{
    NG_UNUSED(user);
    struct ng_graph *g = ng_composer_graph(composer);
    struct ng_pass *p = ng_graph_add_pass(
        g, &(struct ng_pass_params){.name = "glow", .kind = NG_PASS_RASTER, .run = draw_glow});
    struct ng_graph_ref image =
        ng_graph_add_image(g, "glow",
                           &(struct ng_graph_image_params){
                               .format = VK_FORMAT_R8_UNORM, .width = 64, .height = 64, .clear = true});
    image = ng_pass_write(p, image, NG_USE_COLOR);
    return ng_composer_publish(composer, &glow_type, &(struct glow){image});
}

static const struct ng_provider glow_provider = {.name = "glow", .produce = produce_glow};
// --8<--

static ng_result consume_glow(struct ng_composer *composer, void *user)
{
    struct ng_graph *g = ng_composer_graph(composer);
    struct ng_pass *p = pass(g, "sum", NG_PASS_COMPUTE);
    for (size_t i = 0; i < ng_composer_count(composer, &glow_type); i++) {
        const struct glow *glow = ng_composer_get(composer, &glow_type, i);
        ng_pass_read(p, glow->image, NG_USE_SAMPLED);
        ++*(int *)user;
    }
    ng_graph_export(g, ng_pass_write(p, buffer(g, "sum"), NG_USE_STORAGE_WRITE));
    return NG_OK;
}

static void providers_meet_at_lists(void **state)
{
    NG_UNUSED(state);
    struct ng_graph *g = make_graph();
    struct ng_composer *composer = NULL;
    int seen = 0;
    assert_int_equal(ng_composer_create(g, &composer), NG_OK);
    // The consumer is registered first and still sees what is produced.
    struct ng_provider sum = {.name = "sum", .consume = consume_glow, .user = &seen};
    assert_int_equal(ng_composer_register(composer, &sum), NG_OK);
    assert_int_equal(ng_composer_register(composer, &glow_provider), NG_OK);
    struct test_log log;
    test_log_begin(&log);
    assert_int_equal(ng_composer_register(composer, &sum), NG_ERROR_USAGE);
    test_log_end(&log);
    assert_non_null(strstr(log.text, "'sum'"));
    assert_ptr_equal(ng_composer_find(composer, "sum")->user, &seen);
    for (int frame = 0; frame < 3; frame++) {
        ng_composer_begin(composer);
        assert_int_equal(ng_composer_count(composer, &glow_type), 0);
        assert_int_equal(ng_composer_declare(composer), NG_OK);
        assert_int_equal(ng_graph_compile(g), NG_OK);
        assert_int_equal(seen, frame + 1);
        assert_non_null(step_of(ng_graph_plan(g), "glow"));
        assert_null(ng_composer_get(composer, &glow_type, 1));
    }
    ng_composer_unregister(composer, "glow");
    assert_null(ng_composer_find(composer, "glow"));
    ng_composer_begin(composer);
    assert_int_equal(ng_composer_declare(composer), NG_OK);
    assert_int_equal(seen, 3);
    ng_composer_destroy(&composer);
    assert_null(composer);
    ng_graph_destroy(&g);
}

// Who came, in order.
struct guests {
    char names[16];
    size_t count;
};

static ng_result add_guest(void *user, char name)
{
    struct guests *g = user;
    assert_true(g->count + 1 < sizeof g->names);
    g->names[g->count++] = name;
    return NG_OK;
}

static ng_result sign(struct ng_composer *composer, void *user)
{
    (void)composer;
    return add_guest(user, 'b');
}

static ng_result sign_before(struct ng_composer *composer, void *user)
{
    (void)composer;
    return add_guest(user, 'a');
}

static void a_provider_stands_before_another(void **state)
{
    (void)state;
    struct ng_graph *g = make_graph();
    struct ng_composer *composer;
    struct guests order = {.count = 0};
    const struct ng_provider b = {.name = "b", .produce = sign, .consume = sign, .user = &order};
    const struct ng_provider a = {
        .name = "a", .produce = sign_before, .consume = sign_before, .user = &order, .before = "b"};
    const struct ng_provider last = {
        .name = "last", .produce = sign_before, .user = &order, .before = "nobody"};
    assert_int_equal(ng_composer_create(g, &composer), NG_OK);
    assert_int_equal(ng_composer_register(composer, &b), NG_OK);
    assert_int_equal(ng_composer_register(composer, &last), NG_OK);
    assert_int_equal(ng_composer_register(composer, &a), NG_OK);
    ng_composer_begin(composer);
    assert_int_equal(ng_composer_declare(composer), NG_OK);
    assert_string_equal(order.names, "abaab");
    ng_composer_destroy(&composer);
    ng_graph_destroy(&g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_mistake_names_pass_and_resource),
        cmocka_unit_test(a_mistake_of_every_frame_is_logged_once),
        cmocka_unit_test(what_nothing_needs_is_culled),
        cmocka_unit_test(what_is_written_on_demand_runs_if_it_is_read),
        cmocka_unit_test(readback_and_persistent_are_sinks),
        cmocka_unit_test(after_reorders),
        cmocka_unit_test(first_write_clears_if_asked),
        cmocka_unit_test(parts_are_cleared_once),
        cmocka_unit_test(an_image_crosses_to_the_host_and_back_once),
        cmocka_unit_test(buffers_are_used_in_place),
        cmocka_unit_test(chains_share_memory),
        cmocka_unit_test(dumps_show_everything),
        cmocka_unit_test(providers_meet_at_lists),
        cmocka_unit_test(a_provider_stands_before_another),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

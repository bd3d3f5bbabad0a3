// The render graph on a device, with validation and synchronization validation: what passes of all kinds
// compute equals C; aliasing, culling and copies change nothing; history, persistent content, imports and
// readback; a steady frame creates nothing; a pass that fails does not stop the frame.
#include "gpu_test.h"

#include "base/jobs.h"
#include "base/rng.h"
#include "graph/graph.h"
#include "graph/plan.h"
#include "graph_step.comp.spv.h"
#include "graph_step.frag.spv.h"
#include "graph_step.vert.spv.h"
#include "graph_sum.comp.spv.h"

#define WIDTH  40
#define HEIGHT 24
#define TEXELS (WIDTH * HEIGHT)
#define FORMAT VK_FORMAT_R32_UINT

struct rig {
    struct ng_gpu *gpu;
    struct ng_jobs *jobs;
    struct ng_gpu_pipeline *draw, *dispatch, *sum;
};

static struct rig rig_begin(void)
{
    static const struct ng_gpu_slot step_slots[] = {
        {.binding = 0, .type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
        {.binding = 1, .type = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE}};
    struct rig r = {.gpu = gpu_test_begin()};
    assert_int_equal(ng_jobs_create(NULL, &r.jobs), NG_OK);
    struct ng_gpu_graphics_params draw = {.name = "step",
                                          .vertex = NG_SPIRV(ng_spv_graph_step_vert),
                                          .fragment = NG_SPIRV(ng_spv_graph_step_frag),
                                          .slots = step_slots,
                                          .slot_count = 1,
                                          .push_size = 16,
                                          .color_formats = {FORMAT},
                                          .color_count = 1};
    assert_int_equal(ng_gpu_graphics_create(r.gpu, &draw, &r.draw), NG_OK);
    struct ng_gpu_compute_params dispatch = {.name = "step",
                                             .shader = NG_SPIRV(ng_spv_graph_step_comp),
                                             .slots = step_slots,
                                             .slot_count = 2,
                                             .push_size = 16};
    assert_int_equal(ng_gpu_compute_create(r.gpu, &dispatch, &r.dispatch), NG_OK);
    r.sum = gpu_test_map(r.gpu, "sum", NG_SPIRV(ng_spv_graph_sum_comp), 8);
    return r;
}

static void rig_end(struct rig *r)
{
    ng_gpu_pipeline_destroy(&r->draw);
    ng_gpu_pipeline_destroy(&r->dispatch);
    ng_gpu_pipeline_destroy(&r->sum);
    ng_jobs_destroy(&r->jobs);
    gpu_test_end(r->gpu);
}

static struct ng_graph *rig_graph(const struct rig *r, struct ng_graph_params params)
{
    struct ng_graph *g = NULL;
    params.gpu = r->gpu;
    params.jobs = r->jobs;
    assert_int_equal(ng_graph_create(&params, &g), NG_OK);
    return g;
}

// Executes what has been declared as one frame.
static ng_result run_frame(const struct rig *r, struct ng_graph *g)
{
    struct ng_cmd *cmd = NULL;
    assert_int_equal(ng_frame_begin(r->gpu, &cmd), NG_OK);
    ng_result result = ng_graph_execute(g, &cmd);
    assert_int_equal(ng_frame_end(r->gpu, &cmd), NG_OK);
    return result;
}

// ---- Steps: target = source * mul + add + index of the texel, by each kind of pass -----------------------

struct step {
    const struct rig *rig;
    struct ng_graph_ref source, target;
    enum ng_pass_kind kind;
    uint32_t mul, add;
    ng_result result;
};

static uint32_t step_value(const struct step *s, uint32_t source, uint32_t index)
{
    return s->kind == NG_PASS_COPY ? source : source * s->mul + s->add + index;
}

struct host_step {
    const struct step *step;
    const uint32_t *source;
    uint32_t *target;
};

static void host_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    const struct host_step *h = user;
    NG_UNUSED(worker);
    for (uint32_t i = begin; i < end; i++)
        h->target[i] = step_value(h->step, h->source[i], i);
}

static ng_result run_step_on_host(const struct ng_pass_context *ctx, const struct step *s)
{
    struct ng_graph_memory source = ng_pass_memory(ctx, s->source), target = ng_pass_memory(ctx, s->target);
    assert_int_equal(source.size, TEXELS * 4);
    assert_int_equal(target.row_bytes, WIDTH * 4);
    assert_null(ctx->cmd);
    struct host_step h = {s, source.data, target.data};
    ng_jobs_for(ctx->jobs, TEXELS, 64, host_rows, &h);
    return s->result;
}

static ng_result run_step(const struct ng_pass_context *ctx)
{
    const struct step *s = ctx->data;
    if (s->kind == NG_PASS_CPU)
        return run_step_on_host(ctx, s);
    if (s->kind == NG_PASS_COPY) {
        VkImageCopy all = {.srcSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                           .dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                           .extent = {WIDTH, HEIGHT, 1}};
        vkCmdCopyImage(ctx->cmd->handle, ng_pass_image(ctx, s->source)->handle,
                       ng_pass_layout(ctx, s->source), ng_pass_image(ctx, s->target)->handle,
                       ng_pass_layout(ctx, s->target), 1, &all);
        return s->result;
    }
    const uint32_t push[4] = {s->mul, s->add, WIDTH, HEIGHT};
    const struct ng_gpu_binding bindings[] = {
        {.binding = 0,
         .view = ng_pass_view(ctx, s->source),
         .sampler = ng_gpu_sampler(ctx->gpu, &(struct ng_gpu_sampler_params){0})},
        {.binding = 1, .view = ng_pass_view(ctx, s->target)}};
    bool raster = s->kind == NG_PASS_RASTER;
    const struct ng_gpu_pipeline *pipeline = raster ? s->rig->draw : s->rig->dispatch;
    NG_TRY(ng_cmd_bind(ctx->cmd, pipeline, bindings, raster ? 1 : 2));
    ng_cmd_push(ctx->cmd, pipeline, push, sizeof push);
    if (raster) {
        assert_int_equal(ctx->width, WIDTH);
        vkCmdDraw(ctx->cmd->handle, 3, 1, 0, 0);
    } else {
        ng_cmd_dispatch_over(ctx->cmd, (uint32_t[]){WIDTH, HEIGHT, 1}, (uint32_t[]){8, 8, 1});
    }
    return s->result;
}

static const struct ng_graph_image_params picture = {.format = FORMAT, .width = WIDTH, .height = HEIGHT};

static struct ng_graph_ref add_step(struct ng_graph *g, const char *name, struct step s)
{
    static const enum ng_use reads[] = {NG_USE_SAMPLED, NG_USE_SAMPLED, NG_USE_COPY_SRC, NG_USE_HOST_READ};
    static const enum ng_use writes[] = {NG_USE_COLOR, NG_USE_STORAGE_WRITE, NG_USE_COPY_DST,
                                         NG_USE_HOST_WRITE};
    struct ng_pass *p = ng_graph_add_pass(
        g, &(struct ng_pass_params){
               .name = name, .kind = s.kind, .run = run_step, .data = &s, .data_size = sizeof s});
    ng_pass_read(p, s.source, reads[s.kind]);
    return ng_pass_write(p, s.target, writes[s.kind]);
}

static void expect_picture(struct ng_graph *g, const char *name, const uint32_t *expected)
{
    struct ng_graph_memory m;
    assert_int_equal(ng_graph_readback_get(g, name, &m), NG_OK);
    assert_int_equal(m.format, FORMAT);
    assert_int_equal(m.size, TEXELS * 4);
    assert_memory_equal(m.data, expected, TEXELS * 4);
}

// ---- Random chains -------------------------------------------------------------------------------------

#define CHAIN 24

struct chain {
    struct step steps[CHAIN];
    uint32_t source[CHAIN]; // index of an earlier image; image 0 is the cleared one
    uint32_t values[CHAIN + 1][TEXELS];
};

static void make_chain(struct chain *c, uint64_t seed)
{
    struct ng_rng rng = ng_rng_make(seed, 0);
    for (uint32_t i = 0; i < TEXELS; i++)
        c->values[0][i] = 77;
    for (uint32_t k = 0; k < CHAIN; k++) {
        uint32_t back = ng_rng_below(&rng, 3);
        c->source[k] = k > back ? k - back : k;
        c->steps[k] = (struct step){.kind = (enum ng_pass_kind)ng_rng_below(&rng, NG_PASS_KIND_COUNT),
                                    .mul = ng_rng_u32(&rng) | 1,
                                    .add = ng_rng_u32(&rng)};
        for (uint32_t i = 0; i < TEXELS; i++)
            c->values[k + 1][i] = step_value(&c->steps[k], c->values[c->source[k]][i], i);
    }
}

static void declare_chain(const struct rig *r, struct ng_graph *g, const struct chain *c)
{
    struct ng_graph_ref images[CHAIN + 1];
    struct ng_graph_image_params start = picture;
    start.clear = true;
    start.clear_value.color.uint32[0] = 77;
    images[0] = ng_graph_add_image(g, "image0", &start);
    for (uint32_t k = 0; k < CHAIN; k++) {
        char name[32];
        snprintf(name, sizeof name, "image%u", k + 1);
        struct step s = c->steps[k];
        s.rig = r;
        s.source = images[c->source[k]];
        s.target = ng_graph_add_image(g, name, &picture);
        snprintf(name, sizeof name, "chain/step%u", k + 1);
        images[k + 1] = add_step(g, name, s);
    }
    ng_graph_readback(g, "image24");
}

static void chains_equal_c_however_they_are_run(void **state)
{
    NG_UNUSED(state);
    static struct chain c;
    struct rig r = rig_begin();
    for (uint32_t config = 0; config < 8; config++) {
        struct ng_graph *g =
            rig_graph(&r, (struct ng_graph_params){
                              .no_culling = config & 1, .no_aliasing = config & 2, .no_unified = config & 4});
        for (uint64_t seed = 0; seed < 6; seed++) {
            make_chain(&c, seed);
            ng_graph_begin(g);
            declare_chain(&r, g, &c);
            assert_int_equal(run_frame(&r, g), NG_OK);
            expect_picture(g, "image24", c.values[CHAIN]);
        }
        ng_graph_destroy(&g);
    }
    rig_end(&r);
}

static void a_steady_frame_creates_nothing(void **state)
{
    NG_UNUSED(state);
    static struct chain c;
    struct rig r = rig_begin();
    struct ng_graph *g = rig_graph(&r, (struct ng_graph_params){0});
    make_chain(&c, 1);
    uint64_t created = 0;
    uint32_t blocks = 0;
    for (int frame = 0; frame < 12; frame++) {
        ng_graph_begin(g);
        declare_chain(&r, g, &c);
        assert_int_equal(run_frame(&r, g), NG_OK);
        struct ng_graph_counters counters = ng_graph_counters(g);
        if (frame < NG_GPU_FRAMES) { // host memory exists once for each frame in flight
            created = counters.objects_created;
            blocks = ng_gpu_stats(r.gpu).memory_blocks;
            continue;
        }
        assert_int_equal(counters.objects_created, created);
        assert_int_equal(ng_gpu_stats(r.gpu).memory_blocks, blocks);
    }
    expect_picture(g, "image24", c.values[CHAIN]);

    size_t count;
    const struct ng_pass_stats *stats = ng_graph_stats(g, &count);
    uint64_t runs = 0, skipped = 0;
    double gpu_ms = 0, cpu_ms = 0;
    for (size_t i = 0; i < count; i++) {
        runs += stats[i].runs;
        skipped += stats[i].skipped;
        gpu_ms += stats[i].gpu_ms;
        cpu_ms += stats[i].cpu_ms;
        assert_true(strncmp(stats[i].name, "chain/", 6) == 0);
    }
    assert_int_equal(runs + skipped, 12 * CHAIN);
    assert_true(skipped > 0);
    assert_true(gpu_ms > 0 && cpu_ms > 0);
    ng_graph_destroy(&g);
    rig_end(&r);
}

// ---- History, persistent, imported ---------------------------------------------------------------------

struct sum {
    const struct rig *rig;
    struct ng_graph_ref source, target;
    uint32_t add;
};

static ng_result run_sum(const struct ng_pass_context *ctx)
{
    const struct sum *s = ctx->data;
    const struct ng_gpu_binding bindings[] = {{.binding = 0, .buffer = ng_pass_buffer(ctx, s->source)},
                                              {.binding = 1, .buffer = ng_pass_buffer(ctx, s->target)}};
    const uint32_t push[2] = {s->add, 64};
    NG_TRY(ng_cmd_bind(ctx->cmd, s->rig->sum, bindings, 2));
    ng_cmd_push(ctx->cmd, s->rig->sum, push, sizeof push);
    vkCmdDispatch(ctx->cmd->handle, 1, 1, 1);
    return NG_OK;
}

static const struct ng_graph_buffer_params words = {.size = 256};

static struct ng_graph_ref add_sum(struct ng_graph *g, const char *name, struct sum s)
{
    struct ng_pass *p = ng_graph_add_pass(
        g, &(struct ng_pass_params){
               .name = name, .kind = NG_PASS_COMPUTE, .run = run_sum, .data = &s, .data_size = sizeof s});
    ng_pass_read(p, s.source, NG_USE_STORAGE_READ);
    return ng_pass_write(p, s.target, NG_USE_STORAGE_WRITE);
}

static void expect_words(struct ng_graph *g, const char *name, uint32_t value)
{
    struct ng_graph_memory m;
    assert_int_equal(ng_graph_readback_get(g, name, &m), NG_OK);
    assert_int_equal(m.size, 256);
    for (int i = 0; i < 64; i++)
        assert_int_equal(((const uint32_t *)m.data)[i], value);
}

static void history_is_the_last_frame_that_wrote(void **state)
{
    NG_UNUSED(state);
    struct rig r = rig_begin();
    for (int copies = 0; copies < 2; copies++) {
        struct ng_graph *g = rig_graph(&r, (struct ng_graph_params){.no_unified = copies});
        uint32_t expected = 5; // the clear word of the first frame
        for (uint32_t frame = 0; frame < 7; frame++) {
            bool valid, write = frame != 3;
            struct ng_graph_buffer_params params = words;
            params.clear_word = 5;
            params.clear = true;
            ng_graph_begin(g);
            ng_graph_readback(g, "sum");
            struct ng_graph_ref before = ng_graph_history_buffer(g, "sum", &params, &valid);
            assert_int_equal(valid, frame > 0);
            struct sum s = {&r, before, {0}, frame + 1};
            s.target = ng_graph_add_buffer(g, write ? "sum" : "other", &params);
            ng_graph_export(g, add_sum(g, "sum", s));
            assert_int_equal(run_frame(&r, g), NG_OK);
            if (write)
                expect_words(g, "sum", expected += frame + 1);
        }
        ng_graph_destroy(&g);
    }
    rig_end(&r);
}

static ng_result fill_words(const struct ng_pass_context *ctx)
{
    const struct sum *s = ctx->data;
    uint32_t *data = ng_pass_memory(ctx, s->target).data;
    for (int i = 0; i < 64; i++)
        data[i] = s->add;
    return NG_OK;
}

// The memory that one execution uploads from is not overwritten by the next ones before the GPU has read it.
static void a_graph_may_run_several_times_in_a_frame(void **state)
{
    NG_UNUSED(state);
    static const char *const names[] = {"out0", "out1", "out2", "out3"};
    struct rig r = rig_begin();
    struct ng_graph *g = rig_graph(&r, (struct ng_graph_params){0});
    struct ng_cmd *cmd = NULL;
    assert_int_equal(ng_frame_begin(r.gpu, &cmd), NG_OK);
    for (uint32_t round = 0; round < 4; round++) {
        struct ng_graph_ref outs[4];
        ng_graph_begin(g);
        for (int i = 0; i < 4; i++) {
            outs[i] = ng_graph_persistent_buffer(g, names[i], &words, NULL);
            ng_graph_readback(g, names[i]);
        }
        struct sum s = {.rig = &r, .target = ng_graph_add_buffer(g, "words", &words), .add = 10 + round};
        struct ng_pass *fill = ng_graph_add_pass(
            g,
            &(struct ng_pass_params){
                .name = "fill", .kind = NG_PASS_CPU, .run = fill_words, .data = &s, .data_size = sizeof s});
        s.source = ng_pass_write(fill, s.target, NG_USE_HOST_WRITE);
        s.target = outs[round];
        s.add = 0;
        add_sum(g, "sum", s);
        assert_int_equal(ng_graph_execute(g, &cmd), NG_OK);
    }
    assert_int_equal(ng_frame_end(r.gpu, &cmd), NG_OK);
    expect_words(g, "out3", 13);
    ng_graph_begin(g);
    for (int i = 0; i < 4; i++) {
        struct sum s = {.rig = &r, .source = ng_graph_persistent_buffer(g, names[i], &words, NULL)};
        char copy[16];
        snprintf(copy, sizeof copy, "copy%d", i);
        s.target = ng_graph_add_buffer(g, copy, &words);
        add_sum(g, copy, s);
        ng_graph_readback(g, copy);
    }
    assert_int_equal(run_frame(&r, g), NG_OK);
    for (uint32_t i = 0; i < 4; i++) {
        char copy[16];
        snprintf(copy, sizeof copy, "copy%u", i);
        expect_words(g, copy, 10 + i);
    }
    ng_graph_destroy(&g);
    rig_end(&r);
}

static void persistent_content_outlives_its_pass(void **state)
{
    NG_UNUSED(state);
    struct rig r = rig_begin();
    struct ng_graph *g = rig_graph(&r, (struct ng_graph_params){0});
    struct ng_graph_image_params cleared = picture;
    cleared.clear = true;
    struct step draw = {.rig = &r, .kind = NG_PASS_RASTER, .mul = 1, .add = 9};
    struct step copy = {.rig = &r, .kind = NG_PASS_COPY};
    uint32_t expected[TEXELS];
    for (uint32_t i = 0; i < TEXELS; i++)
        expected[i] = step_value(&draw, 0, i);
    const bool declared[] = {true, true, true, false, true};
    const bool has_content[] = {false, true, true, false, false};
    for (int frame = 0; frame < 5; frame++) {
        bool valid = false;
        ng_graph_begin(g);
        if (declared[frame]) {
            struct ng_graph_ref kept = ng_graph_persistent_image(g, "kept", &picture, &valid);
            assert_int_equal(valid, has_content[frame]);
            draw.target = kept;
            draw.source = ng_graph_add_image(g, "zero", &cleared);
            if (!valid) // the pass whose inputs did not change is not declared
                kept = add_step(g, "encode", draw);
            copy.source = kept;
            copy.target = ng_graph_add_image(g, "out", &picture);
            ng_graph_export(g, add_step(g, "show", copy));
            ng_graph_readback(g, "out");
            ng_graph_readback(g, "kept");
        }
        assert_int_equal(run_frame(&r, g), NG_OK);
        if (declared[frame]) {
            expect_picture(g, "out", expected);
            expect_picture(g, "kept", expected);
        }
    }
    ng_graph_destroy(&g);
    rig_end(&r);
}

static void imports_are_left_as_wanted(void **state)
{
    NG_UNUSED(state);
    struct rig r = rig_begin();
    struct ng_graph *g = rig_graph(&r, (struct ng_graph_params){0});
    struct ng_gpu_image *image = NULL;
    struct ng_gpu_image_params params = {.name = "mine",
                                         .width = WIDTH,
                                         .height = HEIGHT,
                                         .format = FORMAT,
                                         .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT |
                                                  VK_IMAGE_USAGE_SAMPLED_BIT |
                                                  VK_IMAGE_USAGE_TRANSFER_SRC_BIT};
    assert_int_equal(ng_gpu_image_create(r.gpu, &params, &image), NG_OK);
    struct ng_graph_image_params cleared = picture;
    cleared.clear = true;
    struct step draw = {.rig = &r, .kind = NG_PASS_RASTER, .mul = 1, .add = 4};
    uint32_t expected[TEXELS];
    for (uint32_t i = 0; i < TEXELS; i++)
        expected[i] = step_value(&draw, 0, i);
    // Drawn in the first frame, only looked at in the second: the layout that was promised is the one found.
    for (int frame = 0; frame < 2; frame++) {
        ng_graph_begin(g);
        struct ng_graph_import import = {.initial = frame ? NG_USE_SAMPLED : NG_USE_NONE,
                                         .final = NG_USE_SAMPLED};
        draw.target = ng_graph_import_image(g, "mine", image, &import);
        draw.source = ng_graph_add_image(g, "zero", &cleared);
        if (!frame)
            add_step(g, "draw", draw);
        ng_graph_readback(g, "mine");
        assert_int_equal(run_frame(&r, g), NG_OK);
        expect_picture(g, "mine", expected);
    }
    ng_graph_destroy(&g);
    ng_gpu_image_destroy(&image);
    rig_end(&r);
}

// ---- Faces, failure, readback --------------------------------------------------------------------------

static void faces_are_drawn_one_by_one(void **state)
{
    NG_UNUSED(state);
    struct rig r = rig_begin();
    struct ng_graph *g = rig_graph(&r, (struct ng_graph_params){0});
    struct ng_graph_image_params cleared = picture, layered = picture;
    cleared.clear = layered.clear = true;
    layered.layers = 6;
    layered.clear_value.color.uint32[0] = 123;
    ng_graph_readback(g, "faces");
    struct ng_graph_ref zero = ng_graph_add_image(g, "zero", &cleared);
    struct ng_graph_ref faces = ng_graph_add_image(g, "faces", &layered);
    for (uint32_t face = 0; face < 6; face += 2) {
        char name[16];
        snprintf(name, sizeof name, "face%u", face);
        struct step s = {
            .rig = &r, .source = zero, .target = faces, .kind = NG_PASS_RASTER, .mul = 1, .add = face};
        struct ng_pass *p = ng_graph_add_pass(
            g, &(struct ng_pass_params){
                   .name = name, .kind = s.kind, .run = run_step, .data = &s, .data_size = sizeof s});
        ng_pass_read(p, zero, NG_USE_SAMPLED);
        faces = ng_pass_write_part(p, faces, NG_USE_COLOR,
                                   &(struct ng_graph_part){.layer = face, .layer_count = 1});
    }
    assert_int_equal(run_frame(&r, g), NG_OK);
    struct ng_graph_memory m;
    assert_int_equal(ng_graph_readback_get(g, "faces", &m), NG_OK);
    assert_int_equal(m.layers, 6);
    for (uint32_t face = 0; face < 6; face++) {
        const uint32_t *layer = (const uint32_t *)m.data + face * m.layer_bytes / 4;
        for (uint32_t i = 0; i < TEXELS; i++)
            assert_int_equal(layer[i], face % 2 ? 123 : face + i);
    }
    ng_graph_destroy(&g);
    rig_end(&r);
}

static void a_failing_pass_does_not_stop_the_frame(void **state)
{
    NG_UNUSED(state);
    struct rig r = rig_begin();
    struct ng_graph *g = rig_graph(&r, (struct ng_graph_params){0});
    struct ng_graph_image_params cleared = picture;
    cleared.clear = true;
    uint32_t expected[TEXELS];
    struct step good = {.rig = &r, .kind = NG_PASS_COMPUTE, .mul = 1, .add = 3};
    for (uint32_t i = 0; i < TEXELS; i++)
        expected[i] = step_value(&good, 0, i);
    for (int frame = 0; frame < 4; frame++) {
        bool valid, fails = frame < 2;
        ng_graph_begin(g);
        struct ng_graph_ref zero = ng_graph_add_image(g, "zero", &cleared);
        struct step bad = {.rig = &r, .source = zero, .kind = NG_PASS_RASTER, .mul = 1};
        bad.result = fails ? NG_ERROR_IO : NG_OK;
        bad.target = ng_graph_persistent_image(g, "kept", &picture, &valid);
        assert_int_equal(valid, frame == 3);
        add_step(g, "bad", bad);
        good.source = zero;
        good.target = ng_graph_add_image(g, "out", &picture);
        add_step(g, "good", good);
        ng_graph_readback(g, "out");
        assert_int_equal(run_frame(&r, g), fails ? NG_ERROR_IO : NG_OK);
        expect_picture(g, "out", expected);
    }
    ng_graph_destroy(&g);
    rig_end(&r);
}

static void mistakes_of_use_are_told(void **state)
{
    NG_UNUSED(state);
    struct rig r = rig_begin();
    struct ng_graph *g = rig_graph(&r, (struct ng_graph_params){0});
    struct ng_graph_memory m;
    struct test_log log;
    // A broken declaration records nothing, and the next frame is fine.
    test_log_begin(&log);
    assert_int_equal(ng_graph_readback_get(g, "out", &m), NG_ERROR_USAGE);
    struct step s = {.rig = &r, .kind = NG_PASS_RASTER};
    s.source = ng_graph_add_image(g, "never written", &picture);
    s.target = ng_graph_add_image(g, "out", &picture);
    add_step(g, "draw", s);
    assert_int_equal(run_frame(&r, g), NG_ERROR_USAGE);
    ng_graph_begin(g);
    assert_int_equal(run_frame(&r, g), NG_OK);
    assert_int_equal(ng_graph_readback_get(g, "nobody", &m), NG_ERROR_NOT_FOUND);
    test_log_end(&log);
    assert_non_null(strstr(log.text, "'never written'"));
    assert_non_null(strstr(log.text, "'nobody'"));
    assert_int_equal(log.errors, 3);
    ng_graph_destroy(&g);
    rig_end(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(chains_equal_c_however_they_are_run),
        cmocka_unit_test(a_steady_frame_creates_nothing),
        cmocka_unit_test(history_is_the_last_frame_that_wrote),
        cmocka_unit_test(a_graph_may_run_several_times_in_a_frame),
        cmocka_unit_test(persistent_content_outlives_its_pass),
        cmocka_unit_test(imports_are_left_as_wanted),
        cmocka_unit_test(faces_are_drawn_one_by_one),
        cmocka_unit_test(a_failing_pass_does_not_stop_the_frame),
        cmocka_unit_test(mistakes_of_use_are_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

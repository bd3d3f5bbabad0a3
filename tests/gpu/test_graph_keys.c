// Keys of the render graph on a device: random frames of CPU passes, over and over with small changes,
// against a model that computes everything anew; and what must not run, does not.
#include "gpu_test.h"

#include "base/hash.h"
#include "base/rng.h"
#include "graph/graph.h"
#include "graph/key.h"

#define MAX_PASSES  10
#define MAX_BUFFERS 8
#define MAX_READS   3
#define WORDS       24

static struct ng_graph *make_graph(struct ng_gpu *gpu, bool no_unified)
{
    struct ng_graph *g = NULL;
    assert_int_equal(ng_graph_create(&(struct ng_graph_params){.gpu = gpu, .no_unified = no_unified}, &g),
                     NG_OK);
    return g;
}

static ng_result run_frame(struct ng_gpu *gpu, struct ng_graph *g)
{
    struct ng_cmd *cmd = NULL;
    assert_int_equal(ng_frame_begin(gpu, &cmd), NG_OK);
    ng_result result = ng_graph_execute(g, &cmd);
    assert_int_equal(ng_frame_end(gpu, &cmd), NG_OK);
    return result;
}

// ---- Frames of passes that mix words ---------------------------------------------------------------------

struct buffer {
    struct ng_graph_ref ref;
    bool persistent, read_back;
    uint64_t value; // what the model says
    bool known;     // it does
};

struct pass {
    uint64_t param; // a word of its own; its key, if it has one
    bool keyed, on_demand, rewrites, fails, ran, failed;
    uint32_t target, read_count, reads[MAX_READS];
    struct ng_graph_ref target_ref, read_refs[MAX_READS];
};

struct frame {
    uint32_t pass_count, buffer_count;
    struct pass passes[MAX_PASSES];
    struct buffer buffers[MAX_BUFFERS];
};

static uint64_t mix(uint64_t value, uint64_t word)
{
    return ng_hash_combine(value, word);
}

static ng_result mix_words(const struct ng_pass_context *ctx)
{
    struct pass *p = ctx->data;
    p->ran = true;
    p->failed = p->fails;
    uint64_t *to = ng_pass_memory(ctx, p->target_ref).data;
    uint64_t value = mix(p->rewrites ? to[0] : 0, p->param);
    assert_int_equal((uintptr_t)to % 64, 0);
    for (uint32_t i = 0; i < p->read_count; i++)
        value = mix(value, *(const uint64_t *)ng_pass_memory(ctx, p->read_refs[i]).data);
    for (size_t i = 0; i < WORDS; i++)
        to[i] = p->fails ? 0xbad : value;
    return p->fails ? NG_ERROR_IO : NG_OK;
}

static void make_frame(struct ng_rng *rng, struct frame *f)
{
    *f = (struct frame){.pass_count = 2 + ng_rng_below(rng, MAX_PASSES - 2),
                        .buffer_count = 3 + ng_rng_below(rng, MAX_BUFFERS - 3)};
    for (uint32_t i = 0; i < f->buffer_count; i++)
        f->buffers[i].persistent = ng_rng_below(rng, 3) > 0;
    for (uint32_t i = 0; i < f->pass_count; i++) {
        struct pass *p = &f->passes[i];
        *p = (struct pass){.param = 1 + ng_rng_below(rng, 4),
                           .keyed = ng_rng_below(rng, 5) > 0,
                           .on_demand = ng_rng_below(rng, 4) == 0,
                           .target = ng_rng_below(rng, f->buffer_count),
                           .read_count = ng_rng_below(rng, MAX_READS + 1)};
        for (uint32_t k = 0; k < p->read_count; k++)
            p->reads[k] = ng_rng_below(rng, f->buffer_count);
    }
}

static bool reads_twice(const struct pass *p, uint32_t k)
{
    for (uint32_t i = 0; i < k; i++)
        if (p->reads[i] == p->reads[k])
            return true;
    return p->reads[k] == p->target;
}

static void declare_pass(struct ng_graph *g, struct frame *f, uint32_t index, bool *written)
{
    struct pass *p = &f->passes[index];
    char name[16];
    snprintf(name, sizeof name, "p%u", index);
    struct ng_pass *pass =
        ng_graph_add_pass(g, &(struct ng_pass_params){.name = name,
                                                      .kind = NG_PASS_CPU,
                                                      .run = mix_words,
                                                      .data = p,
                                                      .flags = p->on_demand ? NG_PASS_ON_DEMAND : 0,
                                                      .key = p->keyed ? p->param : 0});
    uint32_t kept = 0;
    for (uint32_t k = 0; k < p->read_count; k++)
        if (written[p->reads[k]] && !reads_twice(p, k))
            p->reads[kept++] = p->reads[k];
    p->read_count = kept;
    for (uint32_t k = 0; k < kept; k++) {
        p->read_refs[k] = f->buffers[p->reads[k]].ref;
        ng_pass_read(pass, p->read_refs[k], NG_USE_HOST_READ);
    }
    p->rewrites = written[p->target] && p->param % 2;
    p->target_ref = ng_pass_write(pass, f->buffers[p->target].ref,
                                  p->rewrites ? NG_USE_HOST_READ_WRITE : NG_USE_HOST_WRITE);
    f->buffers[p->target].ref = p->target_ref;
    written[p->target] = true;
    p->ran = p->failed = false;
}

// A null `rng`: nothing is read back.
static void declare(struct ng_graph *g, struct ng_rng *rng, struct frame *f)
{
    bool written[MAX_BUFFERS] = {false};
    ng_graph_begin(g);
    for (uint32_t i = 0; i < f->buffer_count; i++) {
        struct buffer *b = &f->buffers[i];
        char name[16];
        snprintf(name, sizeof name, "b%u", i);
        const struct ng_graph_buffer_params params = {.size = WORDS * sizeof(uint64_t)};
        b->ref = b->persistent ? ng_graph_persistent_buffer(g, name, &params, NULL)
                               : ng_graph_add_buffer(g, name, &params);
    }
    for (uint32_t i = 0; i < f->pass_count; i++)
        declare_pass(g, f, i, written);
    for (uint32_t i = 0; i < f->buffer_count; i++) {
        char name[16];
        snprintf(name, sizeof name, "b%u", i);
        f->buffers[i].read_back = rng && written[i] && ng_rng_below(rng, 3) == 0;
        if (f->buffers[i].read_back)
            ng_graph_readback(g, name);
    }
}

// Everything anew. Nothing is known of what a failed pass, or one after it, should have made.
static void run_model(struct frame *f)
{
    for (uint32_t i = 0; i < f->buffer_count; i++)
        f->buffers[i].known = true;
    for (uint32_t i = 0; i < f->pass_count; i++) {
        struct pass *p = &f->passes[i];
        struct buffer *b = &f->buffers[p->target];
        bool known = !p->failed && (!p->rewrites || b->known);
        uint64_t value = mix(p->rewrites ? b->value : 0, p->param);
        for (uint32_t k = 0; k < p->read_count; k++) {
            value = mix(value, f->buffers[p->reads[k]].value);
            known = known && f->buffers[p->reads[k]].known;
        }
        b->value = value;
        b->known = known;
    }
}

static uint32_t check(struct ng_graph *g, const struct frame *f)
{
    uint32_t checked = 0;
    for (uint32_t i = 0; i < f->buffer_count; i++) {
        struct ng_graph_memory m;
        char name[16];
        snprintf(name, sizeof name, "b%u", i);
        if (!f->buffers[i].read_back || !f->buffers[i].known)
            continue;
        assert_int_equal(ng_graph_readback_get(g, name, &m), NG_OK);
        assert_true(((const uint64_t *)m.data)[WORDS - 1] == f->buffers[i].value);
        checked++;
    }
    return checked;
}

// Small changes, as edits make them.
static void change(struct ng_rng *rng, struct frame *f)
{
    for (uint32_t i = 0; i < f->pass_count; i++) {
        struct pass *p = &f->passes[i];
        p->fails = ng_rng_below(rng, 25) == 0;
        if (ng_rng_below(rng, 6) == 0)
            p->param = 1 + ng_rng_below(rng, 4);
    }
}

// Gives a frame up before its pass number *left.
static bool give_up(void *left)
{
    return (*(uint32_t *)left)-- == 0;
}

static void random_frames_equal_a_model_that_redoes_all(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    static struct frame f;
    uint32_t ran = 0, declared = 0, checked = 0, failed = 0, abandoned = 0;
    for (uint64_t seed = 0; seed < 120; seed++) {
        struct ng_rng rng = ng_rng_make(seed, 7);
        struct ng_graph *g = make_graph(gpu, seed % 3 == 0);
        ng_graph_ignore_keys(g, seed % 10 == 9);
        make_frame(&rng, &f);
        for (int n = 0; n < 25; n++) {
            uint32_t left = ng_rng_below(&rng, 4);
            declare(g, &rng, &f);
            if (ng_rng_below(&rng, 5) == 0)
                ng_graph_abandon_when(g, give_up, &left);
            ng_result result = run_frame(gpu, g);
            if (result == NG_ABANDONED) { // whatever it made of it, the next one is right
                abandoned++;
                change(&rng, &f);
                continue;
            }
            bool any = false;
            for (uint32_t i = 0; i < f.pass_count; i++) {
                any |= f.passes[i].failed;
                ran += f.passes[i].ran;
            }
            assert_int_equal(result, any ? NG_ERROR_IO : NG_OK);
            failed += any;
            declared += f.pass_count;
            run_model(&f);
            checked += check(g, &f);
            change(&rng, &f);
        }
        ng_graph_destroy(&g);
    }
    print_message("%u of %u passes ran, %u results compared, %u frames with a failure, %u given up\n", ran,
                  declared, checked, failed, abandoned);
    assert_true(checked > 1000 && failed > 100 && abandoned > 100 && ran * 10 < declared * 8);
    gpu_test_end(gpu);
}

// ---- What need not run -----------------------------------------------------------------------------------

// source -> (transient) -> picture, as a G-buffer and what is made of it.
struct chain {
    struct ng_graph_ref source, middle, picture, token;
    uint32_t runs[3];
    bool fails;
};

static ng_result fill(const struct ng_pass_context *ctx, struct ng_graph_ref ref, uint32_t value)
{
    struct ng_graph_memory m = ng_pass_memory(ctx, ref);
    for (size_t i = 0; i < m.size / 4; i++)
        ((uint32_t *)m.data)[i] = value;
    return NG_OK;
}

static ng_result run_source(const struct ng_pass_context *ctx)
{
    struct chain *c = ctx->data;
    c->runs[0]++;
    return c->fails ? NG_ERROR_IO : NG_OK; // makes something that is not the graph's
}

static ng_result run_middle(const struct ng_pass_context *ctx)
{
    struct chain *c = ctx->data;
    c->runs[1]++;
    return fill(ctx, c->middle, 5);
}

static ng_result run_picture(const struct ng_pass_context *ctx)
{
    struct chain *c = ctx->data;
    c->runs[2]++;
    return fill(ctx, c->picture, 1 + *(const uint32_t *)ng_pass_memory(ctx, c->middle).data);
}

static struct ng_pass *add(struct ng_graph *g, const char *name, ng_pass_fn run, struct chain *c,
                           uint64_t key)
{
    return ng_graph_add_pass(
        g, &(struct ng_pass_params){.name = name, .kind = NG_PASS_CPU, .run = run, .data = c, .key = key});
}

static void declare_chain(struct ng_graph *g, struct chain *c, uint64_t source, uint64_t middle,
                          uint64_t size)
{
    ng_graph_begin(g);
    c->token = ng_pass_write(add(g, "source", run_source, c, source), ng_graph_add_token(g, "outside"),
                             NG_USE_HOST_WRITE);
    struct ng_pass *pass = add(g, "middle", run_middle, c, middle);
    ng_pass_read(pass, c->token, NG_USE_HOST_READ);
    c->middle =
        ng_pass_write(pass, ng_graph_add_buffer(g, "middle", &(struct ng_graph_buffer_params){.size = size}),
                      NG_USE_HOST_WRITE);
    pass = add(g, "picture", run_picture, c, NG_KEY);
    ng_pass_read(pass, c->middle, NG_USE_HOST_READ);
    c->picture = ng_pass_write(
        pass, ng_graph_persistent_buffer(g, "picture", &(struct ng_graph_buffer_params){.size = 64}, NULL),
        NG_USE_HOST_WRITE);
}

static void expect_runs(const struct chain *c, uint32_t source, uint32_t middle, uint32_t picture)
{
    assert_int_equal(c->runs[0], source);
    assert_int_equal(c->runs[1], middle);
    assert_int_equal(c->runs[2], picture);
}

// What the picture holds, without making anything.
static const void *read_picture(struct ng_gpu *gpu, struct ng_graph *g, struct chain *c, uint32_t before)
{
    struct ng_graph_memory m;
    declare_chain(g, c, 10 + before, 1, 64 + 64 * (uint64_t)before);
    ng_graph_readback(g, "picture");
    assert_int_equal(run_frame(gpu, g), NG_OK);
    assert_int_equal(ng_graph_readback_get(g, "picture", &m), NG_OK);
    return m.data;
}

static void only_what_changed_runs(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    struct ng_graph *g = make_graph(gpu, false);
    struct chain c = {0};
    declare_chain(g, &c, 1, 1, 64);
    assert_int_equal(run_frame(gpu, g), NG_OK);
    expect_runs(&c, 1, 1, 1);
    declare_chain(g, &c, 1, 1, 64);
    assert_int_equal(run_frame(gpu, g), NG_OK);
    expect_runs(&c, 1, 1, 1);
    declare_chain(g, &c, 2, 1, 64); // a token hands no key on
    assert_int_equal(run_frame(gpu, g), NG_OK);
    expect_runs(&c, 1, 1, 1);
    declare_chain(g, &c, 2, 3, 64); // through what has no memory from frame to frame
    assert_int_equal(run_frame(gpu, g), NG_OK);
    expect_runs(&c, 2, 2, 2);
    declare_chain(g, &c, 2, 3, 128); // another description is another content
    assert_int_equal(run_frame(gpu, g), NG_OK);
    expect_runs(&c, 3, 3, 3);
    declare_chain(g, &c, 2, 3, 128);
    ng_graph_readback(g, "middle"); // asked for, so made, but the picture is there
    assert_int_equal(run_frame(gpu, g), NG_OK);
    expect_runs(&c, 4, 4, 3);
    declare_chain(g, &c, 2, 0, 128); // no key: nobody knows
    assert_int_equal(run_frame(gpu, g), NG_OK);
    expect_runs(&c, 5, 5, 4);
    ng_graph_ignore_keys(g, true);
    declare_chain(g, &c, 2, 3, 128);
    assert_int_equal(run_frame(gpu, g), NG_OK);
    declare_chain(g, &c, 2, 3, 128);
    assert_int_equal(run_frame(gpu, g), NG_OK);
    expect_runs(&c, 7, 7, 6);
    ng_graph_destroy(&g);
    gpu_test_end(gpu);
}

static void what_follows_a_failure_is_made_later(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    struct ng_graph *g = make_graph(gpu, false);
    struct chain c = {.fails = true};
    declare_chain(g, &c, 1, 1, 64);
    assert_int_equal(run_frame(gpu, g), NG_ERROR_IO);
    expect_runs(&c, 1, 0, 0);
    c.fails = false;
    declare_chain(g, &c, 1, 1, 64);
    assert_int_equal(run_frame(gpu, g), NG_OK);
    expect_runs(&c, 2, 1, 1);
    declare_chain(g, &c, 1, 1, 64);
    assert_int_equal(run_frame(gpu, g), NG_OK);
    expect_runs(&c, 2, 1, 1);
    ng_graph_destroy(&g);
    gpu_test_end(gpu);
}

static void what_was_given_up_is_made_later(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    struct ng_graph *g = make_graph(gpu, false);
    for (uint32_t before = 0; before <= 3; before++) {
        struct chain c = {0};
        uint32_t left = before;
        declare_chain(g, &c, 10 + before, 1, 64 + 64 * (uint64_t)before);
        ng_graph_abandon_when(g, give_up, &left);
        assert_int_equal(run_frame(gpu, g), before < 3 ? NG_ABANDONED : NG_OK);
        expect_runs(&c, before > 0, before > 1, before > 2);
        declare_chain(g, &c, 10 + before, 1, 64 + 64 * (uint64_t)before); // which nobody gives up
        assert_int_equal(run_frame(gpu, g), NG_OK);
        assert_int_equal(c.runs[2], 1);
        assert_int_equal(*(const uint32_t *)read_picture(gpu, g, &c, before), 6);
    }
    ng_graph_destroy(&g);
    gpu_test_end(gpu);
}

// Two large pictures that nobody looks at take nothing; one that is looked at takes its size.
static void what_nobody_reads_takes_no_memory(void **state)
{
    NG_UNUSED(state);
    const uint64_t size = 1 << 22;
    struct ng_gpu *gpu = gpu_test_begin();
    struct ng_graph *g = make_graph(gpu, false);
    for (uint32_t n = 0; n < 6; n++) {
        struct chain c = {0};
        uint64_t before = ng_graph_counters(g).persistent_bytes;
        ng_graph_begin(g);
        struct ng_pass *pass = ng_graph_add_pass(g, &(struct ng_pass_params){.name = "middle",
                                                                             .kind = NG_PASS_CPU,
                                                                             .run = run_middle,
                                                                             .data = &c,
                                                                             .flags = NG_PASS_ON_DEMAND,
                                                                             .key = n < 4 ? 1 : 2});
        c.middle = ng_pass_write(
            pass,
            ng_graph_persistent_buffer(g, "large", &(struct ng_graph_buffer_params){.size = size}, NULL),
            NG_USE_HOST_WRITE);
        if (n == 2)
            ng_graph_readback(g, "large");
        assert_int_equal(run_frame(gpu, g), NG_OK);
        assert_int_equal(c.runs[1], n == 2);
        // What was made stays while it is current, and goes when it is not.
        assert_true(ng_graph_counters(g).persistent_bytes == (n == 2 || n == 3 ? size : 0));
        assert_true(n != 3 || before == size);
    }
    ng_graph_destroy(&g);
    gpu_test_end(gpu);
}

// A chain of large buffers, of which two at a time are alive.
static void buffers_of_cpu_passes_share_memory(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    struct ng_graph *g = make_graph(gpu, false);
    struct frame f = {.pass_count = 8, .buffer_count = 8};
    for (uint32_t i = 0; i < 8; i++)
        f.passes[i] =
            (struct pass){.param = 2, .keyed = true, .target = i, .read_count = i > 0, .reads = {i - 1}};
    f.buffers[7].persistent = true;
    for (int n = 0; n < 4; n++) {
        f.passes[0].param = 2 + 2 * (uint64_t)n;
        declare(g, NULL, &f);
        ng_graph_readback(g, "b7");
        f.buffers[7].read_back = true;
        assert_int_equal(run_frame(gpu, g), NG_OK);
        run_model(&f);
        assert_int_equal(check(g, &f), 1);
        assert_true(ng_graph_counters(g).transient_bytes <= 3 * WORDS * sizeof(uint64_t));
    }
    ng_graph_destroy(&g);
    gpu_test_end(gpu);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_frames_equal_a_model_that_redoes_all),
        cmocka_unit_test(only_what_changed_runs),
        cmocka_unit_test(what_follows_a_failure_is_made_later),
        cmocka_unit_test(what_was_given_up_is_made_later),
        cmocka_unit_test(what_nobody_reads_takes_no_memory),
        cmocka_unit_test(buffers_of_cpu_passes_share_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

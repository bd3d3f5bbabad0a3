// The render graph, one call of its interface a byte, with the bytes after it as arguments. A frame is
// refused with a reason, or its plan is whole: every index leads somewhere, every resource that is used has
// memory.
#include "target.h"

#include "gpu/buffer.h"
#include "gpu/image.h"
#include "graph/graph.h"
#include "graph/plan.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_REFS   64
#define MAX_PASSES 32

struct player {
    const uint8_t *at, *end;
    struct ng_graph *graph;
    struct ng_graph_ref refs[MAX_REFS]; // newest versions and stale ones; of this frame and of earlier ones
    struct ng_pass *passes[MAX_PASSES]; // of this frame
    uint32_t ref_count, pass_count;
    char name[8];
};

static uint8_t take(struct player *p)
{
    return p->at < p->end ? *p->at++ : 0;
}

// Few names, so that they meet; one is empty.
static const char *take_name(struct player *p)
{
    uint8_t number = take(p) % 24;
    snprintf(p->name, sizeof p->name, "n%u", number);
    return number ? p->name : "";
}

static struct ng_graph_ref take_ref(struct player *p)
{
    uint8_t index = take(p);
    if (index == 255) // what no call has given
        return (struct ng_graph_ref){(uint64_t)take(p) << 32 | (uint64_t)take(p) << 16 | take(p)};
    return p->ref_count ? p->refs[index % p->ref_count] : (struct ng_graph_ref){0};
}

static void keep_ref(struct player *p, struct ng_graph_ref ref)
{
    p->refs[p->ref_count < MAX_REFS ? p->ref_count++ : take(p) % MAX_REFS] = ref;
}

static struct ng_pass *take_pass(struct player *p)
{
    uint8_t index = take(p);
    return p->pass_count ? p->passes[index % p->pass_count] : NULL;
}

static enum ng_use take_use(struct player *p)
{
    uint8_t use = take(p); // mostly one that there is
    return (enum ng_use)(use < 240 ? use % NG_USE_COUNT : use);
}

// ---- Resources -----------------------------------------------------------------------------------------

static struct ng_graph_image_params take_image(struct player *p)
{
    static const VkFormat formats[] = {
        VK_FORMAT_R8G8B8A8_UNORM,    VK_FORMAT_D32_SFLOAT,      VK_FORMAT_R16G16B16A16_SFLOAT,
        VK_FORMAT_D24_UNORM_S8_UINT, VK_FORMAT_BC7_UNORM_BLOCK, VK_FORMAT_UNDEFINED,
        VK_FORMAT_R32_UINT,          (VkFormat)0x7ffffffe};
    static const uint32_t sizes[] = {16, 16, 16, 1, 64, 0, 65536, UINT32_MAX};
    uint8_t size = take(p), shape = take(p);
    return (struct ng_graph_image_params){.format = formats[take(p) % NG_COUNT(formats)],
                                          .width = sizes[size % 8],
                                          .height = sizes[size / 8 % 8],
                                          .layers = shape & 7,
                                          .mips = shape >> 3 & 3 ? (uint32_t)shape >> 3 & 3 : take(p),
                                          .array = size >> 6 & 1,
                                          .cube = size >> 7,
                                          .clear = shape >> 5 & 1};
}

static struct ng_graph_buffer_params take_buffer(struct player *p)
{
    uint8_t bits = take(p);
    uint64_t size = bits & 1 ? take(p) : bits & 2 ? UINT64_MAX - take(p) : 64;
    return (struct ng_graph_buffer_params){.size = size, .clear = bits >> 2 & 1, .scratch = bits >> 3 & 1};
}

static void add_image(struct player *p)
{
    struct ng_graph_image_params params = take_image(p);
    keep_ref(p, ng_graph_add_image(p->graph, take_name(p), &params));
}

static void add_buffer(struct player *p)
{
    struct ng_graph_buffer_params params = take_buffer(p);
    keep_ref(p, ng_graph_add_buffer(p->graph, take_name(p), &params));
}

static void persistent_image(struct player *p)
{
    bool valid;
    struct ng_graph_image_params params = take_image(p);
    keep_ref(p, ng_graph_persistent_image(p->graph, take_name(p), &params, &valid));
}

static void persistent_buffer(struct player *p)
{
    bool valid;
    struct ng_graph_buffer_params params = take_buffer(p);
    keep_ref(p, ng_graph_persistent_buffer(p->graph, take_name(p), &params, &valid));
}

static void history_image(struct player *p)
{
    bool valid;
    struct ng_graph_image_params params = take_image(p);
    keep_ref(p, ng_graph_history_image(p->graph, take_name(p), &params, &valid));
}

static void history_buffer(struct player *p)
{
    bool valid;
    struct ng_graph_buffer_params params = take_buffer(p);
    keep_ref(p, ng_graph_history_buffer(p->graph, take_name(p), &params, &valid));
}

static void add_token(struct player *p)
{
    keep_ref(p, ng_graph_add_token(p->graph, take_name(p)));
}

static struct ng_graph_import take_import(struct player *p)
{
    enum ng_use initial = take_use(p);
    return (struct ng_graph_import){initial, take_use(p)};
}

static void import_image(struct player *p)
{
    static struct ng_gpu_image image = {
        .width = 16, .height = 16, .layers = 1, .mips = 1, .format = VK_FORMAT_R8G8B8A8_UNORM, .usage = ~0u};
    struct ng_graph_import import = take_import(p);
    keep_ref(p, ng_graph_import_image(p->graph, take_name(p), take(p) % 8 ? &image : NULL, &import));
}

static void import_buffer(struct player *p)
{
    static char memory[64];
    static struct ng_gpu_buffer mapped = {.size = sizeof memory, .usage = ~0u, .mapped = memory},
                                unmapped = {.size = sizeof memory, .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT};
    struct ng_gpu_buffer *const buffers[] = {&mapped, &mapped, &unmapped, NULL};
    struct ng_graph_import import = take_import(p);
    keep_ref(p, ng_graph_import_buffer(p->graph, take_name(p), buffers[take(p) % 4], &import));
}

static void export_ref(struct player *p)
{
    ng_graph_export(p->graph, take_ref(p));
}

static void read_back(struct player *p)
{
    ng_graph_readback(p->graph, take_name(p));
}

// ---- Passes --------------------------------------------------------------------------------------------

static ng_result nothing(const struct ng_pass_context *ctx)
{
    NG_UNUSED(ctx);
    return NG_OK;
}

static void add_pass(struct player *p)
{
    uint8_t bits = take(p), kind = take(p);
    struct ng_pass_params params = {.kind =
                                        (enum ng_pass_kind)(kind < 250 ? kind % NG_PASS_KIND_COUNT : kind),
                                    .run = bits % 32 == 31 ? NULL : nothing,
                                    .flags = bits >> 5 & 3,
                                    .width = 16,
                                    .height = bits >> 7 ? 16 : take(p),
                                    .key = bits >> 1 & 3};
    params.name = take_name(p);
    struct ng_pass *pass = ng_graph_add_pass(p->graph, &params);
    p->passes[p->pass_count < MAX_PASSES ? p->pass_count++ : take(p) % MAX_PASSES] = pass;
}

static struct ng_graph_part take_part(struct player *p)
{
    uint8_t mip = take(p), layer = take(p);
    return (struct ng_graph_part){mip & 15, mip >> 4, layer & 15,
                                  layer < 250 ? (uint32_t)layer >> 4 : UINT32_MAX};
}

static void read_ref(struct player *p)
{
    struct ng_pass *pass = take_pass(p);
    struct ng_graph_ref ref = take_ref(p);
    if (pass)
        ng_pass_read(pass, ref, take_use(p));
}

static void read_ref_as(struct player *p)
{
    struct ng_pass *pass = take_pass(p);
    struct ng_graph_ref ref = take_ref(p);
    enum ng_use use = take_use(p);
    if (pass)
        ng_pass_read_as(pass, ref, use, take(p));
}

static void read_part(struct player *p)
{
    struct ng_pass *pass = take_pass(p);
    struct ng_graph_ref ref = take_ref(p);
    struct ng_graph_part part = take_part(p);
    if (pass)
        ng_pass_read_part(pass, ref, take_use(p), &part);
}

static void write_ref(struct player *p)
{
    struct ng_pass *pass = take_pass(p);
    struct ng_graph_ref ref = take_ref(p);
    if (pass)
        keep_ref(p, ng_pass_write(pass, ref, take_use(p)));
}

static void write_part(struct player *p)
{
    struct ng_pass *pass = take_pass(p);
    struct ng_graph_ref ref = take_ref(p);
    struct ng_graph_part part = take_part(p);
    if (pass)
        keep_ref(p, ng_pass_write_part(pass, ref, take_use(p), &part));
}

static void after(struct player *p)
{
    struct ng_pass *pass = take_pass(p);
    if (pass)
        ng_pass_after(pass, take_name(p));
}

// ---- Frames --------------------------------------------------------------------------------------------

static void expect(bool truth, const char *what)
{
    if (truth)
        return;
    fprintf(stderr, "the plan is broken: %s\n", what);
    abort();
}

static void check_resource(const struct ng_plan *plan, const struct ng_plan_resource *r)
{
    expect(r->block == NG_PLAN_NONE || r->block < plan->block_count, "block of a resource");
    expect(r->staging == NG_PLAN_NONE || r->staging < plan->resource_count, "staging copy");
    expect(r->block == NG_PLAN_NONE ||
               (r->size && r->offset % r->alignment == 0 && r->size <= plan->blocks[r->block].size &&
                r->offset <= plan->blocks[r->block].size - r->size),
           "memory of a resource");
}

// What lives at the same time shares no byte.
static void check_pair(const struct ng_plan_resource *a, const struct ng_plan_resource *b)
{
    bool together = a->first_step != NG_PLAN_NONE && b->first_step != NG_PLAN_NONE &&
                    a->first_step <= b->last_step && b->first_step <= a->last_step;
    bool meet = a->block != NG_PLAN_NONE && a->block == b->block && a->offset < b->offset + b->size &&
                b->offset < a->offset + a->size;
    expect(!together || !meet, "two resources in one place");
}

static void check_step(const struct ng_plan *plan, const struct ng_plan_step *s)
{
    expect(s->pass == NG_PLAN_NONE || s->pass < plan->pass_count, "pass of a step");
    expect(s->first_use <= plan->use_count && s->use_count <= plan->use_count - s->first_use, "uses");
    expect(s->first_barrier <= plan->barrier_count &&
               s->barrier_count <= plan->barrier_count - s->first_barrier,
           "barriers");
    expect(s->batch <= plan->batch_count, "batch");
    expect(s->wait_batch == NG_PLAN_NONE || s->wait_batch <= s->batch, "a wait for what comes later");
}

static void check_plan(const struct ng_plan *plan)
{
    for (uint32_t i = 0; i < plan->resource_count; i++) {
        check_resource(plan, &plan->resources[i]);
        for (uint32_t k = 0; k < i; k++)
            check_pair(&plan->resources[i], &plan->resources[k]);
    }
    for (uint32_t i = 0; i < plan->step_count; i++)
        check_step(plan, &plan->steps[i]);
    for (uint32_t i = 0; i < plan->use_count; i++)
        expect(plan->uses[i].resource < plan->resource_count && plan->uses[i].declared < plan->resource_count,
               "resource of a use");
    for (uint32_t i = 0; i < plan->barrier_count; i++)
        expect(plan->barriers[i].resource < plan->resource_count, "resource of a barrier");
    for (uint32_t i = 0; i < plan->pass_count; i++)
        expect(plan->passes[i].step == NG_PLAN_NONE || plan->passes[i].step < plan->step_count,
               "step of a pass");
}

static void compile(struct player *p)
{
    static const enum ng_dump dumps[] = {NG_DUMP_TEXT, NG_DUMP_DOT, NG_DUMP_JSON};
    ng_result result = ng_graph_compile(p->graph);
    bool good = result == NG_OK;
    expect(good == (ng_graph_plan(p->graph) != NULL), "there is none, or there should not be");
    expect(good == (ng_graph_error(p->graph)[0] == 0), "an error without a reason, or a reason without");
    if (good)
        check_plan(ng_graph_plan(p->graph));
    for (size_t i = 0; i < NG_COUNT(dumps); i++) {
        char *text = ng_graph_dump(p->graph, dumps[i]);
        expect(good == (text != NULL), "its dump");
        free(text);
    }
}

static void next_frame(struct player *p)
{
    compile(p);
    ng_graph_begin(p->graph);
    p->pass_count = 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static void (*const calls[])(struct player *) = {
        add_image,      add_buffer,  persistent_image, persistent_buffer, history_image,
        history_buffer, add_token,   import_image,     import_buffer,     export_ref,
        read_back,      read_back,   add_pass,         add_pass,          read_ref,
        read_ref,       read_ref_as, read_part,        write_ref,         write_ref,
        write_part,     after,       compile,          next_frame};
    struct player p = {.at = data, .end = data + size};
    uint8_t bits = take(&p);
    target_begin();
    ng_result result = ng_graph_create(&(struct ng_graph_params){.no_culling = bits & 1,
                                                                 .no_aliasing = bits >> 1 & 1,
                                                                 .no_unified = bits >> 2 & 1,
                                                                 .no_keys = bits >> 3 & 1},
                                       &p.graph);
    target_end(result);
    target_begin(); // each frame may have one message of its own
    while (p.at < p.end)
        calls[take(&p) % NG_COUNT(calls)](&p);
    next_frame(&p);
    target_ignore();
    ng_graph_destroy(&p.graph);
    return 0;
}

// 2,000 random frames against an independent reading of their plans.
//
// The reader knows the table of uses and Vulkan's rules, but nothing of how plans are made. It walks the
// steps and keeps, for each resource, every access since the last layout transition: what it is ordered
// before, and to whom its writes are visible. It also follows content: which version of a resource lies in
// which place. So it finds missing barriers and waits, wrong layouts, memory shared by what lives at the same
// time, copies that are missing or useless. To show that it can fail, plans are damaged in every way it
// should notice.
#include "test.h"

#include "base/array.h"
#include "base/rng.h"
#include "gpu/buffer.h"
#include "gpu/image.h"
#include "graph/graph.h"
#include "graph/plan.h"

#define GRAPHS      2000
#define MAX_PASSES  24
#define MAX_USES    5
#define MAX_OBJECTS 20

static ng_result nothing(const struct ng_pass_context *ctx)
{
    NG_UNUSED(ctx);
    return NG_OK;
}

// ---- Random frames -------------------------------------------------------------------------------------

struct random_use {
    uint32_t resource, version; // before
    bool write;
};

struct random_frame {
    uint32_t pass_count, resource_count;
    struct {
        struct random_use uses[MAX_USES];
        uint32_t use_count;
        bool side_effect;
    } passes[MAX_PASSES];
    struct {
        struct ng_graph_ref ref;
        bool is_image, depth, clear, import, content, lasts, exported, read_back;
        uint32_t latest;
    } resources[MAX_OBJECTS];
};

static struct ng_gpu_image fake_images[MAX_OBJECTS];
static struct ng_gpu_buffer fake_buffers[MAX_OBJECTS];
static char fake_memory[16];

static void add_random_image(struct ng_graph *g, struct ng_rng *rng, struct random_frame *f, uint32_t i,
                             const char *name)
{
    bool depth = f->resources[i].depth = ng_rng_below(rng, 3) == 0;
    VkFormat format = depth ? VK_FORMAT_D32_SFLOAT : VK_FORMAT_R8G8B8A8_UNORM;
    if (f->resources[i].import) {
        enum ng_use initial = f->resources[i].content ? NG_USE_SAMPLED : NG_USE_NONE;
        enum ng_use finals[] = {NG_USE_PRESENT, NG_USE_SAMPLED, NG_USE_NONE};
        fake_images[i] = (struct ng_gpu_image){.width = 16,
                                               .height = 16,
                                               .layers = 1,
                                               .mips = 1,
                                               .format = format,
                                               .usage = ~(VkImageUsageFlags)0};
        f->resources[i].ref = ng_graph_import_image(
            g, name, &fake_images[i], &(struct ng_graph_import){initial, finals[ng_rng_below(rng, 3)]});
        return;
    }
    struct ng_graph_image_params p = {
        .format = format, .width = 16, .height = 16, .clear = f->resources[i].clear};
    if (f->resources[i].lasts)
        f->resources[i].ref = ng_graph_persistent_image(g, name, &p, NULL);
    else
        f->resources[i].ref = ng_graph_add_image(g, name, &p);
}

static void add_random_buffer(struct ng_graph *g, struct ng_rng *rng, struct random_frame *f, uint32_t i,
                              const char *name)
{
    if (f->resources[i].import) {
        fake_buffers[i] =
            (struct ng_gpu_buffer){.size = 64, .usage = ~(VkBufferUsageFlags)0, .mapped = fake_memory};
        f->resources[i].ref = ng_graph_import_buffer(
            g, name, &fake_buffers[i],
            &(struct ng_graph_import){f->resources[i].content ? NG_USE_STORAGE_READ : NG_USE_NONE,
                                      NG_USE_NONE});
        return;
    }
    struct ng_graph_buffer_params p = {.size = 64 + 64 * ng_rng_below(rng, 100),
                                       .clear = f->resources[i].clear};
    if (f->resources[i].lasts)
        f->resources[i].ref = ng_graph_persistent_buffer(g, name, &p, NULL);
    else
        f->resources[i].ref = ng_graph_add_buffer(g, name, &p);
}

static void add_random_resource(struct ng_graph *g, struct ng_rng *rng, struct random_frame *f, uint32_t i)
{
    char name[16];
    snprintf(name, sizeof name, "r%u", i);
    f->resources[i].is_image = ng_rng_below(rng, 2);
    uint32_t kind = ng_rng_below(rng, 10);
    f->resources[i].import = kind == 0;
    f->resources[i].lasts = kind <= 1;
    f->resources[i].content = f->resources[i].import && ng_rng_below(rng, 2);
    f->resources[i].clear = !f->resources[i].import && ng_rng_below(rng, 3) == 0;
    if (f->resources[i].is_image)
        add_random_image(g, rng, f, i, name);
    else
        add_random_buffer(g, rng, f, i, name);
    if (ng_rng_below(rng, 8) == 0)
        ng_graph_readback(g, name), f->resources[i].read_back = true;
}

// A word that fits the kind of pass, the resource and the direction; NG_USE_NONE if the try failed.
static enum ng_use random_word(struct ng_rng *rng, const struct random_frame *f, uint32_t i,
                               enum ng_pass_kind kind, bool write, bool defined)
{
    enum ng_use use = (enum ng_use)ng_rng_below(rng, NG_USE_COUNT);
    const struct ng_use_info *info = ng_use_info(use);
    bool storage = info->image_usage & VK_IMAGE_USAGE_STORAGE_BIT;
    bool wants_depth = use == NG_USE_DEPTH || use == NG_USE_DEPTH_READ;
    if (info->writes != write || !info->stages[kind] || use == NG_USE_PRESENT)
        return NG_USE_NONE;
    if (f->resources[i].is_image ? !ng_use_of_images(use) : !ng_use_of_buffers(use))
        return NG_USE_NONE;
    if (f->resources[i].is_image && (f->resources[i].depth ? use == NG_USE_COLOR || storage : wants_depth))
        return NG_USE_NONE;
    return defined || (write && !info->needs_content) ? use : NG_USE_NONE;
}

static void add_random_use(struct ng_rng *rng, struct random_frame *f, uint32_t index, struct ng_pass *pass,
                           enum ng_pass_kind kind, uint32_t *depths)
{
    uint32_t i = ng_rng_below(rng, f->resource_count), *count = &f->passes[index].use_count;
    bool write = ng_rng_below(rng, 2);
    for (uint32_t k = 0; k < *count; k++)
        if (f->passes[index].uses[k].resource == i)
            return;
    bool defined = f->resources[i].latest || f->resources[i].clear || f->resources[i].content;
    enum ng_use use = NG_USE_NONE;
    for (int attempt = 0; attempt < 40 && use == NG_USE_NONE; attempt++)
        use = random_word(rng, f, i, kind, write, defined);
    bool depth = use == NG_USE_DEPTH || use == NG_USE_DEPTH_READ;
    if (use == NG_USE_NONE || (depth && (*depths)++))
        return;
    f->passes[index].uses[(*count)++] = (struct random_use){i, f->resources[i].latest, write};
    if (write) {
        f->resources[i].ref = ng_pass_write(pass, f->resources[i].ref, use);
        f->resources[i].latest++;
    } else {
        ng_pass_read(pass, f->resources[i].ref, use);
    }
}

static void declare_random(struct ng_graph *g, uint64_t seed, struct random_frame *f)
{
    struct ng_rng rng = ng_rng_make(seed, 1);
    memset(f, 0, sizeof *f);
    ng_graph_begin(g);
    f->resource_count = 3 + ng_rng_below(&rng, MAX_OBJECTS - 3);
    f->pass_count = 1 + ng_rng_below(&rng, MAX_PASSES - 1);
    for (uint32_t i = 0; i < f->resource_count; i++)
        add_random_resource(g, &rng, f, i);
    for (uint32_t p = 0; p < f->pass_count; p++) {
        char name[16];
        snprintf(name, sizeof name, "p%u", p);
        enum ng_pass_kind kind = (enum ng_pass_kind)ng_rng_below(&rng, NG_PASS_KIND_COUNT);
        f->passes[p].side_effect = ng_rng_below(&rng, 12) == 0;
        struct ng_pass *pass = ng_graph_add_pass(
            g, &(struct ng_pass_params){.name = name,
                                        .kind = kind,
                                        .run = nothing,
                                        .flags = f->passes[p].side_effect ? NG_PASS_SIDE_EFFECT : 0,
                                        .width = 16,
                                        .height = 16});
        uint32_t depths = 0;
        for (uint32_t k = 1 + ng_rng_below(&rng, MAX_USES); k-- > 0;)
            add_random_use(&rng, f, p, pass, kind, &depths);
    }
    for (uint32_t i = 0; i < f->resource_count; i++)
        if (ng_rng_below(&rng, 6) == 0) {
            ng_graph_export(g, f->resources[i].ref);
            f->resources[i].exported = true;
        }
}

// ---- The reader ----------------------------------------------------------------------------------------

struct record {
    VkPipelineStageFlags2 stages, ordered; // ordered: later work in these stages comes after
    VkAccessFlags2 write;                  // write accesses; 0: a read
    bool available;
    VkAccessFlags2 visible[64]; // by bit of the stage
    uint32_t batch, host_batch; // host_batch: of the barrier that makes it visible to the host, or NONE
    VkAccessFlags2 host_visible;
    bool host;
};

struct place {
    NG_ARRAY(struct record) records;
    VkImageLayout layout;
    int64_t content; // version; -1: none
    bool seen;
};

struct reader {
    const struct ng_plan *plan;
    struct place *places;
    uint32_t waited;       // batches below this number are done and the host knows
    const char *complaint; // the first
};

static uint32_t complaint_step; // of the last plan that was read

static void complain(struct reader *r, const char *text)
{
    if (!r->complaint)
        r->complaint = text;
}

static bool overlap(const struct ng_plan_resource *a, const struct ng_plan_resource *b)
{
    return a->block != NG_PLAN_NONE && a->block == b->block && a->offset < b->offset + b->size &&
           b->offset < a->offset + a->size;
}

// Every stage bit, where "all commands" is all of them but the host.
static VkPipelineStageFlags2 spread(VkPipelineStageFlags2 stages)
{
    return stages & VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT ? ~VK_PIPELINE_STAGE_2_HOST_BIT | stages : stages;
}

// True if the barrier waits for what was recorded.
static bool waits_for(const struct record *a, const struct ng_plan_barrier *b)
{
    VkPipelineStageFlags2 src = spread(b->src_stages);
    return !(a->stages & ~src) || (a->ordered & src);
}

static void pass_barrier(struct record *a, const struct ng_plan_barrier *b, uint32_t batch)
{
    if (!waits_for(a, b))
        return;
    a->ordered |= spread(b->dst_stages);
    bool all_memory = b->src_access & VK_ACCESS_2_MEMORY_WRITE_BIT;
    a->available = a->available || all_memory || !(a->write & ~b->src_access);
    if (!a->available)
        return;
    for (int s = 0; s < 64; s++)
        if (b->dst_stages >> s & 1)
            a->visible[s] |= b->dst_access;
    if (b->dst_stages & VK_PIPELINE_STAGE_2_HOST_BIT && a->host_batch == NG_PLAN_NONE) {
        a->host_batch = batch;
        a->host_visible = b->dst_access; // the first barrier is all that plans should need
    }
}

static void read_barrier(struct reader *r, const struct ng_plan_barrier *b, uint32_t batch)
{
    const struct ng_plan_resource *resources = r->plan->resources;
    struct place *p = &r->places[b->resource];
    for (size_t i = 0; i < p->records.count; i++)
        pass_barrier(&p->records.items[i], b, batch);
    for (uint32_t q = 0; b->alias && q < r->plan->resource_count; q++)
        for (size_t i = 0; overlap(&resources[q], &resources[b->resource]) && i < r->places[q].records.count;
             i++)
            pass_barrier(&r->places[q].records.items[i], b, batch);
    if (!resources[b->resource].is_image || b->old_layout == b->new_layout)
        return;
    if (b->old_layout != p->layout)
        complain(r, "barrier from a layout that the image is not in");
    for (size_t i = 0; i < p->records.count; i++)
        if (!waits_for(&p->records.items[i], b) || !p->records.items[i].available)
            complain(r, "transition before an access is done");
    for (uint32_t q = 0; q < r->plan->resource_count; q++)
        for (size_t i = 0; !p->seen && q != b->resource && overlap(&resources[q], &resources[b->resource]) &&
                           i < r->places[q].records.count;
             i++)
            if (!b->alias || !waits_for(&r->places[q].records.items[i], b))
                complain(r, "transition in memory that another resource still uses");
    p->layout = b->new_layout;
    p->seen = true;
    // From here on the transition stands for everything before it: a write that the barrier makes visible.
    p->records.count = 0;
    struct record t = {
        .ordered = spread(b->dst_stages), .available = true, .batch = batch, .host_batch = NG_PLAN_NONE};
    t.stages = b->dst_stages; // whoever waits for these stages waits for the transition
    t.write = VK_ACCESS_2_MEMORY_WRITE_BIT;
    for (int s = 0; s < 64; s++)
        if (b->dst_stages >> s & 1)
            t.visible[s] = b->dst_access;
    assert_true(ng_array_push(&p->records, t));
}

static void check_against(struct reader *r, const struct record *a, const struct record *b,
                          const VkAccessFlags2 access, bool final)
{
    if (!a->write && !b->write)
        return;
    if (a->host && b->host)
        return;
    if (b->host) { // GPU, then host
        if (!final && a->batch >= r->waited)
            complain(r, "the host does not wait for the GPU");
        bool late = !final && a->host_batch != NG_PLAN_NONE && a->host_batch >= r->waited;
        if (a->write && (a->host_batch == NG_PLAN_NONE || late || access & ~a->host_visible))
            complain(r, "what the GPU wrote is not visible to the host");
        return;
    }
    if (b->stages & ~a->ordered)
        complain(r, "access not ordered after an earlier one");
    if (!a->write)
        return;
    for (int s = 0; s < 64; s++)
        if ((b->stages >> s & 1) && (access & ~a->visible[s]))
            complain(r, "access does not see an earlier write");
}

// All that the step does to one resource, as one access.
static void read_access(struct reader *r, const struct ng_plan_step *step, uint32_t resource)
{
    const struct ng_plan *plan = r->plan;
    struct place *p = &r->places[resource];
    bool final = step->kind == NG_STEP_FINAL;
    VkAccessFlags2 access = 0;
    struct record b = {.batch = step->batch, .host_batch = NG_PLAN_NONE};
    for (uint32_t i = step->first_use; i < step->first_use + step->use_count; i++) {
        const struct ng_plan_use *u = &plan->uses[i];
        const struct ng_use_info *info = ng_use_info(u->use);
        if (u->resource != resource)
            continue;
        for (int k = 0; k < NG_PASS_KIND_COUNT; k++)
            if (final || k == (int)step->pass_kind)
                b.stages |= info->stages[k];
        access |= info->access;
        if (u->write)
            b.write |= ng_use_write_access(info->access);
        if (plan->resources[resource].is_image && p->layout != info->layout)
            complain(r, "image is not in the layout of the use");
    }
    b.host = b.stages == VK_PIPELINE_STAGE_2_HOST_BIT;
    for (size_t i = 0; i < p->records.count; i++)
        check_against(r, &p->records.items[i], &b, access, final);
    for (uint32_t q = 0; !p->seen && q < plan->resource_count; q++)
        for (size_t i = 0; q != resource && overlap(&plan->resources[q], &plan->resources[resource]) &&
                           i < r->places[q].records.count;
             i++)
            if (!(b.host && r->places[q].records.items[i].host) && // CPU passes run one after another
                (b.stages & ~r->places[q].records.items[i].ordered ||
                 !r->places[q].records.items[i].available))
                complain(r, "access to memory that another resource still uses");
    p->seen = true;
    if (!b.write)
        b.available = true;
    if (b.host && b.write)
        p->records.count = 0; // all of it was waited for; what comes later must be ordered after this
    assert_true(ng_array_push(&p->records, b));
}

// Content: a pass finds the version it reads, and every copy carries something new.
static void read_content(struct reader *r, const struct ng_plan_step *step)
{
    const struct ng_plan_use *u = &r->plan->uses[step->first_use];
    if (step->kind == NG_STEP_CLEAR) {
        if (r->places[u->resource].content >= 0)
            complain(r, "content is cleared away");
        r->places[u->resource].content = 0;
    } else if (step->kind == NG_STEP_DOWNLOAD || step->kind == NG_STEP_UPLOAD) {
        if (r->places[u[0].resource].content <= r->places[u[1].resource].content)
            complain(r, "a copy that carries nothing new");
        r->places[u[1].resource].content = r->places[u[0].resource].content;
    }
    for (uint32_t i = 0; step->kind == NG_STEP_PASS && i < step->use_count; i++) {
        int64_t *content = &r->places[u[i].resource].content, before = (int64_t)u[i].version - u[i].write;
        bool starts = before == 0 && *content < 0 && u[i].write && !ng_use_info(u[i].use)->needs_content;
        bool keeps = u[i].use != NG_USE_HOST_WRITE;
        if (keeps && *content != before && !starts)
            complain(r, "a pass finds another version than it declared");
        bool attached = u[i].use == NG_USE_COLOR || u[i].use == NG_USE_DEPTH;
        if (attached && (u[i].load == NG_LOAD_KEEP) != (*content >= 0))
            complain(r, "an attachment is loaded without content, or loses it");
        *content = u[i].write ? (int64_t)u[i].version : *content;
    }
}

// Whether the GPU has any part in a resource of a graph that is new.
static bool gpu_touches(const struct ng_plan *plan, uint32_t resource)
{
    for (uint32_t s = 0; s < plan->step_count; s++)
        for (uint32_t k = 0; k < plan->steps[s].use_count; k++) {
            const struct ng_plan_use *u = &plan->uses[plan->steps[s].first_use + k];
            if (u->resource == resource && !ng_use_info(u->use)->host)
                return true;
        }
    return false;
}

static void start_places(struct reader *r, const struct random_frame *f)
{
    for (uint32_t i = 0; i < r->plan->resource_count; i++) {
        const struct ng_plan_resource *res = &r->plan->resources[i];
        struct place *p = &r->places[i];
        p->records.count = 0;
        p->seen = false;
        p->layout = res->initial_layout;
        p->content = i < f->resource_count && f->resources[i].content ? 0 : -1;
        bool lasts = i < f->resource_count && f->resources[i].lasts;
        if (!lasts || !res->host ||
            (!f->resources[i].import && !f->resources[i].clear && !gpu_touches(r->plan, i)))
            continue;
        // The last frame's GPU may still be at it; the opening barrier orders only the GPU after that.
        struct record before = {.stages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                .ordered = spread(VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT),
                                .write = VK_ACCESS_2_MEMORY_WRITE_BIT,
                                .host_batch = NG_PLAN_NONE};
        for (int s = 0; s < 64; s++)
            before.visible[s] = ~(VkAccessFlags2)0;
        assert_true(ng_array_push(&p->records, before));
    }
}

// Live ranges from the uses alone; an export lives to the end.
static void check_memory(struct reader *r, const struct random_frame *f, uint32_t (*live)[2])
{
    const struct ng_plan *plan = r->plan;
    for (uint32_t i = 0; i < plan->resource_count; i++)
        live[i][0] = UINT32_MAX, live[i][1] = 0;
    for (uint32_t s = 0; s < plan->step_count; s++)
        for (uint32_t k = 0; k < plan->steps[s].use_count; k++) {
            uint32_t i = plan->uses[plan->steps[s].first_use + k].resource;
            live[i][0] = live[i][0] < s ? live[i][0] : s;
            live[i][1] = i < f->resource_count && f->resources[i].exported ? plan->step_count : s;
        }
    for (uint32_t a = 0; a < plan->resource_count; a++) {
        const struct ng_plan_resource *ra = &plan->resources[a];
        bool used = live[a][0] != UINT32_MAX, lasts = a < f->resource_count && f->resources[a].lasts;
        if (used && !lasts &&
            (ra->block == NG_PLAN_NONE || ra->offset % ra->alignment ||
             ra->offset + ra->size > plan->blocks[ra->block].size))
            complain(r, "a resource without its memory");
        for (uint32_t b = 0; used && b < a; b++)
            if (live[b][0] != UINT32_MAX && overlap(ra, &plan->resources[b]) && live[a][0] <= live[b][1] &&
                live[b][0] <= live[a][1])
                complain(r, "two resources live in the same memory at the same time");
    }
}

static const char *read_plan(const struct ng_plan *plan, const struct random_frame *f)
{
    static struct place places[2 * MAX_OBJECTS];
    static uint32_t live[2 * MAX_OBJECTS][2];
    struct reader r = {.plan = plan, .places = places};
    start_places(&r, f);
    check_memory(&r, f, live);
    for (uint32_t s = 0; s < plan->step_count; s++) {
        const struct ng_plan_step *step = &plan->steps[s];
        complaint_step = r.complaint ? complaint_step : s;
        if (step->wait_batch != NG_PLAN_NONE && step->wait_batch >= r.waited)
            r.waited = step->wait_batch + 1;
        for (uint32_t i = 0; i < step->barrier_count; i++)
            read_barrier(&r, &plan->barriers[step->first_barrier + i], step->batch);
        read_content(&r, step);
        for (uint32_t i = 0; i < plan->resource_count; i++)
            for (uint32_t k = 0; k < step->use_count; k++)
                if (plan->uses[step->first_use + k].resource == i) {
                    read_access(&r, step, i);
                    break;
                }
    }
    return r.complaint;
}

// ---- Culling -------------------------------------------------------------------------------------------

static bool writes_version(const struct random_frame *f, uint32_t pass, uint32_t resource, uint32_t version)
{
    for (uint32_t k = 0; k < f->passes[pass].use_count; k++) {
        const struct random_use *u = &f->passes[pass].uses[k];
        if (u->write && u->resource == resource && u->version + 1 == version)
            return true;
    }
    return false;
}

// Reachability by repeating until nothing changes.
static void naive_culling(const struct random_frame *f, bool *live)
{
    for (uint32_t p = 0; p < f->pass_count; p++) {
        live[p] = f->passes[p].side_effect;
        for (uint32_t k = 0; k < f->passes[p].use_count; k++) {
            const struct random_use *u = &f->passes[p].uses[k];
            bool last = u->version + 1 == f->resources[u->resource].latest;
            live[p] |=
                u->write &&
                (f->resources[u->resource].lasts ||
                 ((f->resources[u->resource].exported || f->resources[u->resource].read_back) && last));
        }
    }
    for (bool changed = true; changed;) {
        changed = false;
        for (uint32_t p = 0; p < f->pass_count; p++)
            for (uint32_t k = 0; live[p] && k < f->passes[p].use_count; k++)
                for (uint32_t w = 0; w < f->pass_count; w++)
                    if (!live[w] &&
                        writes_version(f, w, f->passes[p].uses[k].resource, f->passes[p].uses[k].version))
                        live[w] = changed = true;
    }
}

// ---- Tests ---------------------------------------------------------------------------------------------

static struct ng_graph *make_graph(uint64_t seed)
{
    struct ng_graph *g = NULL;
    assert_int_equal(ng_graph_create(&(struct ng_graph_params){.no_aliasing = seed % 7 == 0,
                                                               .no_culling = seed % 5 == 0,
                                                               .no_unified = seed % 3 == 0},
                                     &g),
                     NG_OK);
    return g;
}

static void random_frames_have_no_hazards(void **state)
{
    NG_UNUSED(state);
    static struct random_frame f;
    uint32_t steps = 0, barriers = 0, aliased = 0, waits = 0, copies = 0;
    for (uint64_t seed = 0; seed < GRAPHS; seed++) {
        struct ng_graph *g = make_graph(seed);
        declare_random(g, seed, &f);
        assert_int_equal(ng_graph_compile(g), NG_OK);
        const struct ng_plan *plan = ng_graph_plan(g);
        const char *complaint = read_plan(plan, &f);
        if (complaint) {
            char *text = ng_graph_dump(g, NG_DUMP_TEXT);
            fputs(text, stdout); // cmocka cuts long messages
            fail_msg("frame %d, step %u: %s", (int)seed, complaint_step, complaint);
        }
        bool live[MAX_PASSES];
        naive_culling(&f, live);
        for (uint32_t p = 0; p < f.pass_count; p++)
            assert_int_equal(plan->passes[p].step != NG_PLAN_NONE, live[p] || seed % 5 == 0);
        steps += plan->step_count;
        barriers += plan->barrier_count;
        for (uint32_t i = 0; i < plan->barrier_count; i++)
            aliased += plan->barriers[i].alias;
        for (uint32_t i = 0; i < plan->step_count; i++) {
            waits += plan->steps[i].wait_batch != NG_PLAN_NONE;
            copies += plan->steps[i].kind == NG_STEP_DOWNLOAD || plan->steps[i].kind == NG_STEP_UPLOAD;
        }
        ng_graph_destroy(&g);
    }
    // The frames were worth looking at.
    print_message("%u steps, %u barriers (%u take memory over), %u waits, %u copies\n", steps, barriers,
                  aliased, waits, copies);
    assert_true(barriers > 10 * GRAPHS && aliased > GRAPHS / 2 && waits > GRAPHS / 2 && copies > GRAPHS);
}

// A copy of a plan that may be damaged.
struct damaged {
    struct ng_plan plan;
    struct ng_plan_step steps[512];
    struct ng_plan_barrier barriers[1024];
    struct ng_plan_resource resources[2 * MAX_OBJECTS];
    struct ng_plan_use uses[1024];
};

static void copy_plan(struct damaged *d, const struct ng_plan *plan)
{
    assert_true(plan->step_count <= NG_COUNT(d->steps) && plan->barrier_count <= NG_COUNT(d->barriers) &&
                plan->use_count <= NG_COUNT(d->uses) && plan->resource_count <= NG_COUNT(d->resources));
    d->plan = *plan;
    for (uint32_t i = 0; i < plan->step_count; i++)
        d->steps[i] = plan->steps[i];
    for (uint32_t i = 0; i < plan->barrier_count; i++)
        d->barriers[i] = plan->barriers[i];
    for (uint32_t i = 0; i < plan->resource_count; i++)
        d->resources[i] = plan->resources[i];
    for (uint32_t i = 0; i < plan->use_count; i++)
        d->uses[i] = plan->uses[i];
    d->plan.steps = d->steps;
    d->plan.barriers = d->barriers;
    d->plan.resources = d->resources;
    d->plan.uses = d->uses;
}

static bool noticed(const struct damaged *d, const struct random_frame *f)
{
    return read_plan(&d->plan, f) != NULL;
}

// A barrier without effect: as if it had been forgotten.
static void disarm(struct ng_plan_barrier *b)
{
    b->src_stages = b->dst_stages = 0;
    b->src_access = b->dst_access = 0;
    b->new_layout = b->old_layout;
    b->alias = false;
}

// Every barrier is missed when it is forgotten. (Where memory is taken over that may go unnoticed: these
// barriers are global, and an earlier one may have ordered the same accesses already.)
static void forget_barriers(struct ng_graph *g, const struct random_frame *f, struct damaged *d,
                            uint32_t *taken_over, uint32_t *missed)
{
    const struct ng_plan *plan = ng_graph_plan(g);
    for (uint32_t i = 0; i < plan->barrier_count; i++) {
        copy_plan(d, plan);
        disarm(&d->barriers[i]);
        bool seen = noticed(d, f);
        if (plan->barriers[i].alias) {
            ++*taken_over;
            *missed += seen;
        } else if (!seen) {
            char *text = ng_graph_dump(g, NG_DUMP_TEXT);
            fputs(text, stdout);
            fail_msg("barrier %u of '%s' is not missed", i, plan->resources[plan->barriers[i].resource].name);
        }
    }
}

static void the_reader_notices_forgotten_barriers_and_waits(void **state)
{
    NG_UNUSED(state);
    static struct random_frame f;
    static struct damaged d;
    uint32_t taken_over = 0, missed = 0;
    for (uint64_t seed = 1; seed < 300; seed++) {
        struct ng_graph *g = make_graph(seed);
        declare_random(g, seed, &f);
        assert_int_equal(ng_graph_compile(g), NG_OK);
        const struct ng_plan *plan = ng_graph_plan(g);
        forget_barriers(g, &f, &d, &taken_over, &missed);
        for (uint32_t i = 0; i < plan->step_count; i++) {
            copy_plan(&d, plan);
            d.steps[i].wait_batch = NG_PLAN_NONE;
            assert_true(plan->steps[i].wait_batch == NG_PLAN_NONE || noticed(&d, &f));
        }
        ng_graph_destroy(&g);
    }
    print_message("%u of %u forgotten takeovers noticed\n", missed, taken_over);
    assert_true(taken_over > 50 && missed * 10 >= taken_over * 8);
}

static void the_reader_notices_shared_memory(void **state)
{
    NG_UNUSED(state);
    static struct random_frame f;
    static struct damaged d;
    uint32_t tried = 0;
    for (uint64_t seed = 1; seed < 200; seed++) {
        struct ng_graph *g = make_graph(seed);
        declare_random(g, seed, &f);
        assert_int_equal(ng_graph_compile(g), NG_OK);
        const struct ng_plan *plan = ng_graph_plan(g);
        for (uint32_t a = 0; a < plan->resource_count; a++)
            for (uint32_t b = 0; b < a; b++) {
                const struct ng_plan_resource *ra = &plan->resources[a], *rb = &plan->resources[b];
                if (ra->block == NG_PLAN_NONE || ra->block != rb->block || ra->first_step > rb->last_step ||
                    rb->first_step > ra->last_step)
                    continue;
                copy_plan(&d, plan);
                d.resources[a].offset = rb->offset;
                assert_true(noticed(&d, &f));
                tried++;
            }
        ng_graph_destroy(&g);
    }
    assert_true(tried > 200);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_frames_have_no_hazards),
        cmocka_unit_test(the_reader_notices_forgotten_barriers_and_waits),
        cmocka_unit_test(the_reader_notices_shared_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

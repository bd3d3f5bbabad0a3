// Barriers, by following each resource through the steps in order.
//
// Followed are: the stages and accesses of the last write; to which stage and access that write is visible
// already; the stages that have read since; the layout. A use then needs a barrier if it writes after
// anything, changes the layout, or reads what is not yet visible to it. Layout transitions count as writes.
// Resources are followed as a whole: two passes that write different layers are ordered one after the other.
//
// The host side is different: what the GPU wrote needs a barrier to the host stage and a wait for its batch;
// what the GPU only read needs the wait; what the host wrote is visible to all batches submitted later
// (Vulkan 1.3, 7.9 "Host Write Ordering Guarantees"), the barrier only says so.
//
// Where a resource takes over memory, its first use waits for everything that touched the bytes before.
#include "graph/graph_internal.h"

#include <string.h>

#define HOST        VK_PIPELINE_STAGE_2_HOST_BIT
#define HOST_ACCESS (VK_ACCESS_2_HOST_READ_BIT | VK_ACCESS_2_HOST_WRITE_BIT)

// Single stages, as far as the table of uses has them: the rows of `visible` below.
static const VkPipelineStageFlags2 stage_bits[] = {
    VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
    VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT,
    VK_PIPELINE_STAGE_2_VERTEX_ATTRIBUTE_INPUT_BIT,
    VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT,
    VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT,
    VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT,
    VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT,
    VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
    VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
    VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
    VK_PIPELINE_STAGE_2_HOST_BIT,
};

struct state {
    VkPipelineStageFlags2 write_stages, read_stages;
    VkAccessFlags2 write_access;
    VkAccessFlags2 visible[NG_COUNT(stage_bits)]; // accesses of each stage that see the last write
    VkImageLayout layout;
    uint32_t gpu_batch; // the last batch that touches it, or NONE
    bool touched;
};

// What a step does to a resource: all its uses of it in one.
struct need {
    VkPipelineStageFlags2 stages;
    VkAccessFlags2 access;
    VkImageLayout layout;
    bool write, final;
};

// Bytes of a block and who had them last. Those before did what they did before that one's first use.
struct owned {
    uint32_t block, resource;
    uint64_t begin, end;
};

struct sync {
    struct compile *c;
    struct ng_graph *g;
    struct state *states; // by plan resource
    uint32_t batch;       // the one that is open
    uint32_t waited;      // batches below this number are done and the host knows
    struct owned *owned;  // in order of block and offset
    uint32_t owned_count;
};

static bool visible_to(const struct state *s, const struct need *n)
{
    for (size_t i = 0; i < NG_COUNT(stage_bits); i++)
        if ((n->stages & stage_bits[i]) && (s->visible[i] & n->access) != n->access)
            return false;
    return true;
}

static void make_visible(struct state *s, const struct need *n)
{
    for (size_t i = 0; i < NG_COUNT(stage_bits); i++)
        if (n->stages & stage_bits[i])
            s->visible[i] |= n->access;
}

static void make_invisible(struct state *s)
{
    for (size_t i = 0; i < NG_COUNT(stage_bits); i++)
        s->visible[i] = 0;
}

static ng_result add_barrier(struct sync *y, const struct ng_plan_barrier *b)
{
    return ng_array_push(&y->g->plan_barriers, *b) ? NG_OK : graph_no_memory(y->g);
}

// ---- Memory taken over ---------------------------------------------------------------------------------

// The first entry that ends behind `offset` of the block, or is of a later block.
static uint32_t find_owned(const struct sync *y, uint32_t block, uint64_t offset)
{
    uint32_t low = 0, high = y->owned_count;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        const struct owned *o = &y->owned[middle];
        if (o->block < block || (o->block == block && o->end <= offset))
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

// Adds to the barrier's source what earlier resources did in the memory of `resource`, which is its own now.
static void take_over(struct sync *y, uint32_t resource, struct ng_plan_barrier *b)
{
    const struct ng_plan_resource *r = &y->g->plan_resources.items[resource];
    if (r->block == NG_PLAN_NONE)
        return;
    struct owned mine[3] = {{r->block, resource, r->offset, r->offset + r->size}};
    uint32_t first = find_owned(y, r->block, r->offset), next = first, count = 1;
    for (; next < y->owned_count && y->owned[next].block == r->block && y->owned[next].begin < mine[0].end;
         next++) {
        b->alias = true;
        b->src_stages |= y->c->stages[y->owned[next].resource];
        b->src_access |= y->c->write_access[y->owned[next].resource];
    }
    const struct owned left = next > first ? y->owned[first] : mine[0];
    const struct owned right = next > first ? y->owned[next - 1] : mine[0];
    if (left.begin < r->offset) {
        mine[count++] = mine[0];
        mine[0] = left;
        mine[0].end = r->offset;
    }
    if (right.end > r->offset + r->size) {
        mine[count] = right;
        mine[count++].begin = r->offset + r->size;
    }
    memmove(y->owned + first + count, y->owned + next, (y->owned_count - next) * sizeof *y->owned);
    memcpy(y->owned + first, mine, count * sizeof *mine);
    y->owned_count = y->owned_count - (next - first) + count;
}

// ---- One need ------------------------------------------------------------------------------------------

static ng_result synchronise_gpu(struct sync *y, uint32_t resource, const struct need *n)
{
    struct state *s = &y->states[resource];
    const struct ng_plan_resource *r = &y->g->plan_resources.items[resource];
    struct ng_plan_barrier b = {.resource = resource,
                                .src_stages = s->write_stages | s->read_stages,
                                .src_access = s->write_access,
                                .dst_stages = n->stages,
                                .dst_access = n->access,
                                .old_layout = s->layout,
                                .new_layout = n->layout};
    if (!s->touched)
        take_over(y, resource, &b);
    bool transition = r->is_image && s->layout != n->layout;
    bool unseen = s->write_stages && !visible_to(s, n);
    bool after = n->write && b.src_stages;
    if (transition || unseen || after || b.alias) {
        // A transition of untouched content follows what opened the frame, or the wait for a swapchain image.
        if (!b.src_stages)
            b.src_stages = n->stages ? n->stages : VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
        NG_TRY(add_barrier(y, &b));
        if (transition || n->write)
            make_invisible(s);
        make_visible(s, n);
    }
    if (n->write) {
        make_invisible(s);
        s->write_stages = n->stages;
        s->write_access = ng_use_write_access(n->access);
        s->read_stages = 0;
    } else if (transition) {
        s->write_stages |= b.src_stages | n->stages;
        s->read_stages = n->stages;
    } else {
        s->read_stages |= n->stages;
    }
    s->layout = n->layout;
    s->gpu_batch = y->batch;
    return NG_OK;
}

static ng_result synchronise_host(struct sync *y, uint32_t resource, const struct need *n,
                                  uint32_t *wait_batch)
{
    struct state *s = &y->states[resource];
    // Both accesses are made visible, so that a later use of the other kind finds nothing left to do.
    const struct need any = {.stages = HOST, .access = HOST_ACCESS};
    bool unseen = s->write_stages && !visible_to(s, n);
    if (unseen) {
        NG_TRY(add_barrier(y, &(struct ng_plan_barrier){.resource = resource,
                                                        .src_stages = s->write_stages | s->read_stages,
                                                        .src_access = s->write_access,
                                                        .dst_stages = HOST,
                                                        .dst_access = HOST_ACCESS}));
        make_visible(s, &any);
        s->gpu_batch = y->batch;
    }
    // A write that is visible has been waited for by whoever made it so; reads of the GPU may still be going
    // on.
    bool busy = s->gpu_batch != NG_PLAN_NONE && s->gpu_batch >= y->waited;
    bool wait = busy && (unseen || n->write) && !n->final;
    if (wait && (*wait_batch == NG_PLAN_NONE || *wait_batch < s->gpu_batch))
        *wait_batch = s->gpu_batch;
    if (n->write) {
        make_invisible(s);
        make_visible(s, &any);
        s->write_stages = HOST;
        s->write_access = VK_ACCESS_2_HOST_WRITE_BIT;
        s->read_stages = 0;
        s->gpu_batch = NG_PLAN_NONE;
    } else {
        s->read_stages |= HOST;
    }
    return NG_OK;
}

// ---- Steps ---------------------------------------------------------------------------------------------

// A word's stages outside of any pass: all that it could mean.
static VkPipelineStageFlags2 any_stages(const struct ng_use_info *info)
{
    VkPipelineStageFlags2 stages = 0;
    for (int k = 0; k < NG_PASS_KIND_COUNT; k++)
        stages |= info->stages[k];
    return stages;
}

// All uses that the step makes of the resource of its use `first`; false if an earlier use was that already.
static bool gather(const struct sync *y, const struct ng_plan_step *step, uint32_t first, struct need *n)
{
    const struct ng_plan_use *uses = y->g->plan_uses.items;
    uint32_t end = step->first_use + step->use_count, resource = uses[first].resource;
    for (uint32_t i = step->first_use; i < first; i++)
        if (uses[i].resource == resource)
            return false;
    *n = (struct need){.final = step->kind == NG_STEP_FINAL};
    for (uint32_t i = first; i < end; i++) {
        if (uses[i].resource != resource)
            continue;
        const struct ng_use_info *info = ng_use_info(uses[i].use);
        n->stages |= n->final ? any_stages(info) : info->stages[step->pass_kind];
        n->access |= info->access;
        n->write = n->write || uses[i].write;
        n->layout = y->g->plan_resources.items[resource].is_image ? info->layout : VK_IMAGE_LAYOUT_UNDEFINED;
    }
    return true;
}

static ng_result synchronise_use(struct sync *y, struct ng_plan_step *step, uint32_t use)
{
    struct need n;
    if (!gather(y, step, use, &n))
        return NG_OK;
    uint32_t resource = y->g->plan_uses.items[use].resource;
    if (n.stages == HOST)
        NG_TRY(synchronise_host(y, resource, &n, &step->wait_batch));
    else
        NG_TRY(synchronise_gpu(y, resource, &n));
    y->states[resource].touched = true;
    y->c->stages[resource] |= n.stages;
    y->c->write_access[resource] |= ng_use_write_access(n.access);
    return NG_OK;
}

static ng_result synchronise_step(struct sync *y, uint32_t index)
{
    struct ng_graph *g = y->g;
    struct ng_plan_step *step = &g->plan_steps.items[index];
    step->first_barrier = (uint32_t)g->plan_barriers.count;
    step->batch = y->batch;
    for (uint32_t i = 0; i < step->use_count; i++)
        NG_TRY(synchronise_use(y, step, step->first_use + i));
    step->barrier_count = (uint32_t)g->plan_barriers.count - step->first_barrier;
    if (step->wait_batch != NG_PLAN_NONE)
        y->waited = step->wait_batch + 1;
    if (step->wait_batch == y->batch)
        y->batch++; // the open batch is submitted so that it can be waited for
    return NG_OK;
}

// Buffers that last and that the host touches: the GPU may still be at work on them for an earlier frame, if
// it ever was.
static void start(struct sync *y, uint32_t resource)
{
    const struct ng_plan_resource *r = &y->g->plan_resources.items[resource];
    struct state *s = &y->states[resource];
    s->layout = r->initial_layout;
    s->gpu_batch = NG_PLAN_NONE;
    if (!r->host || r->kind == NG_RESOURCE_TRANSIENT || r->kind == NG_RESOURCE_STAGING)
        return;
    if (r->cpu && !y->g->resources.items[resource].gpu_knows)
        return;
    s->write_stages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    s->write_access = VK_ACCESS_2_MEMORY_WRITE_BIT;
    s->gpu_batch = 0;
    for (size_t i = 0; i < NG_COUNT(stage_bits); i++)
        s->visible[i] = stage_bits[i] == HOST ? 0 : ~(VkAccessFlags2)0;
}

ng_result graph_synchronise(struct compile *c)
{
    struct ng_graph *g = c->g;
    struct sync y = {.c = c, .g = g};
    uint32_t count = (uint32_t)g->plan_resources.count;
    y.states = ng_arena_array(&g->arena, count, sizeof *y.states);
    c->stages = ng_arena_array(&g->arena, count, sizeof *c->stages);
    c->write_access = ng_arena_array(&g->arena, count, sizeof *c->write_access);
    y.owned = ng_arena_array(&g->arena, 2 * (size_t)count + 1, sizeof *y.owned); // each adds two at most
    if (!y.states || !y.owned || !c->stages || !c->write_access)
        return graph_no_memory(g);
    g->plan_barriers.count = 0;
    for (uint32_t i = 0; i < count; i++)
        start(&y, i);
    for (uint32_t s = 0; s < g->plan_steps.count; s++)
        NG_TRY(synchronise_step(&y, s));
    for (uint32_t i = 0; i < count; i++)
        g->plan_resources.items[i].final_layout = y.states[i].layout;
    g->plan.batch_count = y.batch + 1;
    return NG_OK;
}

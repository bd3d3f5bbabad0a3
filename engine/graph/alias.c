// Memory for transient resources: an interval is the steps from first to last use, and resources whose
// intervals do not meet may share bytes.
//
// Greedy by size: the largest first, each at the lowest offset where it collides with nothing that lives at
// the same time. Not optimal, but within a few per cent on frame graphs, and the same result on every
// machine. Host memory that the GPU reads or writes is not shared: the CPU would have to wait for the GPU to
// be done with the one before. What CPU passes alone use is, as they run one after another.
#include "graph/graph_internal.h"

#include <stdlib.h>

static bool is_placed(const struct ng_plan_resource *r)
{
    return (r->kind == NG_RESOURCE_TRANSIENT || r->kind == NG_RESOURCE_STAGING) &&
           r->first_step != NG_PLAN_NONE;
}

static bool lives_with(const struct ng_plan_resource *a, const struct ng_plan_resource *b)
{
    return a->first_step <= b->last_step && b->first_step <= a->last_step;
}

// The block for resources of this kind, opened where there is none.
static ng_result find_block(struct ng_graph *g, const struct ng_plan_resource *r, uint32_t *out)
{
    for (uint32_t i = 0; i < g->plan_blocks.count; i++) {
        const struct ng_plan_block *b = &g->plan_blocks.items[i];
        if (b->host == r->host && b->cpu == r->cpu && b->images == r->is_image &&
            b->memory_types == r->memory_types) {
            *out = i;
            return NG_OK;
        }
    }
    *out = (uint32_t)g->plan_blocks.count;
    struct ng_plan_block block = {.host = r->host,
                                  .cpu = r->cpu,
                                  .images = r->is_image,
                                  .memory_types = r->memory_types,
                                  .alignment = 1};
    return ng_array_push(&g->plan_blocks, block) ? NG_OK : graph_no_memory(g);
}

static uint64_t align_up(uint64_t x, uint64_t alignment)
{
    return (x + alignment - 1) / alignment * alignment;
}

struct sorted {
    uint32_t resource;
    uint64_t size, offset;
};

static int by_size(const void *pa, const void *pb)
{
    const struct sorted *a = pa, *b = pb;
    if (a->size != b->size)
        return a->size < b->size ? 1 : -1;
    return (a->resource > b->resource) - (a->resource < b->resource);
}

// `taken` holds the resources of the same block placed so far, by offset. Returns where to insert.
static uint32_t first_fit(const struct ng_graph *g, const struct sorted *taken, uint32_t count,
                          struct ng_plan_resource *r)
{
    bool share = !g->params.no_aliasing && (!r->host || r->cpu);
    uint64_t offset = 0;
    for (uint32_t i = 0; i < count; i++) {
        const struct ng_plan_resource *other = &g->plan_resources.items[taken[i].resource];
        if (other->block != r->block || (share && !lives_with(r, other)))
            continue;
        if (offset + r->size <= other->offset)
            break;
        uint64_t end = align_up(other->offset + other->size, r->alignment);
        offset = end > offset ? end : offset;
    }
    r->offset = offset;
    uint32_t at = count;
    while (at > 0 && taken[at - 1].offset > offset)
        at--;
    return at;
}

ng_result graph_place(struct compile *c)
{
    struct ng_graph *g = c->g;
    uint32_t count = 0, placed = 0, total = (uint32_t)g->plan_resources.count;
    struct sorted *order = ng_arena_array(&g->arena, total, sizeof *order);
    struct sorted *taken = ng_arena_array(&g->arena, total, sizeof *taken);
    if (!order || !taken)
        return graph_no_memory(g);
    g->plan_blocks.count = 0;
    for (uint32_t i = 0; i < total; i++) {
        struct ng_plan_resource *r = &g->plan_resources.items[i];
        if (!is_placed(r))
            continue;
        NG_TRY(graph_measure(g, r));
        NG_TRY(find_block(g, r, &r->block));
        order[count++] = (struct sorted){i, r->size, 0};
        g->plan.transient_bytes += r->size;
    }
    qsort(order, count, sizeof *order, by_size);
    for (uint32_t k = 0; k < count; k++) {
        struct ng_plan_resource *r = &g->plan_resources.items[order[k].resource];
        uint32_t at = first_fit(g, taken, placed, r);
        for (uint32_t i = placed++; i > at; i--)
            taken[i] = taken[i - 1];
        taken[at] = (struct sorted){order[k].resource, r->size, r->offset};
        struct ng_plan_block *b = &g->plan_blocks.items[r->block];
        b->size = r->offset + r->size > b->size ? r->offset + r->size : b->size;
        b->alignment = r->alignment > b->alignment ? r->alignment : b->alignment;
    }
    return NG_OK;
}

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

// ---- What lives at the same time ------------------------------------------------------------------------

struct placed {
    uint32_t resource;
    struct placed *next;
};

// A segment tree over the steps: an interval is kept at the fewest nodes that make it up, so all that meets
// another interval is found at the nodes that meet it. Node 1 is the root, 2 n and 2 n + 1 are below n.
struct tree {
    struct ng_graph *g;
    struct placed **nodes;
    bool *used; // by node: there is something at it or below
    uint32_t last;
    bool *seen; // by resource
    uint32_t *found, count;
};

static bool insert(struct tree *t, uint32_t node, uint32_t first, uint32_t last, uint32_t resource)
{
    const struct ng_plan_resource *r = &t->g->plan_resources.items[resource];
    if (first > r->last_step || last < r->first_step)
        return true;
    t->used[node] = true;
    if (first < r->first_step || last > r->last_step) {
        uint32_t middle = first + (last - first) / 2;
        return insert(t, 2 * node, first, middle, resource) &&
               insert(t, 2 * node + 1, middle + 1, last, resource);
    }
    struct placed *p = ng_arena_alloc(&t->g->arena, sizeof *p);
    if (!p)
        return false;
    *p = (struct placed){resource, t->nodes[node]};
    t->nodes[node] = p;
    return true;
}

// Lists what has been inserted and lives at the same time as `r`.
static void find(struct tree *t, uint32_t node, uint32_t first, uint32_t last,
                 const struct ng_plan_resource *r)
{
    if (first > r->last_step || last < r->first_step || !t->used[node])
        return;
    for (const struct placed *p = t->nodes[node]; p; p = p->next) {
        if (!t->seen[p->resource])
            t->found[t->count++] = p->resource;
        t->seen[p->resource] = true;
    }
    if (first == last)
        return;
    uint32_t middle = first + (last - first) / 2;
    find(t, 2 * node, first, middle, r);
    find(t, 2 * node + 1, middle + 1, last, r);
}

static ng_result make_tree(struct ng_graph *g, struct tree *t)
{
    size_t nodes = 4 * g->plan_steps.count, resources = g->plan_resources.count;
    *t = (struct tree){.g = g,
                       .nodes = ng_arena_array(&g->arena, nodes, sizeof *t->nodes),
                       .used = ng_arena_array(&g->arena, nodes, sizeof *t->used),
                       .last = (uint32_t)g->plan_steps.count - 1,
                       .seen = ng_arena_array(&g->arena, resources, sizeof *t->seen),
                       .found = ng_arena_array(&g->arena, resources, sizeof *t->found)};
    return t->nodes && t->used && t->seen && t->found ? NG_OK : graph_no_memory(g);
}

// ---- Placing -------------------------------------------------------------------------------------------

struct sorted {
    uint32_t resource;
    uint64_t key;
};

static int by_key(const void *pa, const void *pb)
{
    const struct sorted *a = pa, *b = pb;
    if (a->key != b->key)
        return a->key < b->key ? -1 : 1;
    return (a->resource > b->resource) - (a->resource < b->resource);
}

// The lowest offset at which a resource collides with nothing that lives at the same time.
static uint64_t first_fit(struct tree *t, struct sorted *taken, const struct ng_plan_resource *r)
{
    uint32_t count = 0;
    t->count = 0;
    find(t, 1, 0, t->last, r);
    for (uint32_t i = 0; i < t->count; i++) {
        const struct ng_plan_resource *other = &t->g->plan_resources.items[t->found[i]];
        t->seen[t->found[i]] = false;
        if (other->block == r->block)
            taken[count++] = (struct sorted){t->found[i], other->offset};
    }
    qsort(taken, count, sizeof *taken, by_key);
    uint64_t offset = 0;
    for (uint32_t i = 0; i < count && offset + r->size > taken[i].key; i++) {
        const struct ng_plan_resource *other = &t->g->plan_resources.items[taken[i].resource];
        uint64_t end = graph_align(other->offset + other->size, r->alignment);
        offset = end > offset ? end : offset;
    }
    return offset;
}

static ng_result place(struct tree *t, struct sorted *taken, uint32_t resource)
{
    struct ng_graph *g = t->g;
    struct ng_plan_resource *r = &g->plan_resources.items[resource];
    struct ng_plan_block *b = &g->plan_blocks.items[r->block];
    bool share = !g->params.no_aliasing && (!r->host || r->cpu);
    r->offset = share ? first_fit(t, taken, r) : graph_align(b->size, r->alignment);
    b->size = r->offset + r->size > b->size ? r->offset + r->size : b->size;
    b->alignment = r->alignment > b->alignment ? r->alignment : b->alignment;
    return !share || insert(t, 1, 0, t->last, resource) ? NG_OK : graph_no_memory(g);
}

ng_result graph_place(struct compile *c)
{
    struct ng_graph *g = c->g;
    uint32_t count = 0, total = (uint32_t)g->plan_resources.count;
    struct tree tree;
    struct sorted *order = ng_arena_array(&g->arena, total, sizeof *order);
    struct sorted *taken = ng_arena_array(&g->arena, total, sizeof *taken);
    if (!order || !taken)
        return graph_no_memory(g);
    NG_TRY(make_tree(g, &tree));
    g->plan_blocks.count = 0;
    for (uint32_t i = 0; i < total; i++) {
        struct ng_plan_resource *r = &g->plan_resources.items[i];
        if (!is_placed(r))
            continue;
        NG_TRY(graph_measure(g, r));
        NG_TRY(find_block(g, r, &r->block));
        order[count++] = (struct sorted){i, UINT64_MAX - r->size}; // the largest first
        g->plan.transient_bytes += r->size;
    }
    qsort(order, count, sizeof *order, by_key);
    for (uint32_t k = 0; k < count; k++)
        NG_TRY(place(&tree, taken, order[k].resource));
    return NG_OK;
}

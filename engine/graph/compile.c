// Compilation, stage by stage. Each stage is a file; none of them asks the device for more than sizes.
#include "graph/graph_internal.h"

#include <string.h>

// Readbacks are asked for by name; histories share their names with what they are the history of.
static void mark_readbacks(struct ng_graph *g)
{
    for (size_t i = 0; i < g->readbacks.count; i++)
        for (size_t r = 0; r < g->resources.count; r++)
            if (g->resources.items[r].kind != NG_RESOURCE_HISTORY &&
                g->resources.items[r].kind != NG_RESOURCE_TOKEN &&
                !strcmp(g->resources.items[r].name, g->readbacks.items[i]))
                g->resources.items[r].readback = true;
}

static bool is_current(const struct compile *c, uint32_t pass)
{
    const struct ng_pass *p = c->g->passes.items[pass];
    bool current = false;
    for (size_t i = 0; i < p->uses.count && !c->live[pass]; i++)
        current |= p->uses.items[i].write && c->current[p->uses.items[i].resource];
    return current;
}

static ng_result list_passes(const struct compile *c)
{
    struct ng_graph *g = c->g;
    g->plan.passes = ng_arena_array(&g->arena, g->pass_count, sizeof *g->plan.passes);
    if (!g->plan.passes)
        return graph_no_memory(g);
    g->plan.pass_count = g->pass_count;
    for (uint32_t i = 0; i < g->pass_count; i++) {
        const struct ng_pass *p = g->passes.items[i];
        g->plan.passes[i] = (struct ng_plan_pass){
            .name = p->name, .kind = p->kind, .step = NG_PLAN_NONE, .current = is_current(c, i)};
    }
    return NG_OK;
}

static void publish(struct ng_graph *g)
{
    struct ng_plan *p = &g->plan;
    p->resources = g->plan_resources.items;
    p->resource_count = (uint32_t)g->plan_resources.count;
    p->steps = g->plan_steps.items;
    p->step_count = (uint32_t)g->plan_steps.count;
    p->uses = g->plan_uses.items;
    p->use_count = (uint32_t)g->plan_uses.count;
    p->barriers = g->plan_barriers.items;
    p->barrier_count = (uint32_t)g->plan_barriers.count;
    p->blocks = g->plan_blocks.items;
    p->block_count = (uint32_t)g->plan_blocks.count;
}

static ng_result compile(struct ng_graph *g)
{
    struct compile c = {.g = g};
    mark_readbacks(g);
    NG_TRY(graph_validate(&c));
    NG_TRY(graph_order(&c));
    NG_TRY(graph_find_keys(&c));
    NG_TRY(graph_cull(&c));
    NG_TRY(list_passes(&c));
    NG_TRY(graph_expand(&c));
    NG_TRY(graph_place(&c));
    NG_TRY(graph_synchronise(&c));
    publish(g);
    return NG_OK;
}

ng_result ng_graph_compile(struct ng_graph *g)
{
    if (g->broken)
        return NG_ERROR_USAGE;
    if (g->compiled)
        return NG_OK;
    NG_TRY(compile(g));
    g->compiled = true;
    g->logged[0] = 0;
    return NG_OK;
}

const struct ng_plan *ng_graph_plan(const struct ng_graph *g)
{
    return g->compiled && !g->broken ? &g->plan : NULL;
}

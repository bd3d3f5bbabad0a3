// The order of passes, and which of them run.
//
// A pass needs: the writers of the versions it reads; for what it writes, the writer of the version before
// (the content it does not overwrite is kept) and that version's readers, who must be done; and whom
// ng_pass_after names. Refs are handed on in order of declaration, so only ng_pass_after can ask for another
// order, or for a cycle.
#include "graph/graph_internal.h"

#include <string.h>

struct reader {
    uint32_t pass, next; // next: index of another reader of the same version, or NONE
};

enum mark { UNSEEN, OPEN, DONE };

struct walk {
    struct compile *c;
    struct reader *readers;
    uint32_t *first_reader; // by version
    unsigned char *marks;   // by pass
};

static uint32_t version_index(const struct compile *c, uint32_t resource, uint32_t version)
{
    return c->first_version[resource] + version;
}

static ng_result visit(struct walk *w, uint32_t pass);

// Runs `other` before `pass`.
static ng_result need(struct walk *w, uint32_t pass, uint32_t other, const char *why)
{
    if (other == NG_PLAN_NONE || other == pass)
        return NG_OK;
    struct ng_pass *const *passes = w->c->g->passes.items;
    if (w->marks[other] == OPEN)
        return graph_fail(w->c->g, "cycle: pass '%s' must run after pass '%s' because of '%s', and before it",
                          passes[pass]->name, passes[other]->name, why);
    return visit(w, other);
}

static ng_result visit_uses(struct walk *w, uint32_t pass)
{
    struct compile *c = w->c;
    const struct ng_pass *p = c->g->passes.items[pass];
    for (size_t i = 0; i < p->uses.count; i++) {
        const struct decl_use *u = &p->uses.items[i];
        const char *name = c->g->resources.items[u->resource].name;
        uint32_t version = version_index(c, u->resource, u->version);
        NG_TRY(need(w, pass, c->writer[version], name));
        if (!u->write)
            continue;
        for (uint32_t r = w->first_reader[version]; r != NG_PLAN_NONE; r = w->readers[r].next)
            NG_TRY(need(w, pass, w->readers[r].pass, name));
    }
    return NG_OK;
}

static ng_result visit_after(struct walk *w, uint32_t pass)
{
    struct ng_graph *g = w->c->g;
    const struct ng_pass *p = g->passes.items[pass];
    for (size_t i = 0; i < p->after.count; i++) {
        uint32_t other = 0;
        while (other < g->pass_count && strcmp(g->passes.items[other]->name, p->after.items[i]) != 0)
            other++;
        if (other == g->pass_count)
            return graph_fail(g, "pass '%s' is to run after '%s', which is no pass of this frame", p->name,
                              p->after.items[i]);
        if (other == pass)
            return graph_fail(g, "cycle: pass '%s' is to run after itself", p->name);
        NG_TRY(need(w, pass, other, "ng_pass_after"));
    }
    return NG_OK;
}

static ng_result visit(struct walk *w, uint32_t pass)
{
    if (w->marks[pass] == DONE)
        return NG_OK;
    w->marks[pass] = OPEN;
    NG_TRY(visit_uses(w, pass));
    NG_TRY(visit_after(w, pass));
    w->marks[pass] = DONE;
    w->c->order[w->c->order_count++] = pass;
    return NG_OK;
}

static ng_result list_readers(struct walk *w)
{
    struct compile *c = w->c;
    struct ng_graph *g = c->g;
    uint32_t versions = c->first_version[g->resources.count], count = 0;
    size_t uses = 0;
    for (uint32_t p = 0; p < g->pass_count; p++)
        uses += g->passes.items[p]->uses.count;
    w->first_reader = ng_arena_array(&g->arena, versions, sizeof *w->first_reader);
    w->readers = ng_arena_array(&g->arena, uses, sizeof *w->readers);
    if (!w->first_reader || !w->readers)
        return graph_no_memory(g);
    memset(w->first_reader, 0xff, versions * sizeof *w->first_reader); // NG_PLAN_NONE
    for (uint32_t p = 0; p < g->pass_count; p++)
        for (size_t i = 0; i < g->passes.items[p]->uses.count; i++) {
            const struct decl_use *u = &g->passes.items[p]->uses.items[i];
            uint32_t version = version_index(c, u->resource, u->version);
            if (u->write)
                continue;
            w->readers[count] = (struct reader){p, w->first_reader[version]};
            w->first_reader[version] = count++;
        }
    return NG_OK;
}

ng_result graph_order(struct compile *c)
{
    struct ng_graph *g = c->g;
    struct walk w = {.c = c, .marks = ng_arena_alloc(&g->arena, g->pass_count)};
    c->order = ng_arena_array(&g->arena, g->pass_count, sizeof *c->order);
    if (!w.marks || !c->order)
        return graph_no_memory(g);
    NG_TRY(list_readers(&w));
    for (uint32_t p = 0; p < g->pass_count; p++)
        NG_TRY(visit(&w, p));
    return NG_OK;
}

// ---- Culling -------------------------------------------------------------------------------------------

// Whether what the pass writes leaves the frame, and is not there already.
static bool is_sink(const struct compile *c, const struct ng_pass *p)
{
    if (c->g->params.no_culling || (p->flags & NG_PASS_SIDE_EFFECT))
        return true;
    for (size_t i = 0; i < p->uses.count; i++) {
        const struct decl_use *u = &p->uses.items[i];
        enum ng_resource_kind kind = c->g->resources.items[u->resource].kind;
        bool waits = kind == NG_RESOURCE_PERSISTENT && (p->flags & NG_PASS_ON_DEMAND);
        bool leaves = kind != NG_RESOURCE_TRANSIENT &&
                      !decl_is_keyless(&c->g->resources.items[u->resource]) && !c->current[u->resource];
        if (u->write && leaves && !waits)
            return true;
    }
    return false;
}

static void mark_version(struct compile *c, uint32_t resource, uint32_t version)
{
    uint32_t writer = c->writer[version_index(c, resource, version)];
    const struct decl_resource *r = &c->g->resources.items[resource];
    if (writer != NG_PLAN_NONE && !c->current[resource] && !decl_is_scratch(r))
        c->live[writer] = true;
}

static void mark_sinks(struct compile *c)
{
    const struct ng_graph *g = c->g;
    for (size_t i = 0; i < g->exports.count; i++)
        mark_version(c, REF_RESOURCE(g->exports.items[i]), REF_VERSION(g->exports.items[i]));
    for (uint32_t r = 0; r < g->resources.count; r++)
        if (g->resources.items[r].readback)
            mark_version(c, r, c->first_version[r + 1] - c->first_version[r] - 1);
}

// Passes are in order of need, so one walk from the last to the first reaches everything. False: a pass that
// has to run writes something that was taken for current, too; then it is not.
static bool walk_back(struct compile *c)
{
    bool right = true;
    mark_sinks(c);
    for (uint32_t k = c->order_count; k-- > 0;) {
        const struct ng_pass *p = c->g->passes.items[c->order[k]];
        if (!c->live[c->order[k]] && !is_sink(c, p))
            continue;
        c->live[c->order[k]] = true;
        for (size_t i = 0; i < p->uses.count; i++) {
            const struct decl_use *u = &p->uses.items[i];
            right &= !(u->write && c->current[u->resource]);
            c->current[u->resource] &= !u->write;
            mark_version(c, u->resource, u->version);
        }
    }
    return right;
}

// What is made anew is made from nothing.
static void forget_renewed(struct compile *c)
{
    struct ng_graph *g = c->g;
    for (uint32_t p = 0; p < g->pass_count; p++)
        for (size_t i = 0; c->live[p] && i < g->passes.items[p]->uses.count; i++) {
            const struct decl_use *u = &g->passes.items[p]->uses.items[i];
            if (u->write && c->renewed[u->resource])
                g->resources.items[u->resource].has_content = false;
        }
}

ng_result graph_cull(struct compile *c)
{
    struct ng_graph *g = c->g;
    c->live = ng_arena_array(&g->arena, g->pass_count, sizeof *c->live);
    if (!c->live)
        return graph_no_memory(g);
    while (!walk_back(c)) // each time one resource fewer is current
        ;
    forget_renewed(c);
    g->current = c->current;
    return NG_OK;
}

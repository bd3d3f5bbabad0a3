// From passes to steps: what runs, and what has to happen between for content to be where and what it should
// be.
//
// Two facts are followed for each resource. Which parts are defined: the first use of an undefined part
// decides between clearing it as an attachment is loaded, clearing it by a step of its own, and leaving it.
// And, for resources with a staging copy, where the newest content is: on the GPU, in the copy, or both; a
// use of the side that is behind inserts one copy. So a resource crosses at most once each way, however many
// CPU passes follow one another.
#include "graph/graph_internal.h"

#include "gpu/image.h"

#include <stdio.h>
#include <string.h>

struct side {
    bool gpu_behind, host_behind; // the other one has newer content
    unsigned char *defined;       // by mip * layers + layer; buffers: one
};

struct expand {
    struct compile *c;
    struct ng_graph *g;
    struct side *sides; // by declared resource
};

static bool is_attachment(enum ng_use use)
{
    return use == NG_USE_COLOR || use == NG_USE_DEPTH || use == NG_USE_DEPTH_READ;
}

static bool is_token(const struct expand *e, const struct decl_use *u)
{
    return e->g->resources.items[u->resource].kind == NG_RESOURCE_TOKEN;
}

uint64_t graph_linear_size(const struct ng_graph_image_params *image)
{
    uint64_t texel = ng_gpu_format_size(image->format);
    return texel * image->width * image->height * image->layers; // dimensions are below 2^17 and 2^13
}

// ---- Resources of the plan -----------------------------------------------------------------------------

static ng_result add_resource(struct ng_graph *g, const struct ng_plan_resource *r)
{
    return ng_array_push(&g->plan_resources, *r) ? NG_OK : graph_no_memory(g);
}

static ng_result add_declared(struct expand *e, uint32_t index)
{
    const struct decl_resource *d = &e->g->resources.items[index];
    struct ng_plan_resource r = {.name = d->name,
                                 .kind = d->kind,
                                 .is_image = d->is_image,
                                 .image = d->image,
                                 .buffer = d->buffer,
                                 .initial_layout = d->initial_layout,
                                 .staging = NG_PLAN_NONE,
                                 .first_step = NG_PLAN_NONE,
                                 .last_step = NG_PLAN_NONE,
                                 .block = NG_PLAN_NONE};
    size_t parts = d->is_image ? (size_t)d->image.mips * d->image.layers : 1;
    e->sides[index].defined = ng_arena_alloc(&e->g->arena, parts);
    if (!e->sides[index].defined)
        return graph_no_memory(e->g);
    memset(e->sides[index].defined, d->has_content, parts);
    return add_resource(e->g, &r);
}

// Buffers that the host can reach as well as the GPU need no copy, nor do those that the GPU does not touch.
static bool in_place(const struct expand *e, uint32_t index)
{
    const struct ng_graph *g = e->g;
    const struct decl_resource *d = &g->resources.items[index];
    if (d->is_image)
        return false;
    if (d->kind == NG_RESOURCE_IMPORTED)
        return d->imported.buffer->mapped;
    return g->unified || d->in_host_memory || (g->plan_resources.items[index].cpu && !d->gpu_knows);
}

// Makes a resource reachable by the host: in place, or by giving it a staging copy.
static ng_result make_host_visible(struct expand *e, uint32_t index)
{
    struct ng_graph *g = e->g;
    const struct decl_resource *d = &g->resources.items[index];
    struct ng_plan_resource *r = &g->plan_resources.items[index];
    if (r->host || r->staging != NG_PLAN_NONE)
        return NG_OK;
    if (in_place(e, index)) {
        r->host = true;
        return NG_OK;
    }
    size_t length = strlen(d->name) + sizeof "@host";
    char *name = ng_arena_alloc(&g->arena, length);
    if (!name)
        return graph_no_memory(g);
    snprintf(name, length, "%s@host", d->name);
    r->staging = (uint32_t)g->plan_resources.count;
    e->sides[index].host_behind = d->has_content;
    return add_resource(g, &(struct ng_plan_resource){
                               .name = name,
                               .kind = NG_RESOURCE_STAGING,
                               .buffer.size = d->is_image ? graph_linear_size(&d->image) : d->buffer.size,
                               .host = true,
                               .staging = index,
                               .first_step = NG_PLAN_NONE,
                               .last_step = NG_PLAN_NONE,
                               .block = NG_PLAN_NONE});
}

// Buffers that no pass of the GPU uses, and that nobody clears.
static void find_cpu_only(struct expand *e)
{
    struct ng_graph *g = e->g;
    for (uint32_t i = 0; i < g->resources.count; i++) {
        const struct decl_resource *d = &g->resources.items[i];
        bool ours = d->kind == NG_RESOURCE_TRANSIENT || d->kind == NG_RESOURCE_PERSISTENT;
        g->plan_resources.items[i].cpu = ours && !d->is_image && !d->buffer.clear;
    }
    for (uint32_t p = 0; p < g->pass_count; p++)
        for (size_t i = 0; e->c->live[p] && i < g->passes.items[p]->uses.count; i++) {
            const struct decl_use *u = &g->passes.items[p]->uses.items[i];
            g->plan_resources.items[u->resource].cpu &= ng_use_info(u->use)->host;
        }
}

static ng_result make_resources(struct expand *e)
{
    struct ng_graph *g = e->g;
    for (uint32_t i = 0; i < g->resources.count; i++)
        NG_TRY(add_declared(e, i));
    find_cpu_only(e);
    for (uint32_t p = 0; p < g->pass_count; p++)
        for (size_t i = 0; e->c->live[p] && i < g->passes.items[p]->uses.count; i++)
            if (ng_use_info(g->passes.items[p]->uses.items[i].use)->host &&
                !is_token(e, &g->passes.items[p]->uses.items[i]))
                NG_TRY(make_host_visible(e, g->passes.items[p]->uses.items[i].resource));
    for (uint32_t i = 0; i < g->resources.count; i++)
        if (g->resources.items[i].readback)
            NG_TRY(make_host_visible(e, i));
    return NG_OK;
}

// ---- Steps ---------------------------------------------------------------------------------------------

static ng_result open_step(struct expand *e, enum ng_step_kind kind, enum ng_pass_kind pass_kind,
                           const char *name)
{
    struct ng_plan_step step = {.kind = kind,
                                .pass_kind = pass_kind,
                                .name = name,
                                .pass = NG_PLAN_NONE,
                                .first_use = (uint32_t)e->g->plan_uses.count,
                                .wait_batch = NG_PLAN_NONE};
    return ng_array_push(&e->g->plan_steps, step) ? NG_OK : graph_no_memory(e->g);
}

// Adds a use to the newest step, with what follows from the word: usage bits and lifetime.
static ng_result add_use(struct expand *e, const struct ng_plan_use *use)
{
    struct ng_graph *g = e->g;
    uint32_t index = (uint32_t)g->plan_steps.count - 1;
    const struct ng_use_info *info = ng_use_info(use->use);
    struct ng_plan_resource *r = &g->plan_resources.items[use->resource];
    r->image_usage |= info->image_usage;
    r->buffer_usage |= info->buffer_usage;
    r->written = r->written || use->write;
    if (r->first_step == NG_PLAN_NONE)
        r->first_step = index;
    r->last_step = index;
    g->plan_steps.items[index].use_count++;
    return ng_array_push(&g->plan_uses, *use) ? NG_OK : graph_no_memory(g);
}

static struct ng_graph_part whole(const struct ng_plan_resource *r)
{
    return r->is_image ? (struct ng_graph_part){0, r->image.mips, 0, r->image.layers}
                       : (struct ng_graph_part){0};
}

static struct ng_plan_use copy_use(const struct expand *e, uint32_t resource, uint32_t declared, bool write)
{
    const struct ng_plan_resource *r = &e->g->plan_resources.items[resource];
    struct ng_graph_part part = whole(r);
    part.mip_count = r->is_image ? 1 : 0;
    return (struct ng_plan_use){.resource = resource,
                                .declared = declared,
                                .use = write ? NG_USE_COPY_DST : NG_USE_COPY_SRC,
                                .write = write,
                                .part = part};
}

static ng_result download(struct expand *e, uint32_t resource)
{
    const struct ng_plan_resource *r = &e->g->plan_resources.items[resource];
    uint32_t staging = r->staging;
    struct ng_plan_use from = copy_use(e, resource, resource, false),
                       to = copy_use(e, staging, resource, true);
    NG_TRY(open_step(e, NG_STEP_DOWNLOAD, NG_PASS_COPY, r->name));
    NG_TRY(add_use(e, &from));
    NG_TRY(add_use(e, &to));
    e->sides[resource].host_behind = false;
    return NG_OK;
}

static ng_result upload(struct expand *e, uint32_t resource)
{
    const struct ng_plan_resource *r = &e->g->plan_resources.items[resource];
    uint32_t staging = r->staging;
    struct ng_plan_use from = copy_use(e, staging, resource, false),
                       to = copy_use(e, resource, resource, true);
    NG_TRY(open_step(e, NG_STEP_UPLOAD, NG_PASS_COPY, r->name));
    NG_TRY(add_use(e, &from));
    NG_TRY(add_use(e, &to));
    e->sides[resource].gpu_behind = false;
    return NG_OK;
}

// ---- Defined parts -------------------------------------------------------------------------------------

enum extent { NOTHING, SOME, ALL };

// How much of a part is defined.
static enum extent defined(const struct ng_plan_resource *r, const struct side *side,
                           const struct ng_graph_part *part)
{
    if (!r->is_image)
        return side->defined[0] ? ALL : NOTHING;
    bool some = false, all = true;
    for (uint32_t m = part->mip; m < part->mip + part->mip_count; m++)
        for (uint32_t l = part->layer; l < part->layer + part->layer_count; l++) {
            bool d = side->defined[m * r->image.layers + l];
            some = some || d;
            all = all && d;
        }
    return all ? ALL : some ? SOME : NOTHING;
}

static void define(const struct ng_plan_resource *r, struct side *side, const struct ng_graph_part *part)
{
    if (!r->is_image)
        side->defined[0] = true;
    for (uint32_t m = part->mip; r->is_image && m < part->mip + part->mip_count; m++)
        memset(side->defined + m * r->image.layers + part->layer, true, part->layer_count);
}

// Adds one use for each run of undefined layers of each mip: what a clear step clears.
static ng_result add_undefined_parts(struct expand *e, uint32_t resource)
{
    const struct ng_plan_resource *r = &e->g->plan_resources.items[resource];
    const unsigned char *d = e->sides[resource].defined;
    struct ng_plan_use use = {
        .resource = resource, .declared = resource, .use = NG_USE_COPY_DST, .write = true};
    if (!r->is_image)
        return add_use(e, &use);
    uint32_t layers = r->image.layers, mips = r->image.mips;
    for (uint32_t m = 0; m < mips; m++)
        for (uint32_t l = 0, end; l < layers; l = end) {
            for (end = l + 1; end < layers && d[m * layers + end] == d[m * layers + l]; end++)
                ;
            use.part = (struct ng_graph_part){m, 1, l, end - l};
            if (!d[m * layers + l])
                NG_TRY(add_use(e, &use));
        }
    return NG_OK;
}

static ng_result clear(struct expand *e, uint32_t resource)
{
    struct ng_plan_resource *r = &e->g->plan_resources.items[resource];
    struct ng_graph_part all = whole(r);
    NG_TRY(open_step(e, NG_STEP_CLEAR, NG_PASS_COPY, r->name));
    NG_TRY(add_undefined_parts(e, resource));
    define(r, &e->sides[resource], &all);
    // Where the host is ahead it has written mip 0, and only other mips were cleared.
    e->sides[resource].host_behind = r->staging != NG_PLAN_NONE && !e->sides[resource].gpu_behind;
    return NG_OK;
}

// ---- Passes --------------------------------------------------------------------------------------------

// Before a use of the GPU side: what is undefined is cleared, what the host wrote is copied back.
static ng_result prepare_gpu(struct expand *e, const struct decl_use *u)
{
    const struct ng_plan_resource *r = &e->g->plan_resources.items[u->resource];
    struct side *side = &e->sides[u->resource];
    bool clears = r->is_image ? r->image.clear : r->buffer.clear;
    enum extent extent = defined(r, side, &u->part);
    bool as_loaded = is_attachment(u->use) && u->write && extent == NOTHING;
    if (clears && extent != ALL && !as_loaded)
        NG_TRY(clear(e, u->resource));
    return side->gpu_behind ? upload(e, u->resource) : NG_OK;
}

// Before a use of the staging copy: it gets the GPU's content, unless all of it will be overwritten.
static ng_result prepare_host(struct expand *e, const struct decl_use *u)
{
    const struct ng_plan_resource *r = &e->g->plan_resources.items[u->resource];
    struct side *side = &e->sides[u->resource];
    if (!ng_use_info(u->use)->reads)
        return NG_OK;
    struct ng_graph_part first_mip = whole(r);
    first_mip.mip_count = 1;
    bool clears = r->is_image ? r->image.clear : r->buffer.clear;
    if (clears && defined(r, side, &first_mip) != ALL)
        NG_TRY(clear(e, u->resource));
    return side->host_behind ? download(e, u->resource) : NG_OK;
}

static struct ng_plan_use gpu_use(struct expand *e, const struct decl_use *u)
{
    const struct ng_plan_resource *r = &e->g->plan_resources.items[u->resource];
    struct side *side = &e->sides[u->resource];
    enum ng_load load = NG_LOAD_KEEP;
    if (is_attachment(u->use) && defined(r, side, &u->part) == NOTHING)
        load = r->image.clear ? NG_LOAD_CLEAR : NG_LOAD_UNDEFINED;
    define(r, side, &u->part);
    if (u->write)
        side->host_behind = r->staging != NG_PLAN_NONE;
    return (struct ng_plan_use){.resource = u->resource,
                                .declared = u->resource,
                                .version = u->version + u->write,
                                .use = u->use,
                                .write = u->write,
                                .part = u->part,
                                .load = load};
}

static struct ng_plan_use host_use(struct expand *e, const struct decl_use *u)
{
    const struct ng_plan_resource *r = &e->g->plan_resources.items[u->resource];
    struct side *side = &e->sides[u->resource];
    bool staged = r->staging != NG_PLAN_NONE;
    struct ng_graph_part first_mip = whole(r);
    first_mip.mip_count = r->is_image ? 1 : 0;
    if (u->write) {
        define(r, side, &first_mip);
        side->gpu_behind = staged;
        side->host_behind = false;
    }
    return (struct ng_plan_use){.resource = staged ? r->staging : u->resource,
                                .declared = u->resource,
                                .version = u->version + u->write,
                                .use = u->use,
                                .write = u->write,
                                .part = staged ? (struct ng_graph_part){0} : first_mip};
}

static ng_result expand_pass(struct expand *e, uint32_t index)
{
    const struct ng_pass *p = e->g->passes.items[index];
    for (size_t i = 0; i < p->uses.count; i++) {
        const struct decl_use *u = &p->uses.items[i];
        if (is_token(e, u))
            continue;
        NG_TRY(ng_use_info(u->use)->host ? prepare_host(e, u) : prepare_gpu(e, u));
    }
    NG_TRY(open_step(e, NG_STEP_PASS, p->kind, p->name));
    e->g->plan_steps.items[e->g->plan_steps.count - 1].pass = index;
    e->g->plan.passes[index].step = (uint32_t)e->g->plan_steps.count - 1;
    for (size_t i = 0; i < p->uses.count; i++) {
        const struct decl_use *u = &p->uses.items[i];
        if (is_token(e, u))
            continue;
        struct ng_plan_use use = ng_use_info(u->use)->host ? host_use(e, u) : gpu_use(e, u);
        NG_TRY(add_use(e, &use));
    }
    return NG_OK;
}

// ---- The end of the frame ------------------------------------------------------------------------------

static bool outlives_frame(enum ng_resource_kind kind)
{
    return kind != NG_RESOURCE_TRANSIENT && kind != NG_RESOURCE_STAGING && kind != NG_RESOURCE_TOKEN;
}

// Content that lasts is defined in all its parts, and goes where the next frame, the owner or the reader
// looks for it.
static ng_result settle(struct expand *e, uint32_t index)
{
    const struct decl_resource *d = &e->g->resources.items[index];
    const struct ng_plan_resource *r = &e->g->plan_resources.items[index];
    struct side *side = &e->sides[index];
    bool used = r->first_step != NG_PLAN_NONE, clears = r->is_image ? r->image.clear : r->buffer.clear;
    struct ng_graph_part all = whole(r);
    if (used && clears && (outlives_frame(d->kind) || d->readback) && defined(r, side, &all) != ALL)
        NG_TRY(clear(e, index));
    if (side->gpu_behind && outlives_frame(d->kind))
        NG_TRY(upload(e, index));
    if (d->readback && r->staging != NG_PLAN_NONE && side->host_behind && (used || d->has_content))
        NG_TRY(download(e, index));
    return NG_OK;
}

static ng_result add_final_use(struct expand *e, uint32_t resource, uint32_t declared, enum ng_use use)
{
    struct ng_graph_part part = whole(&e->g->plan_resources.items[resource]);
    return add_use(
        e, &(struct ng_plan_use){.resource = resource, .declared = declared, .use = use, .part = part});
}

// Barriers toward what happens to a resource after the frame. The words are reads: whoever writes next is
// ordered by the barrier that opens a frame.
static ng_result expand_final(struct expand *e)
{
    struct ng_graph *g = e->g;
    NG_TRY(open_step(e, NG_STEP_FINAL, NG_PASS_COPY, "final"));
    for (uint32_t i = 0; i < g->resources.count; i++) {
        const struct decl_resource *d = &g->resources.items[i];
        const struct ng_plan_resource *r = &g->plan_resources.items[i];
        uint32_t host = r->staging != NG_PLAN_NONE ? r->staging : i;
        bool there = g->plan_resources.items[host].written || (host == i && d->has_content);
        if (d->readback && g->plan_resources.items[host].host && there)
            NG_TRY(add_final_use(e, host, i, NG_USE_HOST_READ));
        bool used = r->first_step != NG_PLAN_NONE || d->has_content;
        if (d->kind == NG_RESOURCE_IMPORTED && d->is_image && d->final != NG_USE_NONE && used)
            NG_TRY(add_final_use(e, i, i, d->final));
    }
    return NG_OK;
}

// An attachment is stored unless nobody looks at it again.
static void decide_stores(struct ng_graph *g)
{
    for (uint32_t s = 0; s < g->plan_steps.count; s++) {
        const struct ng_plan_step *step = &g->plan_steps.items[s];
        for (uint32_t i = step->first_use; i < step->first_use + step->use_count; i++) {
            struct ng_plan_use *u = &g->plan_uses.items[i];
            const struct ng_plan_resource *r = &g->plan_resources.items[u->resource];
            u->store = r->last_step > s || outlives_frame(r->kind);
        }
    }
}

// Host copies that no copy to or from the GPU touches: CPU passes hand them on to one another and to whoever
// reads the frame, so they may share memory, and need none for each frame in flight.
static void find_cpu_copies(struct ng_graph *g)
{
    for (uint32_t i = 0; i < g->plan_resources.count; i++)
        if (g->plan_resources.items[i].kind == NG_RESOURCE_STAGING)
            g->plan_resources.items[i].cpu = true;
    for (uint32_t s = 0; s < g->plan_steps.count; s++) {
        const struct ng_plan_step *step = &g->plan_steps.items[s];
        bool copies = step->kind == NG_STEP_DOWNLOAD || step->kind == NG_STEP_UPLOAD;
        for (uint32_t i = step->first_use; i < step->first_use + step->use_count && copies; i++)
            g->plan_resources.items[g->plan_uses.items[i].resource].cpu = false;
    }
}

// What is exported keeps its memory to the end of the frame.
static void extend_exports(struct ng_graph *g)
{
    uint32_t last = (uint32_t)g->plan_steps.count - 1;
    for (size_t i = 0; i < g->exports.count; i++) {
        struct ng_plan_resource *r = &g->plan_resources.items[REF_RESOURCE(g->exports.items[i])];
        if (r->first_step != NG_PLAN_NONE)
            r->last_step = last;
    }
}

ng_result graph_expand(struct compile *c)
{
    struct ng_graph *g = c->g;
    struct expand e = {.c = c, .g = g};
    e.sides = ng_arena_array(&g->arena, g->resources.count, sizeof *e.sides);
    if (!e.sides)
        return graph_no_memory(g);
    g->plan_resources.count = g->plan_steps.count = g->plan_uses.count = 0;
    NG_TRY(make_resources(&e));
    for (uint32_t k = 0; k < c->order_count; k++)
        if (c->live[c->order[k]])
            NG_TRY(expand_pass(&e, c->order[k]));
    for (uint32_t i = 0; i < g->resources.count; i++)
        NG_TRY(settle(&e, i));
    NG_TRY(expand_final(&e));
    extend_exports(g);
    find_cpu_copies(g);
    decide_stores(g);
    return NG_OK;
}

// Keys of versions, and which persistent resources hold already what this frame would make.
//
// The key of a version follows from the pass that writes it: from the pass's own key and the keys of all that
// it reads, so that it stands for everything behind it, however long the chain. Shaders that were replaced
// are in every key: which of them a pass uses, only the pass knows. A resource is current if the content that
// it has kept has the key of its last version in this frame.
#include "graph/graph_internal.h"

#include "graph/key.h"

static uint64_t *key_of(const struct compile *c, const struct decl_use *u, bool after)
{
    return &c->keys[c->first_version[u->resource] + u->version + after];
}

static uint32_t last_version(const struct compile *c, uint32_t resource)
{
    return c->first_version[resource + 1] - c->first_version[resource] - 1;
}

static uint64_t final_key(const struct compile *c, uint32_t resource)
{
    return c->keys[c->first_version[resource] + last_version(c, resource)];
}

// ---- What a frame begins with ----------------------------------------------------------------------------

static uint64_t add_description(uint64_t key, const struct decl_resource *r)
{
    const struct ng_graph_image_params *i = &r->image;
    const uint64_t words[] = {r->buffer.size, i->format, (uint64_t)i->width << 32 | i->height,
                              (uint64_t)i->layers << 32 | i->mips, (uint64_t)i->cube << 1 | i->array};
    return ng_key_add_bytes(key, words, sizeof words);
}

static uint64_t key_when_new(const struct decl_resource *r)
{
    uint64_t key = add_description(NG_KEY, r);
    if (r->is_image && r->image.clear)
        return ng_key_add_bytes(key, &r->image.clear_value, sizeof r->image.clear_value);
    return r->buffer.clear ? ng_key_add(key, r->buffer.clear_word) : key;
}

// Passes that all have keys make a persistent resource anew. Not where one of them, or another pass, looks at
// what was there before.
static void find_renewed(const struct compile *c, bool *renewed)
{
    const struct ng_graph *g = c->g;
    for (uint32_t r = 0; r < g->resources.count; r++)
        renewed[r] = g->resources.items[r].kind == NG_RESOURCE_PERSISTENT && last_version(c, r) > 0 &&
                     !decl_is_keyless(&g->resources.items[r]);
    for (uint32_t p = 0; p < g->pass_count; p++)
        for (size_t i = 0; i < g->passes.items[p]->uses.count; i++) {
            const struct decl_use *u = &g->passes.items[p]->uses.items[i];
            bool looks = !u->version && (!u->write || ng_use_info(u->use)->needs_content);
            if (looks || (u->write && !g->passes.items[p]->key))
                renewed[u->resource] = false;
        }
}

static void start(struct compile *c, const bool *renewed)
{
    for (uint32_t i = 0; i < c->g->resources.count; i++) {
        const struct decl_resource *r = &c->g->resources.items[i];
        uint64_t key = 0;
        if (r->kind == NG_RESOURCE_PERSISTENT && r->has_content && !renewed[i])
            key = r->kept_key;
        else if (r->kind == NG_RESOURCE_TRANSIENT || r->kind == NG_RESOURCE_CURRENT ||
                 r->kind == NG_RESOURCE_TOKEN || r->kind == NG_RESOURCE_PERSISTENT)
            key = key_when_new(r);
        c->keys[c->first_version[i]] = key;
    }
}

// ---- What passes make ------------------------------------------------------------------------------------

// 0 as soon as anything is unknown.
static uint64_t add_known(uint64_t key, uint64_t part)
{
    return key && part ? ng_key_add(key, part) : 0;
}

// What a write leaves of the content before.
static bool keeps_content(const struct decl_use *u)
{
    return u->use != NG_USE_HOST_WRITE;
}

static uint64_t key_of_pass(const struct compile *c, const struct ng_pass *p)
{
    uint64_t shaders = c->g->params.gpu ? c->g->params.gpu->shaders : 0;
    uint64_t key = p->key ? ng_key_add(ng_key_add(p->key, (uintptr_t)p->run), shaders) : 0;
    for (size_t i = 0; i < p->uses.count && key; i++) {
        const struct decl_use *u = &p->uses.items[i];
        if (decl_is_keyless(&c->g->resources.items[u->resource]))
            continue;
        if (u->replaced)
            key = add_known(key, u->key);
        else if (!u->write || keeps_content(u))
            key = add_known(key, *key_of(c, u, false));
    }
    return key;
}

static void find_versions(struct compile *c)
{
    for (uint32_t k = 0; k < c->order_count; k++) {
        const struct ng_pass *p = c->g->passes.items[c->order[k]];
        uint64_t key = key_of_pass(c, p);
        for (size_t i = 0; i < p->uses.count; i++) {
            const struct decl_use *u = &p->uses.items[i];
            if (u->write)
                *key_of(c, u, true) =
                    key ? add_description(ng_key_add(key, i), &c->g->resources.items[u->resource]) : 0;
        }
    }
}

// ---- What is there already -------------------------------------------------------------------------------

static void find_current(struct compile *c, const bool *renewed)
{
    const struct ng_graph *g = c->g;
    for (uint32_t i = 0; i < g->resources.count && !g->params.no_keys && !g->params.no_culling; i++) {
        const struct decl_resource *r = &g->resources.items[i];
        c->current[i] = renewed[i] && r->has_content && r->kept_key && r->kept_key == final_key(c, i);
    }
    // Content is that of the last version: who reads an earlier one needs that made.
    for (uint32_t p = 0; p < g->pass_count; p++)
        for (size_t i = 0; i < g->passes.items[p]->uses.count; i++) {
            const struct decl_use *u = &g->passes.items[p]->uses.items[i];
            if (!u->write && u->version != last_version(c, u->resource))
                c->current[u->resource] = false;
        }
}

ng_result graph_find_keys(struct compile *c)
{
    struct ng_graph *g = c->g;
    bool *renewed = ng_arena_array(&g->arena, g->resources.count, sizeof *renewed);
    c->keys = ng_arena_array(&g->arena, c->first_version[g->resources.count], sizeof *c->keys);
    c->current = ng_arena_array(&g->arena, g->resources.count, sizeof *c->current);
    c->renewed = renewed;
    if (!c->keys || !c->current || !renewed)
        return graph_no_memory(g);
    find_renewed(c, renewed);
    start(c, renewed);
    find_versions(c);
    find_current(c, renewed);
    g->final_keys = ng_arena_array(&g->arena, g->resources.count, sizeof *g->final_keys);
    for (uint32_t i = 0; i < g->resources.count && g->final_keys; i++)
        g->final_keys[i] = decl_is_keyless(&g->resources.items[i]) ? 0 : final_key(c, i);
    return g->final_keys ? NG_OK : graph_no_memory(g);
}

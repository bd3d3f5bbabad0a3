// Lists by type: found by the address of the type, kept as arrays of pointers into the frame's memory.
#include "graph/provider.h"

#include "graph/graph_internal.h"

#include "base/array.h"
#include "base/log.h"

#include <stdlib.h>
#include <string.h>

struct item_list {
    const struct ng_item_type *type;
    NG_ARRAY(const void *) items;
};

// What a provider keeps in the graph is its own: another of its name, or the same one registered again, may
// compute something else, and finds nothing.
struct registration {
    struct ng_provider provider;
    uint64_t number; // never given before
};

struct ng_composer {
    struct ng_graph *graph;
    NG_ARRAY(struct registration) providers;
    uint64_t registered;              // so far
    NG_ARRAY(struct item_list) lists; // emptied, not removed, between frames
};

ng_result ng_composer_create(struct ng_graph *graph, struct ng_composer **out)
{
    NG_REQUIRE(graph && out, "ng_composer_create: graph or out is null");
    *out = calloc(1, sizeof **out);
    if (!*out)
        return ng_out_of_memory("a composer");
    (*out)->graph = graph;
    return NG_OK;
}

void ng_composer_destroy(struct ng_composer **composer)
{
    if (!composer || !*composer)
        return;
    for (size_t i = 0; i < (*composer)->lists.count; i++)
        ng_array_finish(&(*composer)->lists.items[i].items);
    ng_array_finish(&(*composer)->lists);
    ng_array_finish(&(*composer)->providers);
    free(*composer);
    *composer = NULL;
}

struct ng_graph *ng_composer_graph(const struct ng_composer *composer)
{
    return composer->graph;
}

static size_t find_provider(const struct ng_composer *composer, const char *name)
{
    size_t i = 0;
    while (i < composer->providers.count && strcmp(composer->providers.items[i].provider.name, name) != 0)
        i++;
    return i;
}

ng_result ng_composer_register(struct ng_composer *composer, const struct ng_provider *provider)
{
    NG_REQUIRE(provider->name && provider->name[0], "ng_composer_register: a provider without a name");
    NG_REQUIRE(find_provider(composer, provider->name) == composer->providers.count,
               "ng_composer_register: provider '%s' is registered already", provider->name);
    const struct registration registration = {*provider, ++composer->registered};
    size_t count = composer->providers.count,
           at = provider->before ? find_provider(composer, provider->before) : count;
    if (!ng_array_push(&composer->providers, registration))
        return ng_out_of_memory(provider->name);
    struct registration *place = composer->providers.items + at;
    memmove(place + 1, place, (count - at) * sizeof *place);
    *place = registration;
    return NG_OK;
}

void ng_composer_unregister(struct ng_composer *composer, const char *name)
{
    size_t i = find_provider(composer, name), count = composer->providers.count;
    if (i == count)
        return;
    memmove(composer->providers.items + i, composer->providers.items + i + 1,
            (count - i - 1) * sizeof *composer->providers.items);
    composer->providers.count--;
}

const struct ng_provider *ng_composer_find(const struct ng_composer *composer, const char *name)
{
    size_t i = find_provider(composer, name);
    return i < composer->providers.count ? &composer->providers.items[i].provider : NULL;
}

void ng_composer_begin(struct ng_composer *composer)
{
    ng_graph_begin(composer->graph);
    for (size_t i = 0; i < composer->lists.count; i++)
        composer->lists.items[i].items.count = 0;
}

static struct item_list *find_list(const struct ng_composer *composer, const struct ng_item_type *type)
{
    for (size_t i = 0; i < composer->lists.count; i++)
        if (composer->lists.items[i].type == type)
            return &composer->lists.items[i];
    return NULL;
}

ng_result ng_composer_publish(struct ng_composer *composer, const struct ng_item_type *type, const void *item)
{
    struct item_list *list = find_list(composer, type);
    if (!list && ng_array_push(&composer->lists, (struct item_list){.type = type}))
        list = &composer->lists.items[composer->lists.count - 1];
    void *copy = ng_graph_alloc(composer->graph, type->size);
    if (!list || !copy || !ng_array_push(&list->items, copy))
        return ng_out_of_memory(type->name);
    memcpy(copy, item, type->size);
    return NG_OK;
}

size_t ng_composer_count(const struct ng_composer *composer, const struct ng_item_type *type)
{
    const struct item_list *list = find_list(composer, type);
    return list ? list->items.count : 0;
}

const void *ng_composer_get(const struct ng_composer *composer, const struct ng_item_type *type, size_t index)
{
    const struct item_list *list = find_list(composer, type);
    return list && index < list->items.count ? list->items.items[index] : NULL;
}

ng_result ng_composer_declare(struct ng_composer *composer)
{
    ng_result first = NG_OK;
    for (int round = 0; round < 2; round++)
        for (size_t i = 0; i < composer->providers.count; i++) {
            const struct registration *r = &composer->providers.items[i];
            ng_provider_fn fn = round == 0 ? r->provider.produce : r->provider.consume;
            composer->graph->owner = r->number;
            ng_result result = fn ? fn(composer, r->provider.user) : NG_OK;
            first = first == NG_OK ? result : first;
        }
    composer->graph->owner = 0;
    return first;
}

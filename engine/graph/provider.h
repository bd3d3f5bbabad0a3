// Providers: how a feature enters the frame without the frame knowing it.
//
// A feature registers a provider once. Each frame, all `produce` callbacks run in order of registration, then
// all `consume` callbacks. They meet at typed lists of the frame: a producer publishes a struct under a type,
// a consumer walks the list of that type. So a pass that gathers lights never names a kind of light, and a
// feature is added or removed by one registration.
//
//     // in the header that both sides include
//     struct shadow { struct ng_graph_ref depth; };
//     extern const struct ng_item_type shadow_type;
//     // in one .c file
//     const struct ng_item_type shadow_type = {"shadow", sizeof(struct shadow)};
//
//     produce:  ng_composer_publish(composer, &shadow_type, &(struct shadow){depth});
//     consume:  for (size_t i = 0; i < ng_composer_count(composer, &shadow_type); i++) {
//                   const struct shadow *s = ng_composer_get(composer, &shadow_type, i);
//
// What the whole frame is made from (the snapshot, the settings) is published by the caller before it starts.
#ifndef NG_GRAPH_PROVIDER_H
#define NG_GRAPH_PROVIDER_H

#include "base/extern_c.h"
#include "graph/graph.h"

NG_EXTERN_C_BEGIN

struct ng_composer;

// A type of published struct: identified by its address.
struct ng_item_type {
    const char *name;
    size_t size;
};

// Failures are the callback's to log; the others still run.
typedef ng_result (*ng_provider_fn)(struct ng_composer *composer, void *user);

struct ng_provider {
    const char *name;                // borrowed while registered
    ng_provider_fn produce, consume; // either may be null
    void *user;
    // The name of the provider that it stands before, if there is one; null, and if there is none: the last.
    const char *before;
};

// The providers and the lists of one graph. Not thread-safe. The graph is borrowed.
NG_NODISCARD ng_result ng_composer_create(struct ng_graph *graph, struct ng_composer **out);
void ng_composer_destroy(struct ng_composer **composer);
struct ng_graph *ng_composer_graph(const struct ng_composer *composer);

// A name registered twice is refused. A registration owns the persistent resources that it declares: what is
// registered in place of another, or once more, finds none of their content.
NG_NODISCARD ng_result ng_composer_register(struct ng_composer *composer, const struct ng_provider *provider);
void ng_composer_unregister(struct ng_composer *composer, const char *name);
// Borrowed until one is registered or unregistered; null if there is none of that name.
const struct ng_provider *ng_composer_find(const struct ng_composer *composer, const char *name);

// Opens a frame: ng_graph_begin, and all lists become empty.
void ng_composer_begin(struct ng_composer *composer);
// Copies `item` (type->size bytes) to the end of the list; it lives until the next ng_composer_begin.
NG_NODISCARD ng_result ng_composer_publish(struct ng_composer *composer, const struct ng_item_type *type,
                                           const void *item);
size_t ng_composer_count(const struct ng_composer *composer, const struct ng_item_type *type);
// In order of publication; null past the end.
const void *ng_composer_get(const struct ng_composer *composer, const struct ng_item_type *type,
                            size_t index);
// Runs all produce callbacks, then all consume callbacks. The graph is then ready for ng_graph_execute.
// Returns the first failure.
NG_NODISCARD ng_result ng_composer_declare(struct ng_composer *composer);

NG_EXTERN_C_END

#endif

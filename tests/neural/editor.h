// A random editor of a world: it knows no component, only the field tables. Values are valid; a third of them
// are extreme: the ends of a range, 0, 1, -1, tiny, large.
#ifndef NG_TESTS_NEURAL_EDITOR_H
#define NG_TESTS_NEURAL_EDITOR_H

#include "asset/assets.h"
#include "base/rng.h"
#include "scene/world.h"

struct editor {
    struct ng_world *world;
    struct ng_assets *assets;
    struct ng_rng rng;
    char what[256]; // the last edit, for people
};

// Textures, so that every scene has some to exchange.
void editor_begin(struct editor *e, struct ng_world *world, struct ng_assets *assets, uint64_t seed);
// One edit: a field, a component or an entity that comes, goes or gets another parent, an asset that comes,
// goes or has other content, undo or redo. All but a few of assets can be undone.
void editor_edit(struct editor *e);

#endif

#include "render/copies.h"

#include "base/hash.h"
#include "base/log.h"

// Instances of one key cover the same, seen from the same sides. `material`: which one, where it cuts holes;
// else NG_NONE.
static uint64_t key_of(const struct ng_snapshot_instance *i, uint32_t material)
{
    uint64_t sides = i->flags & (NG_INSTANCE_DOUBLE_SIDED | NG_INSTANCE_LAMP);
    uint64_t hash = ng_hash_combine((uint64_t)material << 32 | i->mesh, sides);
    return ng_hash_bytes(hash, i->matrix, sizeof i->matrix) | 1; // never 0
}

// Whether an instance is hidden by those after it, which have been asked before.
static bool is_hidden(const struct ng_copies *c, const struct ng_snapshot *s, uint32_t index)
{
    const struct ng_snapshot_instance *i = &s->instances[index];
    enum ng_alpha_mode mode = s->materials[i->material].alpha_mode;
    return ng_index_map_get(&c->last, key_of(i, NG_NONE)) != NG_NONE ||
           (mode == NG_ALPHA_MASK && c->over.items[index]) ||
           (mode == NG_ALPHA_BLEND && c->over.items[index] >= NG_MOST_BLENDED_COPIES);
}

ng_result ng_copies_find(struct ng_copies *c, const struct ng_snapshot *s)
{
    ng_index_map_clear(&c->last);
    if (!ng_array_resize(&c->hidden, s->instance_count) || !ng_array_resize(&c->over, s->instance_count))
        return ng_out_of_memory("copies of meshes");
    for (uint32_t index = s->instance_count; index-- > 0;) {
        const struct ng_snapshot_instance *i = &s->instances[index];
        bool opaque = s->materials[i->material].alpha_mode == NG_ALPHA_OPAQUE;
        c->hidden.items[index] = false;
        if (i->light != NG_NONE)
            continue;
        uint64_t key = key_of(i, opaque ? NG_NONE : i->material);
        uint32_t later = ng_index_map_get(&c->last, key);
        c->over.items[index] = later == NG_NONE ? 0 : c->over.items[later] + 1;
        c->hidden.items[index] = is_hidden(c, s, index);
        if (!ng_index_map_set(&c->last, key, index))
            return ng_out_of_memory("copies of meshes");
    }
    return NG_OK;
}

void ng_copies_finish(struct ng_copies *c)
{
    ng_array_finish(&c->hidden);
    ng_array_finish(&c->over);
    ng_index_map_finish(&c->last);
}

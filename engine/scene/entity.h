// The two kinds of reference that a component may hold.
#ifndef NG_SCENE_ENTITY_H
#define NG_SCENE_ENTITY_H

#include <stdbool.h>
#include <stdint.h>

// An entity of a world: index in the low 32 bits, generation in the high 32. Zero names nothing. A destroyed
// entity's id is never given again, so a stale reference is found, not followed.
typedef struct ng_entity {
    uint64_t id;
} ng_entity;

// Something the world refers to but does not own: geometry, an image, a clip, ... (asset/assets.h). Zero:
// none.
typedef struct ng_asset {
    uint32_t id;
} ng_asset;

static inline uint32_t ng_entity_index(ng_entity e)
{
    return (uint32_t)e.id;
}
static inline bool ng_entity_same(ng_entity a, ng_entity b)
{
    return a.id == b.id;
}
static inline bool ng_entity_is_null(ng_entity e)
{
    return e.id == 0;
}

#endif

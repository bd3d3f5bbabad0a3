// The world: entities, the components they have, their order in a hierarchy, and when each value changed.
//
// An archetype entity component system. Entities with the same set of components share a table; a table keeps
// each component in a column of its own, so that a loop over two components streams two arrays. query.h
// loops, history.h undoes, event.h tells, system.h runs a frame.
//
// Ownership: the world owns the values; they are plain bytes, copied in and moved by memcpy. A pointer to a
// value is valid until the next structural change (create, destroy, add, remove), and is not to be stored.
// Threads: one at a time, except inside ng_query_run_parallel, where values may be read and own rows written.
//
// Structural changes made while a query is being iterated are put off until the outermost loop ends, and then
// applied in the order made. Such a change is checked when applied: if its entity died meanwhile, it is
// dropped.
#ifndef NG_SCENE_WORLD_H
#define NG_SCENE_WORLD_H

#include "base/extern_c.h"
#include "base/result.h"
#include "scene/component.h"

NG_EXTERN_C_BEGIN

struct ng_world;

// A set of components is one 64-bit word, bit i for component i.
#define NG_COMPONENT_MAX 64

struct ng_world_params {
    uint32_t history_limit; // undo entries kept, the oldest go first; 0: 256
};

// `params` may be null.
NG_NODISCARD ng_result ng_world_create(const struct ng_world_params *params, struct ng_world **out);
void ng_world_destroy(struct ng_world **world);

// ---- components ------------------------------------------------------------------------------------------
// Registers a component and gives its id: 0, 1, ... in order of registration. The description is borrowed for
// the world's life. Errors: a name taken, a field outside its struct, more than NG_COMPONENT_MAX (USAGE).
NG_NODISCARD ng_result ng_world_register(struct ng_world *world, const struct ng_component_desc *desc,
                                         ng_component *out);
uint32_t ng_world_component_count(const struct ng_world *world);
// Null for an id that is not registered.
const struct ng_component_desc *ng_world_component(const struct ng_world *world, ng_component component);
// False if no component has this name.
bool ng_world_find_component(const struct ng_world *world, const char *name, ng_component *out);

// ---- entities --------------------------------------------------------------------------------------------
// A new entity without components, last of the roots. Null (id 0) when out of memory. While a query is being
// iterated the id is given at once, but the entity is alive only when the loop has ended.
ng_entity ng_entity_create(struct ng_world *world);
// Destroys an entity and everything below it in the hierarchy, deepest first.
NG_NODISCARD ng_result ng_entity_destroy(struct ng_world *world, ng_entity e);
bool ng_entity_alive(const struct ng_world *world, ng_entity e);
// Entities alive.
uint32_t ng_world_entity_count(const struct ng_world *world);
// The living entity with this index (ng_entity_index: what an id buffer on the GPU holds), or null.
ng_entity ng_world_entity_at(const struct ng_world *world, uint32_t index);
// The components of an entity, as a set; 0 if not alive.
uint64_t ng_world_components(const struct ng_world *world, ng_entity e);

// ---- values ----------------------------------------------------------------------------------------------
// Gives an entity a component. `value` null: the component's defaults. If it has the component already, its
// value is replaced. Error: entity not alive, component unknown (USAGE).
NG_NODISCARD ng_result ng_world_add(struct ng_world *world, ng_entity e, ng_component component,
                                    const void *value);
// Error: the entity does not have it (USAGE).
NG_NODISCARD ng_result ng_world_remove(struct ng_world *world, ng_entity e, ng_component component);
bool ng_world_has(const struct ng_world *world, ng_entity e, ng_component component);
// The value to read, or null where the entity is dead or does not have it. (A tag has no value:
// ng_world_has.)
const void *ng_world_get(const struct ng_world *world, ng_entity e, ng_component component);
// The value to change by hand: marks it changed now, and an open transaction keeps the old value. Null as
// above.
void *ng_world_edit(struct ng_world *world, ng_entity e, ng_component component);
// The value to change by program, each frame: marks it changed, but no transaction records it and no event
// tells it. For animation and other things that are computed anew from something that is itself kept.
void *ng_world_write(struct ng_world *world, ng_entity e, ng_component component);
// Replaces a value; as ng_world_edit and a copy. Error: the entity does not have it (USAGE).
NG_NODISCARD ng_result ng_world_set(struct ng_world *world, ng_entity e, ng_component component,
                                    const void *value);

// ---- fields by path --------------------------------------------------------------------------------------
// A field, found once and then used for many entities.
struct ng_field_ref {
    ng_component component;
    const struct ng_field *field;
};

// Finds "component.field", such as "camera.fov_y". Logs and returns NOT_FOUND otherwise.
NG_NODISCARD ng_result ng_world_find_field(const struct ng_world *world, const char *path,
                                           struct ng_field_ref *out);
// Copies a field out of or into an entity; `value` has the C type of `type` (component.h), which must be the
// field's. Setting is an edit (ng_world_edit). Errors, logged with entity, path and reason: NOT_FOUND (path,
// or the entity does not have the component), FORMAT (other type; not finite, out of range, no such choice,
// text without end, quaternion not of unit length).
NG_NODISCARD ng_result ng_world_get_field(const struct ng_world *world, ng_entity e, const char *path,
                                          enum ng_field_type type, void *value);
NG_NODISCARD ng_result ng_world_set_field(struct ng_world *world, ng_entity e, const char *path,
                                          enum ng_field_type type, const void *value);

// ---- change ticks ----------------------------------------------------------------------------------------
// Each value carries the tick of its last change (added, edited, undone, marked by a query). A reader asks
// for a stamp when it has looked; whatever changes from then on has a later tick:
//     since = ng_world_stamp(world);  ...  if (ng_world_changed_at(world, e, c) > since) look again
// The first tick is 1, so since = 0 means "everything". The tick moves only where a stamp follows a change:
// 32 bits last a hundred days at eight such stamps a frame and 60 frames a second.
uint32_t ng_world_stamp(struct ng_world *world);
// The tick of a value's last change; 0 where there is none.
uint32_t ng_world_changed_at(const struct ng_world *world, ng_entity e, ng_component component);
// The latest tick at which any value of a component changed (high-water mark; removal does not lower it).
uint32_t ng_world_component_changed_at(const struct ng_world *world, ng_component component);
// When an entity was last given a parent (or created); null entity: the latest of all.
uint32_t ng_world_parent_changed_at(const struct ng_world *world, ng_entity e);

// ---- hierarchy -------------------------------------------------------------------------------------------
// Siblings are ordered. The null entity stands for the root of the world: its children are the entities
// without a parent, and a root's parent is null. All of these return null where there is none.
ng_entity ng_world_parent(const struct ng_world *world, ng_entity e);
ng_entity ng_world_first_child(const struct ng_world *world, ng_entity e);
ng_entity ng_world_last_child(const struct ng_world *world, ng_entity e);
ng_entity ng_world_next_sibling(const struct ng_world *world, ng_entity e);
ng_entity ng_world_previous_sibling(const struct ng_world *world, ng_entity e);
// The entity after `e` in a depth-first walk (parents first) of the tree below `top`; null after the last.
//     for (ng_entity e = top; !ng_entity_is_null(e); e = ng_world_next_below(world, top, e))
ng_entity ng_world_next_below(const struct ng_world *world, ng_entity top, ng_entity e);
// Makes `e` a child of `parent` (null: a root), placed just before its child `before` (null: last).
// Errors, logged: `parent` is `e` or below it; `before` is not a child of `parent` (USAGE).
NG_NODISCARD ng_result ng_world_set_parent(struct ng_world *world, ng_entity e, ng_entity parent,
                                           ng_entity before);

// ---- memory ----------------------------------------------------------------------------------------------
struct ng_world_memory {
    uint64_t values;      // bytes of component values, spare room included
    uint64_t bookkeeping; // everything else of tables and entities: ids, ticks, places, links
};
struct ng_world_memory ng_world_memory(const struct ng_world *world);

NG_EXTERN_C_END

#endif

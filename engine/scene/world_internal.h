// The world from inside. One picture:
//
//   id -> slot (index)  -> table, row      where its values are
//                       -> parent, siblings, children (as indices)
//   table (a set of components) -> chunks of NG_CHUNK_ROWS rows -> per component a column of values and of
//   ticks
//
// The functions here are the steps that the public ones, deferred commands and undo are made of. They trust
// their arguments, neither defer nor record, and queue events.
#ifndef NG_SCENE_WORLD_INTERNAL_H
#define NG_SCENE_WORLD_INTERNAL_H

#include "base/array.h"
#include "base/log.h"
#include "scene/event.h"
#include "scene/history.h"
#include "scene/query.h"
#include "scene/system.h"

#include <stddef.h>

#define NG_NONE UINT32_MAX

// ---- tables (table.c) ------------------------------------------------------------------------------------
struct ng_column {
    unsigned char *values;
    uint32_t *ticks;
    uint32_t high; // no tick in the column is later
};

// Columns, ids, ticks and values are one allocation, which begins with `columns`.
struct ng_chunk {
    struct ng_column *columns;
    ng_entity *entities;
    uint32_t capacity;
};

struct ng_table_column {
    ng_component component;
    uint32_t size;
    uint32_t high; // no tick in any chunk is later
};

// Rows are dense: row r is in chunk r / NG_CHUNK_ROWS, and every chunk but the last is full. The first chunk
// starts small and grows, so that a table of three rows is small too.
struct ng_table {
    uint64_t set;   // of components; column i is its i-th lowest bit
    uint32_t index; // in the world
    uint32_t column_count;
    uint32_t count; // rows
    NG_ARRAY(struct ng_chunk) chunks;
    struct ng_table_column columns[];
};

static inline uint64_t ng_bit(ng_component component)
{
    return (uint64_t)1 << component;
}
static inline uint32_t ng_table_column(const struct ng_table *table, ng_component component)
{
    return (uint32_t)__builtin_popcountll(table->set & (ng_bit(component) - 1));
}
static inline uint32_t ng_table_chunk_count(const struct ng_table *table)
{
    return (table->count + NG_CHUNK_ROWS - 1) / NG_CHUNK_ROWS;
}
static inline uint32_t ng_chunk_rows(const struct ng_table *table, uint32_t chunk)
{
    uint32_t rest = table->count - chunk * NG_CHUNK_ROWS;
    return rest < NG_CHUNK_ROWS ? rest : NG_CHUNK_ROWS;
}

// The table of a set of components, made where there is none. Null when out of memory.
struct ng_table *ng_table_get(struct ng_world *world, uint64_t set);
void ng_table_destroy(struct ng_table *table);
// Appends a row, its values and ticks not yet set. False when out of memory.
bool ng_table_append(struct ng_table *table, ng_entity e);
// Removes a row by moving the last into its place; the entity that moved, or null.
ng_entity ng_table_remove(struct ng_table *table, uint32_t row);
void *ng_table_value(const struct ng_table *table, uint32_t row, uint32_t column);
uint32_t ng_table_tick(const struct ng_table *table, uint32_t row, uint32_t column);
void ng_table_set_tick(struct ng_table *table, uint32_t row, uint32_t column, uint32_t tick);
// Copies the values and ticks that both tables have.
void ng_table_copy_row(struct ng_table *to, uint32_t to_row, const struct ng_table *from, uint32_t from_row);
void ng_table_memory(const struct ng_table *table, struct ng_world_memory *sum);

// ---- entities (entity.c) ---------------------------------------------------------------------------------
// A slot is alive (has a table), free (in the free list, its generation already that of its next entity), or
// held: dead, but its id may come back, since undo speaks of it or a deferred create has yet to run.
struct ng_slot {
    uint32_t generation;
    uint32_t table; // index in the world; NG_NONE: not alive
    uint32_t row;   // in the table; not alive: 0 held, NG_NONE free
    uint32_t parent, previous, next, first,
        last; // slots; 0 is the root of the world. `next` links the free list
    uint32_t parent_tick;
};

#define NG_SLOT_PAGE 1024

// ---- operations as data (command.c) ----------------------------------------------------------------------
// A deferred command is an operation that waits; an undo entry is a list of operations that were done.
enum ng_op_kind { NG_OP_CREATE, NG_OP_DESTROY, NG_OP_ADD, NG_OP_REMOVE, NG_OP_SET, NG_OP_MOVE, NG_OP_OTHER };

struct ng_op {
    enum ng_op_kind kind;
    ng_component component; // ADD, REMOVE, SET
    ng_entity entity;
    ng_entity parent, before;          // CREATE, DESTROY, MOVE
    const struct ng_change_type *type; // OTHER: a change of something that is no entity
    void *change;
    size_t value; // ADD, REMOVE, SET: offset in `bytes`
};

struct ng_op_list {
    NG_ARRAY(struct ng_op) ops;
    NG_ARRAY(unsigned char) bytes;
};

NG_NODISCARD ng_result ng_op_list_push(struct ng_op_list *list, const struct ng_op *op, const void *value,
                                       size_t size);
void ng_op_list_clear(struct ng_op_list *list);
void ng_op_list_finish(struct ng_op_list *list);

// ---- history (history.c) ---------------------------------------------------------------------------------
struct ng_entry {
    char label[NG_TEXT_SIZE];
    struct ng_op_list list;
    uint64_t bytes; // that it holds, counted when it was last done, undone or redone
};

struct ng_history {
    NG_ARRAY(struct ng_entry) entries; // [0, done) can be undone, the rest redone
    size_t done, limit;
    uint64_t bytes, byte_limit; // of all entries
    uint64_t transactions;      // begun so far
    bool open;
    struct ng_entry current; // of the open transaction
    // The values that `current` can already restore: a hash set of slot and component, so that a drag of a
    // thousand edits records one.
    struct {
        uint64_t *keys; // 0: empty; `capacity` is a power of two
        size_t count, capacity;
    } saved;
};

// ---- events (event.c) ------------------------------------------------------------------------------------
struct ng_event_queue {
    NG_ARRAY(struct ng_queued_event {
        struct ng_event event;
        size_t last; // offset in `bytes`
    })
    items;
    NG_ARRAY(unsigned char) bytes;
};

// ---- the world -------------------------------------------------------------------------------------------
struct ng_component_info {
    const struct ng_component_desc *desc;
    void *defaults;    // our copy, zeros where the description has none
    uint32_t observed; // set of enum ng_event_kind
};

struct ng_world {
    struct ng_component_info components[NG_COMPONENT_MAX];
    uint32_t component_count;
    NG_ARRAY(struct ng_table *) tables; // 0: no components
    struct {
        uint32_t *tables; // open addressing by set; NG_NONE: empty
        uint32_t capacity;
    } table_by_set;
    NG_ARRAY(struct ng_slot *) pages;
    uint32_t slot_count, free_slot, alive;
    uint32_t tick, parent_tick;
    bool tick_used;  // something carries the present tick
    uint32_t locked; // query loops under way
    bool parallel;
    struct ng_op_list commands;
    struct ng_history history;
    struct ng_event_queue events, delivering;
    bool dispatching;
    NG_ARRAY(struct ng_observer_desc) observers;
    NG_ARRAY(struct ng_query *) queries;
    NG_ARRAY(struct ng_system_desc) systems[NG_PHASE_COUNT];
};

static inline struct ng_slot *ng_slot(const struct ng_world *world, uint32_t index)
{
    return &world->pages.items[index / NG_SLOT_PAGE][index % NG_SLOT_PAGE];
}
static inline ng_entity ng_slot_entity(const struct ng_world *world, uint32_t index)
{
    return (ng_entity){index ? (uint64_t)ng_slot(world, index)->generation << 32 | index : 0};
}
static inline struct ng_table *ng_slot_table(const struct ng_world *world, const struct ng_slot *slot)
{
    return world->tables.items[slot->table];
}
// The present tick, to be written to something that changes now.
uint32_t ng_world_use_tick(struct ng_world *world);

// entity.c
NG_NODISCARD ng_result ng_entities_init(struct ng_world *world);
void ng_entities_finish(struct ng_world *world);
// Whether the id was given and not destroyed for good: alive or held.
bool ng_entity_known(const struct ng_world *world, ng_entity e);
// A held slot comes alive as the last root, and an open transaction records it.
NG_NODISCARD ng_result ng_entity_enter(struct ng_world *world, ng_entity e);
// A held slot becomes an entity without components at a place in the hierarchy.
NG_NODISCARD ng_result ng_entity_spawn(struct ng_world *world, ng_entity e, ng_entity parent,
                                       ng_entity before);
// An entity without children dies. Its slot is held or made free.
void ng_entity_bury(struct ng_world *world, ng_entity e, bool hold);
// Makes a held slot free.
void ng_entity_release(struct ng_world *world, ng_entity e);
// Moves the entity's row to the table of another set. New columns are not yet set.
NG_NODISCARD ng_result ng_entity_change_set(struct ng_world *world, ng_entity e, uint64_t set);

// world.c
NG_NODISCARD ng_result ng_component_put(struct ng_world *world, ng_entity e, ng_component component,
                                        const void *value);
NG_NODISCARD ng_result ng_component_drop(struct ng_world *world, ng_entity e, ng_component component);

// hierarchy.c: takes a slot out of its parent's list, puts it in before a sibling (0: last).
void ng_unlink(struct ng_world *world, uint32_t index);
void ng_link(struct ng_world *world, uint32_t index, uint32_t parent, uint32_t before);
// Whether a slot is `top` or below it.
bool ng_is_below(const struct ng_world *world, uint32_t top, uint32_t index);
// The `before` for ng_link that an operation's data mean now: 0 if it is no child of `parent` any more.
uint32_t ng_link_before(const struct ng_world *world, ng_entity parent, ng_entity before);

// command.c: structural changes between lock and unlock are kept, and run when the outermost lock ends.
void ng_world_lock(struct ng_world *world);
void ng_world_unlock(struct ng_world *world);

// history.c: records an operation in the open transaction, if there is one and the component is not derived.
NG_NODISCARD ng_result ng_history_record(struct ng_world *world, const struct ng_op *op, const void *value);
// Takes the last record back: its operation failed.
void ng_history_unrecord(struct ng_world *world);
void ng_history_finish(struct ng_world *world);

// event.c
void ng_event_queue(struct ng_world *world, enum ng_event_kind kind, ng_entity e, ng_component component);
void ng_events_finish(struct ng_world *world);

// query.c
NG_NODISCARD bool ng_queries_add_table(struct ng_world *world, struct ng_table *table);
void ng_queries_finish(struct ng_world *world);

#endif

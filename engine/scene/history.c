// History: a transaction is a list of operations, and each operation knows how to be taken back.
//
// An operation holds what the world does not have at the moment: done, the old value; undone, the new one. So
// undo and redo are one function that exchanges the two, run backward or forward over the list. Changes of
// other owners (NG_OP_OTHER) do the same by functions of their own.
#include "scene/world_internal.h"

#include "base/hash.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- the set of values that the open transaction can restore already -------------------------------------
static uint64_t *place_of_key(const struct ng_history *h, uint64_t key)
{
    size_t mask = h->saved.capacity - 1, i = ng_hash_u64(key) & mask;
    while (h->saved.keys[i] && h->saved.keys[i] != key)
        i = (i + 1) & mask;
    return &h->saved.keys[i];
}

static bool grow_saved(struct ng_history *h)
{
    uint64_t *old = h->saved.keys;
    size_t old_capacity = h->saved.capacity, capacity = old_capacity ? old_capacity * 2 : 64;
    uint64_t *keys = calloc(capacity, sizeof *keys);
    if (!keys)
        return false;
    h->saved.keys = keys;
    h->saved.capacity = capacity;
    for (size_t i = 0; i < old_capacity; i++)
        if (old[i])
            *place_of_key(h, old[i]) = old[i];
    free(old);
    return true;
}

// Adds a value to the set; `*fresh` says whether it was new.
static ng_result save_once(struct ng_history *h, ng_entity e, ng_component component, bool *fresh)
{
    if (h->saved.count * 2 >= h->saved.capacity && !grow_saved(h))
        return ng_out_of_memory("a transaction");
    uint64_t key = (uint64_t)ng_entity_index(e) * NG_COMPONENT_MAX + component; // not 0: index 0 is no entity
    uint64_t *place = place_of_key(h, key);
    *fresh = !*place;
    h->saved.count += *fresh;
    *place = key;
    return NG_OK;
}

// ---- recording -------------------------------------------------------------------------------------------
static size_t value_size(const struct ng_world *world, const struct ng_op *op)
{
    bool has_value = op->kind == NG_OP_ADD || op->kind == NG_OP_REMOVE || op->kind == NG_OP_SET;
    return has_value ? world->components[op->component].desc->size : 0;
}

ng_result ng_history_record(struct ng_world *world, const struct ng_op *op, const void *value)
{
    struct ng_history *h = &world->history;
    bool of_component = op->kind == NG_OP_ADD || op->kind == NG_OP_REMOVE || op->kind == NG_OP_SET;
    if (!h->open || (of_component && world->components[op->component].desc->flags & NG_COMPONENT_DERIVED))
        return NG_OK;
    if (op->kind == NG_OP_ADD || op->kind == NG_OP_SET) {
        // What was added in this transaction needs no old value; what was set has one.
        bool fresh = false;
        NG_TRY(save_once(h, op->entity, op->component, &fresh));
        if (op->kind == NG_OP_SET && !fresh)
            return NG_OK;
    }
    return ng_op_list_push(&h->current.list, op, value, value_size(world, op));
}

ng_result ng_world_record(struct ng_world *world, const struct ng_change_type *type, void *change)
{
    struct ng_history *h = &world->history;
    NG_REQUIRE(h->open, "no transaction is open");
    struct ng_op op = {.kind = NG_OP_OTHER, .type = type, .change = change};
    return ng_op_list_push(&h->current.list, &op, NULL, 0);
}

void ng_history_unrecord(struct ng_world *world)
{
    if (world->history.open)
        world->history.current.list.ops.count--;
}

// ---- undo and redo ---------------------------------------------------------------------------------------
static ng_result toggle_life(struct ng_world *world, struct ng_op *op, bool live)
{
    if (live) {
        bool held = ng_entity_known(world, op->entity) && !ng_entity_alive(world, op->entity);
        bool has_parent = ng_entity_is_null(op->parent) || ng_entity_alive(world, op->parent);
        return held ? ng_entity_spawn(world, op->entity, has_parent ? op->parent : (ng_entity){0}, op->before)
                    : NG_OK;
    }
    if (!ng_entity_alive(world, op->entity))
        return NG_OK;
    for (ng_entity c; !ng_entity_is_null(c = ng_world_first_child(world, op->entity));)
        NG_TRY(ng_entity_destroy(world, c)); // put there by something that was not recorded
    op->parent = ng_world_parent(world, op->entity);
    op->before = ng_world_next_sibling(world, op->entity);
    ng_entity_bury(world, op->entity, true);
    return NG_OK;
}

static ng_result toggle_presence(struct ng_world *world, struct ng_op *op, void *value, bool present)
{
    if (!ng_entity_alive(world, op->entity) || ng_world_has(world, op->entity, op->component) == present)
        return NG_OK;
    if (present)
        return ng_component_put(world, op->entity, op->component, value);
    memcpy(value, ng_world_get(world, op->entity, op->component), value_size(world, op));
    return ng_component_drop(world, op->entity, op->component);
}

static ng_result toggle_value(struct ng_world *world, struct ng_op *op, unsigned char *value)
{
    unsigned char *now = ng_world_edit(world, op->entity, op->component);
    for (size_t i = 0, size = value_size(world, op); now && i < size; i++) {
        unsigned char byte = now[i];
        now[i] = value[i];
        value[i] = byte;
    }
    return NG_OK;
}

static ng_result toggle_place(struct ng_world *world, struct ng_op *op)
{
    struct ng_op now = *op;
    if (!ng_entity_alive(world, op->entity) ||
        (!ng_entity_is_null(op->parent) && !ng_entity_alive(world, op->parent)) ||
        ng_is_below(world, ng_entity_index(op->entity), ng_entity_index(op->parent)))
        return NG_OK; // its place to be is gone, or has come to be below it
    now.parent = ng_world_parent(world, op->entity);
    now.before = ng_world_next_sibling(world, op->entity);
    ng_entity before = ng_slot_entity(world, ng_link_before(world, op->parent, op->before));
    ng_result r = ng_world_set_parent(world, op->entity, op->parent, before);
    *op = now;
    return r;
}

static ng_result toggle(struct ng_world *world, struct ng_op_list *list, size_t i, bool forward)
{
    struct ng_op *op = &list->ops.items[i];
    unsigned char *value = list->bytes.items + op->value;
    switch (op->kind) {
    case NG_OP_CREATE:
    case NG_OP_DESTROY:
        return toggle_life(world, op, (op->kind == NG_OP_CREATE) == forward);
    case NG_OP_ADD:
    case NG_OP_REMOVE:
        return toggle_presence(world, op, value, (op->kind == NG_OP_ADD) == forward);
    case NG_OP_SET:
        return toggle_value(world, op, value);
    case NG_OP_MOVE:
        return toggle_place(world, op);
    case NG_OP_OTHER:
        op->type->exchange(op->change, forward);
        return NG_OK;
    }
    assert(false && "no such operation");
    return NG_ERROR_USAGE;
}

// Goes through a whole list; what fails for want of memory is passed over, and the first such result
// returned.
static ng_result apply(struct ng_world *world, struct ng_op_list *list, bool forward)
{
    ng_result result = NG_OK;
    for (size_t n = 0, count = list->ops.count; n < count; n++) {
        ng_result r = toggle(world, list, forward ? n : count - 1 - n, forward);
        result = result == NG_OK ? r : result;
    }
    return result;
}

// ---- entries ---------------------------------------------------------------------------------------------
static void list_finish(struct ng_op_list *list, bool done)
{
    for (size_t i = list->ops.count; i-- > 0;)
        if (list->ops.items[i].kind == NG_OP_OTHER)
            list->ops.items[i].type->finish(list->ops.items[i].change, done);
    ng_op_list_finish(list);
}

// Forgets an entry. Ids held for it become free: of what it destroyed if done, of what it created if undone.
static void entry_finish(struct ng_world *world, struct ng_entry *entry, bool done)
{
    enum ng_op_kind kind = done ? NG_OP_DESTROY : NG_OP_CREATE;
    for (size_t i = 0; i < entry->list.ops.count; i++) {
        ng_entity e = entry->list.ops.items[i].entity;
        if (entry->list.ops.items[i].kind == kind && ng_entity_known(world, e) && !ng_entity_alive(world, e))
            ng_entity_release(world, e);
    }
    world->history.bytes -= entry->bytes;
    list_finish(&entry->list, done);
}

// What an entry holds changes in size as it is exchanged.
static void count_bytes(struct ng_history *h, struct ng_entry *entry)
{
    uint64_t bytes = entry->list.bytes.capacity + entry->list.ops.capacity * sizeof entry->list.ops.items[0];
    for (size_t i = 0; i < entry->list.ops.count; i++) {
        const struct ng_op *op = &entry->list.ops.items[i];
        bytes += op->kind == NG_OP_OTHER ? op->type->bytes(op->change) : 0;
    }
    h->bytes += bytes - entry->bytes;
    entry->bytes = bytes;
}

static void forget_undone(struct ng_world *world)
{
    struct ng_history *h = &world->history;
    while (h->entries.count > h->done)
        entry_finish(world, &h->entries.items[--h->entries.count], false);
}

static void forget_oldest(struct ng_world *world)
{
    struct ng_history *h = &world->history;
    entry_finish(world, &h->entries.items[0], true);
    memmove(h->entries.items, h->entries.items + 1, --h->entries.count * sizeof *h->entries.items);
    h->done--;
}

static void close(struct ng_history *h)
{
    h->open = false;
    h->current = (struct ng_entry){0};
    h->saved.count = 0;
    if (h->saved.capacity)
        memset(h->saved.keys, 0, h->saved.capacity * sizeof *h->saved.keys);
}

// ---- the interface ---------------------------------------------------------------------------------------
ng_result ng_world_begin(struct ng_world *world, const char *label)
{
    struct ng_history *h = &world->history;
    NG_REQUIRE(!h->open, "transaction \"%s\" is open; commit or cancel it before \"%s\"", h->current.label,
               label);
    NG_REQUIRE(!world->locked, "a transaction cannot begin while a query is being iterated");
    h->open = true;
    h->transactions++;
    snprintf(h->current.label, sizeof h->current.label, "%s", label);
    return NG_OK;
}

ng_result ng_world_commit(struct ng_world *world)
{
    struct ng_history *h = &world->history;
    NG_REQUIRE(h->open, "no transaction is open");
    NG_REQUIRE(!world->locked, "a transaction cannot end while a query is being iterated");
    if (h->current.list.ops.count) {
        if (!ng_array_reserve(&h->entries, h->done + 1))
            return ng_out_of_memory("an undo entry");
        forget_undone(world);
        h->entries.items[h->entries.count++] = h->current;
        count_bytes(h, &h->entries.items[h->done++]);
        while (h->done > h->limit || (h->done > 1 && h->bytes > h->byte_limit))
            forget_oldest(world);
    } else {
        ng_op_list_finish(&h->current.list);
    }
    close(h);
    return NG_OK;
}

ng_result ng_world_cancel(struct ng_world *world)
{
    struct ng_history *h = &world->history;
    NG_REQUIRE(h->open, "no transaction is open");
    NG_REQUIRE(!world->locked, "a transaction cannot end while a query is being iterated");
    struct ng_entry entry = h->current;
    close(h); // first: taking back is not recorded
    ng_result r = apply(world, &entry.list, false);
    entry_finish(world, &entry, false);
    return r;
}

bool ng_world_in_transaction(const struct ng_world *world)
{
    return world->history.open;
}

uint64_t ng_world_transaction(const struct ng_world *world)
{
    return world->history.open ? world->history.transactions : 0;
}

static ng_result check_idle(const struct ng_world *world)
{
    NG_REQUIRE(!world->history.open, "not while transaction \"%s\" is open", world->history.current.label);
    NG_REQUIRE(!world->locked, "not while a query is being iterated");
    return NG_OK;
}

static ng_result exchange(struct ng_world *world, struct ng_entry *entry, bool forward)
{
    ng_result r = apply(world, &entry->list, forward);
    count_bytes(&world->history, entry);
    return r;
}

ng_result ng_world_undo(struct ng_world *world)
{
    struct ng_history *h = &world->history;
    NG_TRY(check_idle(world));
    if (!h->done)
        return NG_ERROR_NOT_FOUND;
    return exchange(world, &h->entries.items[--h->done], false);
}

ng_result ng_world_redo(struct ng_world *world)
{
    struct ng_history *h = &world->history;
    NG_TRY(check_idle(world));
    if (h->done == h->entries.count)
        return NG_ERROR_NOT_FOUND;
    return exchange(world, &h->entries.items[h->done++], true);
}

const char *ng_world_undo_label(const struct ng_world *world)
{
    const struct ng_history *h = &world->history;
    return h->done ? h->entries.items[h->done - 1].label : NULL;
}

const char *ng_world_redo_label(const struct ng_world *world)
{
    const struct ng_history *h = &world->history;
    return h->done < h->entries.count ? h->entries.items[h->done].label : NULL;
}

void ng_world_clear_history(struct ng_world *world)
{
    if (check_idle(world) != NG_OK)
        return;
    forget_undone(world);
    while (world->history.done)
        entry_finish(world, &world->history.entries.items[--world->history.done], true);
    world->history.entries.count = 0;
}

void ng_world_limit_history(struct ng_world *world, uint64_t bytes)
{
    world->history.byte_limit = bytes ? bytes : (uint64_t)256 << 20;
}

uint64_t ng_world_history_bytes(const struct ng_world *world)
{
    return world->history.bytes;
}

void ng_history_finish(struct ng_world *world)
{
    struct ng_history *h = &world->history;
    for (size_t i = 0; i < h->entries.count; i++)
        list_finish(&h->entries.items[i].list, i < h->done);
    ng_array_finish(&h->entries);
    list_finish(&h->current.list, true);
    free(h->saved.keys);
}

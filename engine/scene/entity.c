// Entities: slots that say where an entity's values are, and the way between alive, held and free.
#include "scene/world_internal.h"

#include <stdlib.h>
#include <string.h>

// ---- slots -----------------------------------------------------------------------------------------------
static bool add_page(struct ng_world *world)
{
    if (!ng_array_reserve(&world->pages, world->pages.count + 1))
        return false;
    struct ng_slot *page = malloc(NG_SLOT_PAGE * sizeof *page);
    if (!page)
        return false;
    world->pages.items[world->pages.count++] = page;
    return true;
}

// A held slot with an id never given before; 0 when out of memory.
static uint32_t take_slot(struct ng_world *world)
{
    uint32_t index = world->free_slot;
    uint32_t generation = 1;
    if (index) {
        generation = ng_slot(world, index)->generation;
        world->free_slot = ng_slot(world, index)->next;
    } else {
        if (world->slot_count == NG_NONE)
            return 0;
        if (world->slot_count == world->pages.count * NG_SLOT_PAGE && !add_page(world))
            return 0;
        index = world->slot_count++;
    }
    *ng_slot(world, index) = (struct ng_slot){.generation = generation, .table = NG_NONE};
    return index;
}

void ng_entity_release(struct ng_world *world, ng_entity e)
{
    struct ng_slot *slot = ng_slot(world, ng_entity_index(e));
    slot->row = NG_NONE;
    if (slot->generation == UINT32_MAX)
        return; // its ids are used up
    slot->generation++;
    slot->next = world->free_slot;
    world->free_slot = ng_entity_index(e);
}

ng_result ng_entities_init(struct ng_world *world)
{
    if (!add_page(world))
        return ng_out_of_memory("entities");
    *ng_slot(world, 0) = (struct ng_slot){.table = NG_NONE, .row = NG_NONE}; // the root of the world
    world->slot_count = 1;
    return NG_OK;
}

void ng_entities_finish(struct ng_world *world)
{
    for (size_t i = 0; i < world->pages.count; i++)
        free(world->pages.items[i]);
    ng_array_finish(&world->pages);
}

// ---- rows ------------------------------------------------------------------------------------------------
static void remove_row(struct ng_world *world, struct ng_table *table, uint32_t row)
{
    ng_entity moved = ng_table_remove(table, row);
    if (!ng_entity_is_null(moved))
        ng_slot(world, ng_entity_index(moved))->row = row;
}

// A new row for the entity in the table of a set; null when out of memory.
static struct ng_table *append_row(struct ng_world *world, ng_entity e, uint64_t set)
{
    struct ng_table *table = ng_table_get(world, set);
    if (table && ng_table_append(table, e))
        return table;
    ng_out_of_memory("a table of entities");
    return NULL;
}

ng_result ng_entity_change_set(struct ng_world *world, ng_entity e, uint64_t set)
{
    struct ng_slot *slot = ng_slot(world, ng_entity_index(e));
    struct ng_table *from = ng_slot_table(world, slot), *to = append_row(world, e, set);
    if (!to)
        return NG_ERROR_MEMORY;
    ng_table_copy_row(to, to->count - 1, from, slot->row);
    remove_row(world, from, slot->row);
    slot->table = to->index;
    slot->row = to->count - 1;
    return NG_OK;
}

// ---- life and death --------------------------------------------------------------------------------------
ng_result ng_entity_spawn(struct ng_world *world, ng_entity e, ng_entity parent, ng_entity before)
{
    struct ng_table *table = append_row(world, e, 0);
    if (!table)
        return NG_ERROR_MEMORY;
    struct ng_slot *slot = ng_slot(world, ng_entity_index(e));
    slot->table = table->index;
    slot->row = table->count - 1;
    ng_link(world, ng_entity_index(e), ng_entity_index(parent), ng_link_before(world, parent, before));
    world->alive++;
    return NG_OK;
}

void ng_entity_bury(struct ng_world *world, ng_entity e, bool hold)
{
    struct ng_slot *slot = ng_slot(world, ng_entity_index(e));
    struct ng_table *table = ng_slot_table(world, slot);
    for (uint32_t c = 0; c < table->column_count; c++)
        ng_event_queue(world, NG_EVENT_REMOVE, e, table->columns[c].component);
    ng_unlink(world, ng_entity_index(e));
    remove_row(world, table, slot->row);
    slot->table = NG_NONE;
    slot->row = 0;
    world->alive--;
    if (!hold)
        ng_entity_release(world, e);
}

ng_result ng_entity_enter(struct ng_world *world, ng_entity e)
{
    ng_result r = ng_history_record(world, &(struct ng_op){.kind = NG_OP_CREATE, .entity = e}, NULL);
    if (r == NG_OK) {
        r = ng_entity_spawn(world, e, (ng_entity){0}, (ng_entity){0});
        if (r != NG_OK)
            ng_history_unrecord(world);
    }
    if (r != NG_OK)
        ng_entity_release(world, e);
    return r;
}

ng_entity ng_entity_create(struct ng_world *world)
{
    const ng_entity none = {0};
    NG_REQUIRE_OR(!world->parallel, none, "entities cannot be created inside ng_query_run_parallel");
    uint32_t index = take_slot(world);
    if (!index) {
        ng_out_of_memory("an entity");
        return none;
    }
    ng_entity e = ng_slot_entity(world, index);
    if (!world->locked)
        return ng_entity_enter(world, e) == NG_OK ? e : none;
    if (ng_op_list_push(&world->commands, &(struct ng_op){.kind = NG_OP_CREATE, .entity = e}, NULL, 0) !=
        NG_OK) {
        ng_entity_release(world, e);
        return none;
    }
    return e;
}

// Records what undo needs to bring an entity back: its values, then its place.
static ng_result record_death(struct ng_world *world, ng_entity e)
{
    const struct ng_slot *slot = ng_slot(world, ng_entity_index(e));
    const struct ng_table *table = ng_slot_table(world, slot);
    for (uint32_t c = 0; c < table->column_count; c++) {
        struct ng_op op = {.kind = NG_OP_REMOVE, .entity = e, .component = table->columns[c].component};
        NG_TRY(ng_history_record(world, &op, ng_table_value(table, slot->row, c)));
    }
    struct ng_op op = {.kind = NG_OP_DESTROY,
                       .entity = e,
                       .parent = ng_slot_entity(world, slot->parent),
                       .before = ng_slot_entity(world, slot->next)};
    return ng_history_record(world, &op, NULL);
}

ng_result ng_entity_destroy(struct ng_world *world, ng_entity e)
{
    NG_REQUIRE(!world->parallel, "entities cannot be destroyed inside ng_query_run_parallel");
    NG_REQUIRE(ng_entity_known(world, e), "entity %llx does not exist", (unsigned long long)e.id);
    if (world->locked)
        return ng_op_list_push(&world->commands, &(struct ng_op){.kind = NG_OP_DESTROY, .entity = e}, NULL,
                               0);
    NG_REQUIRE(ng_entity_alive(world, e), "entity %llx is not alive", (unsigned long long)e.id);
    uint32_t top = ng_entity_index(e), i = top, parent;
    do {
        while (ng_slot(world, i)->first)
            i = ng_slot(world, i)->first;
        parent = ng_slot(world, i)->parent;
        ng_entity deepest = ng_slot_entity(world, i);
        NG_TRY(record_death(world, deepest));
        ng_entity_bury(world, deepest, world->history.open);
    } while (i != top && (i = parent, true));
    return NG_OK;
}

// ---- asking ----------------------------------------------------------------------------------------------
bool ng_entity_known(const struct ng_world *world, ng_entity e)
{
    uint32_t index = ng_entity_index(e);
    return index && index < world->slot_count && ng_slot(world, index)->row != NG_NONE &&
           ng_slot(world, index)->generation == e.id >> 32;
}

bool ng_entity_alive(const struct ng_world *world, ng_entity e)
{
    return ng_entity_known(world, e) && ng_slot(world, ng_entity_index(e))->table != NG_NONE;
}

uint32_t ng_world_entity_count(const struct ng_world *world)
{
    return world->alive;
}

ng_entity ng_world_entity_at(const struct ng_world *world, uint32_t index)
{
    bool alive = index && index < world->slot_count && ng_slot(world, index)->table != NG_NONE;
    return alive ? ng_slot_entity(world, index) : (ng_entity){0};
}

uint64_t ng_world_components(const struct ng_world *world, ng_entity e)
{
    return ng_entity_alive(world, e) ? ng_slot_table(world, ng_slot(world, ng_entity_index(e)))->set : 0;
}

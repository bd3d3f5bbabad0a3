// The hierarchy: ordered children as a doubly linked list of slots. Slot 0 is the root of the world, so that
// the roots are an ordered list like any other.
#include "scene/world_internal.h"

void ng_unlink(struct ng_world *world, uint32_t index)
{
    struct ng_slot *slot = ng_slot(world, index), *parent = ng_slot(world, slot->parent);
    *(slot->previous ? &ng_slot(world, slot->previous)->next : &parent->first) = slot->next;
    *(slot->next ? &ng_slot(world, slot->next)->previous : &parent->last) = slot->previous;
    slot->parent = slot->previous = slot->next = 0;
}

void ng_link(struct ng_world *world, uint32_t index, uint32_t parent, uint32_t before)
{
    struct ng_slot *slot = ng_slot(world, index), *up = ng_slot(world, parent);
    slot->parent = parent;
    slot->next = before;
    slot->previous = before ? ng_slot(world, before)->previous : up->last;
    *(slot->previous ? &ng_slot(world, slot->previous)->next : &up->first) = index;
    *(before ? &ng_slot(world, before)->previous : &up->last) = index;
    slot->parent_tick = world->parent_tick = ng_world_use_tick(world);
}

static bool is_child(const struct ng_world *world, ng_entity parent, ng_entity e)
{
    return ng_entity_alive(world, e) && ng_slot(world, ng_entity_index(e))->parent == ng_entity_index(parent);
}

uint32_t ng_link_before(const struct ng_world *world, ng_entity parent, ng_entity before)
{
    return is_child(world, parent, before) ? ng_entity_index(before) : 0;
}

bool ng_is_below(const struct ng_world *world, uint32_t top, uint32_t index)
{
    while (index && index != top)
        index = ng_slot(world, index)->parent;
    return index == top;
}

ng_result ng_world_set_parent(struct ng_world *world, ng_entity e, ng_entity parent, ng_entity before)
{
    NG_REQUIRE(!world->parallel, "parents cannot be set inside ng_query_run_parallel");
    NG_REQUIRE(ng_entity_known(world, e), "entity %llx does not exist", (unsigned long long)e.id);
    struct ng_op op = {.kind = NG_OP_MOVE, .entity = e, .parent = parent, .before = before};
    if (world->locked)
        return ng_op_list_push(&world->commands, &op, NULL, 0);
    NG_REQUIRE(ng_entity_alive(world, e), "entity %llx is not alive", (unsigned long long)e.id);
    NG_REQUIRE(ng_entity_is_null(parent) || ng_entity_alive(world, parent), "parent %llx is not alive",
               (unsigned long long)parent.id);
    NG_REQUIRE(!ng_is_below(world, ng_entity_index(e), ng_entity_index(parent)),
               "entity %u cannot be put below itself: entity %u is in its subtree", ng_entity_index(e),
               ng_entity_index(parent));
    NG_REQUIRE(ng_entity_is_null(before) || is_child(world, parent, before),
               "entity %u is not a child of entity %u, so nothing can be placed before it there",
               ng_entity_index(before), ng_entity_index(parent));
    if (ng_entity_same(e, before))
        return NG_OK; // it is there already

    uint32_t index = ng_entity_index(e);
    op.parent = ng_slot_entity(world, ng_slot(world, index)->parent);
    op.before = ng_slot_entity(world, ng_slot(world, index)->next);
    NG_TRY(ng_history_record(world, &op, NULL));
    ng_unlink(world, index);
    ng_link(world, index, ng_entity_index(parent), ng_entity_index(before));
    return NG_OK;
}

// ---- asking: the root of the world answers to the null entity --------------------------------------------
static const struct ng_slot *find(const struct ng_world *world, ng_entity e)
{
    static const struct ng_slot nowhere;
    return ng_entity_is_null(e) || ng_entity_alive(world, e) ? ng_slot(world, ng_entity_index(e)) : &nowhere;
}

ng_entity ng_world_parent(const struct ng_world *world, ng_entity e)
{
    return ng_slot_entity(world, find(world, e)->parent);
}

ng_entity ng_world_first_child(const struct ng_world *world, ng_entity e)
{
    return ng_slot_entity(world, find(world, e)->first);
}

ng_entity ng_world_last_child(const struct ng_world *world, ng_entity e)
{
    return ng_slot_entity(world, find(world, e)->last);
}

ng_entity ng_world_next_sibling(const struct ng_world *world, ng_entity e)
{
    return ng_slot_entity(world, find(world, e)->next);
}

ng_entity ng_world_previous_sibling(const struct ng_world *world, ng_entity e)
{
    return ng_slot_entity(world, find(world, e)->previous);
}

ng_entity ng_world_next_below(const struct ng_world *world, ng_entity top, ng_entity e)
{
    const struct ng_slot *slot = find(world, e);
    if (slot->first)
        return ng_slot_entity(world, slot->first);
    const struct ng_slot *end = find(world, top), *root = ng_slot(world, 0);
    while (slot != end && slot != root && !slot->next)
        slot = ng_slot(world, slot->parent);
    return slot == end ? (ng_entity){0} : ng_slot_entity(world, slot->next);
}

uint32_t ng_world_parent_changed_at(const struct ng_world *world, ng_entity e)
{
    return ng_entity_is_null(e) ? world->parent_tick : find(world, e)->parent_tick;
}

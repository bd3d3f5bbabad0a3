// Commands: structural changes that wait until no query is being iterated.
#include "scene/world_internal.h"

#include <assert.h>
#include <string.h>

ng_result ng_op_list_push(struct ng_op_list *list, const struct ng_op *op, const void *value, size_t size)
{
    size_t offset = list->bytes.count;
    // One byte more than needed: a tag's value, of no bytes, has an address too.
    if (!ng_array_reserve(&list->bytes, offset + size + 1) || !ng_array_push(&list->ops, *op))
        return ng_out_of_memory("a list of changes");
    list->ops.items[list->ops.count - 1].value = offset;
    if (size)
        memcpy(list->bytes.items + offset, value, size);
    list->bytes.count += size;
    return NG_OK;
}

void ng_op_list_clear(struct ng_op_list *list)
{
    list->ops.count = list->bytes.count = 0;
}

void ng_op_list_finish(struct ng_op_list *list)
{
    ng_array_finish(&list->ops);
    ng_array_finish(&list->bytes);
}

static ng_result run_move(struct ng_world *world, const struct ng_op *op)
{
    if (!ng_entity_is_null(op->parent) && !ng_entity_alive(world, op->parent))
        return NG_OK;
    ng_entity before = ng_slot_entity(world, ng_link_before(world, op->parent, op->before));
    return ng_world_set_parent(world, op->entity, op->parent, before);
}

// Does what was put off, unless something before it has made that void.
static ng_result run(struct ng_world *world, const struct ng_op *op, const void *value)
{
    if (op->kind == NG_OP_CREATE)
        return ng_entity_enter(world, op->entity);
    if (!ng_entity_alive(world, op->entity))
        return NG_OK;
    switch (op->kind) {
    case NG_OP_DESTROY:
        return ng_entity_destroy(world, op->entity);
    case NG_OP_ADD:
        return ng_world_add(world, op->entity, op->component, value);
    case NG_OP_REMOVE:
        return ng_world_has(world, op->entity, op->component)
                   ? ng_world_remove(world, op->entity, op->component)
                   : NG_OK;
    case NG_OP_MOVE:
        return run_move(world, op);
    default:
        assert(false && "not a command");
        return NG_ERROR_USAGE;
    }
}

void ng_world_lock(struct ng_world *world)
{
    world->locked++;
}

void ng_world_unlock(struct ng_world *world)
{
    assert(world->locked);
    if (--world->locked)
        return;
    // Running a command never makes another: events wait, and nothing is locked. A failure is logged where it
    // happens; the loop's end has nobody to return it to, and the other commands do not depend on it.
    struct ng_op_list *list = &world->commands;
    for (size_t i = 0; i < list->ops.count; i++)
        NG_UNUSED(run(world, &list->ops.items[i], list->bytes.items + list->ops.items[i].value));
    ng_op_list_clear(list);
}

// The world's life, its components, and the values of its entities.
//
// Every public change is the same four steps: check, defer if a query is being iterated, record if a
// transaction is open, do.
#include "scene/world_internal.h"

#include <stdlib.h>
#include <string.h>

ng_result ng_world_create(const struct ng_world_params *params, struct ng_world **out)
{
    *out = NULL;
    struct ng_world *world = calloc(1, sizeof *world);
    if (!world)
        return ng_out_of_memory("a world");
    world->tick = 1;
    world->history.limit = params && params->history_limit ? params->history_limit : 256;
    ng_world_limit_history(world, 0);
    ng_result r = ng_entities_init(world);
    if (r != NG_OK)
        ng_world_destroy(&world);
    *out = world;
    return r;
}

void ng_world_destroy(struct ng_world **world_)
{
    struct ng_world *world = *world_;
    *world_ = NULL;
    if (!world)
        return;
    for (uint32_t phase = 0; phase < NG_PHASE_COUNT; phase++) {
        for (size_t i = 0; i < world->systems[phase].count; i++)
            if (world->systems[phase].items[i].finish)
                world->systems[phase].items[i].finish(world->systems[phase].items[i].user);
        ng_array_finish(&world->systems[phase]);
    }
    ng_queries_finish(world);
    ng_history_finish(world);
    ng_events_finish(world);
    ng_op_list_finish(&world->commands);
    for (size_t i = 0; i < world->tables.count; i++)
        ng_table_destroy(world->tables.items[i]);
    ng_array_finish(&world->tables);
    free(world->table_by_set.tables);
    ng_entities_finish(world);
    for (uint32_t c = 0; c < world->component_count; c++)
        free(world->components[c].defaults);
    free(world);
}

struct ng_world_memory ng_world_memory(const struct ng_world *world)
{
    struct ng_world_memory sum = {.bookkeeping = world->pages.count * NG_SLOT_PAGE * sizeof(struct ng_slot) +
                                                 world->pages.capacity * sizeof(struct ng_slot *) +
                                                 world->tables.capacity * sizeof(struct ng_table *) +
                                                 world->table_by_set.capacity * sizeof(uint32_t)};
    for (size_t i = 0; i < world->tables.count; i++)
        ng_table_memory(world->tables.items[i], &sum);
    return sum;
}

// ---- components ------------------------------------------------------------------------------------------
static ng_result check_desc(const struct ng_world *world, const struct ng_component_desc *desc)
{
    ng_component taken;
    NG_REQUIRE(desc->name && desc->name[0] && !strchr(desc->name, '.'),
               "a component needs a name without dots");
    NG_REQUIRE(!ng_world_find_component(world, desc->name, &taken), "component %s is registered already",
               desc->name);
    NG_REQUIRE(world->component_count < NG_COMPONENT_MAX, "component %s: a world has at most %d", desc->name,
               NG_COMPONENT_MAX);
    NG_REQUIRE(desc->align <= 16 && (desc->align & (desc->align - 1)) == 0,
               "component %s: alignment %u is not 1, 2, 4, 8 or 16", desc->name, desc->align);
    for (uint32_t i = 0; i < desc->field_count; i++) {
        const struct ng_field *f = &desc->fields[i];
        NG_REQUIRE(f->offset <= desc->size && ng_field_size(f->type) <= desc->size - f->offset,
                   "component %s: field %s is outside its %u bytes", desc->name, f->name, desc->size);
    }
    return NG_OK;
}

ng_result ng_world_register(struct ng_world *world, const struct ng_component_desc *desc, ng_component *out)
{
    NG_TRY(check_desc(world, desc));
    void *defaults = calloc(1, desc->size + 1u);
    if (!defaults)
        return ng_out_of_memory(desc->name);
    if (desc->defaults)
        memcpy(defaults, desc->defaults, desc->size);
    *out = world->component_count++;
    world->components[*out] = (struct ng_component_info){.desc = desc, .defaults = defaults};
    return NG_OK;
}

uint32_t ng_world_component_count(const struct ng_world *world)
{
    return world->component_count;
}

const struct ng_component_desc *ng_world_component(const struct ng_world *world, ng_component component)
{
    return component < world->component_count ? world->components[component].desc : NULL;
}

bool ng_world_find_component(const struct ng_world *world, const char *name, ng_component *out)
{
    for (*out = 0; *out < world->component_count; ++*out)
        if (strcmp(world->components[*out].desc->name, name) == 0)
            return true;
    return false;
}

// ---- values ----------------------------------------------------------------------------------------------
// Where a value is; false if the entity is dead or does not have the component.
static bool find(const struct ng_world *world, ng_entity e, ng_component component, struct ng_table **table,
                 uint32_t *row)
{
    if (!ng_world_has(world, e, component))
        return false;
    const struct ng_slot *slot = ng_slot(world, ng_entity_index(e));
    *table = ng_slot_table(world, slot);
    *row = slot->row;
    return true;
}

// The value, marked as changed now; null as find.
static void *touch(struct ng_world *world, ng_entity e, ng_component component)
{
    struct ng_table *table;
    uint32_t row;
    if (!find(world, e, component, &table, &row))
        return NULL;
    uint32_t column = ng_table_column(table, component);
    ng_table_set_tick(table, row, column, ng_world_use_tick(world));
    return ng_table_value(table, row, column);
}

ng_result ng_component_put(struct ng_world *world, ng_entity e, ng_component component, const void *value)
{
    NG_TRY(ng_entity_change_set(world, e, ng_world_components(world, e) | ng_bit(component)));
    memcpy(touch(world, e, component), value, world->components[component].desc->size);
    ng_event_queue(world, NG_EVENT_ADD, e, component);
    return NG_OK;
}

ng_result ng_component_drop(struct ng_world *world, ng_entity e, ng_component component)
{
    size_t queued = world->events.items.count;
    ng_event_queue(world, NG_EVENT_REMOVE, e, component); // now, while there is a last value
    ng_result r = ng_entity_change_set(world, e, ng_world_components(world, e) & ~ng_bit(component));
    if (r != NG_OK)
        world->events.items.count = queued;
    return r;
}

static ng_result check_change(const struct ng_world *world, ng_entity e, ng_component component)
{
    NG_REQUIRE(!world->parallel, "components cannot be added or removed inside ng_query_run_parallel");
    NG_REQUIRE(component < world->component_count, "component %u is not registered", component);
    NG_REQUIRE(ng_entity_known(world, e), "entity %llx does not exist (component %s)",
               (unsigned long long)e.id, world->components[component].desc->name);
    NG_REQUIRE(world->locked || ng_entity_alive(world, e), "entity %llx is not alive (component %s)",
               (unsigned long long)e.id, world->components[component].desc->name);
    return NG_OK;
}

ng_result ng_world_add(struct ng_world *world, ng_entity e, ng_component component, const void *value)
{
    NG_TRY(check_change(world, e, component));
    const struct ng_component_info *info = &world->components[component];
    struct ng_op op = {.kind = NG_OP_ADD, .entity = e, .component = component};
    value = value ? value : info->defaults;
    if (world->locked)
        return ng_op_list_push(&world->commands, &op, value, info->desc->size);
    if (ng_world_has(world, e, component))
        return ng_world_set(world, e, component, value);
    NG_TRY(ng_history_record(world, &op, value));
    ng_result r = ng_component_put(world, e, component, value);
    if (r != NG_OK)
        ng_history_unrecord(world);
    return r;
}

ng_result ng_world_remove(struct ng_world *world, ng_entity e, ng_component component)
{
    NG_TRY(check_change(world, e, component));
    struct ng_op op = {.kind = NG_OP_REMOVE, .entity = e, .component = component};
    if (world->locked)
        return ng_op_list_push(&world->commands, &op, NULL, 0);
    NG_REQUIRE(ng_world_has(world, e, component), "entity %u has no %s to remove", ng_entity_index(e),
               world->components[component].desc->name);
    NG_TRY(ng_history_record(world, &op, ng_world_get(world, e, component)));
    ng_result r = ng_component_drop(world, e, component);
    if (r != NG_OK)
        ng_history_unrecord(world);
    return r;
}

bool ng_world_has(const struct ng_world *world, ng_entity e, ng_component component)
{
    return component < world->component_count && (ng_world_components(world, e) & ng_bit(component));
}

const void *ng_world_get(const struct ng_world *world, ng_entity e, ng_component component)
{
    struct ng_table *table;
    uint32_t row;
    if (!find(world, e, component, &table, &row))
        return NULL;
    return ng_table_value(table, row, ng_table_column(table, component));
}

void *ng_world_write(struct ng_world *world, ng_entity e, ng_component component)
{
    NG_REQUIRE_OR(!world->parallel, NULL,
                  "inside ng_query_run_parallel only the chunk's own rows can be written");
    return touch(world, e, component);
}

void *ng_world_edit(struct ng_world *world, ng_entity e, ng_component component)
{
    struct ng_op op = {.kind = NG_OP_SET, .entity = e, .component = component};
    const void *old = ng_world_get(world, e, component);
    if (!old || ng_history_record(world, &op, old) != NG_OK)
        return NULL;
    void *value = ng_world_write(world, e, component);
    if (value)
        ng_event_queue(world, NG_EVENT_CHANGE, e, component);
    return value;
}

ng_result ng_world_set(struct ng_world *world, ng_entity e, ng_component component, const void *value)
{
    NG_TRY(check_change(world, e, component));
    const struct ng_component_info *info = &world->components[component];
    NG_REQUIRE(ng_world_has(world, e, component), "entity %u has no %s to set", ng_entity_index(e),
               info->desc->name);
    void *to = ng_world_edit(world, e, component);
    if (!to)
        return NG_ERROR_MEMORY;
    memmove(to, value ? value : info->defaults, info->desc->size);
    return NG_OK;
}

// ---- fields by path --------------------------------------------------------------------------------------
ng_result ng_world_find_field(const struct ng_world *world, const char *path, struct ng_field_ref *out)
{
    const char *dot = strchr(path, '.');
    size_t length = dot ? (size_t)(dot - path) : strlen(path);
    for (ng_component c = 0; c < world->component_count; c++) {
        const struct ng_component_desc *desc = world->components[c].desc;
        if (strlen(desc->name) != length || memcmp(desc->name, path, length) != 0)
            continue;
        const struct ng_field *field = ng_component_field(desc, dot ? dot + 1 : "");
        if (!field) {
            ng_log_error("%s: component %s has no such field", path, desc->name);
            return NG_ERROR_NOT_FOUND;
        }
        *out = (struct ng_field_ref){c, field};
        return NG_OK;
    }
    ng_log_error("%s: there is no component %.*s (a path is component.field)", path, (int)length, path);
    return NG_ERROR_NOT_FOUND;
}

// Finds the field of an entity and checks its type.
static ng_result find_field(const struct ng_world *world, ng_entity e, const char *path,
                            enum ng_field_type type, struct ng_field_ref *out)
{
    NG_TRY(ng_world_find_field(world, path, out));
    if (!ng_world_has(world, e, out->component)) {
        ng_log_error("%s: entity %u does not have this component", path, ng_entity_index(e));
        return NG_ERROR_NOT_FOUND;
    }
    if (out->field->type != type) {
        ng_log_error("%s: the field is of type %s, not %s", path, ng_field_type_name(out->field->type),
                     ng_field_type_name(type));
        return NG_ERROR_FORMAT;
    }
    return NG_OK;
}

ng_result ng_world_get_field(const struct ng_world *world, ng_entity e, const char *path,
                             enum ng_field_type type, void *value)
{
    struct ng_field_ref ref;
    NG_TRY(find_field(world, e, path, type, &ref));
    const unsigned char *from = ng_world_get(world, e, ref.component);
    memcpy(value, from + ref.field->offset, ng_field_size(type));
    return NG_OK;
}

ng_result ng_world_set_field(struct ng_world *world, ng_entity e, const char *path, enum ng_field_type type,
                             const void *value)
{
    struct ng_field_ref ref;
    char reason[NG_REASON_SIZE];
    NG_TRY(find_field(world, e, path, type, &ref));
    if (!ng_field_check(ref.field, value, reason)) {
        ng_log_error("%s of entity %u: %s", path, ng_entity_index(e), reason);
        return NG_ERROR_FORMAT;
    }
    unsigned char *to = ng_world_edit(world, e, ref.component);
    if (!to)
        return NG_ERROR_MEMORY;
    memmove(to + ref.field->offset, value, ng_field_size(type));
    return NG_OK;
}

// ---- change ticks ----------------------------------------------------------------------------------------
uint32_t ng_world_use_tick(struct ng_world *world)
{
    world->tick_used = true;
    return world->tick;
}

uint32_t ng_world_stamp(struct ng_world *world)
{
    // A loop under way may go on marking with whatever the tick is then, without telling.
    if (world->tick_used || world->locked) {
        world->tick++;
        world->tick_used = world->locked > 0;
    }
    return world->tick - 1;
}

uint32_t ng_world_changed_at(const struct ng_world *world, ng_entity e, ng_component component)
{
    struct ng_table *table;
    uint32_t row;
    return find(world, e, component, &table, &row)
               ? ng_table_tick(table, row, ng_table_column(table, component))
               : 0;
}

uint32_t ng_world_component_changed_at(const struct ng_world *world, ng_component component)
{
    uint32_t high = 0;
    for (size_t i = 0; i < world->tables.count; i++) {
        const struct ng_table *table = world->tables.items[i];
        if (!(component < world->component_count && table->set & ng_bit(component)))
            continue;
        uint32_t tick = table->columns[ng_table_column(table, component)].high;
        high = tick > high ? tick : high;
    }
    return high;
}

// Events: two queues that take turns, one being filled while the other is delivered.
#include "scene/world_internal.h"

#include <string.h>

// Last values start at multiples of this, so that observers may read them in place.
#define VALUE_ALIGN 16

static bool push(struct ng_event_queue *queue, const struct ng_event *event, const void *last, size_t size)
{
    size_t offset = (queue->bytes.count + VALUE_ALIGN - 1) & ~(size_t)(VALUE_ALIGN - 1);
    if (!ng_array_reserve(&queue->bytes, offset + size + 1) ||
        !ng_array_push(&queue->items, (struct ng_queued_event){*event, offset}))
        return false;
    if (size)
        memcpy(queue->bytes.items + offset, last, size);
    queue->bytes.count = offset + size;
    return true;
}

// A drag edits one value many times between two deliveries: one event says it.
static bool repeats_last(const struct ng_event_queue *queue, const struct ng_event *event)
{
    if (event->kind != NG_EVENT_CHANGE || !queue->items.count)
        return false;
    const struct ng_event *last = &queue->items.items[queue->items.count - 1].event;
    return last->kind == NG_EVENT_CHANGE && last->component == event->component &&
           ng_entity_same(last->entity, event->entity);
}

void ng_event_queue(struct ng_world *world, enum ng_event_kind kind, ng_entity e, ng_component component)
{
    const struct ng_component_info *info = &world->components[component];
    struct ng_event event = {.kind = kind, .entity = e, .component = component};
    if (!(info->observed & kind) || repeats_last(&world->events, &event))
        return;
    bool removal = kind == NG_EVENT_REMOVE;
    if (!push(&world->events, &event, removal ? ng_world_get(world, e, component) : NULL,
              removal ? info->desc->size : 0))
        ng_out_of_memory("an event, which is lost");
}

ng_result ng_world_observe(struct ng_world *world, const struct ng_observer_desc *desc)
{
    NG_REQUIRE(desc->component < world->component_count, "component %u is not registered", desc->component);
    NG_REQUIRE(desc->fn, "an observer needs a function");
    struct ng_observer_desc observer = *desc;
    if (!observer.kinds)
        observer.kinds = NG_EVENT_ADD | NG_EVENT_REMOVE | NG_EVENT_CHANGE;
    if (!ng_array_push(&world->observers, observer))
        return ng_out_of_memory("an observer");
    world->components[observer.component].observed |= observer.kinds;
    return NG_OK;
}

static void deliver(struct ng_world *world, const struct ng_event *event)
{
    // By index and by copy: an observer may add observers.
    for (size_t i = 0; i < world->observers.count; i++) {
        struct ng_observer_desc observer = world->observers.items[i];
        if (observer.component == event->component && (observer.kinds & event->kind))
            observer.fn(observer.user, world, event);
    }
}

void ng_world_dispatch(struct ng_world *world)
{
    NG_REQUIRE_OR(!world->locked, , "events cannot be delivered while a query is being iterated");
    if (world->dispatching)
        return; // an observer's call; the one under way delivers what it caused
    world->dispatching = true;
    while (world->events.items.count) {
        struct ng_event_queue batch = world->events;
        world->events = world->delivering;
        for (size_t i = 0; i < batch.items.count; i++) {
            struct ng_event event = batch.items.items[i].event;
            if (event.kind == NG_EVENT_REMOVE)
                event.last = batch.bytes.items + batch.items.items[i].last;
            deliver(world, &event);
        }
        batch.items.count = batch.bytes.count = 0;
        world->delivering = batch;
    }
    world->dispatching = false;
}

static void queue_finish(struct ng_event_queue *queue)
{
    ng_array_finish(&queue->items);
    ng_array_finish(&queue->bytes);
}

void ng_events_finish(struct ng_world *world)
{
    queue_finish(&world->events);
    queue_finish(&world->delivering);
    ng_array_finish(&world->observers);
}

// Events: who wants to know is told what was added, removed or changed.
//
// Events are queued where they happen and delivered by ng_world_dispatch (between phases, system.h), in
// order, so that an observer never finds the world in the middle of a change and may change it itself: what
// that causes is delivered by the same call. Nothing is queued that nobody observes.
#ifndef NG_SCENE_EVENT_H
#define NG_SCENE_EVENT_H

#include "base/extern_c.h"
#include "scene/world.h"

NG_EXTERN_C_BEGIN

enum ng_event_kind {
    NG_EVENT_ADD = 1,    // the entity got the component
    NG_EVENT_REMOVE = 2, // the entity lost it, or was destroyed; `last` is the value that it had
    NG_EVENT_CHANGE = 4, // edited or set; loops and ng_world_write are found by their ticks, not told
};

struct ng_event {
    enum ng_event_kind kind;
    ng_entity entity; // need not be alive any more
    ng_component component;
    const void *last; // REMOVE: the last value, valid during the call; else null
};

typedef void (*ng_event_fn)(void *user, struct ng_world *world, const struct ng_event *event);

struct ng_observer_desc {
    ng_component component;
    uint32_t kinds; // set of enum ng_event_kind; 0: all
    ng_event_fn fn;
    void *user;
};

// Observes until the world dies. Observers of one event are called in the order they were added.
NG_NODISCARD ng_result ng_world_observe(struct ng_world *world, const struct ng_observer_desc *desc);
// Delivers all queued events. Not while a query is iterated.
void ng_world_dispatch(struct ng_world *world);

NG_EXTERN_C_END

#endif

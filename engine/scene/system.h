// Systems: what is done to a world each frame, in fixed phases.
//
// ng_world_run goes through the phases in order; in a phase, systems run in the order they were added.
// Changes that a system made inside a query loop are applied when the loop ends, so before the next system;
// events are delivered after each phase.
#ifndef NG_SCENE_SYSTEM_H
#define NG_SCENE_SYSTEM_H

#include "base/extern_c.h"
#include "scene/world.h"

NG_EXTERN_C_BEGIN

enum ng_phase {
    NG_PHASE_INPUT,   // what people did: editor, window
    NG_PHASE_ANIMATE, // clips set fields
    NG_PHASE_UPDATE,  // the application's own rules
    NG_PHASE_PLACE,   // transforms become placements
    NG_PHASE_LATE,    // readers of the finished frame
    NG_PHASE_COUNT,
};

struct ng_system_desc {
    const char *name; // borrowed for the world's life
    enum ng_phase phase;
    // A failure is logged by the system, stops the frame and is returned by ng_world_run.
    ng_result (*run)(void *user, struct ng_world *world, double time);
    void (*finish)(void *user); // called when the world dies, may be null
    void *user;
};

NG_NODISCARD ng_result ng_world_add_system(struct ng_world *world, const struct ng_system_desc *desc);
// One frame at scene time `time`, in seconds.
NG_NODISCARD ng_result ng_world_run(struct ng_world *world, double time);

NG_EXTERN_C_END

#endif

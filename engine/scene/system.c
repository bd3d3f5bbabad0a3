#include "scene/system.h"

#include "scene/world_internal.h"

ng_result ng_world_add_system(struct ng_world *world, const struct ng_system_desc *desc)
{
    NG_REQUIRE(desc->run && desc->name, "a system needs a name and a function");
    NG_REQUIRE((uint32_t)desc->phase < NG_PHASE_COUNT, "system %s: no such phase", desc->name);
    if (!ng_array_push(&world->systems[desc->phase], *desc))
        return ng_out_of_memory("a system");
    return NG_OK;
}

ng_result ng_world_run(struct ng_world *world, double time)
{
    NG_REQUIRE(!world->locked, "a frame cannot run while a query is being iterated");
    for (uint32_t phase = 0; phase < NG_PHASE_COUNT; phase++) {
        for (size_t i = 0; i < world->systems[phase].count; i++) {
            const struct ng_system_desc system = world->systems[phase].items[i];
            NG_TRY(system.run(system.user, world, time));
            NG_REQUIRE(!world->locked, "system %s left a query loop without ng_query_stop", system.name);
        }
        ng_world_dispatch(world);
    }
    return NG_OK;
}

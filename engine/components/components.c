#include "components/components.h"

#include "scene/world.h"

#include <string.h>

static const struct ng_component_desc *const all[] = {
#define X(NAME, name) &ng_##name##_component,
    NG_COMPONENT_LIST(X)
#undef X
};

bool ng_component_is_light(ng_component component)
{
    return component < NG_COUNT(all) && strncmp(all[component]->name, "light_", 6) == 0;
}

ng_result ng_components_register(struct ng_world *world)
{
    NG_REQUIRE(ng_world_component_count(world) == 0, "engine components must be the first of a world");
    for (size_t i = 0; i < NG_COUNT(all); i++) {
        ng_component id;
        NG_TRY(ng_world_register(world, all[i], &id));
    }
    return NG_OK;
}

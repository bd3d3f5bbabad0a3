// The engine's components and their ids.
//
// A component is two files, NAME.h (the struct) and NAME.c (its field table, `ng_NAME_component`). The build
// finds them: there is no list to keep. To add one, copy camera.h and camera.c.
#ifndef NG_COMPONENTS_COMPONENTS_H
#define NG_COMPONENTS_COMPONENTS_H

#include "base/extern_c.h"
#include "base/result.h"
#include "scene/component.h"

NG_EXTERN_C_BEGIN

struct ng_world;

// Generated from the file names, in alphabetical order: NG_COMPONENT_LIST(X) expands X(NAME, name) for each.
#include "components/list.inc"

// The ids: NG_ANIMATION, NG_CAMERA, ...
enum ng_component_id {
#define X(NAME, name) NG_##NAME,
    NG_COMPONENT_LIST(X)
#undef X
        NG_COMPONENT_COUNT
};

// The descriptions: ng_animation_component, ng_camera_component, ...
#define X(NAME, name) extern const struct ng_component_desc ng_##name##_component;
NG_COMPONENT_LIST(X)
#undef X

// Whether a component makes its entity a light (light/light.h): those whose names begin with "light_".
bool ng_component_is_light(ng_component component);

// Registers all of the engine's components; the world must have none yet, so that ids are these.
NG_NODISCARD ng_result ng_components_register(struct ng_world *world);

NG_EXTERN_C_END

#endif

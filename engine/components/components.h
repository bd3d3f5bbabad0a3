// The engine's components and their ids.
//
// A component is two files, NAME.h (the struct) and NAME.c (its field table, `ng_NAME_component`). The build
// finds them: there is no list to keep. To add one, copy camera.h and camera.c.
#ifndef NG_COMPONENTS_COMPONENTS_H
#define NG_COMPONENTS_COMPONENTS_H

#include "base/result.h"
#include "scene/component.h"

struct ng_world;

// Generated from the file names: NG_COMPONENT_LIST(X) expands X(NAME, name) for each component, and the ids
// NG_COMPONENT_ID_<NAME> = 0, 1, ... in alphabetical order. Example: NG_CAMERA.
#include "components/list.inc"

// Registers all of the engine's components; the world must have none yet, so that ids are these.
NG_NODISCARD ng_result ng_components_register(struct ng_world *world);

#endif

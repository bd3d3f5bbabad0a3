// Transforms become placements: local matrices multiplied down the hierarchy.
//
// Every entity with a transform gets a placement; one that lost its transform loses its placement. An entity
// without a transform between two that have one passes its ancestor's matrix on. Only subtrees in which a
// transform or a parent changed are walked, and a placement's tick moves only where its matrix did.
#ifndef NG_COMPONENTS_PLACEMENT_SYSTEM_H
#define NG_COMPONENTS_PLACEMENT_SYSTEM_H

#include "base/extern_c.h"
#include "base/result.h"
#include "components/placement.h"

NG_EXTERN_C_BEGIN

struct ng_transform;
struct ng_world;

// Adds the system to NG_PHASE_PLACE; it lives as long as the world. Engine components must be registered.
NG_NODISCARD ng_result ng_placement_system_add(struct ng_world *world);

// What it finds for an entity without a parent.
struct ng_placement ng_placement_of(const struct ng_transform *transform);

NG_EXTERN_C_END

#endif

// An environment light as engine/shaders/environment.glsl reads it.
#ifndef NG_RENDER_ENVIRONMENT_H
#define NG_RENDER_ENVIRONMENT_H

#include "base/extern_c.h"
#include "render/snapshot.h"

NG_EXTERN_C_BEGIN

// Its push constants.
struct ng_environment_push {
    float world_to_map[12]; // three rows of four
    float radiance[3];
};

bool ng_is_environment(const struct ng_snapshot_light *light);
void ng_environment_push_of(const struct ng_snapshot_light *light, struct ng_environment_push *out);

NG_EXTERN_C_END

#endif

// The G-buffer: what the camera sees (render/frame.h, struct ng_gbuffer). One pass over the scene, one over
// lamps where there are some, one over the background where an environment shows.
#ifndef NG_RENDER_GBUFFER_H
#define NG_RENDER_GBUFFER_H

#include "base/extern_c.h"
#include "graph/provider.h"

NG_EXTERN_C_BEGIN

struct ng_gpu;
struct ng_gbuffer_provider;

NG_NODISCARD ng_result ng_gbuffer_create(struct ng_gpu *gpu, struct ng_gbuffer_provider **out);
void ng_gbuffer_destroy(struct ng_gbuffer_provider **provider);
// Publishes ng_gbuffer_behind_lamps_item, and to consumers after it ng_gbuffer_item. The provider is borrowed
// while registered.
struct ng_provider ng_gbuffer_provider(struct ng_gbuffer_provider *provider);

NG_EXTERN_C_END

#endif

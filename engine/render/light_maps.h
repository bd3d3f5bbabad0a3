// What each light sees: its depth maps and its reflective shadow map (render/frame.h, struct ng_light_maps).
//
// One provider for all lights; each light has passes of its own, "rsm:<light>/depth" and
// "rsm:<light>/surface". They run only when something that they show has changed, the light or an instance
// in its views, and only if a method of the frame reads them.
#ifndef NG_RENDER_LIGHT_MAPS_H
#define NG_RENDER_LIGHT_MAPS_H

#include "base/extern_c.h"
#include "graph/provider.h"

NG_EXTERN_C_BEGIN

struct ng_gpu;
struct ng_light_maps_provider;

struct ng_light_maps_params {
    struct ng_gpu *gpu;
    uint64_t depth_budget; // bytes for all depth maps; 0: 192 MiB. The face size falls from 1024 to fit
    float cascade_radius;  // metres: scenes larger than this give orthographic lights four cascades; 0: 40
    bool always;           // redraw in every frame, whether or not anything changed or anybody reads it
                           // (benchmarks, tests)
    bool bare_depth;       // adds "bare:<light>/depth", the same depth pass into a map of its own, to measure
                           // against
};

NG_NODISCARD ng_result ng_light_maps_create(const struct ng_light_maps_params *params,
                                            struct ng_light_maps_provider **out);
void ng_light_maps_destroy(struct ng_light_maps_provider **provider);
// Publishes one ng_light_maps_item for each light that is on. The provider is borrowed while registered.
struct ng_provider ng_light_maps_provider(struct ng_light_maps_provider *provider);

// Side of a depth face, texels: the largest power of two up to 1024 for which all faces fit the budget; at
// least 64.
uint32_t ng_light_maps_face_size(uint64_t budget, uint32_t faces);

NG_EXTERN_C_END

#endif

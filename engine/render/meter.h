// The light meter of cameras with auto_exposure: passes that find a picture's exposure from how bright it is.
//
// It looks at direct light and emission of surfaces, which all methods have: their pictures of one moment are
// exposed alike, and it does not matter how much of the indirect light a method knows.
#ifndef NG_RENDER_METER_H
#define NG_RENDER_METER_H

#include "base/extern_c.h"
#include "graph/provider.h"

NG_EXTERN_C_BEGIN

struct ng_gpu;
struct ng_meter;
struct ng_radiance;

NG_NODISCARD ng_result ng_meter_create(struct ng_gpu *gpu, struct ng_meter **out);
void ng_meter_destroy(struct ng_meter **meter);

// Declares the passes: after ng_composer_declare, once a frame. The buffer holds the exposure, a float: what
// the meter finds times the camera's own, or where `adaptation` is above 0 and below 1 that part of the way
// there, in stops, from what the last frame had. Of pictures that are averaged the first is measured: after
// it
// (`averaged` above 1) nothing is.
struct ng_graph_ref ng_meter_declare(const struct ng_meter *meter, struct ng_composer *composer,
                                     const struct ng_radiance *radiance, float adaptation, uint32_t averaged);

NG_EXTERN_C_END

#endif

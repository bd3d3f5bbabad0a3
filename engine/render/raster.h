// The method "raster": direct light through the lights' depth maps with percentage-closer soft shadows, area
// lights by their direct VPLs; no indirect light. The baseline that everybody knows.
#ifndef NG_RENDER_RASTER_H
#define NG_RENDER_RASTER_H

#include "base/extern_c.h"
#include "graph/provider.h"

NG_EXTERN_C_BEGIN

struct ng_gpu;
struct ng_raster;

NG_NODISCARD ng_result ng_raster_create(struct ng_gpu *gpu, struct ng_raster **out);
void ng_raster_destroy(struct ng_raster **raster);
// Consumes the G-buffer and the light maps, publishes ng_radiance_item if the frame wants it.
struct ng_provider ng_raster_provider(struct ng_raster *raster);

NG_EXTERN_C_END

#endif

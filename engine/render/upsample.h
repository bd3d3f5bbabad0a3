// Light of fewer pixels than the picture has: upsampled so that edges and textures stay those of the picture.
#ifndef NG_RENDER_UPSAMPLE_H
#define NG_RENDER_UPSAMPLE_H

#include "base/extern_c.h"
#include "graph/provider.h"

NG_EXTERN_C_BEGIN

struct ng_gpu;
struct ng_radiance;
struct ng_upsample;

NG_NODISCARD ng_result ng_upsample_create(struct ng_gpu *gpu, struct ng_upsample **out);
void ng_upsample_destroy(struct ng_upsample **upsample);

// Declares the passes of a guided frame: after ng_composer_declare. Returns "beauty", RGBA32F, with all the
// picture's pixels.
struct ng_graph_ref ng_upsample_declare(const struct ng_upsample *upsample, struct ng_composer *composer,
                                        const struct ng_radiance *radiance);

NG_EXTERN_C_END

#endif

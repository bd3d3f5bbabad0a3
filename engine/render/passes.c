#include "render/passes.h"

#include "fullscreen.vert.spv.h"

ng_result ng_fullscreen_create(struct ng_gpu *gpu, const struct ng_gpu_graphics_params *params,
                               struct ng_gpu_pipeline **out)
{
    struct ng_gpu_graphics_params p = *params;
    p.vertex = NG_SPIRV(ng_spv_fullscreen_vert);
    return ng_gpu_graphics_create(gpu, &p, out);
}

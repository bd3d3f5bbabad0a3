#include "render/passes.h"

#include "fullscreen.vert.spv.h"

struct ng_gpu_binding ng_pass_texture(const struct ng_pass_context *ctx, struct ng_graph_ref ref,
                                      uint32_t binding)
{
    return (struct ng_gpu_binding){.binding = binding,
                                   .view = ng_pass_view(ctx, ref),
                                   .layout = ng_pass_layout(ctx, ref),
                                   .sampler = ng_gpu_sampler(ctx->gpu, &(struct ng_gpu_sampler_params){0})};
}

struct ng_gpu_binding ng_pass_range(const struct ng_frame_range *range, uint32_t binding)
{
    return (struct ng_gpu_binding){
        .binding = binding, .buffer = range->buffer, .offset = range->offset, .range = range->size};
}

ng_result ng_fullscreen_create(struct ng_gpu *gpu, const struct ng_gpu_graphics_params *params,
                               struct ng_gpu_pipeline **out)
{
    struct ng_gpu_graphics_params p = *params;
    p.vertex = NG_SPIRV(ng_spv_fullscreen_vert);
    return ng_gpu_graphics_create(gpu, &p, out);
}

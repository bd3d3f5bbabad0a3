// What passes are written with: textures from the graph, and pipelines that cover the picture.
#ifndef NG_RENDER_PASSES_H
#define NG_RENDER_PASSES_H

#include "gpu/pipeline.h"
#include "graph/graph.h"

// A resource of the graph as a texture that is fetched, not filtered.
static inline struct ng_gpu_binding ng_pass_texture(const struct ng_pass_context *ctx,
                                                    struct ng_graph_ref ref, uint32_t binding)
{
    return (struct ng_gpu_binding){.binding = binding,
                                   .view = ng_pass_view(ctx, ref),
                                   .layout = ng_pass_layout(ctx, ref),
                                   .sampler = ng_gpu_sampler(ctx->gpu, &(struct ng_gpu_sampler_params){0})};
}

// A pipeline that covers the picture: `params` without a vertex stage, which is fullscreen.vert. Draw 3
// vertices.
NG_NODISCARD ng_result ng_fullscreen_create(struct ng_gpu *gpu, const struct ng_gpu_graphics_params *params,
                                            struct ng_gpu_pipeline **out);

#endif

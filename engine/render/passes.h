// What passes are written with: textures from the graph, ranges of the frame's memory, and pipelines that
// cover the picture.
//
// Numbers that shaders branch on travel in storage buffers, never in uniform buffers or push constants:
// lavapipe compiles a shader anew for each value of those (Mesa's inlined uniforms). The camera's view, which
// nothing branches on, stays in a uniform buffer: what lavapipe loads from storage is 0 in the pixels of a
// quad that a triangle does not cover, and derivatives would take that in.
#ifndef NG_RENDER_PASSES_H
#define NG_RENDER_PASSES_H

#include "base/extern_c.h"
#include "gpu/frame.h"
#include "gpu/pipeline.h"
#include "graph/graph.h"

NG_EXTERN_C_BEGIN

// A resource of the graph as a texture that is fetched, not filtered.
struct ng_gpu_binding ng_pass_texture(const struct ng_pass_context *ctx, struct ng_graph_ref ref,
                                      uint32_t binding);

// A range of the frame's memory as a buffer.
struct ng_gpu_binding ng_pass_range(const struct ng_frame_range *range, uint32_t binding);

// A pipeline that covers the picture: `params` without a vertex stage, which is fullscreen.vert. Draw 3
// vertices.
NG_NODISCARD ng_result ng_fullscreen_create(struct ng_gpu *gpu, const struct ng_gpu_graphics_params *params,
                                            struct ng_gpu_pipeline **out);

NG_EXTERN_C_END

#endif

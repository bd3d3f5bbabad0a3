// Commands: recording into a command buffer.
//
// `cmd->handle` is an ordinary VkCommandBuffer: draw, dispatch, copy and barrier with the vkCmd functions.
// Here is what is more than one Vulkan call. A struct ng_cmd comes from gpu/frame.h and is valid until it is
// submitted.
#ifndef NG_GPU_COMMAND_H
#define NG_GPU_COMMAND_H

#include "base/extern_c.h"
#include "gpu/pipeline.h"

NG_EXTERN_C_BEGIN

struct ng_cmd {
    VkCommandBuffer handle;
    struct ng_gpu *gpu;
    struct ng_gpu_recorder *recorder;
};

// Labels nest; debuggers and validation messages show them. Every begin has its end in the same ng_cmd.
void ng_cmd_label_begin(struct ng_cmd *cmd, const char *name);
void ng_cmd_label_end(struct ng_cmd *cmd);

// Binds the pipeline and, if it declares slots in set 0, writes these: all of them, each once.
// A wrong binding (unknown, missing or of another type) is the caller's bug.
NG_NODISCARD ng_result ng_cmd_bind(struct ng_cmd *cmd, const struct ng_gpu_pipeline *pipeline,
                                   const struct ng_gpu_binding *bindings, uint32_t count);
// Binds a group to its set. After ng_cmd_bind with a pipeline that declares the set with the same slots.
void ng_cmd_bind_group(struct ng_cmd *cmd, const struct ng_gpu_pipeline *pipeline,
                       const struct ng_gpu_bind_group *group);
// Push constants from byte 0; `size` at most the pipeline's push_size.
void ng_cmd_push(struct ng_cmd *cmd, const struct ng_gpu_pipeline *pipeline, const void *data, uint32_t size);
// Workgroups that cover x * y * z items in groups of the shader's local size.
void ng_cmd_dispatch_over(struct ng_cmd *cmd, const uint32_t items[3], const uint32_t local_size[3]);

struct ng_gpu_attachment {
    VkImageView view;
    bool load;    // keep the old content; else clear to `clear`
    bool discard; // the content after the pass is not needed
    VkClearValue clear;
};
struct ng_gpu_rendering_params {
    uint32_t width, height; // of the area, from (0, 0); viewport and scissor are set to it
    uint32_t layers;        // 0: 1
    struct ng_gpu_attachment color[NG_GPU_MAX_COLOR]; // in COLOR_ATTACHMENT_OPTIMAL
    uint32_t color_count;
    struct ng_gpu_attachment depth; // no view: none; in DEPTH_ATTACHMENT_OPTIMAL (or the combined layout)
    VkImageLayout depth_layout;     // 0: DEPTH_ATTACHMENT_OPTIMAL
};
void ng_cmd_rendering_begin(struct ng_cmd *cmd, const struct ng_gpu_rendering_params *params);
void ng_cmd_rendering_end(struct ng_cmd *cmd);

NG_EXTERN_C_END

#endif

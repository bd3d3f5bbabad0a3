// What is more than one Vulkan call while recording: binding with descriptors, rendering into attachments,
// labels.
#include "gpu/command.h"

#include "gpu/gpu_internal.h"

void ng_cmd_label_begin(struct ng_cmd *cmd, const char *name)
{
    PFN_vkCmdBeginDebugUtilsLabelEXT begin = cmd->gpu->internal->label_begin;
    if (begin)
        begin(cmd->handle,
              &(VkDebugUtilsLabelEXT){.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT, .pLabelName = name});
}

void ng_cmd_label_end(struct ng_cmd *cmd)
{
    PFN_vkCmdEndDebugUtilsLabelEXT end = cmd->gpu->internal->label_end;
    if (end)
        end(cmd->handle);
}

ng_result ng_cmd_bind(struct ng_cmd *cmd, const struct ng_gpu_pipeline *pipeline,
                      const struct ng_gpu_binding *bindings, uint32_t count)
{
    struct ng_gpu *gpu = cmd->gpu;
    struct ng_gpu_writes w;
    if (!ng_gpu_fill_writes(pipeline, 0, bindings, count, &w))
        return NG_ERROR_USAGE;
    vkCmdBindPipeline(cmd->handle, pipeline->bind_point, pipeline->handle);
    if (!count)
        return NG_OK;
    if (pipeline->push_set) {
        gpu->internal->push_descriptors(cmd->handle, pipeline->bind_point, pipeline->layout, 0, count,
                                        w.writes);
        return NG_OK;
    }
    VkDescriptorSet set;
    NG_TRY(ng_gpu_recorder_set(gpu, cmd->recorder, pipeline->set_layouts[0], &set));
    for (uint32_t i = 0; i < count; i++)
        w.writes[i].dstSet = set;
    vkUpdateDescriptorSets(gpu->device, count, w.writes, 0, NULL);
    vkCmdBindDescriptorSets(cmd->handle, pipeline->bind_point, pipeline->layout, 0, 1, &set, 0, NULL);
    return NG_OK;
}

void ng_cmd_bind_group(struct ng_cmd *cmd, const struct ng_gpu_pipeline *pipeline,
                       const struct ng_gpu_bind_group *group)
{
    vkCmdBindDescriptorSets(cmd->handle, pipeline->bind_point, pipeline->layout, group->set, 1,
                            &group->handle, 0, NULL);
}

void ng_cmd_push(struct ng_cmd *cmd, const struct ng_gpu_pipeline *pipeline, const void *data, uint32_t size)
{
    NG_REQUIRE_OR(size <= pipeline->push_size, , "push constants of '%s' are at most %u bytes",
                  pipeline->live.name, pipeline->push_size);
    vkCmdPushConstants(cmd->handle, pipeline->layout, pipeline->push_stages, 0, size, data);
}

void ng_cmd_dispatch_over(struct ng_cmd *cmd, const uint32_t items[3], const uint32_t local_size[3])
{
    uint32_t groups[3];
    for (int i = 0; i < 3; i++)
        groups[i] = items[i] / local_size[i] + (items[i] % local_size[i] ? 1 : 0);
    vkCmdDispatch(cmd->handle, groups[0], groups[1], groups[2]);
}

static VkRenderingAttachmentInfo attachment_info(const struct ng_gpu_attachment *a, VkImageLayout layout)
{
    return (VkRenderingAttachmentInfo){
        .sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
        .imageView = a->view,
        .imageLayout = layout,
        .loadOp = a->load ? VK_ATTACHMENT_LOAD_OP_LOAD : VK_ATTACHMENT_LOAD_OP_CLEAR,
        .storeOp = a->discard ? VK_ATTACHMENT_STORE_OP_DONT_CARE : VK_ATTACHMENT_STORE_OP_STORE,
        .clearValue = a->clear};
}

void ng_cmd_rendering_begin(struct ng_cmd *cmd, const struct ng_gpu_rendering_params *params)
{
    NG_REQUIRE_OR(params->color_count <= NG_GPU_MAX_COLOR, , "at most %d colour attachments",
                  NG_GPU_MAX_COLOR);
    VkRenderingAttachmentInfo color[NG_GPU_MAX_COLOR];
    for (uint32_t i = 0; i < params->color_count; i++)
        color[i] = attachment_info(&params->color[i], VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    VkRenderingAttachmentInfo depth =
        attachment_info(&params->depth, params->depth_layout ? params->depth_layout
                                                             : VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL);
    VkRect2D area = {.extent = {params->width, params->height}};
    VkRenderingInfo info = {.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                            .renderArea = area,
                            .layerCount = params->layers ? params->layers : 1,
                            .colorAttachmentCount = params->color_count,
                            .pColorAttachments = color,
                            .pDepthAttachment = params->depth.view ? &depth : NULL};
    VkViewport viewport = {0, 0, (float)params->width, (float)params->height, 0, 1};
    vkCmdBeginRendering(cmd->handle, &info);
    vkCmdSetViewport(cmd->handle, 0, 1, &viewport);
    vkCmdSetScissor(cmd->handle, 0, 1, &area);
}

void ng_cmd_rendering_end(struct ng_cmd *cmd)
{
    vkCmdEndRendering(cmd->handle);
}

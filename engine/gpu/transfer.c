// Uploads are recorded into a command buffer of their own, which ng_gpu_submit puts ahead of the next
// commands. Their bytes wait in staging buffers of a fixed size, reused once the submission that read them is
// done; what does not fit in one gets a buffer for itself. Host-visible targets are written in place.
#include "gpu/transfer.h"

#include "gpu/gpu_internal.h"

#include <string.h>

#define STAGING_SIZE      ((uint64_t)8 << 20)
#define STAGING_COUNT     4                    // then the oldest is waited for
#define STAGING_ONCE      ((uint64_t)64 << 20) // bytes of buffers for single use before a submission is forced
#define STAGING_ALIGNMENT 48                   // a multiple of every texel size and of 4

// ---- The upload command buffer ---------------------------------------------------------------------------

ng_result ng_gpu_uploads_init(struct ng_gpu *gpu)
{
    VkCommandPoolCreateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                    .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                    .queueFamilyIndex = gpu->queue_family};
    NG_TRY(ng_gpu_check(gpu, vkCreateCommandPool(gpu->device, &info, NULL, &gpu->internal->upload_pool),
                        "create", "upload command pool"));
    ng_gpu_set_name(gpu, VK_OBJECT_TYPE_COMMAND_POOL, (uint64_t)gpu->internal->upload_pool,
                    "upload command pool");
    return NG_OK;
}

void ng_gpu_uploads_finish(struct ng_gpu *gpu)
{
    struct ng_gpu_internal *in = gpu->internal;
    in->upload = VK_NULL_HANDLE;
    for (size_t i = 0; i < in->staging.count; i++)
        ng_gpu_buffer_destroy(&in->staging.items[i].buffer);
    ng_array_finish(&in->staging);
    ng_array_finish(&in->upload_commands);
    vkDestroyCommandPool(gpu->device, in->upload_pool, NULL);
}

static void full_barrier(VkCommandBuffer commands, VkPipelineStageFlags2 from, VkPipelineStageFlags2 to)
{
    VkMemoryBarrier2 barrier = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                .srcStageMask = from,
                                .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
                                .dstStageMask = to,
                                .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT};
    VkDependencyInfo dependency = {
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &barrier};
    vkCmdPipelineBarrier2(commands, &dependency);
}

// A command buffer whose last submission is done, or a new one.
static ng_result free_commands(struct ng_gpu *gpu, struct ng_gpu_upload_commands **out)
{
    struct ng_gpu_internal *in = gpu->internal;
    for (size_t i = 0; i < in->upload_commands.count; i++)
        if (in->upload_commands.items[i].serial <= in->done_serial) {
            *out = &in->upload_commands.items[i];
            return NG_OK;
        }
    struct ng_gpu_upload_commands commands = {0};
    VkCommandBufferAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                        .commandPool = in->upload_pool,
                                        .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                        .commandBufferCount = 1};
    if (!ng_array_reserve(&in->upload_commands, in->upload_commands.count + 1)) {
        ng_log_error("gpu: out of host memory for an upload");
        return NG_ERROR_MEMORY;
    }
    NG_TRY(ng_gpu_check(gpu,
                        NG_GPU_CREATE(gpu, vkAllocateCommandBuffers(gpu->device, &info, &commands.handle)),
                        "allocate", "upload commands"));
    ng_gpu_set_name(gpu, VK_OBJECT_TYPE_COMMAND_BUFFER, (uint64_t)(uintptr_t)commands.handle,
                    "upload commands");
    *out = &in->upload_commands.items[in->upload_commands.count++];
    **out = commands;
    return NG_OK;
}

// Opens the upload command buffer unless it is open.
static ng_result upload_begin(struct ng_gpu *gpu)
{
    struct ng_gpu_internal *in = gpu->internal;
    if (in->upload)
        return NG_OK;
    struct ng_gpu_upload_commands *commands;
    NG_TRY(free_commands(gpu, &commands));
    VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                      .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    NG_TRY(ng_gpu_check(gpu, NG_GPU_CALL(gpu, vkBeginCommandBuffer(commands->handle, &begin)), "begin",
                        "upload commands"));
    commands->serial = UINT64_MAX; // in use until ng_gpu_uploads_take knows better
    in->upload = commands->handle;
    if (in->label_begin)
        in->label_begin(in->upload, &(VkDebugUtilsLabelEXT){.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT,
                                                            .pLabelName = "upload"});
    // Earlier submissions may still read or write the targets.
    full_barrier(in->upload, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT);
    return NG_OK;
}

VkCommandBuffer ng_gpu_uploads_take(struct ng_gpu *gpu, uint64_t serial)
{
    struct ng_gpu_internal *in = gpu->internal;
    VkCommandBuffer commands = in->upload;
    if (!commands)
        return VK_NULL_HANDLE;
    full_barrier(commands, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);
    if (in->label_end)
        in->label_end(commands);
    for (size_t i = 0; i < in->upload_commands.count; i++)
        if (in->upload_commands.items[i].handle == commands)
            in->upload_commands.items[i].serial = serial;
    in->upload = VK_NULL_HANDLE;
    in->staging_once = 0;
    return commands;
}

// ---- Staging ---------------------------------------------------------------------------------------------

struct staged {
    struct ng_gpu_buffer *buffer;
    uint64_t offset;
    bool once; // destroy after recording
};

static ng_result staging_create(struct ng_gpu *gpu, uint64_t size, struct ng_gpu_buffer **out)
{
    struct ng_gpu_buffer_params params = {.name = "staging",
                                          .size = size,
                                          .usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
                                          .memory = NG_GPU_MEMORY_UPLOAD};
    return ng_gpu_buffer_create(gpu, &params, out);
}

// A staging buffer with room for `size` bytes, or null.
static struct ng_gpu_staging *staging_with_room(struct ng_gpu_internal *in, uint64_t size)
{
    for (size_t i = 0; i < in->staging.count; i++) {
        struct ng_gpu_staging *s = &in->staging.items[i];
        if (s->serial <= in->done_serial)
            s->used = 0;
        if (size <= STAGING_SIZE - s->used)
            return s;
    }
    return NULL;
}

static ng_result staging_grow(struct ng_gpu *gpu)
{
    struct ng_gpu_internal *in = gpu->internal;
    if (in->staging.count == STAGING_COUNT) {
        // Everything is full: let the device read it. With a frame open, its own commands come later as ever.
        NG_TRY(ng_gpu_submit(gpu, VK_NULL_HANDLE, false));
        return ng_gpu_wait(gpu, in->next_serial - 1);
    }
    struct ng_gpu_staging s = {0};
    NG_TRY(staging_create(gpu, STAGING_SIZE, &s.buffer));
    if (ng_array_push(&in->staging, s))
        return NG_OK;
    ng_log_error("gpu: out of host memory for staging");
    ng_gpu_buffer_destroy(&s.buffer);
    return NG_ERROR_MEMORY;
}

// Room for `size` bytes that the next upload commands read.
static ng_result stage(struct ng_gpu *gpu, uint64_t size, struct staged *out)
{
    struct ng_gpu_internal *in = gpu->internal;
    if (size > STAGING_SIZE) {
        if (in->staging_once > STAGING_ONCE) {
            NG_TRY(ng_gpu_submit(gpu, VK_NULL_HANDLE, false));
            NG_TRY(ng_gpu_wait(gpu, in->next_serial - 1));
        }
        *out = (struct staged){.once = true};
        in->staging_once += size;
        return staging_create(gpu, size, &out->buffer);
    }
    struct ng_gpu_staging *s;
    while (!(s = staging_with_room(in, size)))
        NG_TRY(staging_grow(gpu));
    *out = (struct staged){.buffer = s->buffer, .offset = s->used};
    uint64_t used = ng_gpu_align(s->used + size, STAGING_ALIGNMENT);
    s->used = used < STAGING_SIZE ? used : STAGING_SIZE;
    s->serial = in->next_serial;
    return NG_OK;
}

// Copies the bytes and opens the upload commands that will read them.
static ng_result stage_bytes(struct ng_gpu *gpu, const void *data, uint64_t size, struct staged *out)
{
    NG_TRY(stage(gpu, size, out));
    memcpy((unsigned char *)out->buffer->mapped + out->offset, data, size);
    ng_result r = upload_begin(gpu);
    if (r != NG_OK && out->once)
        ng_gpu_buffer_destroy(&out->buffer);
    return r;
}

// ---- Buffers ---------------------------------------------------------------------------------------------

static bool within(uint64_t offset, uint64_t size, uint64_t whole)
{
    return size <= whole && offset <= whole - size;
}

ng_result ng_upload_buffer(struct ng_gpu_buffer *buffer, uint64_t offset, const void *data, uint64_t size)
{
    struct ng_gpu *gpu = buffer->live.gpu;
    NG_REQUIRE(within(offset, size, buffer->size), "an upload fits buffer '%s' of %llu bytes",
               buffer->live.name, (unsigned long long)buffer->size);
    if (gpu->lost)
        return NG_ERROR_DEVICE;
    if (!size)
        return NG_OK;
    if (buffer->mapped) {
        memcpy((unsigned char *)buffer->mapped + offset, data, size);
        return NG_OK;
    }
    struct staged from;
    NG_TRY(stage_bytes(gpu, data, size, &from));
    // A second upload of the same bytes must come second.
    VkCommandBuffer commands = gpu->internal->upload;
    VkBufferCopy copy = {from.offset, offset, size};
    full_barrier(commands, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT);
    vkCmdCopyBuffer(commands, from.buffer->handle, buffer->handle, 1, &copy);
    if (from.once)
        ng_gpu_buffer_destroy(&from.buffer);
    return NG_OK;
}

// A host-visible buffer for one readback; destroyed by the caller.
static ng_result readback_create(struct ng_gpu *gpu, uint64_t size, struct ng_gpu_buffer **out)
{
    struct ng_gpu_buffer_params params = {.name = "readback",
                                          .size = size,
                                          .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                                          .memory = NG_GPU_MEMORY_READBACK};
    return ng_gpu_buffer_create(gpu, &params, out);
}

static ng_result copy_buffer_back(struct ng_gpu_buffer *buffer, uint64_t offset, struct ng_gpu_buffer *to)
{
    struct ng_gpu *gpu = buffer->live.gpu;
    struct ng_cmd *cmd;
    NG_TRY(ng_gpu_once_begin(gpu, &cmd));
    VkBufferCopy copy = {offset, 0, to->size};
    full_barrier(cmd->handle, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT);
    vkCmdCopyBuffer(cmd->handle, buffer->handle, to->handle, 1, &copy);
    return ng_gpu_once_end(gpu, &cmd);
}

ng_result ng_readback_buffer(struct ng_gpu_buffer *buffer, uint64_t offset, void *out, uint64_t size)
{
    struct ng_gpu *gpu = buffer->live.gpu;
    NG_REQUIRE(within(offset, size, buffer->size), "a readback is within buffer '%s' of %llu bytes",
               buffer->live.name, (unsigned long long)buffer->size);
    if (gpu->lost)
        return NG_ERROR_DEVICE;
    if (!size)
        return NG_OK;
    if (buffer->mapped) {
        NG_TRY(ng_gpu_wait_idle(gpu));
        memcpy(out, (unsigned char *)buffer->mapped + offset, size);
        return NG_OK;
    }
    struct ng_gpu_buffer *to;
    NG_TRY(readback_create(gpu, size, &to));
    ng_result r = copy_buffer_back(buffer, offset, to);
    if (r == NG_OK)
        memcpy(out, to->mapped, size);
    ng_gpu_buffer_destroy(&to);
    return r;
}

// ---- Images ----------------------------------------------------------------------------------------------

static uint64_t level_size(const struct ng_gpu_image *image, uint32_t mip, uint32_t layers)
{
    return (uint64_t)ng_gpu_mip_extent(image->width, mip) * ng_gpu_mip_extent(image->height, mip) *
           ng_gpu_mip_extent(image->depth, mip) * layers * ng_gpu_format_size(image->format);
}

uint64_t ng_transfer_image_size(const struct ng_gpu_image *image, uint32_t mip, uint32_t mips, uint32_t layer,
                                uint32_t layers)
{
    uint64_t size = 0;
    uint32_t end = mips ? mip + mips : image->mips;
    for (uint32_t i = mip; i < end; i++)
        size += level_size(image, i, layers ? layers : image->layers - layer);
    return size;
}

// Levels and layers of a copy, with defaults resolved.
static ng_result resolve(const struct ng_gpu_image *image, VkImageSubresourceRange *part, uint64_t size,
                         const void *data)
{
    NG_REQUIRE(ng_gpu_format_size(image->format), "the format of image '%s' can be copied", image->live.name);
    NG_REQUIRE(within(part->baseMipLevel, part->levelCount, image->mips) && part->baseMipLevel < image->mips,
               "a copy is within the %u mip levels of image '%s'", image->mips, image->live.name);
    NG_REQUIRE(within(part->baseArrayLayer, part->layerCount, image->layers) &&
                   part->baseArrayLayer < image->layers,
               "a copy is within the %u layers of image '%s'", image->layers, image->live.name);
    part->aspectMask = image->aspect;
    part->levelCount = part->levelCount ? part->levelCount : image->mips - part->baseMipLevel;
    part->layerCount = part->layerCount ? part->layerCount : image->layers - part->baseArrayLayer;
    uint64_t need = ng_transfer_image_size(image, part->baseMipLevel, part->levelCount, part->baseArrayLayer,
                                           part->layerCount);
    NG_REQUIRE(data && size == need, "a copy of image '%s' takes %llu bytes, not %llu", image->live.name,
               (unsigned long long)need, (unsigned long long)size);
    return NG_OK;
}

// One region a level; returns how many.
static uint32_t regions_of(const struct ng_gpu_image *image, const VkImageSubresourceRange *part,
                           uint64_t offset, VkBufferImageCopy regions[32])
{
    for (uint32_t i = 0; i < part->levelCount; i++) {
        uint32_t mip = part->baseMipLevel + i;
        regions[i] = (VkBufferImageCopy){
            .bufferOffset = offset,
            .imageSubresource = {part->aspectMask, mip, part->baseArrayLayer, part->layerCount},
            .imageExtent = {ng_gpu_mip_extent(image->width, mip), ng_gpu_mip_extent(image->height, mip),
                            ng_gpu_mip_extent(image->depth, mip)}};
        offset += level_size(image, mip, part->layerCount);
    }
    return part->levelCount;
}

static void image_barrier(VkCommandBuffer commands, const struct ng_gpu_image *image,
                          const VkImageSubresourceRange *part, VkImageLayout from, VkImageLayout to)
{
    VkImageMemoryBarrier2 barrier = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
        .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
        .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
        .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
        .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT,
        .oldLayout = from,
        .newLayout = to,
        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .image = image->handle,
        .subresourceRange = *part,
    };
    VkDependencyInfo dependency = {.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                                   .imageMemoryBarrierCount = 1,
                                   .pImageMemoryBarriers = &barrier};
    vkCmdPipelineBarrier2(commands, &dependency);
}

ng_result ng_upload_image(struct ng_gpu_image *image, const struct ng_upload_image_params *params)
{
    struct ng_gpu *gpu = image->live.gpu;
    VkImageSubresourceRange part = {.baseMipLevel = params->mip,
                                    .levelCount = params->mips,
                                    .baseArrayLayer = params->layer,
                                    .layerCount = params->layers};
    NG_TRY(resolve(image, &part, params->size, params->data));
    if (gpu->lost)
        return NG_ERROR_DEVICE;
    struct staged from;
    NG_TRY(stage_bytes(gpu, params->data, params->size, &from));
    VkCommandBuffer commands = gpu->internal->upload;
    VkBufferImageCopy regions[32];
    uint32_t count = regions_of(image, &part, from.offset, regions);
    image_barrier(commands, image, &part, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    vkCmdCopyBufferToImage(commands, from.buffer->handle, image->handle, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                           count, regions);
    image_barrier(commands, image, &part, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                  params->layout ? params->layout : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    if (from.once)
        ng_gpu_buffer_destroy(&from.buffer);
    return NG_OK;
}

static ng_result copy_image_back(struct ng_gpu_image *image, const VkImageSubresourceRange *part,
                                 VkImageLayout layout, struct ng_gpu_buffer *to)
{
    struct ng_gpu *gpu = image->live.gpu;
    struct ng_cmd *cmd;
    NG_TRY(ng_gpu_once_begin(gpu, &cmd));
    VkBufferImageCopy regions[32];
    uint32_t count = regions_of(image, part, 0, regions);
    image_barrier(cmd->handle, image, part, layout, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    vkCmdCopyImageToBuffer(cmd->handle, image->handle, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to->handle,
                           count, regions);
    image_barrier(cmd->handle, image, part, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, layout);
    return ng_gpu_once_end(gpu, &cmd);
}

ng_result ng_readback_image(struct ng_gpu_image *image, const struct ng_readback_image_params *params)
{
    struct ng_gpu *gpu = image->live.gpu;
    VkImageSubresourceRange part = {.baseMipLevel = params->mip,
                                    .levelCount = params->mips,
                                    .baseArrayLayer = params->layer,
                                    .layerCount = params->layers};
    NG_REQUIRE(params->layout != VK_IMAGE_LAYOUT_UNDEFINED, "a readback of image '%s' says its layout",
               image->live.name);
    NG_TRY(resolve(image, &part, params->size, params->out));
    struct ng_gpu_buffer *to;
    NG_TRY(readback_create(gpu, params->size, &to));
    ng_result r = copy_image_back(image, &part, params->layout, to);
    if (r == NG_OK)
        memcpy(params->out, to->mapped, params->size);
    ng_gpu_buffer_destroy(&to);
    return r;
}

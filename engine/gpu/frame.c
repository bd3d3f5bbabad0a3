// Recording and submission. A recorder owns what lives from one begin to the next: its command pool is reset
// as a whole, its descriptor pools too, its memory chunks are filled again from the start.
//
// Every submission ends with a barrier towards the host, so that waiting for its serial is all a reader
// needs.
#include "gpu/frame.h"

#include "gpu/gpu_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHUNK_SIZE      ((uint64_t)1 << 20)
#define CHUNK_ALIGNMENT 256 // the largest minimum alignment of uniform and storage offsets that Vulkan allows

// ---- Recorders -------------------------------------------------------------------------------------------

static ng_result recorder_init(struct ng_gpu *gpu, struct ng_gpu_recorder *r)
{
    VkCommandPoolCreateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                    .flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
                                    .queueFamilyIndex = gpu->queue_family};
    NG_TRY(ng_gpu_check(gpu, vkCreateCommandPool(gpu->device, &info, NULL, &r->commands), "create",
                        "command pool"));
    ng_gpu_set_name(gpu, VK_OBJECT_TYPE_COMMAND_POOL, (uint64_t)r->commands, "command pool");
    r->cmd = (struct ng_cmd){.gpu = gpu, .recorder = r};
    return NG_OK;
}

static void recorder_finish(struct ng_gpu *gpu, struct ng_gpu_recorder *r)
{
    for (size_t i = 0; i < r->descriptors.count; i++)
        vkDestroyDescriptorPool(gpu->device, r->descriptors.items[i], NULL);
    for (size_t i = 0; i < r->chunks.count; i++)
        ng_gpu_buffer_destroy(&r->chunks.items[i]);
    vkDestroyQueryPool(gpu->device, r->queries, NULL);
    vkDestroyCommandPool(gpu->device, r->commands, NULL);
    free(r->scopes);
    ng_array_finish(&r->buffers);
    ng_array_finish(&r->descriptors);
    ng_array_finish(&r->chunks);
}

// Opens the recorder's next command buffer.
static ng_result recorder_next(struct ng_gpu *gpu, struct ng_gpu_recorder *r)
{
    if (r->buffers_used == r->buffers.count) {
        VkCommandBuffer buffer = VK_NULL_HANDLE;
        VkCommandBufferAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                            .commandPool = r->commands,
                                            .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                            .commandBufferCount = 1};
        if (!ng_array_reserve(&r->buffers, r->buffers.count + 1)) {
            ng_log_error("gpu: out of host memory for a command buffer");
            return NG_ERROR_MEMORY;
        }
        NG_TRY(ng_gpu_check(gpu, NG_GPU_CREATE(gpu, vkAllocateCommandBuffers(gpu->device, &info, &buffer)),
                            "allocate", "command buffer"));
        r->buffers.items[r->buffers.count++] = buffer;
        ng_gpu_set_name(gpu, VK_OBJECT_TYPE_COMMAND_BUFFER, (uint64_t)(uintptr_t)buffer, "commands");
    }
    VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                      .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    VkCommandBuffer buffer = r->buffers.items[r->buffers_used];
    NG_TRY(
        ng_gpu_check(gpu, NG_GPU_CALL(gpu, vkBeginCommandBuffer(buffer, &begin)), "begin", "command buffer"));
    r->buffers_used++;
    r->cmd.handle = buffer;
    return NG_OK;
}

// Makes all of the recorder's things free again; its last submission must be done.
static ng_result recorder_reset(struct ng_gpu *gpu, struct ng_gpu_recorder *r)
{
    NG_TRY(ng_gpu_check(gpu, NG_GPU_CALL(gpu, vkResetCommandPool(gpu->device, r->commands, 0)), "reset",
                        "command pool"));
    for (size_t i = 0; i < r->descriptors.count && i <= r->descriptors_used; i++)
        vkResetDescriptorPool(gpu->device, r->descriptors.items[i], 0);
    r->buffers_used = r->descriptors_used = r->chunks_used = 0;
    r->chunk_offset = 0;
    return NG_OK;
}

ng_result ng_gpu_frames_init(struct ng_gpu *gpu)
{
    struct ng_gpu_internal *in = gpu->internal;
    VkSemaphoreTypeCreateInfo type = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO,
                                      .semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE};
    VkSemaphoreCreateInfo info = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, .pNext = &type};
    NG_TRY(
        ng_gpu_check(gpu, vkCreateSemaphore(gpu->device, &info, NULL, &in->timeline), "create", "timeline"));
    ng_gpu_set_name(gpu, VK_OBJECT_TYPE_SEMAPHORE, (uint64_t)in->timeline, "timeline");
    in->next_serial = 1;
    NG_TRY(recorder_init(gpu, &in->immediate));
    for (int i = 0; i < NG_GPU_FRAMES; i++) {
        NG_TRY(recorder_init(gpu, &in->frames[i]));
        NG_TRY(ng_gpu_timers_init(gpu, &in->frames[i]));
    }
    return NG_OK;
}

void ng_gpu_frames_finish(struct ng_gpu *gpu)
{
    struct ng_gpu_internal *in = gpu->internal;
    in->open = NULL;
    in->open_serial = 0;
    recorder_finish(gpu, &in->immediate);
    for (int i = 0; i < NG_GPU_FRAMES; i++)
        recorder_finish(gpu, &in->frames[i]);
    free(in->timings);
    vkDestroySemaphore(gpu->device, in->timeline, NULL);
}

// ---- Submission ------------------------------------------------------------------------------------------

static bool fault_loses_device(struct ng_gpu *gpu)
{
    uint32_t *n = &gpu->internal->faults.lose_device;
    return *n && --*n == 0;
}

static VkSemaphoreSubmitInfo semaphore_info(VkSemaphore semaphore, uint64_t value)
{
    return (VkSemaphoreSubmitInfo){.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                   .semaphore = semaphore,
                                   .value = value,
                                   .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT};
}

static ng_result end_commands(struct ng_gpu *gpu, VkCommandBuffer commands)
{
    VkMemoryBarrier2 to_host = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
                                .dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT,
                                .dstAccessMask = VK_ACCESS_2_HOST_READ_BIT};
    VkDependencyInfo dependency = {
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &to_host};
    vkCmdPipelineBarrier2(commands, &dependency);
    return ng_gpu_check(gpu, vkEndCommandBuffer(commands), "record", "commands");
}

ng_result ng_gpu_submit(struct ng_gpu *gpu, VkCommandBuffer commands, bool last_of_frame)
{
    struct ng_gpu_internal *in = gpu->internal;
    if (gpu->lost)
        return NG_ERROR_DEVICE;
    VkCommandBufferSubmitInfo buffers[2];
    uint32_t buffer_count = 0;
    VkCommandBuffer list[] = {ng_gpu_uploads_take(gpu, in->next_serial), commands};
    for (int i = 0; i < 2; i++) {
        if (!list[i])
            continue;
        NG_TRY(end_commands(gpu, list[i]));
        buffers[buffer_count++] = (VkCommandBufferSubmitInfo){
            .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO, .commandBuffer = list[i]};
    }
    bool present = last_of_frame && in->presentable;
    VkSemaphoreSubmitInfo wait = semaphore_info(in->acquired, 0);
    VkSemaphoreSubmitInfo signals[] = {semaphore_info(in->timeline, in->next_serial),
                                       semaphore_info(in->presentable, 0)};
    VkSubmitInfo2 submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
                            .waitSemaphoreInfoCount = in->acquired ? 1 : 0,
                            .pWaitSemaphoreInfos = &wait,
                            .commandBufferInfoCount = buffer_count,
                            .pCommandBufferInfos = buffers,
                            .signalSemaphoreInfoCount = present ? 2 : 1,
                            .pSignalSemaphoreInfos = signals};
    VkResult r = fault_loses_device(gpu) ? VK_ERROR_DEVICE_LOST
                                         : vkQueueSubmit2(gpu->queue, 1, &submit, VK_NULL_HANDLE);
    NG_TRY(ng_gpu_check(gpu, r, "submit to", "queue"));
    in->next_serial++;
    in->acquired = VK_NULL_HANDLE;
    if (present)
        in->presentable = VK_NULL_HANDLE;
    return NG_OK;
}

ng_result ng_gpu_wait(struct ng_gpu *gpu, uint64_t serial)
{
    struct ng_gpu_internal *in = gpu->internal;
    if (gpu->lost)
        return NG_ERROR_DEVICE;
    NG_REQUIRE(serial < in->next_serial, "serial %llu has been submitted", (unsigned long long)serial);
    if (serial > in->done_serial) {
        VkSemaphoreWaitInfo info = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO,
                                    .semaphoreCount = 1,
                                    .pSemaphores = &in->timeline,
                                    .pValues = &serial};
        NG_TRY(ng_gpu_check(gpu, vkWaitSemaphores(gpu->device, &info, UINT64_MAX), "wait for", "queue"));
    }
    ng_gpu_collect(gpu);
    return NG_OK;
}

ng_result ng_gpu_wait_idle(struct ng_gpu *gpu)
{
    struct ng_gpu_internal *in = gpu->internal;
    if (gpu->lost)
        return NG_ERROR_DEVICE;
    if (in->upload)
        NG_TRY(ng_gpu_submit(gpu, VK_NULL_HANDLE, false));
    NG_TRY(ng_gpu_wait(gpu, in->next_serial - 1));
    if (!in->open && in->frame_number)
        ng_gpu_timers_collect(gpu, &in->frames[(in->frame_number - 1) % NG_GPU_FRAMES]);
    return NG_OK;
}

uint64_t ng_gpu_serial(const struct ng_gpu *gpu)
{
    return gpu->internal->next_serial;
}

uint64_t ng_frame_number(const struct ng_gpu *gpu)
{
    return gpu->internal->frame_number;
}

// ---- Frames ----------------------------------------------------------------------------------------------

static ng_result open_recorder(struct ng_gpu *gpu, struct ng_gpu_recorder *r, struct ng_cmd **cmd)
{
    struct ng_gpu_internal *in = gpu->internal;
    NG_TRY(recorder_next(gpu, r));
    in->open = r;
    in->open_serial = in->next_serial;
    *cmd = &r->cmd;
    return NG_OK;
}

// Submits the open recording. What was destroyed meanwhile may be in it, so it waits for this submission.
static ng_result submit_open(struct ng_gpu *gpu, bool last)
{
    struct ng_gpu_internal *in = gpu->internal;
    struct ng_gpu_recorder *r = in->open;
    ng_result result = ng_gpu_submit(gpu, r->cmd.handle, last);
    if (result == NG_OK) {
        r->serial = in->next_serial - 1;
        ng_gpu_retired_stamp(gpu, in->open_serial, r->serial);
    }
    bool over = last || result != NG_OK;
    in->open_serial = over ? 0 : in->next_serial;
    in->open = over ? NULL : r;
    return result;
}

ng_result ng_frame_begin(struct ng_gpu *gpu, struct ng_cmd **cmd)
{
    struct ng_gpu_internal *in = gpu->internal;
    *cmd = NULL;
    NG_REQUIRE(!in->open, "one frame is recorded at a time");
    struct ng_gpu_recorder *r = &in->frames[in->frame_number % NG_GPU_FRAMES];
    NG_TRY(ng_gpu_wait(gpu, r->serial));
    ng_gpu_timers_collect(gpu, r);
    NG_TRY(recorder_reset(gpu, r));
    NG_TRY(open_recorder(gpu, r, cmd));
    r->frame = in->frame_number++;
    return NG_OK;
}

ng_result ng_frame_submit(struct ng_gpu *gpu, struct ng_cmd **cmd, uint64_t *serial)
{
    struct ng_gpu_internal *in = gpu->internal;
    NG_REQUIRE(in->open && *cmd == &in->open->cmd,
               "the frame's own commands are submitted, between begin and end");
    *cmd = NULL;
    NG_TRY(submit_open(gpu, false));
    if (serial)
        *serial = in->next_serial - 1;
    ng_result r = recorder_next(gpu, in->open);
    if (r == NG_OK)
        *cmd = &in->open->cmd;
    else
        in->open = NULL, in->open_serial = 0;
    return r;
}

ng_result ng_frame_end(struct ng_gpu *gpu, struct ng_cmd **cmd)
{
    struct ng_gpu_internal *in = gpu->internal;
    NG_REQUIRE(in->open && *cmd == &in->open->cmd, "the frame that was begun is ended");
    *cmd = NULL;
    return submit_open(gpu, true);
}

// ---- Commands outside a frame ----------------------------------------------------------------------------

// The immediate recorder is used within an open frame too (a readback): it leaves `open` alone then.
ng_result ng_gpu_once_begin(struct ng_gpu *gpu, struct ng_cmd **cmd)
{
    struct ng_gpu_recorder *r = &gpu->internal->immediate;
    *cmd = NULL;
    NG_REQUIRE(gpu->internal->open != r, "a readback is not within immediate commands");
    NG_TRY(ng_gpu_wait(gpu, r->serial));
    NG_TRY(recorder_reset(gpu, r));
    NG_TRY(recorder_next(gpu, r));
    *cmd = &r->cmd;
    return NG_OK;
}

ng_result ng_gpu_once_end(struct ng_gpu *gpu, struct ng_cmd **cmd)
{
    struct ng_gpu_recorder *r = (*cmd)->recorder;
    *cmd = NULL;
    NG_TRY(ng_gpu_submit(gpu, r->cmd.handle, false));
    r->serial = gpu->internal->next_serial - 1;
    return ng_gpu_wait(gpu, r->serial);
}

ng_result ng_immediate_begin(struct ng_gpu *gpu, struct ng_cmd **cmd)
{
    struct ng_gpu_internal *in = gpu->internal;
    *cmd = NULL;
    NG_REQUIRE(!in->open, "immediate commands are recorded outside a frame");
    NG_TRY(ng_gpu_wait(gpu, in->immediate.serial));
    NG_TRY(recorder_reset(gpu, &in->immediate));
    return open_recorder(gpu, &in->immediate, cmd);
}

ng_result ng_immediate_end(struct ng_gpu *gpu, struct ng_cmd **cmd)
{
    struct ng_gpu_internal *in = gpu->internal;
    NG_REQUIRE(in->open == &in->immediate && *cmd == &in->open->cmd,
               "the immediate commands begun are ended");
    *cmd = NULL;
    NG_TRY(submit_open(gpu, true));
    return ng_gpu_wait(gpu, in->immediate.serial);
}

// ---- Memory of the frame ---------------------------------------------------------------------------------

// Makes the next chunk, one of at least `size` bytes, the one in use.
static ng_result next_chunk(struct ng_gpu *gpu, struct ng_gpu_recorder *r, uint64_t size)
{
    if (r->chunks_used == r->chunks.count) {
        struct ng_gpu_buffer *chunk;
        struct ng_gpu_buffer_params params = {.name = "frame memory",
                                              .size = size > CHUNK_SIZE ? size : CHUNK_SIZE,
                                              .memory = NG_GPU_MEMORY_UPLOAD};
        NG_TRY(ng_gpu_buffer_create(gpu, &params, &chunk));
        if (!ng_array_push(&r->chunks, chunk)) {
            ng_log_error("gpu: out of host memory for the frame's memory");
            ng_gpu_buffer_destroy(&chunk);
            return NG_ERROR_MEMORY;
        }
    }
    r->chunks_used++;
    r->chunk_offset = 0;
    return NG_OK;
}

static bool chunk_has_room(const struct ng_gpu_recorder *r, uint64_t size)
{
    return r->chunks_used && size <= r->chunks.items[r->chunks_used - 1]->size - r->chunk_offset;
}

ng_result ng_frame_alloc(struct ng_gpu *gpu, uint64_t size, struct ng_frame_range *out)
{
    *out = (struct ng_frame_range){0};
    struct ng_gpu_recorder *r = gpu->internal->open;
    NG_REQUIRE(r, "memory of the frame is for a frame being recorded");
    NG_REQUIRE(size && size <= UINT64_MAX / 2, "memory of the frame has a size");
    uint64_t aligned = ng_gpu_align(size, CHUNK_ALIGNMENT);
    while (!chunk_has_room(r, aligned))
        NG_TRY(next_chunk(gpu, r, aligned));
    struct ng_gpu_buffer *chunk = r->chunks.items[r->chunks_used - 1];
    *out = (struct ng_frame_range){.mapped = (unsigned char *)chunk->mapped + r->chunk_offset,
                                   .buffer = chunk,
                                   .offset = r->chunk_offset,
                                   .size = size,
                                   .address = chunk->address + r->chunk_offset};
    r->chunk_offset += aligned;
    return NG_OK;
}

ng_result ng_frame_put(struct ng_gpu *gpu, const void *data, uint64_t size, struct ng_frame_range *out)
{
    NG_TRY(ng_frame_alloc(gpu, size, out));
    memcpy(out->mapped, data, (size_t)size);
    return NG_OK;
}

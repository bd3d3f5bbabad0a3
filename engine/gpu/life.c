// The life of objects. A ring links all that the caller owns, so that the device can name what was forgotten.
// What the caller destroys waits in a queue until the serial of its last possible use is done.
#include "gpu/gpu_internal.h"

#include <stdio.h>
#include <string.h>

void ng_gpu_live_add(struct ng_gpu *gpu, struct ng_gpu_live *live, enum ng_gpu_kind kind, const char *name)
{
    struct ng_gpu_live *head = &gpu->internal->live;
    live->gpu = gpu;
    live->kind = kind;
    snprintf(live->name, sizeof live->name, "%s", name);
    live->previous = head->previous;
    live->next = head;
    head->previous->next = live;
    head->previous = live;
    gpu->internal->live_count[kind]++;
    gpu->internal->made_count[kind]++;
}

void ng_gpu_live_remove(struct ng_gpu_live *live)
{
    live->previous->next = live->next;
    live->next->previous = live->previous;
    live->gpu->internal->live_count[live->kind]--;
}

static void destroy_now(struct ng_gpu *gpu, const struct ng_gpu_retired *r)
{
    VkDevice device = gpu->device;
    switch (r->type) {
    case VK_OBJECT_TYPE_BUFFER:
        vkDestroyBuffer(device, (VkBuffer)r->handle, NULL);
        break;
    case VK_OBJECT_TYPE_IMAGE:
        vkDestroyImage(device, (VkImage)r->handle, NULL);
        break;
    case VK_OBJECT_TYPE_IMAGE_VIEW:
        vkDestroyImageView(device, (VkImageView)r->handle, NULL);
        break;
    case VK_OBJECT_TYPE_PIPELINE:
        vkDestroyPipeline(device, (VkPipeline)r->handle, NULL);
        break;
    case VK_OBJECT_TYPE_PIPELINE_LAYOUT:
        vkDestroyPipelineLayout(device, (VkPipelineLayout)r->handle, NULL);
        break;
    case VK_OBJECT_TYPE_DESCRIPTOR_SET: {
        VkDescriptorSet set = (VkDescriptorSet)r->handle;
        vkFreeDescriptorSets(device, r->pool, 1, &set);
        break;
    }
    default:
        ng_gpu_memory_free_now(gpu, &r->memory);
        break;
    }
}

// Serial of the last submission that may use what exists now.
static uint64_t last_use(const struct ng_gpu_internal *in)
{
    return in->open_serial || in->upload ? in->next_serial : in->next_serial - 1;
}

static void retire(struct ng_gpu *gpu, struct ng_gpu_retired r)
{
    struct ng_gpu_internal *in = gpu->internal;
    r.serial = last_use(in);
    if (r.serial <= in->done_serial) {
        destroy_now(gpu, &r);
    } else if (!ng_array_push(&in->retired, r)) {
        // No memory to remember it by. Waiting for what was submitted is all that can be done at once; where
        // commands still to be submitted may use it, leaking it is the lesser harm.
        ng_log_error("gpu: out of host memory while destroying an object");
        if (vkDeviceWaitIdle(gpu->device) == VK_SUCCESS && r.serial < in->next_serial)
            destroy_now(gpu, &r);
    }
}

void ng_gpu_retire(struct ng_gpu *gpu, VkObjectType type, uint64_t handle)
{
    if (handle)
        retire(gpu, (struct ng_gpu_retired){.type = type, .handle = handle});
}

void ng_gpu_retire_memory(struct ng_gpu *gpu, const struct ng_gpu_memory *memory)
{
    if (memory->block)
        retire(gpu, (struct ng_gpu_retired){.type = VK_OBJECT_TYPE_DEVICE_MEMORY, .memory = *memory});
}

void ng_gpu_retire_set(struct ng_gpu *gpu, VkDescriptorSet set, VkDescriptorPool pool)
{
    retire(gpu, (struct ng_gpu_retired){
                    .type = VK_OBJECT_TYPE_DESCRIPTOR_SET, .handle = (uint64_t)set, .pool = pool});
}

// While a frame is open, an object retired since it opened may be in its commands, whatever serial was
// submitted between: it waits for ng_gpu_retired_stamp.
static bool is_done(const struct ng_gpu_internal *in, const struct ng_gpu_retired *r)
{
    return r->serial <= in->done_serial && !(in->open_serial && r->serial >= in->open_serial);
}

void ng_gpu_collect(struct ng_gpu *gpu)
{
    struct ng_gpu_internal *in = gpu->internal;
    uint64_t done;
    if (gpu->lost || ng_gpu_check(gpu, vkGetSemaphoreCounterValue(gpu->device, in->timeline, &done), "query",
                                  "timeline") != NG_OK)
        return;
    in->done_serial = done;
    while (in->retired_first < in->retired.count && is_done(in, &in->retired.items[in->retired_first]))
        destroy_now(gpu, &in->retired.items[in->retired_first++]);
    // Moving the rest down once half is gone keeps the queue as short as it ever needs to be.
    if (in->retired_first > in->retired.count / 2) {
        in->retired.count -= in->retired_first;
        memmove(in->retired.items, in->retired.items + in->retired_first,
                in->retired.count * sizeof *in->retired.items);
        in->retired_first = 0;
    }
}

void ng_gpu_retired_stamp(struct ng_gpu *gpu, uint64_t from, uint64_t serial)
{
    struct ng_gpu_internal *in = gpu->internal;
    for (size_t i = in->retired.count; i-- > in->retired_first && in->retired.items[i].serial >= from;)
        in->retired.items[i].serial = serial;
}

static void destroy_forgotten(struct ng_gpu_live *live)
{
    static const char *const kinds[NG_GPU_KIND_COUNT] = {"buffer", "image", "pipeline", "bind group",
                                                         "swapchain"};
    ng_log_error("gpu: the %s '%s' was not destroyed before the device", kinds[live->kind], live->name);
    // `live` is the first member of each of these.
    switch ((enum ng_gpu_kind)live->kind) {
    case NG_GPU_KIND_BUFFER:
        ng_gpu_buffer_destroy(&(struct ng_gpu_buffer *){(void *)live});
        break;
    case NG_GPU_KIND_IMAGE:
        ng_gpu_image_destroy(&(struct ng_gpu_image *){(void *)live});
        break;
    case NG_GPU_KIND_PIPELINE:
        ng_gpu_pipeline_destroy(&(struct ng_gpu_pipeline *){(void *)live});
        break;
    case NG_GPU_KIND_BIND_GROUP:
        ng_gpu_bind_group_destroy(&(struct ng_gpu_bind_group *){(void *)live});
        break;
    default:
        ng_swapchain_destroy(&(struct ng_swapchain *){(void *)live});
        break;
    }
}

void ng_gpu_live_finish(struct ng_gpu *gpu)
{
    struct ng_gpu_internal *in = gpu->internal;
    while (in->live.next != &in->live)
        destroy_forgotten(in->live.next);
    for (size_t i = in->retired_first; i < in->retired.count; i++)
        destroy_now(gpu, &in->retired.items[i]);
    ng_array_finish(&in->retired);
}

// A buffer is a Vulkan buffer, a range of memory (its own, or a place that the caller owns) and an address.
#include "gpu/buffer.h"

#include "gpu/gpu_internal.h"

#include <stdlib.h>

static VkBufferCreateInfo create_info(const struct ng_gpu_buffer_params *params)
{
    const VkBufferUsageFlags general = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                                       VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT |
                                       VK_BUFFER_USAGE_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_INDEX_BUFFER_BIT |
                                       VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |
                                       VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    return (VkBufferCreateInfo){
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
        .size = params->size,
        .usage = (params->usage ? params->usage : general) | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
    };
}

ng_result ng_gpu_buffer_requirements(struct ng_gpu *gpu, const struct ng_gpu_buffer_params *params,
                                     VkMemoryRequirements *out)
{
    *out = (VkMemoryRequirements){0};
    NG_REQUIRE(params->name && params->size, "a buffer has a name and a size");
    if (gpu->lost)
        return NG_ERROR_DEVICE;
    VkBufferCreateInfo info = create_info(params);
    VkDeviceBufferMemoryRequirements query = {.sType = VK_STRUCTURE_TYPE_DEVICE_BUFFER_MEMORY_REQUIREMENTS,
                                              .pCreateInfo = &info};
    VkMemoryRequirements2 result = {.sType = VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2};
    vkGetDeviceBufferMemoryRequirements(gpu->device, &query, &result);
    *out = result.memoryRequirements;
    return NG_OK;
}

static ng_result place_buffer(struct ng_gpu *gpu, const struct ng_gpu_buffer_params *params,
                              struct ng_gpu_buffer *buffer)
{
    struct ng_gpu_memory place = params->place ? *params->place : (struct ng_gpu_memory){0};
    uint64_t offset = params->place ? params->place_offset : 0;
    VkMemoryRequirements need;
    vkGetBufferMemoryRequirements(gpu->device, buffer->handle, &need);
    if (params->place) {
        NG_REQUIRE(offset % need.alignment == 0 && need.size <= place.size &&
                       offset <= place.size - need.size,
                   "the place of buffer '%s' fits it and is aligned to %llu", params->name,
                   (unsigned long long)need.alignment);
    } else {
        NG_TRY(ng_gpu_memory_allocate(gpu, &need, params->memory, "a list of the scene", &buffer->own));
        place = buffer->own;
    }
    if (place.mapped)
        buffer->mapped = (unsigned char *)place.mapped + offset;
    return ng_gpu_check(gpu,
                        NG_GPU_CREATE(gpu, vkBindBufferMemory(gpu->device, buffer->handle, place.memory,
                                                              place.offset + offset)),
                        "bind memory of buffer", params->name);
}

static ng_result make_buffer(struct ng_gpu *gpu, const struct ng_gpu_buffer_params *params,
                             struct ng_gpu_buffer *buffer)
{
    VkBufferCreateInfo info = create_info(params);
    NG_TRY(ng_gpu_check(gpu, NG_GPU_CREATE(gpu, vkCreateBuffer(gpu->device, &info, NULL, &buffer->handle)),
                        "create buffer", params->name));
    ng_gpu_set_name(gpu, VK_OBJECT_TYPE_BUFFER, (uint64_t)buffer->handle, params->name);
    NG_TRY(place_buffer(gpu, params, buffer));
    VkBufferDeviceAddressInfo address = {.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO,
                                         .buffer = buffer->handle};
    buffer->address = vkGetBufferDeviceAddress(gpu->device, &address);
    return NG_OK;
}

ng_result ng_gpu_buffer_create(struct ng_gpu *gpu, const struct ng_gpu_buffer_params *params,
                               struct ng_gpu_buffer **out)
{
    *out = NULL;
    NG_REQUIRE(params->name && params->size, "a buffer has a name and a size");
    if (gpu->lost)
        return NG_ERROR_DEVICE;
    struct ng_gpu_buffer *buffer = ng_gpu_host_alloc(gpu, sizeof *buffer, params->name);
    if (!buffer)
        return NG_ERROR_MEMORY;
    buffer->size = params->size;
    buffer->usage = create_info(params).usage;
    buffer->memory = params->memory;
    ng_gpu_live_add(gpu, &buffer->live, NG_GPU_KIND_BUFFER, params->name);
    ng_result r = make_buffer(gpu, params, buffer);
    if (r == NG_OK)
        *out = buffer;
    else
        ng_gpu_buffer_destroy(&buffer);
    return r;
}

void ng_gpu_buffer_destroy(struct ng_gpu_buffer **buffer)
{
    struct ng_gpu_buffer *b = *buffer;
    if (!b)
        return;
    *buffer = NULL;
    ng_gpu_retire(b->live.gpu, VK_OBJECT_TYPE_BUFFER, (uint64_t)b->handle);
    ng_gpu_memory_free(b->live.gpu, &b->own);
    ng_gpu_live_remove(&b->live);
    free(b);
}

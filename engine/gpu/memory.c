// Blocks of device memory, found by memory type. Ranges start and end at multiples of bufferImageGranularity,
// so that buffers and images may be neighbours. Every block allows device addresses.
#include "gpu/memory.h"

#include "gpu/gpu_internal.h"
#include "gpu/suballocator.h"

#include <stdlib.h>

#define MIB        (1 << 20)
#define BLOCK_SIZE ((uint64_t)64 * MIB)

struct ng_gpu_memory_block {
    VkDeviceMemory memory;
    uint64_t size;
    uint32_t type;
    bool dedicated; // serves a single range
    unsigned char *mapped;
    struct ng_suballocator ranges;
};

// The first allowed type with these properties, or UINT32_MAX.
static uint32_t find_type(const struct ng_gpu *gpu, uint32_t allowed, VkMemoryPropertyFlags properties)
{
    const VkPhysicalDeviceMemoryProperties *m = &gpu->internal->memory;
    for (uint32_t i = 0; i < m->memoryTypeCount; i++)
        if ((allowed >> i & 1) && (m->memoryTypes[i].propertyFlags & properties) == properties)
            return i;
    return UINT32_MAX;
}

static uint32_t choose_type(const struct ng_gpu *gpu, uint32_t allowed, enum ng_gpu_memory_kind kind)
{
    // From wish to need: Vulkan promises a coherent host-visible type to buffers, and some type to
    // everything.
    const VkMemoryPropertyFlags host =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    const VkMemoryPropertyFlags wish[] = {
        [NG_GPU_MEMORY_DEVICE] = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT,
        [NG_GPU_MEMORY_UPLOAD] = host,
        [NG_GPU_MEMORY_READBACK] = host | VK_MEMORY_PROPERTY_HOST_CACHED_BIT,
    };
    uint32_t type = find_type(gpu, allowed, wish[kind]);
    return type != UINT32_MAX ? type : find_type(gpu, allowed, kind == NG_GPU_MEMORY_DEVICE ? 0 : host);
}

static void block_destroy(struct ng_gpu *gpu, struct ng_gpu_memory_block *block)
{
    if (block->memory)
        gpu->internal->memory_reserved -= block->size;
    vkFreeMemory(gpu->device, block->memory, NULL); // unmaps
    ng_suballocator_finish(&block->ranges);
    free(block);
}

static ng_result block_allocate(struct ng_gpu *gpu, struct ng_gpu_memory_block *block, const char *name)
{
    struct ng_gpu_internal *in = gpu->internal;
    uint64_t left = in->memory_limit > in->memory_reserved ? in->memory_limit - in->memory_reserved : 0;
    // Linux promises more than it has, and ends the program when the promise is called in.
    if (block->size > left) {
        ng_log_error("gpu: %s needs %.1f MiB of memory, of which %.1f MiB are left; draw less, or smaller",
                     name, (double)block->size / MIB, (double)left / MIB);
        return NG_ERROR_MEMORY;
    }
    VkMemoryAllocateFlagsInfo flags = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
                                       .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT};
    VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                 .pNext = &flags,
                                 .allocationSize = block->size,
                                 .memoryTypeIndex = block->type};
    VkResult result = NG_GPU_CREATE(gpu, vkAllocateMemory(gpu->device, &info, NULL, &block->memory));
    if (result == VK_ERROR_OUT_OF_HOST_MEMORY || result == VK_ERROR_OUT_OF_DEVICE_MEMORY) {
        ng_log_error(
            "gpu: %s needs %.1f MiB of memory, which the device does not have; draw less, or smaller", name,
            (double)block->size / MIB);
        return NG_ERROR_MEMORY;
    }
    NG_TRY(ng_gpu_check(gpu, result, "allocate memory for", name));
    in->memory_reserved += block->size;
    if (in->memory_reserved > in->memory_peak)
        in->memory_peak = in->memory_reserved;
    if (!(in->memory.memoryTypes[block->type].propertyFlags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT))
        return NG_OK;
    void *mapped = NULL;
    NG_TRY(ng_gpu_check(
        gpu, NG_GPU_CREATE(gpu, vkMapMemory(gpu->device, block->memory, 0, VK_WHOLE_SIZE, 0, &mapped)),
        "map memory of", name));
    block->mapped = mapped;
    return NG_OK;
}

static ng_result block_create(struct ng_gpu *gpu, uint32_t type, uint64_t size, bool dedicated,
                              const char *name, struct ng_gpu_memory_block **out)
{
    struct ng_gpu_memory_block *block = ng_gpu_host_alloc(gpu, sizeof *block, name);
    if (!block)
        return NG_ERROR_MEMORY;
    *block = (struct ng_gpu_memory_block){.type = type, .size = size, .dedicated = dedicated};
    ng_result r = block_allocate(gpu, block, name);
    if (r == NG_OK &&
        !(ng_suballocator_init(&block->ranges, size) && ng_array_push(&gpu->internal->blocks, block))) {
        ng_log_error("gpu: out of host memory for '%s'", name);
        r = NG_ERROR_MEMORY;
    }
    if (r != NG_OK)
        block_destroy(gpu, block);
    else
        *out = block;
    return r;
}

// A range of a block of that type that has room, or null.
static struct ng_gpu_memory_block *take_range(struct ng_gpu *gpu, uint32_t type, uint64_t size,
                                              uint64_t alignment, uint64_t *offset)
{
    for (size_t i = 0; i < gpu->internal->blocks.count; i++) {
        struct ng_gpu_memory_block *block = gpu->internal->blocks.items[i];
        if (block->type != type || block->dedicated)
            continue;
        *offset = ng_suballocator_allocate(&block->ranges, size, alignment);
        if (*offset != NG_SUBALLOCATOR_FULL)
            return block;
    }
    return NULL;
}

ng_result ng_gpu_memory_allocate(struct ng_gpu *gpu, const VkMemoryRequirements *requirements,
                                 enum ng_gpu_memory_kind kind, const char *name, struct ng_gpu_memory *out)
{
    *out = (struct ng_gpu_memory){0};
    NG_REQUIRE(requirements->size && requirements->alignment, "memory for '%s' has a size and an alignment",
               name);
    struct ng_gpu_internal *in = gpu->internal;
    uint32_t type = choose_type(gpu, requirements->memoryTypeBits, kind);
    if (type == UINT32_MAX) {
        ng_log_error("gpu: no memory type of this device suits '%s'", name);
        return NG_ERROR_UNSUPPORTED;
    }
    uint64_t granularity = gpu->properties.limits.bufferImageGranularity;
    uint64_t alignment = requirements->alignment > granularity ? requirements->alignment : granularity;
    uint64_t size = ng_gpu_align(requirements->size, granularity), offset = 0;
    uint64_t heap = in->memory.memoryHeaps[in->memory.memoryTypes[type].heapIndex].size;
    uint64_t block_size = heap / 8 < BLOCK_SIZE ? heap / 8 : BLOCK_SIZE;
    bool dedicated = size > block_size / 2;
    struct ng_gpu_memory_block *block = dedicated ? NULL : take_range(gpu, type, size, alignment, &offset);
    if (!block) {
        NG_TRY(block_create(gpu, type, dedicated ? size : block_size, dedicated, name, &block));
        offset = ng_suballocator_allocate(&block->ranges, size, alignment);
        NG_REQUIRE_OR(offset != NG_SUBALLOCATOR_FULL, NG_ERROR_MEMORY, "a new block has room for '%s'", name);
    }
    in->memory_used += size;
    // Device-local memory may happen to be mapped; whoever asked for it must not come to rely on that.
    *out = (struct ng_gpu_memory){
        .memory = block->memory,
        .offset = offset,
        .size = size,
        .mapped = kind == NG_GPU_MEMORY_DEVICE ? NULL : block->mapped + offset,
        .block = block,
    };
    return NG_OK;
}

// One empty block of a type is kept, so that an object made and destroyed in turn does not allocate each
// time.
static bool is_spare(const struct ng_gpu *gpu, const struct ng_gpu_memory_block *block)
{
    if (block->dedicated)
        return false;
    for (size_t i = 0; i < gpu->internal->blocks.count; i++) {
        const struct ng_gpu_memory_block *other = gpu->internal->blocks.items[i];
        if (other != block && other->type == block->type && !other->dedicated && !other->ranges.live)
            return false;
    }
    return true;
}

void ng_gpu_memory_free_now(struct ng_gpu *gpu, const struct ng_gpu_memory *memory)
{
    struct ng_gpu_internal *in = gpu->internal;
    struct ng_gpu_memory_block *block = memory->block;
    if (!block)
        return;
    in->memory_used -= memory->size;
    ng_suballocator_free(&block->ranges, memory->offset, memory->size);
    if (block->ranges.live || is_spare(gpu, block))
        return;
    for (size_t i = 0; i < in->blocks.count; i++)
        if (in->blocks.items[i] == block) {
            ng_array_swap_remove(&in->blocks, i);
            break;
        }
    block_destroy(gpu, block);
}

void ng_gpu_memory_free(struct ng_gpu *gpu, struct ng_gpu_memory *memory)
{
    if (memory->block)
        ng_gpu_retire_memory(gpu, memory);
    *memory = (struct ng_gpu_memory){0};
}

void ng_gpu_memory_finish(struct ng_gpu *gpu)
{
    struct ng_gpu_internal *in = gpu->internal;
    if (in->memory_used)
        ng_log_error("gpu: %llu bytes of device memory were not freed before the device",
                     (unsigned long long)in->memory_used);
    for (size_t i = 0; i < in->blocks.count; i++)
        block_destroy(gpu, in->blocks.items[i]);
    ng_array_finish(&in->blocks);
}

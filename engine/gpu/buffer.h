// Buffers.
#ifndef NG_GPU_BUFFER_H
#define NG_GPU_BUFFER_H

#include "base/extern_c.h"
#include "gpu/memory.h"

NG_EXTERN_C_BEGIN

struct ng_gpu_buffer_params {
    const char *name; // needed; copied
    uint64_t size;    // bytes, at least 1
    // 0: storage, uniform, vertex, index, indirect and copies both ways. Shader device address is always
    // added.
    VkBufferUsageFlags usage;
    enum ng_gpu_memory_kind memory;
    // Where to place it: null for memory of its own. The range is borrowed and must outlive the buffer.
    const struct ng_gpu_memory *place;
    uint64_t place_offset; // within `place`, a multiple of the alignment that is required
};

// Read only for callers.
struct ng_gpu_buffer {
    struct ng_gpu_live live; // device and name
    VkBuffer handle;
    uint64_t size;
    VkBufferUsageFlags usage;
    enum ng_gpu_memory_kind memory;
    void *mapped; // `size` bytes; null for NG_GPU_MEMORY_DEVICE
    VkDeviceAddress address;
    struct ng_gpu_memory own; // zero if placed
};

NG_NODISCARD ng_result ng_gpu_buffer_create(struct ng_gpu *gpu, const struct ng_gpu_buffer_params *params,
                                            struct ng_gpu_buffer **out);
// The Vulkan object dies when the frame being recorded is done.
void ng_gpu_buffer_destroy(struct ng_gpu_buffer **buffer);

// What such a buffer will need of a place, without creating it. `place` is ignored.
NG_NODISCARD ng_result ng_gpu_buffer_requirements(struct ng_gpu *gpu,
                                                  const struct ng_gpu_buffer_params *params,
                                                  VkMemoryRequirements *out);

NG_EXTERN_C_END

#endif

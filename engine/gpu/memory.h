// Device memory: a few large blocks for each memory type, handed out in ranges.
//
// A block is 64 MiB (an eighth of the heap if that is less); a request of more than half a block gets a
// VkDeviceMemory of its own. Within a block a free list, sorted by offset, gives the first range that fits;
// neighbours that are free merge. Host-visible blocks stay mapped for their life. Buffers and images take
// their memory from here on their own; call these functions only to place several objects in one range
// (aliasing in the render graph).
#ifndef NG_GPU_MEMORY_H
#define NG_GPU_MEMORY_H

#include "base/extern_c.h"
#include "gpu/device.h"

NG_EXTERN_C_BEGIN

enum ng_gpu_memory_kind {
    NG_GPU_MEMORY_DEVICE = 0, // fast for the GPU; not mapped
    NG_GPU_MEMORY_UPLOAD,     // mapped, coherent: the CPU writes in order, the GPU reads
    NG_GPU_MEMORY_READBACK, // mapped, coherent, cached by the CPU where the device has such memory: both read
                            // and write
};

struct ng_gpu_memory_block;

// A range of device memory. Zero is none. Copy it freely, free it once.
struct ng_gpu_memory {
    VkDeviceMemory memory;
    uint64_t offset, size; // size: at least what was asked for
    void *mapped;          // the first byte of the range; null for NG_GPU_MEMORY_DEVICE
    struct ng_gpu_memory_block *block;
};

// `name` is for messages to a user: what it is, with its size, not what the program calls it.
// NG_ERROR_MEMORY, logged with what is needed and left, if the device has none left.
NG_NODISCARD ng_result ng_gpu_memory_allocate(struct ng_gpu *gpu, const VkMemoryRequirements *requirements,
                                              enum ng_gpu_memory_kind kind, const char *name,
                                              struct ng_gpu_memory *out);
// The range is free for others once the frame being recorded is done. Zeroes `*memory`; accepts zero.
void ng_gpu_memory_free(struct ng_gpu *gpu, struct ng_gpu_memory *memory);

NG_EXTERN_C_END

#endif

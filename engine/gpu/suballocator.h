// Ranges of a block: a free list sorted by offset, first fit, neighbours merge. Knows nothing of Vulkan.
#ifndef NG_GPU_SUBALLOCATOR_H
#define NG_GPU_SUBALLOCATOR_H

#include "base/array.h"
#include "base/extern_c.h"

#include <stdint.h>

NG_EXTERN_C_BEGIN

struct ng_gpu_range {
    uint64_t offset, size;
};

// Zero is a block of no bytes.
struct ng_suballocator {
    NG_ARRAY(struct ng_gpu_range) free;
    uint64_t size;
    uint32_t live; // ranges given out
};

#define NG_SUBALLOCATOR_FULL UINT64_MAX

// False when out of host memory.
bool ng_suballocator_init(struct ng_suballocator *s, uint64_t size);
void ng_suballocator_finish(struct ng_suballocator *s);
// The offset of `size` bytes (at least 1) at a multiple of `alignment` (at least 1), or NG_SUBALLOCATOR_FULL:
// no such range, or out of host memory.
uint64_t ng_suballocator_allocate(struct ng_suballocator *s, uint64_t size, uint64_t alignment);
// Gives back exactly what was allocated. Never fails: its memory was reserved by the allocation.
void ng_suballocator_free(struct ng_suballocator *s, uint64_t offset, uint64_t size);

NG_EXTERN_C_END

#endif

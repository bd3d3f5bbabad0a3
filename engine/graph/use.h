// The one table of the code base that knows barriers: a word for how a pass uses a resource, and what the
// word means to Vulkan (Vulkan 1.3 specification, "Synchronization and Cache Control", table of access
// types).
//
// Passes declare a word for each resource; the graph derives stages, accesses, image layout, the usage bits
// of the object, and the descriptor type. Nothing outside this folder writes a barrier.
#ifndef NG_GRAPH_USE_H
#define NG_GRAPH_USE_H

#include "base/extern_c.h"

#include <stdbool.h>
#include <vulkan/vulkan_core.h>

NG_EXTERN_C_BEGIN

enum ng_pass_kind {
    NG_PASS_RASTER,  // draws; rendering is begun and ended by the graph
    NG_PASS_COMPUTE, // dispatches
    NG_PASS_COPY,    // copies, blits, fills, updates
    NG_PASS_CPU,     // runs on host threads over host-visible memory; no command buffer
    NG_PASS_KIND_COUNT
};

// "Reads" and "writes" below say which of ng_pass_read and ng_pass_write takes the word.
enum ng_use {
    NG_USE_NONE,               // imports only: content undefined before, or any layout will do after
    NG_USE_COLOR,              // writes: colour attachment; the order of declaration is the location
    NG_USE_DEPTH,              // writes: depth attachment, tested and written
    NG_USE_DEPTH_READ,         // reads: depth attachment, tested only
    NG_USE_SAMPLED,            // reads: sampled image (vertex, fragment or compute shader)
    NG_USE_STORAGE_READ,       // reads: storage image or buffer
    NG_USE_STORAGE_WRITE,      // writes: storage image or buffer; what is not written keeps its content
    NG_USE_STORAGE_READ_WRITE, // writes, and reads what was there: atomics, updates in place
    NG_USE_UNIFORM,            // reads: uniform buffer
    NG_USE_VERTEX,             // reads: vertex buffer
    NG_USE_INDEX,              // reads: index buffer
    NG_USE_INDIRECT,           // reads: arguments of an indirect draw or dispatch
    NG_USE_COPY_SRC,           // reads: source of a copy or blit
    NG_USE_COPY_DST,           // writes: destination of a copy, blit, fill or update
    NG_USE_HOST_READ,          // reads: by a CPU pass
    NG_USE_HOST_WRITE,         // writes: by a CPU pass, every byte of it
    NG_USE_HOST_READ_WRITE,    // writes: by a CPU pass, and reads what was there
    NG_USE_PRESENT,            // imports only: shown on screen after the frame
    NG_USE_COUNT
};

struct ng_use_info {
    const char *name;                                 // "color", "storage read", ...
    VkPipelineStageFlags2 stages[NG_PASS_KIND_COUNT]; // by pass kind; 0: the kind cannot use the word
    VkAccessFlags2 access;
    VkImageLayout layout;
    VkImageUsageFlags image_usage;
    VkBufferUsageFlags buffer_usage;
    VkDescriptorType image_descriptor, buffer_descriptor; // VK_DESCRIPTOR_TYPE_MAX_ENUM: none
    bool reads, writes;
    bool needs_content; // reads what was there and writes: an error if there is nothing
    bool host;          // by the CPU
};

// Never null for words below NG_USE_COUNT. Thread-safe.
const struct ng_use_info *ng_use_info(enum ng_use use);
// What the word can be said of.
bool ng_use_of_images(enum ng_use use);
bool ng_use_of_buffers(enum ng_use use);
// All bits of `access` that write.
VkAccessFlags2 ng_use_write_access(VkAccessFlags2 access);

NG_EXTERN_C_END

#endif

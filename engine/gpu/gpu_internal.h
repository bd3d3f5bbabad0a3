// What the files of engine/gpu share: the device's own state, error reports, object life.
#ifndef NG_GPU_INTERNAL_H
#define NG_GPU_INTERNAL_H

#include "base/array.h"
#include "base/log.h"
#include "gpu/buffer.h"
#include "gpu/frame.h"
#include "gpu/image.h"
#include "gpu/pipeline.h"
#include "gpu/swapchain.h"
#include "gpu/timer.h"

#include <stdatomic.h>

enum ng_gpu_kind {
    NG_GPU_KIND_BUFFER,
    NG_GPU_KIND_IMAGE,
    NG_GPU_KIND_PIPELINE,
    NG_GPU_KIND_BIND_GROUP,
    NG_GPU_KIND_SWAPCHAIN,
    NG_GPU_KIND_COUNT
};

// A Vulkan object that waits for its last use. Which handle is meant follows from `type`.
struct ng_gpu_retired {
    uint64_t serial;
    VkObjectType type; // VK_OBJECT_TYPE_DEVICE_MEMORY: `memory` is freed
    uint64_t handle;
    VkDescriptorPool pool; // of a descriptor set
    struct ng_gpu_memory memory;
};

struct ng_gpu_scope {
    char name[64];
    bool ended;
};

// Command buffers, descriptors and memory that live from one begin to the next: one for each frame in flight,
// and one for immediate commands.
struct ng_gpu_recorder {
    VkCommandPool commands;
    NG_ARRAY(VkCommandBuffer) buffers;
    size_t buffers_used;
    NG_ARRAY(VkDescriptorPool) descriptors;
    size_t descriptors_used; // the pools before this one are full
    NG_ARRAY(struct ng_gpu_buffer *) chunks;
    size_t chunks_used;    // the chunk in use is the one before this index
    uint64_t chunk_offset; // in the chunk in use
    struct ng_cmd cmd;
    uint64_t serial; // of the last submission
    // Timestamps; null for immediate commands and devices without.
    VkQueryPool queries;
    struct ng_gpu_scope *scopes;
    uint32_t scope_count;
    uint64_t frame; // number of the frame recorded last
};

struct ng_gpu_set_layout {
    struct ng_gpu_slot slots[NG_GPU_MAX_SLOTS]; // with count and stages resolved
    uint32_t slot_count;
    bool push;
    VkDescriptorSetLayout handle;
};

// What a pipeline is made of: to make it again of other shaders.
struct ng_gpu_built {
    struct ng_gpu_pipeline pipeline;
    struct ng_spirv shaders[2];             // vertex and fragment, or compute; no words: none
    struct ng_gpu_graphics_params graphics; // its shaders are those above, its slots the pipeline's
    struct ng_gpu_vertex_binding vertex_bindings[16];
    struct ng_gpu_vertex_attribute vertex_attributes[16];
};

struct ng_gpu_sampler_entry {
    struct ng_gpu_sampler_params params;
    VkSampler handle;
};

// A staging buffer of the upload ring.
struct ng_gpu_staging {
    struct ng_gpu_buffer *buffer;
    uint64_t used, serial; // serial of the last submission that reads it
};

struct ng_gpu_upload_commands {
    VkCommandBuffer handle;
    uint64_t serial;
};

struct ng_gpu_internal {
    // Functions of extensions; null where missing.
    PFN_vkSetDebugUtilsObjectNameEXT set_name;
    PFN_vkCmdBeginDebugUtilsLabelEXT label_begin;
    PFN_vkCmdEndDebugUtilsLabelEXT label_end;
    PFN_vkCmdPushDescriptorSetKHR push_descriptors;
    VkDebugUtilsMessengerEXT messenger;
    atomic_uint validation_messages;
    bool cube_arrays, depth_clamp, swapchains;
    uint32_t max_push_descriptors, timestamp_bits;

    struct ng_gpu_faults faults;
    struct ng_gpu_live live; // head of the ring of all objects
    uint32_t live_count[NG_GPU_KIND_COUNT];
    uint64_t made_count[NG_GPU_KIND_COUNT];
    NG_ARRAY(struct ng_gpu_retired) retired; // serials ascend
    size_t retired_first;                    // those before are freed

    VkPhysicalDeviceMemoryProperties memory;
    NG_ARRAY(struct ng_gpu_memory_block *) blocks;
    uint64_t memory_reserved, memory_used, memory_peak;
    uint64_t memory_limit; // of memory_reserved: what the system had left, where that is the device's memory

    NG_ARRAY(struct ng_gpu_sampler_entry) samplers;
    NG_ARRAY(struct ng_gpu_set_layout) set_layouts;
    struct ng_gpu_shader **shaders; // those that were replaced
    uint32_t shader_count;
    NG_ARRAY(VkDescriptorPool) group_pools;
    VkPipelineCache pipeline_cache;

    VkSemaphore timeline;
    uint64_t next_serial, done_serial; // to be submitted next; known to be done
    uint64_t open_serial; // next_serial when the open recording began or was last submitted; 0: none
    uint64_t frame_number;
    struct ng_gpu_recorder frames[NG_GPU_FRAMES], immediate;
    struct ng_gpu_recorder *open; // the recorder between begin and end
    // Of a swapchain: the next submission waits, the frame's last one signals.
    VkSemaphore acquired, presentable;

    VkCommandPool upload_pool;
    NG_ARRAY(struct ng_gpu_upload_commands) upload_commands;
    VkCommandBuffer upload; // being recorded; null: none
    NG_ARRAY(struct ng_gpu_staging) staging;
    uint64_t staging_once; // bytes of single-use staging buffers since the last submission

    struct ng_gpu_timing *timings;
    uint32_t timing_count;
    uint64_t timings_frame;
};

// ---- device.c --------------------------------------------------------------------------------------------

// Turns a VkResult into an ng_result, and logs a failure: "gpu: cannot WHAT 'NAME': REASON". Marks the device
// lost. Silent once the device is lost.
ng_result ng_gpu_check(struct ng_gpu *gpu, VkResult result, const char *what, const char *name);
// True when the injected fault is due: the caller then behaves as if the driver had no memory.
bool ng_gpu_fault_allocation(struct ng_gpu *gpu);
// Zeroed memory from calloc; logs and counts as an allocation for fault injection.
void *ng_gpu_host_alloc(struct ng_gpu *gpu, size_t size, const char *name);
void ng_gpu_set_name(struct ng_gpu *gpu, VkObjectType type, uint64_t handle, const char *name);
const char *ng_gpu_vk_text(VkResult result);

// A call that reaches the driver only while there is a device.
#define NG_GPU_CALL(gpu, call) ((gpu)->lost ? VK_ERROR_DEVICE_LOST : (call))
// The same for what allocates, where tests inject failures.
#define NG_GPU_CREATE(gpu, call)                                                                             \
    NG_GPU_CALL(gpu, ng_gpu_fault_allocation(gpu) ? VK_ERROR_OUT_OF_DEVICE_MEMORY : (call))

// ---- life.c ----------------------------------------------------------------------------------------------

void ng_gpu_live_add(struct ng_gpu *gpu, struct ng_gpu_live *live, enum ng_gpu_kind kind, const char *name);
void ng_gpu_live_remove(struct ng_gpu_live *live);
// Frees the object when the commands being recorded are done; at once where nothing can still use it.
void ng_gpu_retire(struct ng_gpu *gpu, VkObjectType type, uint64_t handle);
void ng_gpu_retire_memory(struct ng_gpu *gpu, const struct ng_gpu_memory *memory);
void ng_gpu_retire_set(struct ng_gpu *gpu, VkDescriptorSet set, VkDescriptorPool pool);
// Frees what is done.
void ng_gpu_collect(struct ng_gpu *gpu);
// The submission with this serial was the open recording's: what it retired now waits for exactly this
// serial.
void ng_gpu_retired_stamp(struct ng_gpu *gpu, uint64_t from, uint64_t serial);
// Logs and destroys all objects left; the device is idle.
void ng_gpu_live_finish(struct ng_gpu *gpu);

// ---- the other files -------------------------------------------------------------------------------------

void ng_gpu_memory_free_now(struct ng_gpu *gpu, const struct ng_gpu_memory *memory);
void ng_gpu_memory_finish(struct ng_gpu *gpu);

// Destroys an image's views at once; for images that nothing uses.
void ng_gpu_image_drop_views(struct ng_gpu_image *image);
void ng_gpu_samplers_finish(struct ng_gpu *gpu);
void ng_gpu_pipelines_finish(struct ng_gpu *gpu);
// A pipeline of the shaders that hold now.
ng_result ng_gpu_pipeline_compile(struct ng_gpu *gpu, const struct ng_gpu_built *built, VkPipeline *out);
// What stands in the place of a shader, if anything does.
struct ng_spirv ng_gpu_shader_now(const struct ng_gpu *gpu, struct ng_spirv built_in);
void ng_gpu_shaders_finish(struct ng_gpu *gpu);

ng_result ng_gpu_frames_init(struct ng_gpu *gpu);
void ng_gpu_frames_finish(struct ng_gpu *gpu);
// Immediate commands, also while a frame is being recorded.
ng_result ng_gpu_once_begin(struct ng_gpu *gpu, struct ng_cmd **cmd);
ng_result ng_gpu_once_end(struct ng_gpu *gpu, struct ng_cmd **cmd);
// Submits the recorded uploads, and `commands` (may be null) after them.
ng_result ng_gpu_submit(struct ng_gpu *gpu, VkCommandBuffer commands, bool last_of_frame);

// Descriptor sets that die with the recorder's frame.
ng_result ng_gpu_recorder_set(struct ng_gpu *gpu, struct ng_gpu_recorder *r, VkDescriptorSetLayout layout,
                              VkDescriptorSet *out);
ng_result ng_gpu_descriptor_pool(struct ng_gpu *gpu, bool can_free, VkDescriptorPool *out);
// Fills one write for each binding. False (logged) where a binding is wrong or missing.
struct ng_gpu_writes {
    VkWriteDescriptorSet writes[NG_GPU_MAX_SLOTS];
    VkDescriptorBufferInfo buffers[NG_GPU_MAX_SLOTS];
    VkDescriptorImageInfo images[NG_GPU_MAX_SLOTS];
};
bool ng_gpu_fill_writes(const struct ng_gpu_pipeline *pipeline, uint32_t set,
                        const struct ng_gpu_binding *bindings, uint32_t count, struct ng_gpu_writes *out);

ng_result ng_gpu_timers_init(struct ng_gpu *gpu, struct ng_gpu_recorder *r);
// Publishes what the recorder's last frame measured and readies the recorder for the next one.
void ng_gpu_timers_collect(struct ng_gpu *gpu, struct ng_gpu_recorder *r);

// Ends the upload command buffer, if any is open, and gives it; null if none.
VkCommandBuffer ng_gpu_uploads_take(struct ng_gpu *gpu, uint64_t serial);
ng_result ng_gpu_uploads_init(struct ng_gpu *gpu);
void ng_gpu_uploads_finish(struct ng_gpu *gpu);

static inline VkDeviceSize ng_gpu_align(VkDeviceSize value, VkDeviceSize alignment)
{
    return (value + alignment - 1) / alignment * alignment;
}

#endif

// Pipelines and what they bind.
//
// A pipeline declares its bindings ("slots"). Set 0 is written while recording, by ng_cmd_bind: it changes
// with every pass or draw and costs no allocation (push descriptors where the driver has them, else a pool of
// the frame). Sets 1 to 3 hold bind groups, made once (a material's textures) and bound by a single cheap
// call. Buffers may also travel as 64-bit addresses in push constants (buffer_reference in GLSL).
//
// Shaders are GLSL in the folder that uses them, compiled at build by ng_shaders
// (tools/cmake/ng_shaders.cmake) into headers with a word array each, so nothing is read at run time:
//
//     #include "gbuffer.frag.spv.h"         // defines ng_spv_gbuffer_frag
//     .fragment = NG_SPIRV(ng_spv_gbuffer_frag)
//
// While a program runs, ng_gpu_replace_shaders puts other code in their place.
#ifndef NG_GPU_PIPELINE_H
#define NG_GPU_PIPELINE_H

#include "base/extern_c.h"
#include "gpu/buffer.h"
#include "gpu/image.h"

#include <stddef.h>

NG_EXTERN_C_BEGIN

#define NG_GPU_MAX_COLOR 8  // colour attachments
#define NG_GPU_MAX_SLOTS 32 // of one pipeline
#define NG_GPU_MAX_SETS  4
#define NG_GPU_MAX_PUSH  128 // bytes of push constants

struct ng_spirv {
    const uint32_t *words;
    size_t size;      // bytes
    const char *name; // of the file, under which it can be replaced; null: never
};
#define NG_SPIRV(array) ((struct ng_spirv){(array), sizeof(array), array##_name})

struct ng_gpu_slot {
    uint32_t set, binding; // of the GLSL layout()
    // COMBINED_IMAGE_SAMPLER, SAMPLED_IMAGE, SAMPLER, STORAGE_IMAGE, UNIFORM_BUFFER or STORAGE_BUFFER
    VkDescriptorType type;
    uint32_t count;            // array size; 0: 1
    VkShaderStageFlags stages; // 0: every stage of the pipeline
};

struct ng_gpu_vertex_attribute {
    uint32_t location, binding, offset;
    VkFormat format;
};
struct ng_gpu_vertex_binding {
    uint32_t stride;
    bool per_instance;
};

enum ng_gpu_blend {
    NG_GPU_BLEND_NONE,
    NG_GPU_BLEND_OVER, // source alpha over destination
    NG_GPU_BLEND_ADD,
};

struct ng_gpu_graphics_params {
    const char *name;                 // needed; copied
    struct ng_spirv vertex, fragment; // fragment: zero for depth only
    const struct ng_gpu_slot *slots;
    uint32_t slot_count;
    uint32_t push_size; // bytes of push constants, a multiple of 4

    // Vertex input; none where the shader pulls vertices from storage buffers. Bindings count up from 0.
    const struct ng_gpu_vertex_binding *vertex_bindings;
    const struct ng_gpu_vertex_attribute *vertex_attributes;
    uint32_t vertex_binding_count, vertex_attribute_count;
    VkPrimitiveTopology topology; // 0 is points in Vulkan; here 0 means triangle list, see `points`
    bool points;

    VkCullModeFlags cull; // 0: none
    bool clockwise;       // front faces are clockwise on screen; false: counter-clockwise
    bool dynamic_strides; // of the vertex bindings: set with them (vkCmdBindVertexBuffers2)
    bool dynamic_cull;    // cull mode and front face are set while recording (vkCmdSetCullMode, -FrontFace)
    bool depth_clamp;     // where the device has it

    // Attachments.
    VkFormat color_formats[NG_GPU_MAX_COLOR];
    uint32_t color_count;
    VkFormat depth_format; // 0: none
    bool depth_test, depth_write;
    VkCompareOp depth_compare; // of depth_test; 0 (never): greater or equal, as reverse-Z wants it
    float depth_bias_constant, depth_bias_slope; // both 0: no bias
    enum ng_gpu_blend blend;                     // of every attachment
};

struct ng_gpu_compute_params {
    const char *name; // needed; copied
    struct ng_spirv shader;
    const struct ng_gpu_slot *slots;
    uint32_t slot_count;
    uint32_t push_size;
};

// Read only for callers.
struct ng_gpu_pipeline {
    struct ng_gpu_live live; // device and name
    VkPipeline handle;
    VkPipelineLayout layout;
    VkPipelineBindPoint bind_point;
    VkShaderStageFlags push_stages;
    bool push_set; // set 0 is written by push descriptors
    uint32_t push_size;
    VkDescriptorSetLayout set_layouts[NG_GPU_MAX_SETS];
    uint32_t set_count;
    struct ng_gpu_slot slots[NG_GPU_MAX_SLOTS];
    uint32_t slot_count;
};

// Compiles; takes milliseconds to seconds, so not in the frame loop. `params` and what it points to are not
// kept, except for the words and names of shaders, which outlive the pipeline.
NG_NODISCARD ng_result ng_gpu_graphics_create(struct ng_gpu *gpu, const struct ng_gpu_graphics_params *params,
                                              struct ng_gpu_pipeline **out);
NG_NODISCARD ng_result ng_gpu_compute_create(struct ng_gpu *gpu, const struct ng_gpu_compute_params *params,
                                             struct ng_gpu_pipeline **out);
void ng_gpu_pipeline_destroy(struct ng_gpu_pipeline **pipeline);

// Puts these shaders in the place of those that have their names, in the pipelines there are and in those to
// come. Between frames: what was submitted ends with the code it began with. All or none: code that does not
// fit the slots of its pipelines, or that the driver refuses, is logged by name and changes nothing. Copies
// the words. Compiles, as creation does; gpu->shaders is another number from then on.
NG_NODISCARD ng_result ng_gpu_replace_shaders(struct ng_gpu *gpu, const struct ng_spirv *shaders,
                                              uint32_t count);

// ---- What goes into a slot -------------------------------------------------------------------------------

// Fill what the slot's type asks for; the rest is zero.
struct ng_gpu_binding {
    uint32_t binding, element; // of the slot; element: in an array slot
    const struct ng_gpu_buffer *buffer;
    uint64_t offset, range; // of the buffer in bytes; range 0: the rest
    VkImageView view;
    VkImageLayout layout; // 0: SHADER_READ_ONLY_OPTIMAL, for storage images GENERAL
    VkSampler sampler;
};

// An immutable descriptor set for sets 1 to 3. It fits every pipeline that declares that set with the same
// slots. The buffers and views in it must outlive it.
struct ng_gpu_bind_group {
    struct ng_gpu_live live;
    VkDescriptorSet handle;
    uint32_t set;
    VkDescriptorPool pool;
};

NG_NODISCARD ng_result ng_gpu_bind_group_create(struct ng_gpu *gpu, const char *name,
                                                const struct ng_gpu_pipeline *pipeline, uint32_t set,
                                                const struct ng_gpu_binding *bindings, uint32_t count,
                                                struct ng_gpu_bind_group **out);
void ng_gpu_bind_group_destroy(struct ng_gpu_bind_group **group);

NG_EXTERN_C_END

#endif

// Pipelines. Descriptor set layouts are cached by what they declare, so that two pipelines that declare a set
// alike share its layout and a bind group fits both.
#include "gpu/pipeline.h"

#include "gpu/gpu_internal.h"

#include <stdlib.h>
#include <string.h>

// ---- Layouts ---------------------------------------------------------------------------------------------

static bool same_slots(const struct ng_gpu_set_layout *layout, const struct ng_gpu_slot *slots,
                       uint32_t count, bool push)
{
    bool same = layout->slot_count == count && layout->push == push;
    for (uint32_t i = 0; same && i < count; i++) {
        const struct ng_gpu_slot *a = &layout->slots[i], *b = &slots[i];
        same =
            a->binding == b->binding && a->type == b->type && a->count == b->count && a->stages == b->stages;
    }
    return same;
}

static ng_result set_layout_create(struct ng_gpu *gpu, struct ng_gpu_set_layout *layout, const char *name)
{
    VkDescriptorSetLayoutBinding bindings[NG_GPU_MAX_SLOTS];
    for (uint32_t i = 0; i < layout->slot_count; i++)
        bindings[i] = (VkDescriptorSetLayoutBinding){.binding = layout->slots[i].binding,
                                                     .descriptorType = layout->slots[i].type,
                                                     .descriptorCount = layout->slots[i].count,
                                                     .stageFlags = layout->slots[i].stages};
    VkDescriptorSetLayoutCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
        .flags = layout->push ? VK_DESCRIPTOR_SET_LAYOUT_CREATE_PUSH_DESCRIPTOR_BIT_KHR : 0,
        .bindingCount = layout->slot_count,
        .pBindings = bindings};
    NG_TRY(ng_gpu_check(
        gpu, NG_GPU_CREATE(gpu, vkCreateDescriptorSetLayout(gpu->device, &info, NULL, &layout->handle)),
        "create the set layout of", name));
    ng_gpu_set_name(gpu, VK_OBJECT_TYPE_DESCRIPTOR_SET_LAYOUT, (uint64_t)layout->handle, name);
    return NG_OK;
}

// The layout of these slots, from the cache where it is there.
static ng_result set_layout_get(struct ng_gpu *gpu, const struct ng_gpu_slot *slots, uint32_t count,
                                bool push, const char *name, VkDescriptorSetLayout *out)
{
    struct ng_gpu_internal *in = gpu->internal;
    for (size_t i = 0; i < in->set_layouts.count; i++)
        if (same_slots(&in->set_layouts.items[i], slots, count, push)) {
            *out = in->set_layouts.items[i].handle;
            return NG_OK;
        }
    struct ng_gpu_set_layout layout = {.slot_count = count, .push = push};
    if (count)
        memcpy(layout.slots, slots, count * sizeof *slots);
    if (!ng_array_reserve(&in->set_layouts, in->set_layouts.count + 1)) {
        ng_log_error("gpu: out of host memory for pipeline '%s'", name);
        return NG_ERROR_MEMORY;
    }
    NG_TRY(set_layout_create(gpu, &layout, name));
    in->set_layouts.items[in->set_layouts.count++] = layout;
    *out = layout.handle;
    return NG_OK;
}

static bool known_type(VkDescriptorType type)
{
    return type == VK_DESCRIPTOR_TYPE_SAMPLER || type == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER ||
           type == VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE || type == VK_DESCRIPTOR_TYPE_STORAGE_IMAGE ||
           type == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER || type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
}

// Copies the slots into the pipeline, with defaults resolved, sorted by set and binding.
static ng_result take_slots(struct ng_gpu_pipeline *p, const struct ng_gpu_slot *slots, uint32_t count,
                            VkShaderStageFlags stages)
{
    NG_REQUIRE(count <= NG_GPU_MAX_SLOTS, "pipeline '%s' has at most %d slots", p->live.name,
               NG_GPU_MAX_SLOTS);
    for (uint32_t i = 0; i < count; i++) {
        struct ng_gpu_slot s = slots[i];
        NG_REQUIRE(s.set < NG_GPU_MAX_SETS, "sets of pipeline '%s' are below %d", p->live.name,
                   NG_GPU_MAX_SETS);
        NG_REQUIRE(known_type(s.type), "slot %u.%u of pipeline '%s' has one of the six descriptor types",
                   s.set, s.binding, p->live.name);
        s.count = s.count ? s.count : 1;
        s.stages = s.stages ? s.stages : stages;
        uint32_t at = i;
        for (; at && (p->slots[at - 1].set > s.set ||
                      (p->slots[at - 1].set == s.set && p->slots[at - 1].binding > s.binding));
             at--)
            p->slots[at] = p->slots[at - 1];
        NG_REQUIRE(!at || p->slots[at - 1].set != s.set || p->slots[at - 1].binding != s.binding,
                   "slot %u.%u of pipeline '%s' is declared once", s.set, s.binding, p->live.name);
        p->slots[at] = s;
    }
    p->slot_count = count;
    return NG_OK;
}

static ng_result layout_create(struct ng_gpu *gpu, struct ng_gpu_pipeline *p)
{
    NG_REQUIRE(p->push_size <= NG_GPU_MAX_PUSH && p->push_size % 4 == 0,
               "push constants of pipeline '%s' are at most %d bytes, a multiple of 4", p->live.name,
               NG_GPU_MAX_PUSH);
    uint32_t descriptors = 0, first = 0;
    for (uint32_t i = 0; i < p->slot_count; i++) {
        descriptors += p->slots[i].set == 0 ? p->slots[i].count : 0;
        p->set_count = p->slots[i].set + 1;
    }
    p->push_set = gpu->push_descriptors && descriptors && descriptors <= gpu->internal->max_push_descriptors;
    for (uint32_t set = 0; set < p->set_count; set++) {
        uint32_t end = first;
        while (end < p->slot_count && p->slots[end].set == set)
            end++;
        NG_TRY(set_layout_get(gpu, p->slots + first, end - first, set == 0 && p->push_set, p->live.name,
                              &p->set_layouts[set]));
        first = end;
    }
    VkPushConstantRange range = {p->push_stages, 0, p->push_size};
    VkPipelineLayoutCreateInfo info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                       .setLayoutCount = p->set_count,
                                       .pSetLayouts = p->set_layouts,
                                       .pushConstantRangeCount = p->push_size ? 1 : 0,
                                       .pPushConstantRanges = &range};
    NG_TRY(ng_gpu_check(gpu, NG_GPU_CREATE(gpu, vkCreatePipelineLayout(gpu->device, &info, NULL, &p->layout)),
                        "create the layout of pipeline", p->live.name));
    ng_gpu_set_name(gpu, VK_OBJECT_TYPE_PIPELINE_LAYOUT, (uint64_t)p->layout, p->live.name);
    return NG_OK;
}

// ---- Stages ----------------------------------------------------------------------------------------------

static ng_result module_create(struct ng_gpu *gpu, struct ng_spirv code, const char *name,
                               VkShaderModule *out)
{
    NG_REQUIRE(code.words && code.size >= 20 && code.size % 4 == 0 && code.words[0] == 0x07230203u,
               "the shaders of pipeline '%s' are SPIR-V", name);
    VkShaderModuleCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = code.size, .pCode = code.words};
    NG_TRY(ng_gpu_check(gpu, NG_GPU_CREATE(gpu, vkCreateShaderModule(gpu->device, &info, NULL, out)),
                        "create a shader of pipeline", name));
    ng_gpu_set_name(gpu, VK_OBJECT_TYPE_SHADER_MODULE, (uint64_t)*out, name);
    return NG_OK;
}

static VkPipelineShaderStageCreateInfo stage_info(VkShaderStageFlagBits stage, VkShaderModule module)
{
    return (VkPipelineShaderStageCreateInfo){.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                             .stage = stage,
                                             .module = module,
                                             .pName = "main"};
}

// ---- Creation --------------------------------------------------------------------------------------------

// An empty pipeline object, named and counted.
static struct ng_gpu_built *pipeline_new(struct ng_gpu *gpu, const char *name, VkPipelineBindPoint bind_point,
                                         VkShaderStageFlags stages, uint32_t push_size)
{
    struct ng_gpu_built *b = ng_gpu_host_alloc(gpu, sizeof *b, name);
    if (!b)
        return NULL;
    b->pipeline.bind_point = bind_point;
    b->pipeline.push_stages = stages;
    b->pipeline.push_size = push_size;
    ng_gpu_live_add(gpu, &b->pipeline.live, NG_GPU_KIND_PIPELINE, name);
    return b;
}

static ng_result compute_compile(struct ng_gpu *gpu, const struct ng_gpu_built *b,
                                 const VkPipelineShaderStageCreateInfo *stage, VkPipeline *out)
{
    VkComputePipelineCreateInfo info = {.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
                                        .stage = *stage,
                                        .layout = b->pipeline.layout};
    return ng_gpu_check(
        gpu,
        NG_GPU_CREATE(
            gpu, vkCreateComputePipelines(gpu->device, gpu->internal->pipeline_cache, 1, &info, NULL, out)),
        "create pipeline", b->pipeline.live.name);
}

// Everything of a graphics pipeline but its shaders.
struct graphics_state {
    VkVertexInputBindingDescription bindings[16];
    VkVertexInputAttributeDescription attributes[16];
    VkPipelineVertexInputStateCreateInfo input;
    VkPipelineInputAssemblyStateCreateInfo assembly;
    VkPipelineViewportStateCreateInfo viewport;
    VkPipelineRasterizationStateCreateInfo raster;
    VkPipelineMultisampleStateCreateInfo samples;
    VkPipelineDepthStencilStateCreateInfo depth;
    VkPipelineColorBlendAttachmentState blends[NG_GPU_MAX_COLOR];
    VkPipelineColorBlendStateCreateInfo blend;
    VkDynamicState dynamics[5];
    VkPipelineDynamicStateCreateInfo dynamic;
    VkPipelineRenderingCreateInfo rendering;
};

static void fill_vertex_input(const struct ng_gpu_graphics_params *p, struct graphics_state *s)
{
    for (uint32_t i = 0; i < p->vertex_binding_count; i++)
        s->bindings[i] = (VkVertexInputBindingDescription){
            i, p->vertex_bindings[i].stride,
            p->vertex_bindings[i].per_instance ? VK_VERTEX_INPUT_RATE_INSTANCE : VK_VERTEX_INPUT_RATE_VERTEX};
    for (uint32_t i = 0; i < p->vertex_attribute_count; i++) {
        const struct ng_gpu_vertex_attribute *a = &p->vertex_attributes[i];
        s->attributes[i] = (VkVertexInputAttributeDescription){a->location, a->binding, a->format, a->offset};
    }
    s->input = (VkPipelineVertexInputStateCreateInfo){
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
        .vertexBindingDescriptionCount = p->vertex_binding_count,
        .pVertexBindingDescriptions = s->bindings,
        .vertexAttributeDescriptionCount = p->vertex_attribute_count,
        .pVertexAttributeDescriptions = s->attributes};
    s->assembly = (VkPipelineInputAssemblyStateCreateInfo){
        .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
        .topology = p->topology || p->points ? p->topology : VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
}

static void fill_raster(const struct ng_gpu *gpu, const struct ng_gpu_graphics_params *p,
                        struct graphics_state *s)
{
    bool bias = p->depth_bias_constant != 0 || p->depth_bias_slope != 0;
    s->viewport =
        (VkPipelineViewportStateCreateInfo){.sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
                                            .viewportCount = 1,
                                            .scissorCount = 1};
    s->raster = (VkPipelineRasterizationStateCreateInfo){
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
        .depthClampEnable = p->depth_clamp && gpu->internal->depth_clamp,
        .polygonMode = VK_POLYGON_MODE_FILL,
        .cullMode = p->cull,
        .frontFace = p->clockwise ? VK_FRONT_FACE_CLOCKWISE : VK_FRONT_FACE_COUNTER_CLOCKWISE,
        .depthBiasEnable = bias,
        .depthBiasConstantFactor = p->depth_bias_constant,
        .depthBiasSlopeFactor = p->depth_bias_slope,
        .lineWidth = 1};
    s->samples = (VkPipelineMultisampleStateCreateInfo){
        .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
        .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
    uint32_t count = 0;
    s->dynamics[count++] = VK_DYNAMIC_STATE_VIEWPORT;
    s->dynamics[count++] = VK_DYNAMIC_STATE_SCISSOR;
    if (p->dynamic_cull) {
        s->dynamics[count++] = VK_DYNAMIC_STATE_CULL_MODE;
        s->dynamics[count++] = VK_DYNAMIC_STATE_FRONT_FACE;
    }
    if (p->dynamic_strides)
        s->dynamics[count++] = VK_DYNAMIC_STATE_VERTEX_INPUT_BINDING_STRIDE;
    s->dynamic =
        (VkPipelineDynamicStateCreateInfo){.sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
                                           .dynamicStateCount = count,
                                           .pDynamicStates = s->dynamics};
}

static void fill_output(const struct ng_gpu_graphics_params *p, struct graphics_state *s)
{
    s->depth = (VkPipelineDepthStencilStateCreateInfo){
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
        .depthTestEnable = p->depth_test || p->depth_write, // without the test Vulkan writes nothing
        .depthWriteEnable = p->depth_write,
        .depthCompareOp = !p->depth_test     ? VK_COMPARE_OP_ALWAYS
                          : p->depth_compare ? p->depth_compare
                                             : VK_COMPARE_OP_GREATER_OR_EQUAL};
    bool add = p->blend == NG_GPU_BLEND_ADD;
    for (uint32_t i = 0; i < p->color_count; i++)
        s->blends[i] = (VkPipelineColorBlendAttachmentState){
            .blendEnable = p->blend != NG_GPU_BLEND_NONE,
            .srcColorBlendFactor = add ? VK_BLEND_FACTOR_ONE : VK_BLEND_FACTOR_SRC_ALPHA,
            .dstColorBlendFactor = add ? VK_BLEND_FACTOR_ONE : VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA,
            .colorBlendOp = VK_BLEND_OP_ADD,
            .srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE,
            .dstAlphaBlendFactor = add ? VK_BLEND_FACTOR_ONE : VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA,
            .alphaBlendOp = VK_BLEND_OP_ADD,
            .colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT |
                              VK_COLOR_COMPONENT_A_BIT};
    s->blend = (VkPipelineColorBlendStateCreateInfo){
        .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
        .attachmentCount = p->color_count,
        .pAttachments = s->blends};
    s->rendering = (VkPipelineRenderingCreateInfo){.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
                                                   .colorAttachmentCount = p->color_count,
                                                   .pColorAttachmentFormats = p->color_formats,
                                                   .depthAttachmentFormat = p->depth_format};
}

static ng_result graphics_compile(struct ng_gpu *gpu, const struct ng_gpu_built *b,
                                  const VkPipelineShaderStageCreateInfo *stages, uint32_t stage_count,
                                  VkPipeline *out)
{
    struct graphics_state s;
    fill_vertex_input(&b->graphics, &s);
    fill_raster(gpu, &b->graphics, &s);
    fill_output(&b->graphics, &s);
    VkGraphicsPipelineCreateInfo info = {.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                         .pNext = &s.rendering,
                                         .stageCount = stage_count,
                                         .pStages = stages,
                                         .pVertexInputState = &s.input,
                                         .pInputAssemblyState = &s.assembly,
                                         .pViewportState = &s.viewport,
                                         .pRasterizationState = &s.raster,
                                         .pMultisampleState = &s.samples,
                                         .pDepthStencilState = &s.depth,
                                         .pColorBlendState = &s.blend,
                                         .pDynamicState = &s.dynamic,
                                         .layout = b->pipeline.layout};
    return ng_gpu_check(
        gpu,
        NG_GPU_CREATE(
            gpu, vkCreateGraphicsPipelines(gpu->device, gpu->internal->pipeline_cache, 1, &info, NULL, out)),
        "create pipeline", b->pipeline.live.name);
}

ng_result ng_gpu_pipeline_compile(struct ng_gpu *gpu, const struct ng_gpu_built *b, VkPipeline *out)
{
    bool compute = b->pipeline.bind_point == VK_PIPELINE_BIND_POINT_COMPUTE;
    const VkShaderStageFlagBits kinds[] = {compute ? VK_SHADER_STAGE_COMPUTE_BIT : VK_SHADER_STAGE_VERTEX_BIT,
                                           VK_SHADER_STAGE_FRAGMENT_BIT};
    VkPipelineShaderStageCreateInfo stages[2];
    VkShaderModule modules[2] = {VK_NULL_HANDLE, VK_NULL_HANDLE};
    ng_result r = NG_OK;
    uint32_t count = 0;
    for (; r == NG_OK && count < 2 && (count == 0 || b->shaders[count].words); count++) {
        r = module_create(gpu, ng_gpu_shader_now(gpu, b->shaders[count]), b->pipeline.live.name,
                          &modules[count]);
        stages[count] = stage_info(kinds[count], modules[count]);
    }
    if (r == NG_OK)
        r = compute ? compute_compile(gpu, b, stages, out) : graphics_compile(gpu, b, stages, count, out);
    for (uint32_t i = 0; i < 2; i++)
        vkDestroyShaderModule(gpu->device, modules[i], NULL);
    return r;
}

static void keep_graphics(struct ng_gpu_built *b, const struct ng_gpu_graphics_params *params)
{
    b->shaders[0] = params->vertex;
    b->shaders[1] = params->fragment;
    b->graphics = *params;
    if (params->vertex_binding_count)
        memcpy(b->vertex_bindings, params->vertex_bindings,
               params->vertex_binding_count * sizeof *b->vertex_bindings);
    if (params->vertex_attribute_count)
        memcpy(b->vertex_attributes, params->vertex_attributes,
               params->vertex_attribute_count * sizeof *b->vertex_attributes);
    b->graphics.vertex_bindings = b->vertex_bindings;
    b->graphics.vertex_attributes = b->vertex_attributes;
    b->graphics.name = NULL; // the caller's
    b->graphics.slots = NULL;
}

static ng_result build(struct ng_gpu *gpu, struct ng_gpu_built *b, const struct ng_gpu_slot *slots,
                       uint32_t slot_count)
{
    NG_TRY(take_slots(&b->pipeline, slots, slot_count, b->pipeline.push_stages));
    NG_TRY(layout_create(gpu, &b->pipeline));
    return ng_gpu_pipeline_compile(gpu, b, &b->pipeline.handle);
}

static ng_result pipeline_done(struct ng_gpu *gpu, ng_result r, struct ng_gpu_built *b,
                               struct ng_gpu_pipeline **out)
{
    struct ng_gpu_pipeline *p = &b->pipeline;
    if (r != NG_OK) {
        ng_gpu_pipeline_destroy(&p);
        return r;
    }
    ng_gpu_set_name(gpu, VK_OBJECT_TYPE_PIPELINE, (uint64_t)p->handle, p->live.name);
    *out = p;
    return NG_OK;
}

ng_result ng_gpu_compute_create(struct ng_gpu *gpu, const struct ng_gpu_compute_params *params,
                                struct ng_gpu_pipeline **out)
{
    *out = NULL;
    NG_REQUIRE(params->name, "a pipeline has a name");
    if (gpu->lost)
        return NG_ERROR_DEVICE;
    struct ng_gpu_built *b = pipeline_new(gpu, params->name, VK_PIPELINE_BIND_POINT_COMPUTE,
                                          VK_SHADER_STAGE_COMPUTE_BIT, params->push_size);
    if (!b)
        return NG_ERROR_MEMORY;
    b->shaders[0] = params->shader;
    return pipeline_done(gpu, build(gpu, b, params->slots, params->slot_count), b, out);
}

ng_result ng_gpu_graphics_create(struct ng_gpu *gpu, const struct ng_gpu_graphics_params *params,
                                 struct ng_gpu_pipeline **out)
{
    *out = NULL;
    NG_REQUIRE(params->name, "a pipeline has a name");
    NG_REQUIRE(params->color_count <= NG_GPU_MAX_COLOR, "pipeline '%s' has at most %d colour attachments",
               params->name, NG_GPU_MAX_COLOR);
    NG_REQUIRE(params->vertex_binding_count <= 16 && params->vertex_attribute_count <= 16,
               "pipeline '%s' has at most 16 vertex bindings and attributes", params->name);
    if (gpu->lost)
        return NG_ERROR_DEVICE;
    struct ng_gpu_built *b =
        pipeline_new(gpu, params->name, VK_PIPELINE_BIND_POINT_GRAPHICS,
                     VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, params->push_size);
    if (!b)
        return NG_ERROR_MEMORY;
    keep_graphics(b, params);
    return pipeline_done(gpu, build(gpu, b, params->slots, params->slot_count), b, out);
}

void ng_gpu_pipeline_destroy(struct ng_gpu_pipeline **pipeline)
{
    struct ng_gpu_pipeline *p = *pipeline;
    if (!p)
        return;
    *pipeline = NULL;
    ng_gpu_retire(p->live.gpu, VK_OBJECT_TYPE_PIPELINE, (uint64_t)p->handle);
    ng_gpu_retire(p->live.gpu, VK_OBJECT_TYPE_PIPELINE_LAYOUT, (uint64_t)p->layout);
    ng_gpu_live_remove(&p->live);
    free(p);
}

void ng_gpu_pipelines_finish(struct ng_gpu *gpu)
{
    struct ng_gpu_internal *in = gpu->internal;
    for (size_t i = 0; i < in->group_pools.count; i++)
        vkDestroyDescriptorPool(gpu->device, in->group_pools.items[i], NULL);
    for (size_t i = 0; i < in->set_layouts.count; i++)
        vkDestroyDescriptorSetLayout(gpu->device, in->set_layouts.items[i].handle, NULL);
    vkDestroyPipelineCache(gpu->device, in->pipeline_cache, NULL);
    ng_array_finish(&in->group_pools);
    ng_array_finish(&in->set_layouts);
}

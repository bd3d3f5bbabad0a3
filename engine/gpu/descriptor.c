// What goes into a slot: checked against the pipeline's declaration, written by push descriptors, into a set
// of the recorder's pools, or into a bind group's own set.
#include "gpu/gpu_internal.h"

#include <stdlib.h>

#define POOL_SETS 128

// ---- Writes ----------------------------------------------------------------------------------------------

static const struct ng_gpu_slot *find_slot(const struct ng_gpu_pipeline *p, uint32_t set, uint32_t binding)
{
    for (uint32_t i = 0; i < p->slot_count; i++)
        if (p->slots[i].set == set && p->slots[i].binding == binding)
            return &p->slots[i];
    return NULL;
}

static bool is_buffer(VkDescriptorType type)
{
    return type == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER || type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
}

// Does the binding bring what a slot of that type asks for?
static bool is_filled(const struct ng_gpu_binding *b, VkDescriptorType type)
{
    if (is_buffer(type))
        return b->buffer && b->offset < b->buffer->size && b->range <= b->buffer->size - b->offset;
    bool wants_view = type != VK_DESCRIPTOR_TYPE_SAMPLER;
    bool wants_sampler =
        type == VK_DESCRIPTOR_TYPE_SAMPLER || type == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    return (!wants_view || b->view) && (!wants_sampler || b->sampler);
}

static bool is_repeated(const struct ng_gpu_binding *bindings, uint32_t i)
{
    for (uint32_t j = 0; j < i; j++)
        if (bindings[j].binding == bindings[i].binding && bindings[j].element == bindings[i].element)
            return true;
    return false;
}

static uint32_t count_descriptors(const struct ng_gpu_pipeline *p, uint32_t set)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < p->slot_count; i++)
        count += p->slots[i].set == set ? p->slots[i].count : 0;
    return count;
}

bool ng_gpu_fill_writes(const struct ng_gpu_pipeline *p, uint32_t set, const struct ng_gpu_binding *bindings,
                        uint32_t count, struct ng_gpu_writes *out)
{
    const char *name = p->live.name;
    NG_REQUIRE_OR(count <= NG_GPU_MAX_SLOTS, false, "at most %d descriptors are bound to '%s' at once",
                  NG_GPU_MAX_SLOTS, name);
    NG_REQUIRE_OR(count == count_descriptors(p, set), false,
                  "each slot of set %u of pipeline '%s' is bound: it has %u, not %u", set, name,
                  count_descriptors(p, set), count);
    for (uint32_t i = 0; i < count; i++) {
        const struct ng_gpu_binding *b = &bindings[i];
        const struct ng_gpu_slot *slot = find_slot(p, set, b->binding);
        NG_REQUIRE_OR(slot && b->element < slot->count, false, "pipeline '%s' declares slot %u.%u[%u]", name,
                      set, b->binding, b->element);
        NG_REQUIRE_OR(!is_repeated(bindings, i), false, "slot %u.%u[%u] of pipeline '%s' is bound once", set,
                      b->binding, b->element, name);
        NG_REQUIRE_OR(is_filled(b, slot->type), false,
                      "slot %u.%u of pipeline '%s' gets what its type needs (VkDescriptorType %d)", set,
                      b->binding, name, (int)slot->type);
        VkImageLayout usual = slot->type == VK_DESCRIPTOR_TYPE_STORAGE_IMAGE
                                  ? VK_IMAGE_LAYOUT_GENERAL
                                  : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
        if (is_buffer(slot->type))
            out->buffers[i] =
                (VkDescriptorBufferInfo){b->buffer->handle, b->offset, b->range ? b->range : VK_WHOLE_SIZE};
        else
            out->images[i] = (VkDescriptorImageInfo){b->sampler, b->view, b->layout ? b->layout : usual};
        out->writes[i] = (VkWriteDescriptorSet){.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                                .dstBinding = b->binding,
                                                .dstArrayElement = b->element,
                                                .descriptorCount = 1,
                                                .descriptorType = slot->type,
                                                .pImageInfo = &out->images[i],
                                                .pBufferInfo = &out->buffers[i]};
    }
    return true;
}

// ---- Pools -----------------------------------------------------------------------------------------------

ng_result ng_gpu_descriptor_pool(struct ng_gpu *gpu, bool can_free, VkDescriptorPool *out)
{
    // A pool is full when any of these runs out; the proportions suit passes and materials alike.
    static const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, POOL_SETS * 8},
                                                 {VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, POOL_SETS * 4},
                                                 {VK_DESCRIPTOR_TYPE_SAMPLER, POOL_SETS * 2},
                                                 {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, POOL_SETS * 4},
                                                 {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, POOL_SETS * 4},
                                                 {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, POOL_SETS * 8}};
    VkDescriptorPoolCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                       .flags =
                                           can_free ? VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT : 0,
                                       .maxSets = POOL_SETS,
                                       .poolSizeCount = NG_COUNT(sizes),
                                       .pPoolSizes = sizes};
    NG_TRY(ng_gpu_check(gpu, NG_GPU_CREATE(gpu, vkCreateDescriptorPool(gpu->device, &info, NULL, out)),
                        "create", "descriptor pool"));
    ng_gpu_set_name(gpu, VK_OBJECT_TYPE_DESCRIPTOR_POOL, (uint64_t)*out, "descriptor pool");
    return NG_OK;
}

static VkResult allocate_set(struct ng_gpu *gpu, VkDescriptorPool pool, VkDescriptorSetLayout layout,
                             VkDescriptorSet *out)
{
    VkDescriptorSetAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                        .descriptorPool = pool,
                                        .descriptorSetCount = 1,
                                        .pSetLayouts = &layout};
    return NG_GPU_CALL(gpu, vkAllocateDescriptorSets(gpu->device, &info, out));
}

static bool is_full(VkResult r)
{
    return r == VK_ERROR_OUT_OF_POOL_MEMORY || r == VK_ERROR_FRAGMENTED_POOL;
}

ng_result ng_gpu_recorder_set(struct ng_gpu *gpu, struct ng_gpu_recorder *r, VkDescriptorSetLayout layout,
                              VkDescriptorSet *out)
{
    for (;; r->descriptors_used++) {
        bool fresh = r->descriptors_used == r->descriptors.count;
        if (fresh) {
            VkDescriptorPool pool = VK_NULL_HANDLE;
            NG_TRY(ng_gpu_descriptor_pool(gpu, false, &pool));
            if (!ng_array_push(&r->descriptors, pool)) {
                vkDestroyDescriptorPool(gpu->device, pool, NULL);
                ng_log_error("gpu: out of host memory for descriptors");
                return NG_ERROR_MEMORY;
            }
        }
        VkResult result = allocate_set(gpu, r->descriptors.items[r->descriptors_used], layout, out);
        if (!is_full(result) || fresh)
            return ng_gpu_check(gpu, result, "allocate", "descriptor set");
    }
}

// ---- Bind groups -----------------------------------------------------------------------------------------

static ng_result group_allocate(struct ng_gpu *gpu, struct ng_gpu_bind_group *group,
                                VkDescriptorSetLayout layout)
{
    struct ng_gpu_internal *in = gpu->internal;
    for (size_t i = 0; i < in->group_pools.count; i++) {
        group->pool = in->group_pools.items[i];
        VkResult r = allocate_set(gpu, group->pool, layout, &group->handle);
        if (!is_full(r))
            return ng_gpu_check(gpu, r, "allocate bind group", group->live.name);
    }
    VkDescriptorPool pool = VK_NULL_HANDLE;
    NG_TRY(ng_gpu_descriptor_pool(gpu, true, &pool));
    if (!ng_array_push(&in->group_pools, pool)) {
        vkDestroyDescriptorPool(gpu->device, pool, NULL);
        ng_log_error("gpu: out of host memory for bind group '%s'", group->live.name);
        return NG_ERROR_MEMORY;
    }
    group->pool = pool;
    return ng_gpu_check(gpu, allocate_set(gpu, pool, layout, &group->handle), "allocate bind group",
                        group->live.name);
}

ng_result ng_gpu_bind_group_create(struct ng_gpu *gpu, const char *name,
                                   const struct ng_gpu_pipeline *pipeline, uint32_t set,
                                   const struct ng_gpu_binding *bindings, uint32_t count,
                                   struct ng_gpu_bind_group **out)
{
    *out = NULL;
    NG_REQUIRE(set > 0 && set < pipeline->set_count,
               "bind group '%s' is for a set from 1 on that pipeline '%s' declares", name,
               pipeline->live.name);
    struct ng_gpu_writes writes;
    if (!ng_gpu_fill_writes(pipeline, set, bindings, count, &writes))
        return NG_ERROR_USAGE;
    if (gpu->lost)
        return NG_ERROR_DEVICE;
    struct ng_gpu_bind_group *group = ng_gpu_host_alloc(gpu, sizeof *group, name);
    if (!group)
        return NG_ERROR_MEMORY;
    group->set = set;
    ng_gpu_live_add(gpu, &group->live, NG_GPU_KIND_BIND_GROUP, name);
    ng_result r = group_allocate(gpu, group, pipeline->set_layouts[set]);
    if (r != NG_OK) {
        group->handle = VK_NULL_HANDLE;
        ng_gpu_bind_group_destroy(&group);
        return r;
    }
    ng_gpu_set_name(gpu, VK_OBJECT_TYPE_DESCRIPTOR_SET, (uint64_t)group->handle, name);
    for (uint32_t i = 0; i < count; i++)
        writes.writes[i].dstSet = group->handle;
    vkUpdateDescriptorSets(gpu->device, count, writes.writes, 0, NULL);
    *out = group;
    return NG_OK;
}

void ng_gpu_bind_group_destroy(struct ng_gpu_bind_group **group)
{
    struct ng_gpu_bind_group *g = *group;
    if (!g)
        return;
    *group = NULL;
    if (g->handle)
        ng_gpu_retire_set(g->live.gpu, g->handle, g->pool);
    ng_gpu_live_remove(&g->live);
    free(g);
}

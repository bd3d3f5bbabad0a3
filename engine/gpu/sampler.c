// Samplers are few and cheap to keep: a linear list, searched by description.
#include "gpu/gpu_internal.h"

static bool same_sampler(const struct ng_gpu_sampler_params *a, const struct ng_gpu_sampler_params *b)
{
    return a->mag_filter == b->mag_filter && a->min_filter == b->min_filter && a->no_mips == b->no_mips &&
           a->mip_filter == b->mip_filter && a->address_u == b->address_u && a->address_v == b->address_v &&
           a->address_w == b->address_w && a->compare == b->compare && a->compare_op == b->compare_op &&
           a->anisotropy == b->anisotropy && a->border == b->border;
}

static VkSampler sampler_create(struct ng_gpu *gpu, const struct ng_gpu_sampler_params *p)
{
    float anisotropy = p->anisotropy < gpu->max_anisotropy ? p->anisotropy : gpu->max_anisotropy;
    VkSamplerCreateInfo info = {.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                .magFilter = p->mag_filter,
                                .minFilter = p->min_filter,
                                .mipmapMode = p->mip_filter,
                                .addressModeU = p->address_u,
                                .addressModeV = p->address_v,
                                .addressModeW = p->address_w,
                                .anisotropyEnable = anisotropy > 1,
                                .maxAnisotropy = anisotropy > 1 ? anisotropy : 1,
                                .compareEnable = p->compare,
                                .compareOp = p->compare_op,
                                .maxLod = p->no_mips ? 0.25f : VK_LOD_CLAMP_NONE,
                                .borderColor = p->border};
    VkSampler sampler = VK_NULL_HANDLE;
    if (ng_gpu_check(gpu, NG_GPU_CREATE(gpu, vkCreateSampler(gpu->device, &info, NULL, &sampler)), "create",
                     "sampler") != NG_OK)
        return VK_NULL_HANDLE;
    ng_gpu_set_name(gpu, VK_OBJECT_TYPE_SAMPLER, (uint64_t)sampler, "sampler");
    return sampler;
}

VkSampler ng_gpu_sampler(struct ng_gpu *gpu, const struct ng_gpu_sampler_params *params)
{
    struct ng_gpu_internal *in = gpu->internal;
    for (size_t i = 0; i < in->samplers.count; i++)
        if (same_sampler(&in->samplers.items[i].params, params))
            return in->samplers.items[i].handle;
    VkSampler sampler = sampler_create(gpu, params);
    if (sampler && !ng_array_push(&in->samplers, (struct ng_gpu_sampler_entry){*params, sampler})) {
        ng_log_error("gpu: out of host memory for a sampler");
        vkDestroySampler(gpu->device, sampler, NULL);
        return VK_NULL_HANDLE;
    }
    return sampler;
}

void ng_gpu_samplers_finish(struct ng_gpu *gpu)
{
    struct ng_gpu_internal *in = gpu->internal;
    for (size_t i = 0; i < in->samplers.count; i++)
        vkDestroySampler(gpu->device, in->samplers.items[i].handle, NULL);
    ng_array_finish(&in->samplers);
}

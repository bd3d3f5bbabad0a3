// An image is a Vulkan image, its memory, the view of all of it, and a short list of views of its parts.
#include "gpu/image.h"

#include "gpu/gpu_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct ng_gpu_view_entry {
    struct ng_gpu_view_params params; // with every default resolved
    VkImageView handle;
};

static uint32_t or_one(uint32_t n)
{
    return n ? n : 1;
}

static VkImageCreateInfo create_info(const struct ng_gpu_image_params *params)
{
    const VkImageUsageFlags general =
        VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    return (VkImageCreateInfo){
        .sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
        .flags = params->cube ? VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT : 0,
        .imageType = params->depth > 1 ? VK_IMAGE_TYPE_3D : VK_IMAGE_TYPE_2D,
        .format = params->format,
        .extent = {params->width, params->height, or_one(params->depth)},
        .mipLevels = or_one(params->mips),
        .arrayLayers = or_one(params->layers),
        .samples = VK_SAMPLE_COUNT_1_BIT,
        .tiling = VK_IMAGE_TILING_OPTIMAL,
        .usage = params->usage ? params->usage : general,
    };
}

// Rules of the interface, and what this device can do.
static ng_result check_params(struct ng_gpu *gpu, const struct ng_gpu_image_params *params)
{
    NG_REQUIRE(params->name && params->format, "an image has a name and a format");
    NG_REQUIRE(params->width && params->height, "image '%s' has a width and a height", params->name);
    NG_REQUIRE(!params->cube || (or_one(params->layers) % 6 == 0 && params->width == params->height),
               "cube image '%s' is square and has 6 layers a cube", params->name);
    if (gpu->lost)
        return NG_ERROR_DEVICE;
    VkImageCreateInfo info = create_info(params);
    VkImageFormatProperties can;
    VkResult r = vkGetPhysicalDeviceImageFormatProperties(gpu->physical, info.format, info.imageType,
                                                          info.tiling, info.usage, info.flags, &can);
    if (r == VK_ERROR_FORMAT_NOT_SUPPORTED) {
        ng_log_error("gpu: image '%s': this device does not support VkFormat %d with usage 0x%x",
                     params->name, (int)info.format, info.usage);
        return NG_ERROR_UNSUPPORTED;
    }
    NG_TRY(ng_gpu_check(gpu, r, "query the format of image", params->name));
    if (info.extent.width > can.maxExtent.width || info.extent.height > can.maxExtent.height ||
        info.extent.depth > can.maxExtent.depth || info.arrayLayers > can.maxArrayLayers) {
        ng_log_error(
            "gpu: image '%s' of %ux%ux%u, %u layers is larger than this device allows (%ux%ux%u, %u)",
            params->name, info.extent.width, info.extent.height, info.extent.depth, info.arrayLayers,
            can.maxExtent.width, can.maxExtent.height, can.maxExtent.depth, can.maxArrayLayers);
        return NG_ERROR_UNSUPPORTED;
    }
    NG_REQUIRE(info.mipLevels <= can.maxMipLevels, "image '%s' has at most %u mip levels", params->name,
               can.maxMipLevels);
    return NG_OK;
}

ng_result ng_gpu_image_requirements(struct ng_gpu *gpu, const struct ng_gpu_image_params *params,
                                    VkMemoryRequirements *out)
{
    *out = (VkMemoryRequirements){0};
    NG_TRY(check_params(gpu, params));
    VkImageCreateInfo info = create_info(params);
    VkDeviceImageMemoryRequirements query = {.sType = VK_STRUCTURE_TYPE_DEVICE_IMAGE_MEMORY_REQUIREMENTS,
                                             .pCreateInfo = &info};
    VkMemoryRequirements2 result = {.sType = VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2};
    vkGetDeviceImageMemoryRequirements(gpu->device, &query, &result);
    *out = result.memoryRequirements;
    return NG_OK;
}

static ng_result place_image(struct ng_gpu *gpu, const struct ng_gpu_image_params *params,
                             struct ng_gpu_image *image)
{
    struct ng_gpu_memory place = params->place ? *params->place : (struct ng_gpu_memory){0};
    uint64_t offset = params->place ? params->place_offset : 0;
    VkMemoryRequirements need;
    vkGetImageMemoryRequirements(gpu->device, image->handle, &need);
    if (params->place) {
        NG_REQUIRE(offset % need.alignment == 0 && need.size <= place.size &&
                       offset <= place.size - need.size,
                   "the place of image '%s' fits it and is aligned to %llu", params->name,
                   (unsigned long long)need.alignment);
    } else {
        char what[64];
        snprintf(what, sizeof what, "a picture of %u x %u pixels", params->width, params->height);
        NG_TRY(ng_gpu_memory_allocate(gpu, &need, NG_GPU_MEMORY_DEVICE, what, &image->own));
        place = image->own;
    }
    return ng_gpu_check(gpu,
                        NG_GPU_CREATE(gpu, vkBindImageMemory(gpu->device, image->handle, place.memory,
                                                             place.offset + offset)),
                        "bind memory of image", params->name);
}

static bool has_views(const struct ng_gpu_image *image)
{
    return image->usage & (VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT |
                           VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
}

static ng_result make_image(struct ng_gpu *gpu, const struct ng_gpu_image_params *params,
                            struct ng_gpu_image *image)
{
    VkImageCreateInfo info = create_info(params);
    NG_TRY(ng_gpu_check(gpu, NG_GPU_CREATE(gpu, vkCreateImage(gpu->device, &info, NULL, &image->handle)),
                        "create image", params->name));
    ng_gpu_set_name(gpu, VK_OBJECT_TYPE_IMAGE, (uint64_t)image->handle, params->name);
    NG_TRY(place_image(gpu, params, image));
    if (!has_views(image))
        return NG_OK;
    image->view = ng_gpu_image_view(image, &(struct ng_gpu_view_params){0});
    return image->view ? NG_OK : gpu->lost ? NG_ERROR_DEVICE : NG_ERROR_MEMORY;
}

ng_result ng_gpu_image_create(struct ng_gpu *gpu, const struct ng_gpu_image_params *params,
                              struct ng_gpu_image **out)
{
    *out = NULL;
    NG_TRY(check_params(gpu, params));
    struct ng_gpu_image *image = ng_gpu_host_alloc(gpu, sizeof *image, params->name);
    if (!image)
        return NG_ERROR_MEMORY;
    VkImageCreateInfo info = create_info(params);
    image->width = info.extent.width;
    image->height = info.extent.height;
    image->depth = info.extent.depth;
    image->layers = info.arrayLayers;
    image->mips = info.mipLevels;
    image->format = info.format;
    image->usage = info.usage;
    image->aspect = ng_gpu_format_aspect(info.format);
    image->cube = params->cube;
    ng_gpu_live_add(gpu, &image->live, NG_GPU_KIND_IMAGE, params->name);
    ng_result r = make_image(gpu, params, image);
    if (r == NG_OK)
        *out = image;
    else
        ng_gpu_image_destroy(&image);
    return r;
}

void ng_gpu_image_destroy(struct ng_gpu_image **image)
{
    struct ng_gpu_image *i = *image;
    if (!i)
        return;
    *image = NULL;
    for (uint32_t v = 0; v < i->view_count; v++)
        ng_gpu_retire(i->live.gpu, VK_OBJECT_TYPE_IMAGE_VIEW, (uint64_t)i->views[v].handle);
    if (!i->imported)
        ng_gpu_retire(i->live.gpu, VK_OBJECT_TYPE_IMAGE, (uint64_t)i->handle);
    ng_gpu_memory_free(i->live.gpu, &i->own);
    ng_gpu_live_remove(&i->live);
    free(i->views);
    free(i);
}

void ng_gpu_image_drop_views(struct ng_gpu_image *image)
{
    for (uint32_t v = 0; v < image->view_count; v++)
        vkDestroyImageView(image->live.gpu->device, image->views[v].handle, NULL);
    image->view_count = 0;
    image->view = VK_NULL_HANDLE;
}

// ---- Views -----------------------------------------------------------------------------------------------

static VkImageViewType view_type(const struct ng_gpu_image *image, uint32_t layers)
{
    if (image->depth > 1)
        return VK_IMAGE_VIEW_TYPE_3D;
    if (image->cube && layers == 6)
        return VK_IMAGE_VIEW_TYPE_CUBE;
    if (image->cube && layers % 6 == 0 && image->live.gpu->internal->cube_arrays)
        return VK_IMAGE_VIEW_TYPE_CUBE_ARRAY;
    return layers > 1 ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D;
}

static struct ng_gpu_view_params resolve(const struct ng_gpu_image *image,
                                         const struct ng_gpu_view_params *params)
{
    struct ng_gpu_view_params p = *params;
    p.mips = p.mips ? p.mips : image->mips - p.mip;
    p.layers = p.layers ? p.layers : image->layers - p.layer;
    p.type = p.type ? p.type : view_type(image, p.layers);
    if (!p.aspect)
        p.aspect = image->aspect & VK_IMAGE_ASPECT_DEPTH_BIT ? VK_IMAGE_ASPECT_DEPTH_BIT : image->aspect;
    return p;
}

static bool same_view(const struct ng_gpu_view_params *a, const struct ng_gpu_view_params *b)
{
    return a->type == b->type && a->mip == b->mip && a->mips == b->mips && a->layer == b->layer &&
           a->layers == b->layers && a->aspect == b->aspect;
}

static VkImageView view_create(struct ng_gpu_image *image, const struct ng_gpu_view_params *p)
{
    struct ng_gpu *gpu = image->live.gpu;
    if (image->view_count == image->view_capacity) {
        uint32_t capacity = image->view_capacity ? image->view_capacity * 2 : 2;
        struct ng_gpu_view_entry *views = ng_gpu_host_alloc(gpu, capacity * sizeof *views, image->live.name);
        if (!views)
            return VK_NULL_HANDLE;
        if (image->view_count)
            memcpy(views, image->views, image->view_count * sizeof *views);
        free(image->views);
        image->views = views;
        image->view_capacity = capacity;
    }
    VkImageViewCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                  .image = image->handle,
                                  .viewType = p->type,
                                  .format = image->format,
                                  .subresourceRange = {p->aspect, p->mip, p->mips, p->layer, p->layers}};
    VkImageView view = VK_NULL_HANDLE;
    if (ng_gpu_check(gpu, NG_GPU_CREATE(gpu, vkCreateImageView(gpu->device, &info, NULL, &view)),
                     "create a view of image", image->live.name) != NG_OK)
        return VK_NULL_HANDLE;
    ng_gpu_set_name(gpu, VK_OBJECT_TYPE_IMAGE_VIEW, (uint64_t)view, image->live.name);
    image->views[image->view_count++] = (struct ng_gpu_view_entry){*p, view};
    return view;
}

VkImageView ng_gpu_image_view(struct ng_gpu_image *image, const struct ng_gpu_view_params *params)
{
    if (!params)
        return image->view;
    NG_REQUIRE_OR(params->mip < image->mips && params->mips <= image->mips - params->mip, VK_NULL_HANDLE,
                  "a view of image '%s' is of its %u mip levels", image->live.name, image->mips);
    NG_REQUIRE_OR(params->layer < image->layers && params->layers <= image->layers - params->layer,
                  VK_NULL_HANDLE, "a view of image '%s' is of its %u layers", image->live.name,
                  image->layers);
    struct ng_gpu_view_params p = resolve(image, params);
    for (uint32_t i = 0; i < image->view_count; i++)
        if (same_view(&image->views[i].params, &p))
            return image->views[i].handle;
    return view_create(image, &p);
}

// Images, their views, and samplers.
//
// A new image is in VK_IMAGE_LAYOUT_UNDEFINED. Layouts are the affair of whoever records commands (the render
// graph); this layer keeps no state of an image.
#ifndef NG_GPU_IMAGE_H
#define NG_GPU_IMAGE_H

#include "base/extern_c.h"
#include "gpu/memory.h"

NG_EXTERN_C_BEGIN

struct ng_gpu_image_params {
    const char *name;        // needed; copied
    uint32_t width, height;  // texels, at least 1
    uint32_t depth;          // 0 and 1: a 2D image; more: 3D
    uint32_t layers;         // 0: 1
    uint32_t mips;           // 0: 1
    VkFormat format;         // needed
    VkImageUsageFlags usage; // 0: sampled and copies both ways
    bool cube; // `layers` is a multiple of 6 and `width` equals `height`; cube views are allowed
    // Where to place it: null for memory of its own. The range is borrowed and must outlive the image.
    const struct ng_gpu_memory *place;
    uint64_t place_offset; // within `place`, a multiple of the alignment that is required
};

struct ng_gpu_view_entry;

// Read only for callers.
struct ng_gpu_image {
    struct ng_gpu_live live; // device and name
    VkImage handle;
    VkImageView
        view; // all of it, for sampling (2D, array, cube, 3D by the shape); null where usage has no view
    uint32_t width, height, depth, layers, mips;
    VkFormat format;
    VkImageUsageFlags usage;
    VkImageAspectFlags aspect; // colour, or depth (and stencil) by the format
    bool cube;
    bool imported;            // handle belongs to another (a swapchain)
    struct ng_gpu_memory own; // zero if placed or imported
    struct ng_gpu_view_entry *views;
    uint32_t view_count, view_capacity;
};

NG_NODISCARD ng_result ng_gpu_image_create(struct ng_gpu *gpu, const struct ng_gpu_image_params *params,
                                           struct ng_gpu_image **out);
// The Vulkan objects (image and views) die when the frame being recorded is done.
void ng_gpu_image_destroy(struct ng_gpu_image **image);

// What such an image will need of a place, without creating it. `place` is ignored.
NG_NODISCARD ng_result ng_gpu_image_requirements(struct ng_gpu *gpu, const struct ng_gpu_image_params *params,
                                                 VkMemoryRequirements *out);

struct ng_gpu_view_params {
    VkImageViewType type;      // 2D is 1 in Vulkan; 0 (1D) means: by the image and the number of layers
    uint32_t mip, mips;        // first level and how many; mips 0: the rest
    uint32_t layer, layers;    // first layer (cube face: layer = 6 * cube + face) and how many; 0: the rest
    VkImageAspectFlags aspect; // 0: the image's (depth only where it has depth and stencil)
};

// A view of a part, made on first use and kept until the image dies. Borrowed. VK_NULL_HANDLE on failure
// (logged). Null `params`: image->view.
VkImageView ng_gpu_image_view(struct ng_gpu_image *image, const struct ng_gpu_view_params *params);

// Extent of a mip level, at least 1.
static inline uint32_t ng_gpu_mip_extent(uint32_t extent, uint32_t mip)
{
    return mip < 32 && extent >> mip ? extent >> mip : 1;
}

// Bytes of a texel; 0 for formats that this layer does not copy (compressed, combined depth and stencil).
uint32_t ng_gpu_format_size(VkFormat format);
VkImageAspectFlags ng_gpu_format_aspect(VkFormat format);
static inline bool ng_gpu_format_is_depth(VkFormat format)
{
    return (ng_gpu_format_aspect(format) & VK_IMAGE_ASPECT_DEPTH_BIT) != 0;
}

// ---- Samplers --------------------------------------------------------------------------------------------

struct ng_gpu_sampler_params {
    VkFilter mag_filter, min_filter;                      // 0: nearest; of magnified textures, and of others
    VkSamplerMipmapMode mip_filter;                       // 0: nearest
    VkSamplerAddressMode address_u, address_v, address_w; // 0: repeat
    bool no_mips;                                         // level 0 alone
    bool compare;                                         // a shadow sampler (sampler2DShadow)
    VkCompareOp compare_op;
    float anisotropy;     // 0 or 1: none; clamped to what the device has
    VkBorderColor border; // for VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_BORDER
};

// The sampler of this description: made on first use, kept until the device is destroyed. Borrowed.
// VK_NULL_HANDLE on failure (logged).
VkSampler ng_gpu_sampler(struct ng_gpu *gpu, const struct ng_gpu_sampler_params *params);

NG_EXTERN_C_END

#endif

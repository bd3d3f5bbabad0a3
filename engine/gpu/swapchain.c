// The swapchain is made lazily at acquire, whenever the size changed or the surface says so. Making it anew
// waits for the device to be idle: it happens while a window is being resized, and is simple to get right.
//
// Semaphores: one for acquiring for each frame in flight (its frame has waited for it before it comes round
// again), one for presenting for each image (the image is acquired again only after its presentation took the
// semaphore).
#include "gpu/swapchain.h"

#include "gpu/gpu_internal.h"

#include <stdlib.h>

#define MAX_IMAGES 8

struct ng_swapchain_internal {
    VkSurfaceKHR surface;
    VkSwapchainKHR handle;
    VkSurfaceFormatKHR surface_format;
    uint32_t wanted_width, wanted_height;
    bool stale; // to be made again
    struct ng_gpu_image *images[MAX_IMAGES];
    VkSemaphore presentable[MAX_IMAGES], acquired[NG_GPU_FRAMES];
    uint32_t image_count, acquired_index;
    bool has_image; // acquired and not presented
};

// ---- Choices ---------------------------------------------------------------------------------------------

static ng_result choose_format(struct ng_gpu *gpu, struct ng_swapchain *s)
{
    VkSurfaceFormatKHR formats[64];
    uint32_t count = NG_COUNT(formats);
    NG_TRY(ng_gpu_check(
        gpu, vkGetPhysicalDeviceSurfaceFormatsKHR(gpu->physical, s->internal->surface, &count, formats),
        "query the formats of", s->live.name));
    static const VkFormat wishes[] = {VK_FORMAT_B8G8R8A8_UNORM, VK_FORMAT_R8G8B8A8_UNORM,
                                      VK_FORMAT_B8G8R8A8_SRGB, VK_FORMAT_R8G8B8A8_SRGB};
    for (size_t w = 0; w < NG_COUNT(wishes); w++)
        for (uint32_t i = 0; i < count; i++)
            if (formats[i].format == wishes[w] &&
                formats[i].colorSpace == VK_COLOR_SPACE_SRGB_NONLINEAR_KHR) {
                s->internal->surface_format = formats[i];
                s->format = wishes[w];
                s->srgb = w >= 2;
                return NG_OK;
            }
    ng_log_error("gpu: %s offers no 8-bit RGBA format", s->live.name);
    return NG_ERROR_UNSUPPORTED;
}

static ng_result choose_present_mode(struct ng_gpu *gpu, struct ng_swapchain *s, bool no_vsync)
{
    VkPresentModeKHR modes[16];
    uint32_t count = NG_COUNT(modes);
    NG_TRY(ng_gpu_check(
        gpu, vkGetPhysicalDeviceSurfacePresentModesKHR(gpu->physical, s->internal->surface, &count, modes),
        "query the present modes of", s->live.name));
    s->present_mode = VK_PRESENT_MODE_FIFO_KHR; // always there
    for (uint32_t i = 0; no_vsync && i < count; i++)
        if (modes[i] == VK_PRESENT_MODE_MAILBOX_KHR ||
            (modes[i] == VK_PRESENT_MODE_IMMEDIATE_KHR && s->present_mode == VK_PRESENT_MODE_FIFO_KHR))
            s->present_mode = modes[i];
    return NG_OK;
}

static uint32_t clamp(uint32_t value, uint32_t low, uint32_t high)
{
    return value < low ? low : value > high ? high : value;
}

// ---- Making the images -----------------------------------------------------------------------------------

static ng_result semaphore_create(struct ng_swapchain *s, VkSemaphore *out)
{
    struct ng_gpu *gpu = s->live.gpu;
    VkSemaphoreCreateInfo info = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    NG_TRY(ng_gpu_check(gpu, NG_GPU_CREATE(gpu, vkCreateSemaphore(gpu->device, &info, NULL, out)),
                        "create a semaphore of", s->live.name));
    ng_gpu_set_name(gpu, VK_OBJECT_TYPE_SEMAPHORE, (uint64_t)*out, s->live.name);
    return NG_OK;
}

// The device is idle, and an open frame has not acquired an image yet: nothing can be using them.
static void drop_images(struct ng_swapchain *s)
{
    struct ng_gpu *gpu = s->live.gpu;
    struct ng_swapchain_internal *in = s->internal;
    for (uint32_t i = 0; i < in->image_count; i++) {
        ng_gpu_image_drop_views(in->images[i]); // before their swapchain goes
        ng_gpu_image_destroy(&in->images[i]);
        vkDestroySemaphore(gpu->device, in->presentable[i], NULL);
        in->presentable[i] = VK_NULL_HANDLE;
    }
    in->image_count = 0;
    in->has_image = false;
}

// Wraps one of the swapchain's images as an image that the rest of the engine knows.
static ng_result import_image(struct ng_swapchain *s, VkImage handle, struct ng_gpu_image **out)
{
    struct ng_gpu *gpu = s->live.gpu;
    struct ng_gpu_image *image = ng_gpu_host_alloc(gpu, sizeof *image, s->live.name);
    if (!image)
        return NG_ERROR_MEMORY;
    *image =
        (struct ng_gpu_image){.handle = handle,
                              .width = s->width,
                              .height = s->height,
                              .depth = 1,
                              .layers = 1,
                              .mips = 1,
                              .format = s->format,
                              .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                              .aspect = VK_IMAGE_ASPECT_COLOR_BIT,
                              .imported = true};
    ng_gpu_live_add(gpu, &image->live, NG_GPU_KIND_IMAGE, s->live.name);
    ng_gpu_set_name(gpu, VK_OBJECT_TYPE_IMAGE, (uint64_t)handle, s->live.name);
    *out = image;
    image->view = ng_gpu_image_view(image, &(struct ng_gpu_view_params){0});
    return image->view ? NG_OK : NG_ERROR_MEMORY;
}

static ng_result import_images(struct ng_swapchain *s)
{
    struct ng_gpu *gpu = s->live.gpu;
    struct ng_swapchain_internal *in = s->internal;
    VkImage handles[MAX_IMAGES];
    uint32_t count = 0;
    NG_TRY(ng_gpu_check(gpu, vkGetSwapchainImagesKHR(gpu->device, in->handle, &count, NULL),
                        "list the images of", s->live.name));
    if (count > MAX_IMAGES) {
        ng_log_error("gpu: %s has %u images; at most %d are supported", s->live.name, count, MAX_IMAGES);
        return NG_ERROR_UNSUPPORTED;
    }
    NG_TRY(ng_gpu_check(gpu, vkGetSwapchainImagesKHR(gpu->device, in->handle, &count, handles),
                        "list the images of", s->live.name));
    for (; in->image_count < count; in->image_count++) {
        uint32_t i = in->image_count;
        ng_result r = import_image(s, handles[i], &in->images[i]);
        if (r == NG_OK)
            r = semaphore_create(s, &in->presentable[i]);
        if (r != NG_OK) {
            ng_gpu_image_destroy(&in->images[i]);
            return r;
        }
    }
    return NG_OK;
}

// Makes the swapchain for the surface's present size. Leaves it without images while that is 0 x 0.
static ng_result rebuild(struct ng_swapchain *s)
{
    struct ng_gpu *gpu = s->live.gpu;
    struct ng_swapchain_internal *in = s->internal;
    VkSurfaceCapabilitiesKHR can;
    NG_TRY(ng_gpu_check(gpu, NG_GPU_CALL(gpu, vkQueueWaitIdle(gpu->queue)), "wait for", s->live.name));
    NG_TRY(ng_gpu_check(gpu, vkGetPhysicalDeviceSurfaceCapabilitiesKHR(gpu->physical, in->surface, &can),
                        "query the surface of", s->live.name));
    bool fixed = can.currentExtent.width != UINT32_MAX;
    s->width = fixed ? can.currentExtent.width
                     : clamp(in->wanted_width, can.minImageExtent.width, can.maxImageExtent.width);
    s->height = fixed ? can.currentExtent.height
                      : clamp(in->wanted_height, can.minImageExtent.height, can.maxImageExtent.height);
    drop_images(s);
    if (!s->width || !s->height || !in->wanted_width || !in->wanted_height)
        return NG_OK;
    uint32_t images = can.minImageCount + 1;
    bool opaque = can.supportedCompositeAlpha & VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR;
    VkSwapchainKHR old = in->handle;
    VkSwapchainCreateInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR,
        .surface = in->surface,
        .minImageCount = can.maxImageCount && images > can.maxImageCount ? can.maxImageCount : images,
        .imageFormat = in->surface_format.format,
        .imageColorSpace = in->surface_format.colorSpace,
        .imageExtent = {s->width, s->height},
        .imageArrayLayers = 1,
        .imageUsage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
        .preTransform = can.currentTransform,
        .compositeAlpha = opaque ? VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR : VK_COMPOSITE_ALPHA_INHERIT_BIT_KHR,
        .presentMode = s->present_mode,
        .clipped = VK_TRUE,
        .oldSwapchain = old};
    in->handle = VK_NULL_HANDLE;
    VkResult r = NG_GPU_CREATE(gpu, vkCreateSwapchainKHR(gpu->device, &info, NULL, &in->handle));
    vkDestroySwapchainKHR(gpu->device, old, NULL);
    NG_TRY(ng_gpu_check(gpu, r, "create the swapchain of", s->live.name));
    ng_gpu_set_name(gpu, VK_OBJECT_TYPE_SWAPCHAIN_KHR, (uint64_t)in->handle, s->live.name);
    NG_TRY(import_images(s));
    in->stale = false;
    return NG_OK;
}

// ---- The interface ---------------------------------------------------------------------------------------

static ng_result setup(struct ng_swapchain *s, const struct ng_swapchain_params *params)
{
    struct ng_gpu *gpu = s->live.gpu;
    struct ng_swapchain_internal *in = s->internal;
    *in = (struct ng_swapchain_internal){.surface = params->surface,
                                         .wanted_width = params->width,
                                         .wanted_height = params->height,
                                         .stale = true};
    VkBool32 can_present = VK_FALSE;
    NG_TRY(ng_gpu_check(
        gpu,
        vkGetPhysicalDeviceSurfaceSupportKHR(gpu->physical, gpu->queue_family, in->surface, &can_present),
        "query the surface of", s->live.name));
    if (!can_present) {
        ng_log_error("gpu: the device %s cannot show pictures in %s; choose another with --device",
                     gpu->properties.deviceName, s->live.name);
        return NG_ERROR_UNSUPPORTED;
    }
    NG_TRY(choose_format(gpu, s));
    NG_TRY(choose_present_mode(gpu, s, params->no_vsync));
    for (int i = 0; i < NG_GPU_FRAMES; i++)
        NG_TRY(semaphore_create(s, &in->acquired[i]));
    return rebuild(s);
}

ng_result ng_swapchain_create(struct ng_gpu *gpu, const struct ng_swapchain_params *params,
                              struct ng_swapchain **out)
{
    *out = NULL;
    NG_REQUIRE(params->surface && gpu->internal->swapchains,
               "a swapchain has a surface, and its device was made with instance extensions");
    if (gpu->lost)
        return NG_ERROR_DEVICE;
    const char *name = params->name ? params->name : "window";
    struct ng_swapchain *s = ng_gpu_host_alloc(gpu, sizeof *s, name);
    struct ng_swapchain_internal *in = s ? ng_gpu_host_alloc(gpu, sizeof *in, name) : NULL;
    if (!in) {
        free(s);
        return NG_ERROR_MEMORY;
    }
    s->internal = in;
    ng_gpu_live_add(gpu, &s->live, NG_GPU_KIND_SWAPCHAIN, name);
    ng_result r = setup(s, params);
    if (r == NG_OK)
        *out = s;
    else
        ng_swapchain_destroy(&s);
    return r;
}

void ng_swapchain_destroy(struct ng_swapchain **swapchain)
{
    struct ng_swapchain *s = *swapchain;
    if (!s)
        return;
    *swapchain = NULL;
    struct ng_gpu *gpu = s->live.gpu;
    vkQueueWaitIdle(gpu->queue);
    ng_gpu_collect(gpu);
    gpu->internal->acquired = gpu->internal->presentable = VK_NULL_HANDLE;
    drop_images(s);
    for (int i = 0; i < NG_GPU_FRAMES; i++)
        vkDestroySemaphore(gpu->device, s->internal->acquired[i], NULL);
    vkDestroySwapchainKHR(gpu->device, s->internal->handle, NULL);
    ng_gpu_live_remove(&s->live);
    free(s->internal);
    free(s);
}

void ng_swapchain_resize(struct ng_swapchain *s, uint32_t width, uint32_t height)
{
    struct ng_swapchain_internal *in = s->internal;
    in->stale |= width != in->wanted_width || height != in->wanted_height;
    in->wanted_width = width;
    in->wanted_height = height;
}

ng_result ng_swapchain_acquire(struct ng_swapchain *s, struct ng_gpu_image **out)
{
    struct ng_gpu *gpu = s->live.gpu;
    struct ng_gpu_internal *g = gpu->internal;
    struct ng_swapchain_internal *in = s->internal;
    *out = NULL;
    NG_REQUIRE(g->open && !in->has_image, "a frame acquires one image of %s, between its begin and end",
               s->live.name);
    VkSemaphore acquired = in->acquired[g->frame_number % NG_GPU_FRAMES];
    // A second attempt serves a surface that changed between the first and the acquire.
    for (int attempt = 0; attempt < 2; attempt++) {
        if (in->stale)
            NG_TRY(rebuild(s));
        if (!in->image_count)
            return NG_OK;
        VkResult r = NG_GPU_CALL(gpu, vkAcquireNextImageKHR(gpu->device, in->handle, UINT64_MAX, acquired,
                                                            VK_NULL_HANDLE, &in->acquired_index));
        in->stale = r == VK_ERROR_OUT_OF_DATE_KHR || r == VK_SUBOPTIMAL_KHR;
        if (r == VK_ERROR_OUT_OF_DATE_KHR)
            continue;
        NG_TRY(ng_gpu_check(gpu, r, "acquire an image of", s->live.name));
        in->has_image = true;
        g->acquired = acquired;
        g->presentable = in->presentable[in->acquired_index];
        *out = in->images[in->acquired_index];
        return NG_OK;
    }
    return NG_OK;
}

ng_result ng_swapchain_present(struct ng_swapchain *s)
{
    struct ng_gpu *gpu = s->live.gpu;
    struct ng_swapchain_internal *in = s->internal;
    if (!in->has_image)
        return NG_OK;
    NG_REQUIRE(!gpu->internal->open, "an image of %s is presented after the frame's end", s->live.name);
    in->has_image = false;
    VkPresentInfoKHR info = {.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR,
                             .waitSemaphoreCount = 1,
                             .pWaitSemaphores = &in->presentable[in->acquired_index],
                             .swapchainCount = 1,
                             .pSwapchains = &in->handle,
                             .pImageIndices = &in->acquired_index};
    VkResult r = NG_GPU_CALL(gpu, vkQueuePresentKHR(gpu->queue, &info));
    in->stale |= r == VK_ERROR_OUT_OF_DATE_KHR || r == VK_SUBOPTIMAL_KHR;
    return r == VK_ERROR_OUT_OF_DATE_KHR ? NG_OK : ng_gpu_check(gpu, r, "present", s->live.name);
}

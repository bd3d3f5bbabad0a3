// A window's images.
//
//     ng_frame_begin(gpu, &cmd);
//     ng_swapchain_acquire(swapchain, &image);      // image is null where there is nothing to draw to
//     ... write the image, leave it in PRESENT_SRC_KHR ...
//     ng_frame_end(gpu, &cmd);
//     ng_swapchain_present(swapchain);
//
// The format is B8G8R8A8_UNORM (or R8G8B8A8_UNORM): the tone map writes values that are already encoded, in a
// compute shader, a draw or a copy alike. Where only an sRGB format is offered, it is taken and `srgb` says
// so.
#ifndef NG_GPU_SWAPCHAIN_H
#define NG_GPU_SWAPCHAIN_H

#include "base/extern_c.h"
#include "gpu/frame.h"

NG_EXTERN_C_BEGIN

struct ng_swapchain_params {
    const char *name;     // null: "window"
    VkSurfaceKHR surface; // borrowed; made by the application from gpu->instance; must outlive the swapchain
    uint32_t width, height; // of the framebuffer in pixels, where the surface does not say itself
    bool no_vsync;          // mailbox, or immediate, where offered; else FIFO
};

// Read only for callers.
struct ng_swapchain {
    struct ng_gpu_live live; // device and name
    uint32_t width, height;
    VkFormat format;
    VkPresentModeKHR present_mode;
    bool srgb;
    struct ng_swapchain_internal *internal;
};

NG_NODISCARD ng_result ng_swapchain_create(struct ng_gpu *gpu, const struct ng_swapchain_params *params,
                                           struct ng_swapchain **out);
void ng_swapchain_destroy(struct ng_swapchain **swapchain);

// New size of the framebuffer; the images are made again at the next acquire. 0 x 0: minimised.
void ng_swapchain_resize(struct ng_swapchain *swapchain, uint32_t width, uint32_t height);

// The image to write in this frame: undefined content and layout, usage colour attachment and copy
// destination. Owned by the swapchain; an imported resource for a graph. NG_OK with null: nothing can be
// shown now (minimised); record the frame without it. Out-of-date swapchains are made again here. The frame's
// next submission waits for the image, its last one signals the presentation.
NG_NODISCARD ng_result ng_swapchain_acquire(struct ng_swapchain *swapchain, struct ng_gpu_image **out);
// Presents the image acquired last; nothing if there is none.
NG_NODISCARD ng_result ng_swapchain_present(struct ng_swapchain *swapchain);

NG_EXTERN_C_END

#endif

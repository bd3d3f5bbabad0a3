// A window of the desktop (X11 or Wayland, through GLFW): its size, what a person does in it, and a surface
// for Vulkan to draw on.
//
//     ng_window_create(&params, &window);
//     extensions = ng_window_extensions(&count);             // for ng_gpu_params, then ng_gpu_create
//     ng_window_create_surface(window, gpu->instance, &surface);
//     while (!window->closed) {
//         ng_window_poll(window);
//         ... read window->input, draw ...
//     }
//     ... swapchain destroyed ...
//     ng_window_destroy_surface(window);                      // before the device
//     ng_window_destroy(&window);
//
// All calls come from the main thread, unless they say otherwise. One window a process is what this is made
// for; more work as well.
#ifndef NG_APP_WINDOW_H
#define NG_APP_WINDOW_H

#include "app/input.h"
#include "base/extern_c.h"
#include "base/result.h"

#include <stdint.h>
#include <vulkan/vulkan_core.h>

NG_EXTERN_C_BEGIN

struct ng_window_params {
    const char *title;      // null: "lightformer"
    uint32_t width, height; // pixels; 0: 1280 x 720
};

// Read only for callers.
struct ng_window {
    uint32_t width, height; // of the framebuffer in pixels; 0 where minimised
    bool closed;            // the person or ng_window_close asked for it
    bool stirred;           // something happened since the last poll: input, another size, it was uncovered
    struct ng_input input;  // since the last poll
    const char
        *dropped; // path of a file that was dropped on it since the last poll, the first of several; or null
    struct ng_window_internal *internal;
};

// NG_ERROR_DEVICE, logged, where there is no display.
NG_NODISCARD ng_result ng_window_create(const struct ng_window_params *params, struct ng_window **out);
// The surface must be destroyed before.
void ng_window_destroy(struct ng_window **window);

// Instance extensions that surfaces need; valid while a window lives.
const char *const *ng_window_extensions(uint32_t *count);
// The surface belongs to the window; one at a time.
NG_NODISCARD ng_result ng_window_create_surface(struct ng_window *window, VkInstance instance,
                                                VkSurfaceKHR *out);
void ng_window_destroy_surface(struct ng_window *window);

// Takes in what happened since the last poll.
void ng_window_poll(struct ng_window *window);
// The same, but waits for something to happen, at most `seconds`.
void ng_window_wait(struct ng_window *window, double seconds);
// Lets events come in and be given their times, but changes nothing that callers read: the next poll tells
// them. For who waits for something else, at most `seconds` at a time.
void ng_window_pump(struct ng_window *window, double seconds);
// Ends a wait. From any thread.
void ng_window_wake(struct ng_window *window);
void ng_window_close(struct ng_window *window);
// Takes it off the desktop, for a program that has to finish something before it ends.
void ng_window_hide(struct ng_window *window);
void ng_window_set_title(struct ng_window *window, const char *title);
// Fills the screen that most of the window is on, or goes back to where and as large as it was.
void ng_window_set_full_screen(struct ng_window *window, bool full);
bool ng_window_is_full_screen(const struct ng_window *window);

NG_EXTERN_C_END

#endif

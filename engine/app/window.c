// The one user of GLFW. Its callbacks collect into what the next poll says.
#include "app/window.h"

#include "base/log.h"
#include "base/printable.h"

#define GLFW_INCLUDE_NONE
#define GLFW_INCLUDE_VULKAN
#include <GLFW/glfw3.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct ng_window_internal {
    GLFWwindow *handle;
    VkInstance instance;
    VkSurfaceKHR surface;
    // What the next poll will say, so that events can come in while somebody works with what the last one
    // said.
    struct ng_input input;
    uint32_t width, height;
    bool stirred, has_drop;
    bool full_screen;
    int restored[4]; // place and size before that
    char next_dropped[4096], dropped[4096];
};

static int window_count; // GLFW lives while there is a window

static int key_of_glfw(int key)
{
    if (key >= GLFW_KEY_SPACE && key < NG_KEY_ESCAPE)
        return key; // GLFW uses the same codes
    if (key >= GLFW_KEY_F1 && key <= GLFW_KEY_F12)
        return NG_KEY_F1 + (key - GLFW_KEY_F1);
    switch (key) {
    case GLFW_KEY_ESCAPE:
        return NG_KEY_ESCAPE;
    case GLFW_KEY_TAB:
        return NG_KEY_TAB;
    case GLFW_KEY_LEFT:
        return NG_KEY_LEFT;
    case GLFW_KEY_RIGHT:
        return NG_KEY_RIGHT;
    case GLFW_KEY_UP:
        return NG_KEY_UP;
    case GLFW_KEY_DOWN:
        return NG_KEY_DOWN;
    case GLFW_KEY_HOME:
        return NG_KEY_HOME;
    case GLFW_KEY_END:
        return NG_KEY_END;
    case GLFW_KEY_LEFT_SHIFT:
    case GLFW_KEY_RIGHT_SHIFT:
        return NG_KEY_SHIFT;
    case GLFW_KEY_LEFT_CONTROL:
    case GLFW_KEY_RIGHT_CONTROL:
        return NG_KEY_CONTROL;
    default:
        return -1;
    }
}

static struct ng_window_internal *internal_of(GLFWwindow *handle)
{
    struct ng_window_internal *internal = ((struct ng_window *)glfwGetWindowUserPointer(handle))->internal;
    internal->stirred = true; // only callbacks ask
    return internal;
}

// GLFW does not tell when an event happened: the moment in which it comes in stands for that.
static void on_key(GLFWwindow *handle, int glfw_key, int scancode, int action, int mods)
{
    NG_UNUSED(scancode);
    NG_UNUSED(mods);
    int key = key_of_glfw(glfw_key);
    if (key >= 0)
        ng_input_key(&internal_of(handle)->input, key, action != GLFW_RELEASE, glfwGetTime());
}

static void on_button(GLFWwindow *handle, int button, int action, int mods)
{
    NG_UNUSED(mods);
    enum ng_button b = button == GLFW_MOUSE_BUTTON_LEFT     ? NG_BUTTON_LEFT
                       : button == GLFW_MOUSE_BUTTON_RIGHT  ? NG_BUTTON_RIGHT
                       : button == GLFW_MOUSE_BUTTON_MIDDLE ? NG_BUTTON_MIDDLE
                                                            : NG_BUTTON_COUNT;
    if (b != NG_BUTTON_COUNT)
        ng_input_button(&internal_of(handle)->input, b, action == GLFW_PRESS, glfwGetTime());
}

static void on_pointer(GLFWwindow *handle, double x, double y)
{
    struct ng_window_internal *w = internal_of(handle);
    // GLFW counts in screen coordinates, which are not pixels on every desktop.
    int width, height;
    glfwGetWindowSize(handle, &width, &height);
    ng_input_pointer(&w->input, (float)x * (width > 0 ? (float)w->width / (float)width : 1),
                     (float)y * (height > 0 ? (float)w->height / (float)height : 1), glfwGetTime());
}

static void on_scroll(GLFWwindow *handle, double x, double y)
{
    NG_UNUSED(x);
    ng_input_scroll(&internal_of(handle)->input, (float)y, glfwGetTime());
}

static void on_drop(GLFWwindow *handle, int count, const char **paths)
{
    struct ng_window_internal *w = internal_of(handle);
    if (count < 1 || strlen(paths[0]) >= sizeof w->next_dropped)
        return;
    memcpy(w->next_dropped, paths[0], strlen(paths[0]) + 1); // theirs until we return
    w->has_drop = true;
}

static void on_framebuffer_size(GLFWwindow *handle, int width, int height)
{
    struct ng_window_internal *w = internal_of(handle);
    w->width = (uint32_t)width;
    w->height = (uint32_t)height;
}

static void on_refresh(GLFWwindow *handle)
{
    (void)internal_of(handle);
}

static const char *glfw_reason(void)
{
    const char *reason;
    return glfwGetError(&reason) != GLFW_NO_ERROR ? reason : "no reason given";
}

static ng_result acquire_glfw(void)
{
    if (window_count == 0 && !glfwInit()) {
        ng_log_error("cannot open a window: %s; is there a display (DISPLAY, WAYLAND_DISPLAY)?",
                     glfw_reason());
        return NG_ERROR_DEVICE;
    }
    window_count++;
    return NG_OK;
}

static void release_glfw(void)
{
    if (--window_count == 0)
        glfwTerminate();
}

ng_result ng_window_create(const struct ng_window_params *params, struct ng_window **out)
{
    *out = NULL;
    struct ng_window *w = calloc(1, sizeof *w);
    struct ng_window_internal *internal = calloc(1, sizeof *internal);
    ng_result result = NG_ERROR_MEMORY;
    if (!w || !internal) {
        ng_log_error("out of memory for a window");
        goto fail;
    }
    w->internal = internal;
    result = acquire_glfw();
    if (result != NG_OK)
        goto fail;
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    internal->handle =
        glfwCreateWindow(params->width ? (int)params->width : 1280,
                         params->height ? (int)params->height : 720, "lightformer", NULL, NULL);
    if (internal->handle && params->title)
        ng_window_set_title(w, params->title);
    if (!internal->handle) {
        ng_log_error("cannot open a window: %s", glfw_reason());
        result = NG_ERROR_DEVICE;
        release_glfw();
        goto fail;
    }
    int width, height;
    glfwGetFramebufferSize(internal->handle, &width, &height);
    w->width = internal->width = (uint32_t)width;
    w->height = internal->height = (uint32_t)height;
    internal->input.time = glfwGetTime();
    glfwSetWindowUserPointer(internal->handle, w);
    glfwSetKeyCallback(internal->handle, on_key);
    glfwSetMouseButtonCallback(internal->handle, on_button);
    glfwSetCursorPosCallback(internal->handle, on_pointer);
    glfwSetScrollCallback(internal->handle, on_scroll);
    glfwSetFramebufferSizeCallback(internal->handle, on_framebuffer_size);
    glfwSetDropCallback(internal->handle, on_drop);
    glfwSetWindowRefreshCallback(internal->handle, on_refresh);
    *out = w;
    return NG_OK;
fail:
    free(internal);
    free(w);
    return result;
}

void ng_window_destroy(struct ng_window **window)
{
    struct ng_window *w = *window;
    if (!w)
        return;
    *window = NULL;
    glfwDestroyWindow(w->internal->handle);
    release_glfw();
    free(w->internal);
    free(w);
}

const char *const *ng_window_extensions(uint32_t *count)
{
    *count = 0;
    return (const char *const *)glfwGetRequiredInstanceExtensions(count);
}

ng_result ng_window_create_surface(struct ng_window *window, VkInstance instance, VkSurfaceKHR *out)
{
    struct ng_window_internal *internal = window->internal;
    NG_REQUIRE(!internal->surface, "a window has one surface");
    VkResult r = glfwCreateWindowSurface(instance, internal->handle, NULL, &internal->surface);
    if (r != VK_SUCCESS) {
        ng_log_error("cannot draw in a window: %s (%d); does the driver know this display?", glfw_reason(),
                     (int)r);
        return NG_ERROR_DEVICE;
    }
    internal->instance = instance;
    *out = internal->surface;
    return NG_OK;
}

void ng_window_destroy_surface(struct ng_window *window)
{
    struct ng_window_internal *internal = window->internal;
    if (internal->surface)
        vkDestroySurfaceKHR(internal->instance, internal->surface, NULL);
    internal->surface = VK_NULL_HANDLE;
}

void ng_window_pump(struct ng_window *window, double seconds)
{
    if (seconds > 0)
        glfwWaitEventsTimeout(seconds);
    else
        glfwPollEvents();
    ng_input_pass(&window->internal->input, glfwGetTime());
}

void ng_window_wait(struct ng_window *window, double seconds)
{
    struct ng_window_internal *internal = window->internal;
    ng_window_pump(window, seconds);
    window->input = internal->input;
    ng_input_begin(&internal->input);
    window->width = internal->width;
    window->height = internal->height;
    window->dropped = internal->has_drop ? internal->dropped : NULL;
    if (internal->has_drop)
        memcpy(internal->dropped, internal->next_dropped, sizeof internal->dropped);
    window->stirred = internal->stirred;
    internal->has_drop = internal->stirred = false;
    window->closed |= glfwWindowShouldClose(internal->handle) != 0;
}

void ng_window_poll(struct ng_window *window)
{
    ng_window_wait(window, 0);
}

void ng_window_wake(struct ng_window *window)
{
    NG_UNUSED(window);
    glfwPostEmptyEvent();
}

void ng_window_close(struct ng_window *window)
{
    window->closed = true;
}

void ng_window_hide(struct ng_window *window)
{
    glfwHideWindow(window->internal->handle);
}

void ng_window_set_title(struct ng_window *window, const char *title)
{
    char shown[1024];
    snprintf(shown, sizeof shown, "%s", title);
    ng_make_printable(shown);
    glfwSetWindowTitle(window->internal->handle, shown);
}

// The monitor that the middle of a window is on; the first one if it is on none.
static GLFWmonitor *monitor_of(GLFWwindow *handle)
{
    int count, x, y, width, height;
    GLFWmonitor **monitors = glfwGetMonitors(&count);
    glfwGetWindowPos(handle, &x, &y);
    glfwGetWindowSize(handle, &width, &height);
    for (int i = 0; i < count; i++) {
        int left, top;
        const GLFWvidmode *mode = glfwGetVideoMode(monitors[i]);
        glfwGetMonitorPos(monitors[i], &left, &top);
        int right = x + width / 2 - left, down = y + height / 2 - top;
        if (mode && right >= 0 && down >= 0 && right < mode->width && down < mode->height)
            return monitors[i];
    }
    return count > 0 ? monitors[0] : NULL;
}

void ng_window_set_full_screen(struct ng_window *window, bool full)
{
    struct ng_window_internal *w = window->internal;
    GLFWmonitor *monitor = monitor_of(w->handle);
    const GLFWvidmode *mode = monitor ? glfwGetVideoMode(monitor) : NULL;
    int *r = w->restored;
    if (full == w->full_screen || (full && !mode))
        return;
    w->full_screen = full;
    if (full) {
        glfwGetWindowPos(w->handle, &r[0], &r[1]);
        glfwGetWindowSize(w->handle, &r[2], &r[3]);
        glfwSetWindowMonitor(w->handle, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
    } else {
        glfwSetWindowMonitor(w->handle, NULL, r[0], r[1], r[2], r[3], GLFW_DONT_CARE);
    }
}

bool ng_window_is_full_screen(const struct ng_window *window)
{
    return window->internal->full_screen;
}

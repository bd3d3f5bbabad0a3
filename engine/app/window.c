// The one user of GLFW. Its callbacks collect into the input of the poll that runs them.
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
    char dropped[4096];
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

static void on_key(GLFWwindow *handle, int glfw_key, int scancode, int action, int mods)
{
    NG_UNUSED(scancode);
    NG_UNUSED(mods);
    struct ng_input *input = &((struct ng_window *)glfwGetWindowUserPointer(handle))->input;
    int key = key_of_glfw(glfw_key);
    if (key < 0)
        return;
    input->down[key] = action != GLFW_RELEASE;
    input->pressed[key] |= action != GLFW_RELEASE;
}

static void on_button(GLFWwindow *handle, int button, int action, int mods)
{
    NG_UNUSED(mods);
    struct ng_window *w = glfwGetWindowUserPointer(handle);
    enum ng_button b = button == GLFW_MOUSE_BUTTON_LEFT     ? NG_BUTTON_LEFT
                       : button == GLFW_MOUSE_BUTTON_RIGHT  ? NG_BUTTON_RIGHT
                       : button == GLFW_MOUSE_BUTTON_MIDDLE ? NG_BUTTON_MIDDLE
                                                            : NG_BUTTON_COUNT;
    if (b == NG_BUTTON_COUNT)
        return;
    w->input.buttons[b] = action == GLFW_PRESS;
    if (action == GLFW_PRESS)
        memcpy(w->input.grip[b], w->input.pointer, sizeof w->input.grip[b]);
}

static void on_pointer(GLFWwindow *handle, double x, double y)
{
    struct ng_window *w = glfwGetWindowUserPointer(handle);
    // GLFW counts in screen coordinates, which are not pixels on every desktop.
    int width, height;
    glfwGetWindowSize(handle, &width, &height);
    float position[2] = {(float)x * (width > 0 ? (float)w->width / (float)width : 1),
                         (float)y * (height > 0 ? (float)w->height / (float)height : 1)};
    struct ng_input *input = &w->input;
    for (int i = 0; i < 2; i++) {
        for (int b = 0; b < NG_BUTTON_COUNT; b++) {
            if (input->buttons[b])
                input->drag[b][i] += position[i] - input->pointer[i];
        }
        input->pointer[i] = position[i];
    }
}

static void on_scroll(GLFWwindow *handle, double x, double y)
{
    NG_UNUSED(x);
    ((struct ng_window *)glfwGetWindowUserPointer(handle))->input.scroll += (float)y;
}

static void on_drop(GLFWwindow *handle, int count, const char **paths)
{
    struct ng_window *w = glfwGetWindowUserPointer(handle);
    char *room = w->internal->dropped;
    if (count < 1 || strlen(paths[0]) >= sizeof w->internal->dropped)
        return;
    memcpy(room, paths[0], strlen(paths[0]) + 1); // theirs until we return
    w->dropped = room;
}

static void on_framebuffer_size(GLFWwindow *handle, int width, int height)
{
    struct ng_window *w = glfwGetWindowUserPointer(handle);
    w->width = (uint32_t)width;
    w->height = (uint32_t)height;
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
    w->width = (uint32_t)width;
    w->height = (uint32_t)height;
    glfwSetWindowUserPointer(internal->handle, w);
    glfwSetKeyCallback(internal->handle, on_key);
    glfwSetMouseButtonCallback(internal->handle, on_button);
    glfwSetCursorPosCallback(internal->handle, on_pointer);
    glfwSetScrollCallback(internal->handle, on_scroll);
    glfwSetFramebufferSizeCallback(internal->handle, on_framebuffer_size);
    glfwSetDropCallback(internal->handle, on_drop);
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

// Forgets what was since the last poll; what is held down stays.
static void begin_input(struct ng_window *window)
{
    struct ng_input *input = &window->input;
    window->dropped = NULL;
    input->scroll = 0;
    memset(input->drag, 0, sizeof input->drag);
    memset(input->pressed, 0, sizeof input->pressed);
}

void ng_window_poll(struct ng_window *window)
{
    begin_input(window);
    glfwPollEvents();
    window->closed |= glfwWindowShouldClose(window->internal->handle) != 0;
}

void ng_window_wait(struct ng_window *window, double seconds)
{
    begin_input(window);
    glfwWaitEventsTimeout(seconds);
    window->closed |= glfwWindowShouldClose(window->internal->handle) != 0;
}

void ng_window_close(struct ng_window *window)
{
    window->closed = true;
}

void ng_window_set_title(struct ng_window *window, const char *title)
{
    char shown[1024];
    snprintf(shown, sizeof shown, "%s", title);
    ng_make_printable(shown);
    glfwSetWindowTitle(window->internal->handle, shown);
}

// A window's images: acquired, written, presented, through resizing and minimising. Needs a display (CTest
// runs it under xvfb-run); without one there is nothing to test.
#define GLFW_INCLUDE_NONE
#include "gpu_test.h"

#include "gpu/swapchain.h"
#include <GLFW/glfw3.h>

// One frame: clears what was acquired. Returns whether there was an image, of the expected size.
static bool show(struct ng_gpu *gpu, struct ng_swapchain *s, uint32_t width, uint32_t height)
{
    struct ng_cmd *cmd;
    struct ng_gpu_image *image;
    assert_int_equal(ng_frame_begin(gpu, &cmd), NG_OK);
    assert_int_equal(ng_swapchain_acquire(s, &image), NG_OK);
    bool shown = image;
    if (image) {
        assert_int_equal(image->width, width);
        assert_int_equal(image->height, height);
        assert_int_equal(image->format, s->format);
        gpu_test_barrier(cmd, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
        VkImageSubresourceRange all = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
        vkCmdClearColorImage(cmd->handle, image->handle, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                             &(VkClearColorValue){.float32 = {1, 0, 0, 1}}, 1, &all);
        assert_int_equal(ng_frame_submit(gpu, &cmd, NULL), NG_OK); // a frame in parts presents once
        gpu_test_barrier(cmd, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR);
    }
    assert_int_equal(ng_frame_end(gpu, &cmd), NG_OK);
    assert_int_equal(ng_swapchain_present(s), NG_OK);
    return shown;
}

static void resize(GLFWwindow *window, struct ng_swapchain *s, int width, int height)
{
    int w = 0, h = 0;
    glfwSetWindowSize(window, width, height);
    for (int i = 0; i < 200 && (w != width || h != height); i++) {
        glfwWaitEventsTimeout(0.01);
        glfwGetFramebufferSize(window, &w, &h);
    }
    ng_swapchain_resize(s, (uint32_t)w, (uint32_t)h);
}

static void run(GLFWwindow *window, bool no_vsync)
{
    struct ng_gpu_params params = {0};
    params.instance_extensions = glfwGetRequiredInstanceExtensions(&params.instance_extension_count);
    struct ng_gpu *gpu = gpu_test_create(params);
    VkSurfaceKHR surface;
    assert_int_equal(glfwCreateWindowSurface(gpu->instance, window, NULL, &surface), VK_SUCCESS);
    struct ng_swapchain *s;
    struct ng_swapchain_params swapchain_params = {
        .surface = surface, .width = 320, .height = 200, .no_vsync = no_vsync};
    assert_int_equal(ng_swapchain_create(gpu, &swapchain_params, &s), NG_OK);
    assert_false(s->srgb);
    assert_true(no_vsync || s->present_mode == VK_PRESENT_MODE_FIFO_KHR);
    for (int i = 0; i < 8; i++)
        assert_true(show(gpu, s, 320, 200));
    resize(window, s, 401, 133);
    for (int i = 0; i < 4; i++)
        assert_true(show(gpu, s, 401, 133));
    ng_swapchain_resize(s, 0, 0); // minimised
    assert_false(show(gpu, s, 0, 0));
    assert_false(show(gpu, s, 0, 0));
    resize(window, s, 320, 200);
    assert_true(show(gpu, s, 320, 200));
    ng_swapchain_destroy(&s);
    assert_null(s);
    vkDestroySurfaceKHR(gpu->instance, surface, NULL);
    gpu_test_end(gpu);
}

static void test_window(void **state)
{
    NG_UNUSED(state);
    if (!glfwInit())
        skip();
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    GLFWwindow *window = glfwCreateWindow(320, 200, "test", NULL, NULL);
    assert_non_null(window);
    run(window, false);
    run(window, true);
    glfwDestroyWindow(window);
    glfwTerminate();
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_window)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

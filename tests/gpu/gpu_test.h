// What every test on a device needs: a device with validation and synchronization validation, the promise
// that not one validation message came and that nothing was left behind, and the objects that most tests
// make.
//
// The device is the one that NG_DEVICE names, or the engine's own choice. Where the validation layer is not
// installed tests run without it, and say so.
#ifndef NG_TESTS_GPU_TEST_H
#define NG_TESTS_GPU_TEST_H

#include "test.h"

#include "gpu/buffer.h"
#include "gpu/device.h"
#include "gpu/frame.h"
#include "gpu/image.h"
#include "gpu/pipeline.h"

static inline struct ng_gpu *gpu_test_create(struct ng_gpu_params params)
{
    struct ng_gpu *gpu = NULL;
    params.validation = true;
    ng_result r = ng_gpu_create(&params, &gpu);
    if (r == NG_ERROR_NOT_FOUND) {
        print_message("the validation layer is missing: running without it\n");
        params.validation = false;
        r = ng_gpu_create(&params, &gpu);
    }
    assert_int_equal(r, NG_OK);
    assert_non_null(gpu);
    return gpu;
}

static inline struct ng_gpu *gpu_test_begin(void)
{
    return gpu_test_create((struct ng_gpu_params){0});
}

// Everything made by the test has been destroyed by now; the device goes too.
static inline void gpu_test_end(struct ng_gpu *gpu)
{
    struct test_log log;
    if (!gpu->lost)
        assert_int_equal(ng_gpu_wait_idle(gpu), NG_OK);
    struct ng_gpu_stats stats = ng_gpu_stats(gpu);
    uint32_t messages = ng_gpu_validation_messages(gpu);
    test_log_begin(&log);
    ng_gpu_destroy(&gpu);
    test_log_end(&log);
    if (log.errors)
        print_error("%s", log.text);
    assert_int_equal(messages, 0);
    assert_int_equal(log.errors, 0); // validation at destruction, forgotten objects and memory
    assert_int_equal(stats.pipelines + stats.bind_groups + stats.images + stats.swapchains, 0);
}

static inline struct ng_gpu_buffer *gpu_test_buffer(struct ng_gpu *gpu, uint64_t size,
                                                    enum ng_gpu_memory_kind kind)
{
    struct ng_gpu_buffer *b;
    struct ng_gpu_buffer_params params = {.name = "buffer", .size = size, .memory = kind};
    assert_int_equal(ng_gpu_buffer_create(gpu, &params, &b), NG_OK);
    return b;
}

// A compute pipeline that maps the storage buffer at binding 0 to that at binding 1.
static inline struct ng_gpu_pipeline *gpu_test_map(struct ng_gpu *gpu, const char *name,
                                                   struct ng_spirv shader, uint32_t push_size)
{
    static const struct ng_gpu_slot slots[] = {{.binding = 0, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
                                               {.binding = 1, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}};
    struct ng_gpu_compute_params params = {
        .name = name, .shader = shader, .slots = slots, .slot_count = 2, .push_size = push_size};
    struct ng_gpu_pipeline *p;
    assert_int_equal(ng_gpu_compute_create(gpu, &params, &p), NG_OK);
    return p;
}

// Everything before, then everything after: for tests that are not about the graph, which knows better.
static inline void gpu_test_barrier(struct ng_cmd *cmd, struct ng_gpu_image *image, VkImageLayout from,
                                    VkImageLayout to)
{
    VkImageMemoryBarrier2 b = {.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
                               .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                               .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
                               .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                               .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT,
                               .oldLayout = from,
                               .newLayout = to,
                               .image = image->handle,
                               .subresourceRange = {image->aspect, 0, 1, 0, 1}};
    VkDependencyInfo d = {
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .imageMemoryBarrierCount = 1, .pImageMemoryBarriers = &b};
    vkCmdPipelineBarrier2(cmd->handle, &d);
}

#endif

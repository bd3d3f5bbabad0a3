// Frames in flight: what dies when, what the frame's memory keeps, timers, and what happens when allocations
// fail or the device is lost.
#include "gpu_test.h"

#include "double.comp.spv.h"
#include "gpu/timer.h"
#include "gpu/transfer.h"

static void begin(struct ng_gpu *gpu, struct ng_cmd **cmd)
{
    assert_int_equal(ng_frame_begin(gpu, cmd), NG_OK);
}

static void end(struct ng_gpu *gpu, struct ng_cmd **cmd)
{
    assert_int_equal(ng_frame_end(gpu, cmd), NG_OK);
}

static void test_deferred_destruction(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    struct ng_cmd *cmd;
    uint32_t waiting = ng_gpu_stats(gpu).waiting;
    // Nothing can be using it: gone at once.
    struct ng_gpu_buffer *idle = gpu_test_buffer(gpu, 1000, NG_GPU_MEMORY_DEVICE);
    ng_gpu_buffer_destroy(&idle);
    assert_int_equal(ng_gpu_stats(gpu).waiting, waiting);
    // Used by the frame being recorded, and by a part of it that was submitted before.
    struct ng_gpu_buffer *used = gpu_test_buffer(gpu, 1000, NG_GPU_MEMORY_DEVICE);
    uint64_t memory = ng_gpu_stats(gpu).memory_used, serial;
    begin(gpu, &cmd);
    vkCmdFillBuffer(cmd->handle, used->handle, 0, VK_WHOLE_SIZE, 1);
    assert_int_equal(ng_frame_submit(gpu, &cmd, &serial), NG_OK);
    assert_int_equal(ng_gpu_wait(gpu, serial), NG_OK);
    ng_gpu_buffer_destroy(&used);
    assert_null(used);
    assert_int_equal(ng_gpu_stats(gpu).waiting, waiting + 2); // the buffer and its memory
    assert_int_equal(ng_gpu_stats(gpu).memory_used, memory);
    end(gpu, &cmd);
    assert_int_equal(ng_gpu_wait_idle(gpu), NG_OK);
    assert_int_equal(ng_gpu_stats(gpu).waiting, waiting);
    assert_true(ng_gpu_stats(gpu).memory_used < memory);
    // In a steady state each frame's waste is gone two frames later.
    for (int i = 0; i < 50; i++) {
        begin(gpu, &cmd);
        struct ng_gpu_buffer *b = gpu_test_buffer(gpu, 100, NG_GPU_MEMORY_DEVICE);
        vkCmdFillBuffer(cmd->handle, b->handle, 0, VK_WHOLE_SIZE, 1);
        ng_gpu_buffer_destroy(&b);
        end(gpu, &cmd);
        assert_true(ng_gpu_stats(gpu).waiting <= waiting + 2 * (NG_GPU_FRAMES + 1));
    }
    gpu_test_end(gpu);
}

// A frame that the device cannot finish until the host lets it: what it uses stays, although a submission
// that was made after the destruction is done.
static void test_destruction_waits_for_the_frame(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    struct ng_gpu_buffer *used = gpu_test_buffer(gpu, 64, NG_GPU_MEMORY_DEVICE);
    struct ng_gpu_buffer *other = gpu_test_buffer(gpu, 64, NG_GPU_MEMORY_DEVICE);
    VkEvent event;
    VkEventCreateInfo info = {.sType = VK_STRUCTURE_TYPE_EVENT_CREATE_INFO};
    assert_int_equal(vkCreateEvent(gpu->device, &info, NULL, &event), VK_SUCCESS);
    uint32_t waiting = ng_gpu_stats(gpu).waiting, words[16];
    struct ng_cmd *cmd;
    begin(gpu, &cmd);
    vkCmdWaitEvents(cmd->handle, 1, &event, VK_PIPELINE_STAGE_HOST_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0,
                    NULL, 0, NULL, 0, NULL);
    vkCmdFillBuffer(cmd->handle, used->handle, 0, VK_WHOLE_SIZE, 1);
    ng_gpu_buffer_destroy(&used);
    assert_int_equal(ng_readback_buffer(other, 0, words, 64), NG_OK); // a whole submission within the frame
    uint64_t between = ng_gpu_serial(gpu) - 1;
    end(gpu, &cmd);
    assert_int_equal(ng_gpu_wait(gpu, between), NG_OK); // frees what is done
    assert_true(ng_gpu_stats(gpu).waiting >= waiting + 2);
    vkSetEvent(gpu->device, event);
    assert_int_equal(ng_gpu_wait_idle(gpu), NG_OK);
    assert_int_equal(ng_gpu_stats(gpu).waiting, waiting);
    vkDestroyEvent(gpu->device, event, NULL);
    ng_gpu_buffer_destroy(&other);
    gpu_test_end(gpu);
}

// The CPU in the middle of a frame: it reads what the first part wrote, and writes what the second part
// reads.
static void test_frame_in_parts(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    struct ng_gpu_buffer *a = gpu_test_buffer(gpu, 64, NG_GPU_MEMORY_READBACK);
    struct ng_gpu_buffer *b = gpu_test_buffer(gpu, 64, NG_GPU_MEMORY_READBACK);
    uint64_t first, before = ng_gpu_serial(gpu);
    struct ng_cmd *cmd;
    begin(gpu, &cmd);
    vkCmdFillBuffer(cmd->handle, a->handle, 0, 64, 41);
    assert_int_equal(ng_frame_submit(gpu, &cmd, &first), NG_OK);
    assert_int_equal(first, before);
    assert_int_equal(ng_gpu_wait(gpu, first), NG_OK);
    uint32_t *words = a->mapped;
    assert_int_equal(words[15], 41);
    words[15]++;
    vkCmdCopyBuffer(cmd->handle, a->handle, b->handle, 1, &(VkBufferCopy){.size = 64});
    end(gpu, &cmd);
    assert_int_equal(ng_gpu_wait_idle(gpu), NG_OK);
    assert_int_equal(((uint32_t *)b->mapped)[15], 42);
    ng_gpu_buffer_destroy(&a);
    ng_gpu_buffer_destroy(&b);
    gpu_test_end(gpu);
}

// Two frames in flight have memory of their own, and a steady load allocates nothing more.
static void test_frame_memory(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    uint64_t steady = 0;
    struct ng_frame_range ranges[3][40];
    for (int frame = 0; frame < 12; frame++) {
        struct ng_cmd *cmd;
        begin(gpu, &cmd);
        struct ng_frame_range *now = ranges[frame % 3], *previous = ranges[(frame + 2) % 3];
        for (uint64_t i = 0; i < 40; i++) {
            uint64_t size = i == 20 ? 3u << 20 : 1 + i * 2000; // one beyond a chunk
            assert_int_equal(ng_frame_alloc(gpu, size, &now[i]), NG_OK);
            assert_int_equal(now[i].offset % 256, 0);
            assert_true(now[i].address == now[i].buffer->address + now[i].offset);
            memset(now[i].mapped, frame, size);
            if (frame) // the frame before may still be read by the device
                assert_int_equal(*(unsigned char *)previous[i].mapped, frame - 1);
        }
        end(gpu, &cmd);
        if (frame == 5)
            steady = ng_gpu_stats(gpu).memory_used;
    }
    assert_int_equal(ng_gpu_stats(gpu).memory_used, steady);
    gpu_test_end(gpu);
}

static void test_timers(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    struct ng_gpu_buffer *b = gpu_test_buffer(gpu, 4 << 20, NG_GPU_MEMORY_DEVICE);
    uint32_t count;
    assert_null(ng_gpu_timings(gpu, &count));
    for (int frame = 0; frame < 5; frame++) {
        struct ng_cmd *cmd;
        begin(gpu, &cmd);
        uint32_t all = ng_timer_begin(cmd, "all");
        uint32_t fill = ng_timer_begin(cmd, "fill");
        vkCmdFillBuffer(cmd->handle, b->handle, 0, VK_WHOLE_SIZE, 1);
        ng_timer_end(cmd, fill);
        uint32_t empty = ng_timer_begin(cmd, "empty");
        ng_timer_end(cmd, empty);
        ng_timer_end(cmd, all);
        ng_timer_begin(cmd, "never ended");
        end(gpu, &cmd);
    }
    assert_int_equal(ng_gpu_wait_idle(gpu), NG_OK);
    const struct ng_gpu_timing *t = ng_gpu_timings(gpu, &count);
    if (t) { // a device without timestamps publishes nothing
        assert_int_equal(count, 3);
        assert_int_equal(ng_gpu_timings_frame(gpu), 4);
        assert_string_equal(t[0].name, "all");
        assert_string_equal(t[1].name, "fill");
        assert_string_equal(t[2].name, "empty");
        for (uint32_t i = 0; i < count; i++)
            assert_true(t[i].gpu_ms >= 0 && t[i].begin_ms >= 0);
        // Nested and in order.
        assert_true(t[0].begin_ms <= t[1].begin_ms && t[1].begin_ms + t[1].gpu_ms <= t[2].begin_ms);
        assert_true(t[2].begin_ms + t[2].gpu_ms <= t[0].begin_ms + t[0].gpu_ms);
        assert_true(t[1].gpu_ms > 0);
    }
    ng_gpu_buffer_destroy(&b);
    gpu_test_end(gpu);
}

static void test_forgotten_objects_are_named(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    struct ng_gpu_buffer *b;
    struct test_log log;
    assert_int_equal(
        ng_gpu_buffer_create(gpu, &(struct ng_gpu_buffer_params){.name = "forgotten one", .size = 8}, &b),
        NG_OK);
    test_log_begin(&log);
    ng_gpu_destroy(&gpu);
    test_log_end(&log);
    assert_int_equal(log.errors, 1); // and validation is content: it was freed
    assert_non_null(strstr(log.text, "the buffer 'forgotten one'"));
}

// ---- Failures --------------------------------------------------------------------------------------------

// Makes one of everything and uses it; cleans up whatever happened. The first failure is returned.
static ng_result make_everything(struct ng_gpu *gpu)
{
    const struct ng_gpu_slot slots[] = {
        {.set = 0, .binding = 0, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
        {.set = 0, .binding = 1, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
        {.set = 1, .binding = 0, .type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER}};
    struct ng_gpu_buffer_params buffer_params = {.name = "faulty buffer", .size = 40 << 20};
    struct ng_gpu_image_params image_params = {
        .name = "faulty image", .width = 4, .height = 4, .mips = 2, .format = VK_FORMAT_R8G8B8A8_UNORM};
    struct ng_gpu_compute_params pipeline_params = {.name = "faulty pipeline",
                                                    .shader = NG_SPIRV(ng_spv_double_comp),
                                                    .slots = slots,
                                                    .slot_count = 3,
                                                    .push_size = 8};
    unsigned char pixels[80] = {0}, back[80];
    struct ng_gpu_buffer *buffer = NULL;
    struct ng_gpu_image *image = NULL;
    struct ng_gpu_pipeline *pipeline = NULL;
    struct ng_gpu_bind_group *group = NULL;
    struct ng_cmd *cmd = NULL;
    struct ng_frame_range range;
    ng_result r = ng_gpu_buffer_create(gpu, &buffer_params, &buffer);
    if (r == NG_OK)
        r = ng_gpu_image_create(gpu, &image_params, &image);
    if (r == NG_OK)
        r = ng_upload_image(image, &(struct ng_upload_image_params){.data = pixels, .size = sizeof pixels});
    if (r == NG_OK)
        r = ng_gpu_compute_create(gpu, &pipeline_params, &pipeline);
    VkSampler sampler = r == NG_OK ? ng_gpu_sampler(gpu, &(struct ng_gpu_sampler_params){0}) : VK_NULL_HANDLE;
    if (r == NG_OK && !sampler)
        r = gpu->lost ? NG_ERROR_DEVICE : NG_ERROR_MEMORY;
    struct ng_gpu_binding texture = {.view = image ? image->view : VK_NULL_HANDLE, .sampler = sampler};
    if (r == NG_OK)
        r = ng_gpu_bind_group_create(gpu, "faulty group", pipeline, 1, &texture, 1, &group);
    if (r == NG_OK)
        r = ng_frame_begin(gpu, &cmd);
    if (r == NG_OK) {
        r = ng_frame_alloc(gpu, 100, &range);
        struct ng_gpu_binding both[] = {{.binding = 0, .buffer = buffer}, {.binding = 1, .buffer = buffer}};
        if (r == NG_OK)
            r = ng_cmd_bind(cmd, pipeline, both, 2);
        if (r == NG_OK)
            r = ng_frame_submit(gpu, &cmd, NULL);
        ng_result ended = cmd ? ng_frame_end(gpu, &cmd) : r;
        r = r == NG_OK ? ended : r;
    }
    if (r == NG_OK)
        r = ng_readback_image(
            image, &(struct ng_readback_image_params){
                       .layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, .out = back, .size = sizeof back});
    ng_gpu_bind_group_destroy(&group);
    ng_gpu_pipeline_destroy(&pipeline);
    ng_gpu_image_destroy(&image);
    ng_gpu_buffer_destroy(&buffer);
    return r;
}

// Each allocation fails once, the first to the last: always one message and NG_ERROR_MEMORY, never a leak,
// and the device goes on working.
static void test_every_allocation_fails_once(void **state)
{
    NG_UNUSED(state);
    bool done = false;
    uint32_t n = 0;
    while (!done) {
        struct ng_gpu *gpu = gpu_test_create((struct ng_gpu_params){.no_push_descriptors = n % 2});
        for (int k = 0; k < 6 && !done; k++) {
            struct test_log log;
            ng_gpu_inject_faults(gpu, &(struct ng_gpu_faults){.fail_allocation = ++n});
            test_log_begin(&log);
            ng_result r = make_everything(gpu);
            test_log_end(&log);
            ng_gpu_inject_faults(gpu, &(struct ng_gpu_faults){0});
            done = r == NG_OK;
            if (!done && (r != NG_ERROR_MEMORY || log.errors != 1))
                fail_msg("allocation %u: result %d, log:\n%s", n, r, log.text);
            assert_int_equal(ng_gpu_wait_idle(gpu), NG_OK);
            assert_int_equal(ng_gpu_stats(gpu).waiting, 0);
        }
        assert_int_equal(make_everything(gpu), NG_OK);
        gpu_test_end(gpu);
    }
    assert_true(n > 20); // it was not the first call that succeeded
}

// The device is lost at each submission in turn: one message, then quick failure of everything, and a clean
// end.
static void test_device_lost(void **state)
{
    NG_UNUSED(state);
    for (uint32_t n = 1; n <= 3; n++) {
        struct ng_gpu *gpu = gpu_test_begin();
        struct ng_gpu_buffer *survivor = gpu_test_buffer(gpu, 100, NG_GPU_MEMORY_DEVICE);
        struct test_log log;
        ng_gpu_inject_faults(gpu, &(struct ng_gpu_faults){.lose_device = n});
        test_log_begin(&log);
        assert_int_equal(make_everything(gpu), NG_ERROR_DEVICE);
        assert_true(gpu->lost);
        assert_int_equal(log.errors, 1);
        assert_non_null(strstr(log.text, "was lost"));
        // Silent from here on.
        uint32_t words[2];
        struct ng_cmd *cmd;
        assert_int_equal(make_everything(gpu), NG_ERROR_DEVICE);
        assert_int_equal(ng_frame_begin(gpu, &cmd), NG_ERROR_DEVICE);
        assert_int_equal(ng_immediate_begin(gpu, &cmd), NG_ERROR_DEVICE);
        assert_int_equal(ng_upload_buffer(survivor, 0, words, 8), NG_ERROR_DEVICE);
        assert_int_equal(ng_readback_buffer(survivor, 0, words, 8), NG_ERROR_DEVICE);
        assert_int_equal(ng_gpu_wait_idle(gpu), NG_ERROR_DEVICE);
        test_log_end(&log);
        assert_int_equal(log.errors, 1);
        ng_gpu_buffer_destroy(&survivor);
        gpu_test_end(gpu);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_deferred_destruction),
        cmocka_unit_test(test_destruction_waits_for_the_frame),
        cmocka_unit_test(test_frame_in_parts),
        cmocka_unit_test(test_frame_memory),
        cmocka_unit_test(test_timers),
        cmocka_unit_test(test_forgotten_objects_are_named),
        cmocka_unit_test(test_every_allocation_fails_once),
        cmocka_unit_test(test_device_lost),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

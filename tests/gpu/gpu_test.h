// What every test on a device needs: a device with validation and synchronization validation, and the promise
// that not one validation message came and that nothing was left behind.
//
// The device is the one that NG_DEVICE names, or the engine's own choice. Where the validation layer is not
// installed tests run without it, and say so.
#ifndef NG_TESTS_GPU_TEST_H
#define NG_TESTS_GPU_TEST_H

#include "test.h"

#include "gpu/device.h"

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

#endif

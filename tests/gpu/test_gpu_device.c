// Which device is chosen, and what one reads when there is none.
#define _POSIX_C_SOURCE 200809L // setenv
#include "gpu_test.h"

static void test_list(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu_info *infos;
    uint32_t count;
    assert_int_equal(ng_gpu_list(&infos, &count), NG_OK);
    assert_true(count > 0);
    for (uint32_t i = 0; i < count; i++) {
        assert_int_equal(infos[i].index, i);
        assert_true(*infos[i].name && *infos[i].type && infos[i].limits.maxImageDimension2D >= 4096);
        assert_true(infos[i].usable == (*infos[i].missing == '\0'));
        assert_true(infos[i].device_memory + infos[i].host_memory > 0);
    }
    free(infos);
}

// Every usable device answers to its index and to its name in any case.
static void test_choice(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu_info *infos;
    uint32_t count;
    assert_int_equal(ng_gpu_list(&infos, &count), NG_OK);
    for (uint32_t i = 0; i < count; i++) {
        if (!infos[i].usable)
            continue;
        char index[16], name[sizeof infos[i].name];
        snprintf(index, sizeof index, "%u", i);
        for (size_t c = 0; c < sizeof name; c++)
            name[c] = (char)(infos[i].name[c] >= 'a' && infos[i].name[c] <= 'z' ? infos[i].name[c] - 32
                                                                                : infos[i].name[c]);
        const char *wishes[] = {index, name};
        for (int w = 0; w < 2; w++) {
            struct ng_gpu *gpu = gpu_test_create((struct ng_gpu_params){.device = wishes[w]});
            assert_string_equal(gpu->properties.deviceName, infos[i].name);
            gpu_test_end(gpu);
        }
    }
    free(infos);
}

static void expect_failure(const char *device, ng_result expected, const char *message)
{
    struct test_log log;
    struct ng_gpu *gpu;
    test_log_begin(&log);
    assert_int_equal(ng_gpu_create(&(struct ng_gpu_params){.device = device}, &gpu), expected);
    test_log_end(&log);
    assert_null(gpu);
    assert_int_equal(log.errors, 1);
    assert_non_null(strstr(log.text, message));
}

static void test_unknown_device(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu_info *infos;
    uint32_t count;
    assert_int_equal(ng_gpu_list(&infos, &count), NG_OK);
    expect_failure("Voodoo2", NG_ERROR_NOT_FOUND, "no usable device matches 'Voodoo2'");
    expect_failure("Voodoo2", NG_ERROR_NOT_FOUND, infos[0].name); // and what there is
    expect_failure("99", NG_ERROR_NOT_FOUND, "'99'");
    free(infos);
    const char *old = getenv("NG_DEVICE");
    char *kept = old ? strdup(old) : NULL;
    setenv("NG_DEVICE", "from the environment", 1);
    expect_failure(NULL, NG_ERROR_NOT_FOUND, "'from the environment'");
    expect_failure("the argument wins", NG_ERROR_NOT_FOUND, "'the argument wins'");
    if (kept)
        setenv("NG_DEVICE", kept, 1);
    else
        unsetenv("NG_DEVICE");
    free(kept);
}

static void test_no_driver(void **state)
{
    NG_UNUSED(state);
    setenv("VK_ICD_FILENAMES", "/nonexistent.json", 1);
    setenv("VK_DRIVER_FILES", "/nonexistent.json", 1);
    expect_failure(NULL, NG_ERROR_DEVICE, "mesa-vulkan-drivers");
    struct test_log log;
    struct ng_gpu_info *infos;
    uint32_t count;
    test_log_begin(&log);
    assert_int_equal(ng_gpu_list(&infos, &count), NG_ERROR_DEVICE);
    test_log_end(&log);
    assert_null(infos);
    assert_int_equal(count, 0);
    assert_int_equal(log.errors, 1);
    unsetenv("VK_ICD_FILENAMES");
    unsetenv("VK_DRIVER_FILES");
}

static void test_missing_window_extension(void **state)
{
    NG_UNUSED(state);
    struct test_log log;
    struct ng_gpu *gpu;
    const char *extension = "VK_KHR_no_such_surface";
    struct ng_gpu_params params = {.instance_extensions = &extension, .instance_extension_count = 1};
    test_log_begin(&log);
    assert_int_equal(ng_gpu_create(&params, &gpu), NG_ERROR_DEVICE);
    test_log_end(&log);
    assert_int_equal(log.errors, 1);
    assert_non_null(strstr(log.text, extension));
}

// The layer must be heard, or every other test here proves nothing.
static void test_validation_is_heard(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    if (gpu->validation) {
        struct test_log log;
        VkBuffer buffer = VK_NULL_HANDLE;
        VkBufferCreateInfo wrong = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = 0};
        test_log_begin(&log);
        if (vkCreateBuffer(gpu->device, &wrong, NULL, &buffer) == VK_SUCCESS)
            vkDestroyBuffer(gpu->device, buffer, NULL);
        test_log_end(&log);
        assert_true(ng_gpu_validation_messages(gpu) > 0);
        assert_int_equal(ng_gpu_validation_messages(gpu), log.errors);
    }
    ng_gpu_destroy(&gpu);
    assert_null(gpu);
    ng_gpu_destroy(&gpu); // null is fine
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_list),
        cmocka_unit_test(test_choice),
        cmocka_unit_test(test_unknown_device),
        cmocka_unit_test(test_no_driver),
        cmocka_unit_test(test_missing_window_extension),
        cmocka_unit_test(test_validation_is_heard),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

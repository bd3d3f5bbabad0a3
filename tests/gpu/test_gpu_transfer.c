// Bytes that go to the device and come back are the same bytes.
#include "gpu_test.h"

#include "base/rng.h"
#include "gpu/transfer.h"

static unsigned char *random_bytes(size_t size, uint64_t seed)
{
    unsigned char *bytes = malloc(size);
    struct ng_rng rng = ng_rng_make(seed, 1);
    assert_non_null(bytes);
    for (size_t i = 0; i < size; i++)
        bytes[i] = (unsigned char)ng_rng_u32(&rng);
    return bytes;
}

static void expect_bytes(struct ng_gpu_buffer *b, uint64_t offset, const unsigned char *expected, size_t size)
{
    unsigned char *back = malloc(size);
    assert_non_null(back);
    assert_int_equal(ng_readback_buffer(b, offset, back, size), NG_OK);
    assert_memory_equal(back, expected, size);
    free(back);
}

static void test_buffers(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    const size_t sizes[] = {1, 7, 4096, (5 << 20) + 3, (20 << 20) + 1}; // within staging, and beyond it
    for (size_t s = 0; s < NG_COUNT(sizes); s++)
        for (int kind = 0; kind < 3; kind++) {
            struct ng_gpu_buffer *b = gpu_test_buffer(gpu, sizes[s] + 13, (enum ng_gpu_memory_kind)kind);
            unsigned char *bytes = random_bytes(sizes[s], s);
            assert_int_equal(ng_upload_buffer(b, 13, bytes, sizes[s]), NG_OK);
            expect_bytes(b, 13, bytes, sizes[s]);
            free(bytes);
            ng_gpu_buffer_destroy(&b);
        }
    gpu_test_end(gpu);
}

// More than all staging buffers hold, without waiting in between; the later upload wins.
static void test_many_uploads(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    enum { PIECE = 1000000, COUNT = 60 };
    struct ng_gpu_buffer *b = gpu_test_buffer(gpu, (uint64_t)PIECE * COUNT, NG_GPU_MEMORY_DEVICE);
    unsigned char *bytes = random_bytes(PIECE + COUNT, 3);
    for (size_t i = 0; i < COUNT; i++) {
        assert_int_equal(ng_upload_buffer(b, PIECE * i, bytes, PIECE), NG_OK);
        assert_int_equal(ng_upload_buffer(b, PIECE * i, bytes + i, PIECE), NG_OK);
    }
    for (size_t i = 0; i < COUNT; i++)
        expect_bytes(b, PIECE * i, bytes + i, PIECE);
    free(bytes);
    ng_gpu_buffer_destroy(&b);
    assert_int_equal(ng_gpu_wait_idle(gpu), NG_OK);
    assert_true(ng_gpu_stats(gpu).memory_used < (64u << 20)); // staging stays bounded
    gpu_test_end(gpu);
}

// An upload made while a frame is recorded is seen by that frame, and a readback within it does not disturb
// it.
static void test_within_a_frame(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    struct ng_gpu_buffer *a = gpu_test_buffer(gpu, 256, NG_GPU_MEMORY_DEVICE);
    struct ng_gpu_buffer *b = gpu_test_buffer(gpu, 256, NG_GPU_MEMORY_DEVICE);
    struct ng_gpu_buffer *gone = gpu_test_buffer(gpu, 256, NG_GPU_MEMORY_DEVICE);
    unsigned char *bytes = random_bytes(256, 5);
    struct ng_cmd *cmd;
    assert_int_equal(ng_frame_begin(gpu, &cmd), NG_OK);
    assert_int_equal(ng_upload_buffer(a, 0, bytes, 256), NG_OK);
    vkCmdCopyBuffer(cmd->handle, a->handle, b->handle, 1, &(VkBufferCopy){.size = 256});
    vkCmdFillBuffer(cmd->handle, gone->handle, 0, 256, 1);
    ng_gpu_buffer_destroy(&gone); // its last use is in the open frame, which the readback must not forget
    expect_bytes(a, 0, bytes, 256);
    assert_true(ng_gpu_stats(gpu).waiting > 0);
    assert_int_equal(ng_frame_end(gpu, &cmd), NG_OK);
    assert_null(cmd);
    expect_bytes(b, 0, bytes, 256);
    free(bytes);
    ng_gpu_buffer_destroy(&a);
    ng_gpu_buffer_destroy(&b);
    gpu_test_end(gpu);
}

static void round_trip(struct ng_gpu *gpu, struct ng_gpu_image_params params)
{
    struct ng_gpu_image *image;
    params.name = "picture";
    assert_int_equal(ng_gpu_image_create(gpu, &params, &image), NG_OK);
    uint64_t size = ng_transfer_image_size(image, 0, 0, 0, 0);
    unsigned char *bytes = random_bytes(size, params.width), *back = calloc(1, size);
    if (params.format == VK_FORMAT_D32_SFLOAT) // depths, not any bits
        for (size_t i = 0; i < size / 4; i++)
            ((float *)(void *)bytes)[i] = (float)(i % 1000) / 1000;
    assert_non_null(back);
    struct ng_upload_image_params up = {.data = bytes, .size = size};
    assert_int_equal(ng_upload_image(image, &up), NG_OK);
    struct ng_readback_image_params down = {
        .layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, .out = back, .size = size};
    assert_int_equal(ng_readback_image(image, &down), NG_OK);
    assert_memory_equal(back, bytes, size);
    // The last level of the last layer alone.
    down.mip = image->mips - 1;
    down.layer = image->layers - 1;
    down.size = ng_transfer_image_size(image, down.mip, 1, down.layer, 1);
    assert_int_equal(ng_readback_image(image, &down), NG_OK);
    assert_memory_equal(back, bytes + size - down.size, down.size);
    free(bytes);
    free(back);
    ng_gpu_image_destroy(&image);
}

static void test_images(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    round_trip(gpu, (struct ng_gpu_image_params){.width = 1, .height = 1, .format = VK_FORMAT_R8_UNORM});
    round_trip(gpu, (struct ng_gpu_image_params){
                        .width = 100, .height = 37, .mips = 7, .format = VK_FORMAT_R8G8B8A8_SRGB});
    round_trip(gpu, (struct ng_gpu_image_params){.width = 64,
                                                 .height = 64,
                                                 .mips = 3,
                                                 .layers = 12,
                                                 .cube = true,
                                                 .format = VK_FORMAT_R16G16B16A16_SFLOAT});
    round_trip(gpu, (struct ng_gpu_image_params){
                        .width = 33, .height = 17, .layers = 3, .format = VK_FORMAT_R32G32B32A32_SFLOAT});
    round_trip(gpu, (struct ng_gpu_image_params){
                        .width = 9, .height = 8, .depth = 7, .mips = 2, .format = VK_FORMAT_R32_UINT});
    round_trip(gpu, (struct ng_gpu_image_params){.width = 65, .height = 31, .format = VK_FORMAT_D32_SFLOAT});
    round_trip(gpu, (struct ng_gpu_image_params){// larger than a staging buffer
                                                 .width = 2048,
                                                 .height = 1500,
                                                 .mips = 2,
                                                 .format = VK_FORMAT_R8G8B8A8_UNORM});
    gpu_test_end(gpu);
}

static void test_views(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    struct ng_gpu_image_params params = {.name = "cube",
                                         .width = 16,
                                         .height = 16,
                                         .layers = 6,
                                         .mips = 3,
                                         .cube = true,
                                         .format = VK_FORMAT_D32_SFLOAT,
                                         .usage = VK_IMAGE_USAGE_SAMPLED_BIT |
                                                  VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT};
    struct ng_gpu_image *image;
    assert_int_equal(ng_gpu_image_create(gpu, &params, &image), NG_OK);
    struct ng_gpu_view_params face = {.layer = 4, .layers = 1, .mips = 1};
    VkImageView view = ng_gpu_image_view(image, &face);
    assert_non_null(view);
    assert_true(view != image->view);
    assert_true(view == ng_gpu_image_view(image, &face)); // kept, not made again
    face.mip = 1;
    assert_true(view != ng_gpu_image_view(image, &face));
    assert_true(ng_gpu_image_view(image, NULL) == image->view);
    assert_true(ng_gpu_image_view(image, &(struct ng_gpu_view_params){0}) == image->view);
    struct test_log log;
    test_log_begin(&log);
    face.mip = 3;
    assert_null(ng_gpu_image_view(image, &face));
    face.mip = 0, face.layer = 5, face.layers = 2;
    assert_null(ng_gpu_image_view(image, &face));
    test_log_end(&log);
    assert_int_equal(log.errors, 2);
    assert_non_null(strstr(log.text, "'cube'"));
    ng_gpu_image_destroy(&image);
    struct ng_gpu_sampler_params linear = {
        .mag_filter = VK_FILTER_LINEAR, .min_filter = VK_FILTER_LINEAR, .anisotropy = 1000};
    VkSampler sampler = ng_gpu_sampler(gpu, &linear);
    assert_non_null(sampler);
    assert_true(sampler == ng_gpu_sampler(gpu, &linear));
    linear.compare = true;
    assert_true(sampler != ng_gpu_sampler(gpu, &linear));
    assert_int_equal(ng_gpu_stats(gpu).samplers, 2);
    gpu_test_end(gpu);
}

// What no device has is refused with the image's name, not handed to the driver.
static void test_refusals(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    struct test_log log;
    struct ng_gpu_image *image;
    struct ng_gpu_image_params big = {
        .name = "gigapixel", .width = 1u << 20, .height = 1u << 20, .format = VK_FORMAT_R8G8B8A8_UNORM};
    test_log_begin(&log);
    assert_int_equal(ng_gpu_image_create(gpu, &big, &image), NG_ERROR_UNSUPPORTED);
    assert_null(image);
    big = (struct ng_gpu_image_params){.name = "odd", .width = 4, .height = 4};
    big.format = VK_FORMAT_R64G64B64A64_SFLOAT;
    big.usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
    assert_int_equal(ng_gpu_image_create(gpu, &big, &image), NG_ERROR_UNSUPPORTED);
    big = (struct ng_gpu_image_params){.name = "flat", .width = 4, .format = VK_FORMAT_R8G8B8A8_UNORM};
    assert_int_equal(ng_gpu_image_create(gpu, &big, &image), NG_ERROR_USAGE);
    test_log_end(&log);
    assert_int_equal(log.errors, 3);
    assert_non_null(strstr(log.text, "'gigapixel' of 1048576x1048576"));
    assert_non_null(strstr(log.text, "'odd'"));
    assert_non_null(strstr(log.text, "'flat'"));
    gpu_test_end(gpu);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_buffers),        cmocka_unit_test(test_many_uploads),
        cmocka_unit_test(test_within_a_frame), cmocka_unit_test(test_images),
        cmocka_unit_test(test_views),          cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

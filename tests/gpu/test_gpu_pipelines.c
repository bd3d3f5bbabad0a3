// Shaders compute what C computes, triangles land on the pixels they should, and wrong bindings are refused.
// Everything twice: with push descriptors and with descriptor pools, as drivers without them need.
#include "gpu_test.h"

#include "copy.comp.spv.h"
#include "double.comp.spv.h"
#include "fill.frag.spv.h"
#include "fill.vert.spv.h"
#include "gpu/transfer.h"
#include "test_gpu_shared.h"
#include "triangle.frag.spv.h"
#include "triangle.vert.spv.h"

enum { SIZE = 32 };

static struct ng_gpu_image *make_image(struct ng_gpu *gpu, VkFormat format, VkImageUsageFlags usage)
{
    struct ng_gpu_image *i;
    struct ng_gpu_image_params params = {
        .name = "image", .width = SIZE, .height = SIZE, .format = format, .usage = usage};
    assert_int_equal(ng_gpu_image_create(gpu, &params, &i), NG_OK);
    return i;
}

// ---- Compute ---------------------------------------------------------------------------------------------

static void compute(struct ng_gpu *gpu)
{
    enum { COUNT = 1000, ROUNDS = 300 }; // more binds than one descriptor pool serves
    struct ng_gpu_pipeline *pipeline = gpu_test_map(gpu, "double", NG_SPIRV(ng_spv_double_comp), 8);
    struct ng_gpu_buffer *source = gpu_test_buffer(gpu, COUNT * 4, NG_GPU_MEMORY_DEVICE);
    struct ng_gpu_buffer *target = gpu_test_buffer(gpu, (uint64_t)ROUNDS * 4096, NG_GPU_MEMORY_READBACK);
    uint32_t in[COUNT];
    for (uint32_t i = 0; i < COUNT; i++)
        in[i] = i * 7919;
    assert_int_equal(ng_upload_buffer(source, 0, in, sizeof in), NG_OK);
    struct ng_cmd *cmd;
    assert_int_equal(ng_immediate_begin(gpu, &cmd), NG_OK);
    for (uint32_t round = 0; round < ROUNDS; round++) {
        const struct ng_gpu_binding bindings[] = {
            {.binding = 1, .buffer = target, .offset = round * 4096ull, .range = 4096},
            {.binding = 0, .buffer = source}};
        uint32_t push[2] = {COUNT, round};
        assert_int_equal(ng_cmd_bind(cmd, pipeline, bindings, 2), NG_OK);
        ng_cmd_push(cmd, pipeline, push, sizeof push);
        ng_cmd_dispatch_over(cmd, (uint32_t[]){COUNT, 1, 1}, (uint32_t[]){64, 1, 1});
    }
    assert_int_equal(ng_immediate_end(gpu, &cmd), NG_OK);
    const uint32_t *out = target->mapped;
    for (uint32_t round = 0; round < ROUNDS; round++)
        for (uint32_t i = 0; i < COUNT; i++)
            if (out[round * 1024 + i] != test_mix(in[i], round))
                fail_msg("round %u, element %u: %u", round, i, out[round * 1024 + i]);
    ng_gpu_buffer_destroy(&source);
    ng_gpu_buffer_destroy(&target);
    ng_gpu_pipeline_destroy(&pipeline);
}

static void test_compute(void **state)
{
    NG_UNUSED(state);
    for (int pools = 0; pools < 2; pools++) {
        struct ng_gpu *gpu = gpu_test_create((struct ng_gpu_params){.no_push_descriptors = pools});
        compute(gpu);
        gpu_test_end(gpu);
    }
}

static void test_wrong_bindings(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    struct ng_gpu_pipeline *p = gpu_test_map(gpu, "double", NG_SPIRV(ng_spv_double_comp), 8);
    struct ng_gpu_buffer *b = gpu_test_buffer(gpu, 64, NG_GPU_MEMORY_DEVICE);
    struct ng_cmd *cmd;
    struct test_log log;
    const struct ng_gpu_binding good = {.binding = 0, .buffer = b};
    const struct ng_gpu_binding wrong[][2] = {
        {good, {.binding = 2, .buffer = b}},                       // no such slot
        {good, {.binding = 0, .buffer = b}},                       // twice
        {good, {.binding = 1, .view = (VkImageView)(uintptr_t)8}}, // not a buffer
        {good, {.binding = 1, .buffer = b, .offset = 64}},         // behind its end
        {good, {.binding = 1, .buffer = b, .offset = 32, .range = 33}},
        {good, {.binding = 1, .element = 1, .buffer = b}}, // not an array
    };
    assert_int_equal(ng_immediate_begin(gpu, &cmd), NG_OK);
    test_log_begin(&log);
    for (size_t i = 0; i < NG_COUNT(wrong); i++)
        assert_int_equal(ng_cmd_bind(cmd, p, wrong[i], 2), NG_ERROR_USAGE);
    assert_int_equal(ng_cmd_bind(cmd, p, &good, 1), NG_ERROR_USAGE); // one is missing
    test_log_end(&log);
    assert_int_equal(log.errors, NG_COUNT(wrong) + 1);
    assert_non_null(strstr(log.text, "'double'"));
    assert_int_equal(ng_immediate_end(gpu, &cmd), NG_OK);
    ng_gpu_buffer_destroy(&b);
    ng_gpu_pipeline_destroy(&p);
    gpu_test_end(gpu);
}

// ---- Drawing ---------------------------------------------------------------------------------------------

static const VkImageUsageFlags target_usage =
    VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;

static struct ng_gpu_pipeline *make_triangle(struct ng_gpu *gpu)
{
    const struct ng_gpu_slot slots[] = {
        {.set = 1, .binding = 0, .type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
        {.set = 0, .binding = 0, .type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER},
    };
    struct ng_gpu_graphics_params params = {.name = "triangle",
                                            .vertex = NG_SPIRV(ng_spv_triangle_vert),
                                            .fragment = NG_SPIRV(ng_spv_triangle_frag),
                                            .slots = slots,
                                            .slot_count = 2,
                                            .push_size = 4,
                                            .color_formats = {VK_FORMAT_R32G32B32A32_SFLOAT},
                                            .color_count = 1,
                                            .depth_format = VK_FORMAT_D32_SFLOAT,
                                            .depth_test = true,
                                            .depth_write = true};
    struct ng_gpu_pipeline *p;
    assert_int_equal(ng_gpu_graphics_create(gpu, &params, &p), NG_OK);
    return p;
}

// A red 1x1 picture, and the group that shows it to the triangle's pipeline.
static struct ng_gpu_image *make_picture(struct ng_gpu *gpu)
{
    struct ng_gpu_image *picture;
    struct ng_gpu_image_params params = {
        .name = "red", .width = 1, .height = 1, .format = VK_FORMAT_R8G8B8A8_UNORM};
    assert_int_equal(ng_gpu_image_create(gpu, &params, &picture), NG_OK);
    struct ng_upload_image_params up = {.data = (const unsigned char[]){255, 0, 0, 255}, .size = 4};
    assert_int_equal(ng_upload_image(picture, &up), NG_OK);
    return picture;
}

static void draw_tinted(struct ng_cmd *cmd, const struct ng_gpu_pipeline *p,
                        const struct ng_gpu_bind_group *group, float tint, float depth)
{
    struct ng_frame_range frame;
    assert_int_equal(ng_frame_alloc(cmd->gpu, 16, &frame), NG_OK);
    memcpy(frame.mapped, (float[]){tint, tint, tint, 1}, 16);
    struct ng_gpu_binding binding = {
        .binding = 0, .buffer = frame.buffer, .offset = frame.offset, .range = 16};
    assert_int_equal(ng_cmd_bind(cmd, p, &binding, 1), NG_OK);
    ng_cmd_bind_group(cmd, p, group);
    ng_cmd_push(cmd, p, &depth, 4);
    vkCmdDraw(cmd->handle, 3, 1, 0, 0);
}

static void draw(struct ng_gpu *gpu)
{
    struct ng_gpu_pipeline *p = make_triangle(gpu);
    struct ng_gpu_image *color = make_image(gpu, VK_FORMAT_R32G32B32A32_SFLOAT, target_usage);
    struct ng_gpu_image *depth =
        make_image(gpu, VK_FORMAT_D32_SFLOAT, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
    struct ng_gpu_image *picture = make_picture(gpu);
    struct ng_gpu_bind_group *group;
    struct ng_gpu_binding texture = {.binding = 0,
                                     .view = picture->view,
                                     .sampler = ng_gpu_sampler(gpu, &(struct ng_gpu_sampler_params){0})};
    assert_int_equal(ng_gpu_bind_group_create(gpu, "material", p, 1, &texture, 1, &group), NG_OK);
    struct ng_cmd *cmd;
    assert_int_equal(ng_frame_begin(gpu, &cmd), NG_OK);
    ng_cmd_label_begin(cmd, "triangle");
    gpu_test_barrier(cmd, color, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    gpu_test_barrier(cmd, depth, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL);
    struct ng_gpu_rendering_params rendering = {
        .width = SIZE,
        .height = SIZE,
        .color = {{.view = color->view, .clear.color.float32 = {0.125f, 0.25f, 0.5f, 0}}},
        .color_count = 1,
        .depth = {.view = depth->view, .discard = true, .clear.depthStencil.depth = 0}};
    ng_cmd_rendering_begin(cmd, &rendering);
    draw_tinted(cmd, p, group, 0.5f, 0.5f);
    draw_tinted(cmd, p, group, 0.75f, 0.25f); // farther, in reverse-Z: hidden
    ng_cmd_rendering_end(cmd);
    ng_cmd_label_end(cmd);
    assert_int_equal(ng_frame_end(gpu, &cmd), NG_OK);
    static float pixels[SIZE][SIZE][4];
    struct ng_readback_image_params down = {
        .layout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, .out = pixels, .size = sizeof pixels};
    assert_int_equal(ng_readback_image(color, &down), NG_OK);
    for (int y = 0; y < SIZE; y++)
        for (int x = 0; x < SIZE; x++) {
            bool inside = x + y < SIZE - 1, edge = x + y == SIZE - 1;
            const float in[4] = {0.5f, 0, 0, 1}, out[4] = {0.125f, 0.25f, 0.5f, 0};
            if (!edge)
                assert_memory_equal(pixels[y][x], inside ? in : out, 16);
        }
    ng_gpu_bind_group_destroy(&group);
    ng_gpu_image_destroy(&picture);
    ng_gpu_image_destroy(&depth);
    ng_gpu_image_destroy(&color);
    ng_gpu_pipeline_destroy(&p);
}

static void test_draw(void **state)
{
    NG_UNUSED(state);
    for (int pools = 0; pools < 2; pools++) {
        struct ng_gpu *gpu = gpu_test_create((struct ng_gpu_params){.no_push_descriptors = pools});
        draw(gpu);
        gpu_test_end(gpu);
    }
}

// Vertex buffers, culling by the stated winding, and attachments that are kept.
static void test_vertex_buffer_and_culling(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    const struct ng_gpu_vertex_binding stream = {.stride = 28};
    const struct ng_gpu_vertex_attribute attributes[] = {
        {.location = 0, .format = VK_FORMAT_R32G32B32_SFLOAT},
        {.location = 1, .format = VK_FORMAT_R32G32B32A32_SFLOAT, .offset = 12}};
    struct ng_gpu_graphics_params params = {.name = "fill",
                                            .vertex = NG_SPIRV(ng_spv_fill_vert),
                                            .fragment = NG_SPIRV(ng_spv_fill_frag),
                                            .vertex_bindings = &stream,
                                            .vertex_binding_count = 1,
                                            .vertex_attributes = attributes,
                                            .vertex_attribute_count = 2,
                                            .cull = VK_CULL_MODE_BACK_BIT,
                                            .color_formats = {VK_FORMAT_R32G32B32A32_SFLOAT},
                                            .color_count = 1};
    struct ng_gpu_pipeline *p;
    assert_int_equal(ng_gpu_graphics_create(gpu, &params, &p), NG_OK);
    // Two triangles that cover everything: the first clockwise on screen, the second counter-clockwise.
    const float vertices[6][7] = {{-1, -1, 0, 1, 0, 0, 1}, {3, -1, 0, 1, 0, 0, 1}, {-1, 3, 0, 1, 0, 0, 1},
                                  {-1, -1, 0, 0, 1, 0, 1}, {-1, 3, 0, 0, 1, 0, 1}, {3, -1, 0, 0, 1, 0, 1}};
    struct ng_gpu_buffer *buffer = gpu_test_buffer(gpu, sizeof vertices, NG_GPU_MEMORY_DEVICE);
    assert_int_equal(ng_upload_buffer(buffer, 0, vertices, sizeof vertices), NG_OK);
    struct ng_gpu_image *color = make_image(gpu, VK_FORMAT_R32G32B32A32_SFLOAT, target_usage);
    for (uint32_t first = 0; first < 2; first++) {
        struct ng_cmd *cmd;
        assert_int_equal(ng_immediate_begin(gpu, &cmd), NG_OK);
        gpu_test_barrier(cmd, color,
                         first ? VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL : VK_IMAGE_LAYOUT_UNDEFINED,
                         VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
        ng_cmd_rendering_begin(
            cmd, &(struct ng_gpu_rendering_params){.width = SIZE,
                                                   .height = SIZE,
                                                   .color = {{.view = color->view, .load = first > 0}},
                                                   .color_count = 1});
        assert_int_equal(ng_cmd_bind(cmd, p, NULL, 0), NG_OK);
        vkCmdBindVertexBuffers(cmd->handle, 0, 1, &buffer->handle, &(VkDeviceSize){0});
        vkCmdDraw(cmd->handle, 3, 1, first ? 0 : 3,
                  0); // the clockwise one last: culled, the old picture stays
        ng_cmd_rendering_end(cmd);
        assert_int_equal(ng_immediate_end(gpu, &cmd), NG_OK);
        static float pixels[SIZE][SIZE][4];
        struct ng_readback_image_params down = {
            .layout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, .out = pixels, .size = sizeof pixels};
        assert_int_equal(ng_readback_image(color, &down), NG_OK);
        for (int i = 0; i < SIZE * SIZE; i++)
            assert_memory_equal(pixels[i / SIZE][i % SIZE], ((float[]){0, 1, 0, 1}), 16);
    }
    ng_gpu_image_destroy(&color);
    ng_gpu_buffer_destroy(&buffer);
    ng_gpu_pipeline_destroy(&p);
    gpu_test_end(gpu);
}

static void test_wrong_declarations(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    struct ng_gpu_pipeline *p;
    struct test_log log;
    const struct ng_gpu_slot twice[] = {{.binding = 3, .type = VK_DESCRIPTOR_TYPE_SAMPLER},
                                        {.binding = 3, .type = VK_DESCRIPTOR_TYPE_SAMPLER}};
    struct ng_gpu_compute_params params = {.name = "wrong", .shader = NG_SPIRV(ng_spv_double_comp)};
    test_log_begin(&log);
    params.slots = twice, params.slot_count = 2;
    assert_int_equal(ng_gpu_compute_create(gpu, &params, &p), NG_ERROR_USAGE);
    params.slot_count = 0, params.push_size = 129;
    assert_int_equal(ng_gpu_compute_create(gpu, &params, &p), NG_ERROR_USAGE);
    params.push_size = 0, params.shader = (struct ng_spirv){(const uint32_t[]){1, 2, 3, 4, 5}, 20, NULL};
    assert_int_equal(ng_gpu_compute_create(gpu, &params, &p), NG_ERROR_USAGE);
    test_log_end(&log);
    assert_null(p);
    assert_int_equal(log.errors, 3);
    gpu_test_end(gpu);
}

// ---- Replaced shaders ------------------------------------------------------------------------------------

static uint32_t compute_one(struct ng_gpu *gpu, const struct ng_gpu_pipeline *pipeline)
{
    struct ng_gpu_buffer *source = gpu_test_buffer(gpu, 4, NG_GPU_MEMORY_DEVICE);
    struct ng_gpu_buffer *target = gpu_test_buffer(gpu, 4, NG_GPU_MEMORY_READBACK);
    const struct ng_gpu_binding bindings[] = {{.binding = 0, .buffer = source},
                                              {.binding = 1, .buffer = target}};
    const uint32_t in = 7919, push[2] = {1, 3};
    struct ng_cmd *cmd;
    assert_int_equal(ng_upload_buffer(source, 0, &in, sizeof in), NG_OK);
    assert_int_equal(ng_immediate_begin(gpu, &cmd), NG_OK);
    assert_int_equal(ng_cmd_bind(cmd, pipeline, bindings, 2), NG_OK);
    ng_cmd_push(cmd, pipeline, push, sizeof push);
    vkCmdDispatch(cmd->handle, 1, 1, 1);
    assert_int_equal(ng_immediate_end(gpu, &cmd), NG_OK);
    uint32_t out = *(const uint32_t *)target->mapped;
    ng_gpu_buffer_destroy(&source);
    ng_gpu_buffer_destroy(&target);
    return out;
}

// Another shader under the name of the first, and back. Each allocation fails once: all is as it was then.
static void test_replaced(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    struct ng_gpu_pipeline *pipeline = gpu_test_map(gpu, "double", NG_SPIRV(ng_spv_double_comp), 8);
    const struct ng_spirv first = NG_SPIRV(ng_spv_double_comp);
    const struct ng_spirv second = {ng_spv_copy_comp, sizeof ng_spv_copy_comp, first.name};
    ng_result result = NG_ERROR_MEMORY;
    assert_int_equal(gpu->shaders, 0);
    for (uint32_t n = 1; result != NG_OK; n++) {
        struct test_log log;
        ng_gpu_inject_faults(gpu, &(struct ng_gpu_faults){.fail_allocation = n});
        test_log_begin(&log);
        result = ng_gpu_replace_shaders(gpu, &second, 1);
        test_log_end(&log);
        ng_gpu_inject_faults(gpu, &(struct ng_gpu_faults){0});
        assert_int_equal(log.errors, result != NG_OK);
        assert_true((gpu->shaders != 0) == (result == NG_OK));
        assert_int_equal(compute_one(gpu, pipeline), result == NG_OK ? 7919 : test_mix(7919, 3));
    }
    uint64_t key = gpu->shaders;
    struct ng_gpu_pipeline *later = gpu_test_map(gpu, "later", first, 8);
    assert_int_equal(compute_one(gpu, later), 7919);
    assert_int_equal(ng_gpu_replace_shaders(gpu, (struct ng_spirv[]){second, first}, 2),
                     NG_OK); // the last holds
    assert_int_equal(compute_one(gpu, later), test_mix(7919, 3));
    assert_true(gpu->shaders != key);
    assert_int_equal(ng_gpu_replace_shaders(gpu, &second, 1), NG_OK);
    assert_true(gpu->shaders == key); // the same content
    ng_gpu_pipeline_destroy(&pipeline);
    ng_gpu_pipeline_destroy(&later);
    gpu_test_end(gpu);
}

static void test_code_that_cannot_replace(void **state)
{
    NG_UNUSED(state);
    struct ng_gpu *gpu = gpu_test_begin();
    struct ng_gpu_pipeline *pipeline = gpu_test_map(gpu, "double", NG_SPIRV(ng_spv_double_comp), 8);
    const struct ng_spirv good = NG_SPIRV(ng_spv_double_comp);
    static uint32_t broken[NG_COUNT(ng_spv_double_comp)];
    memcpy(broken, ng_spv_double_comp, sizeof broken);
    broken[5] &= 0xffff; // an instruction without length
    const struct ng_spirv wrong[] = {
        {good.words, 8, good.name},                                     // no whole header
        {good.words, good.size - 4, good.name},                         // cut
        {good.words, good.size - 2, good.name},                         // in a word
        {broken, sizeof broken, good.name},                             //
        {good.words + 1, good.size - 4, good.name},                     // no SPIR-V
        {good.words, good.size, NULL},                                  // nobody's
        {ng_spv_triangle_frag, sizeof ng_spv_triangle_frag, good.name}, // binds something else
    };
    for (size_t i = 0; i < NG_COUNT(wrong); i++) {
        struct test_log log;
        test_log_begin(&log);
        assert_int_equal(ng_gpu_replace_shaders(gpu, (struct ng_spirv[]){good, wrong[i]}, 2), NG_ERROR_USAGE);
        test_log_end(&log);
        assert_int_equal(log.errors, 1);
        assert_int_equal(gpu->shaders, 0);
        assert_int_equal(compute_one(gpu, pipeline), test_mix(7919, 3));
    }
    ng_gpu_pipeline_destroy(&pipeline);
    gpu_test_end(gpu);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_compute),
        cmocka_unit_test(test_wrong_bindings),
        cmocka_unit_test(test_draw),
        cmocka_unit_test(test_vertex_buffer_and_culling),
        cmocka_unit_test(test_wrong_declarations),
        cmocka_unit_test(test_replaced),
        cmocka_unit_test(test_code_that_cannot_replace),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

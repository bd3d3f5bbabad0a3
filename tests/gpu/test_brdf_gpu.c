// The shared BRDF gives on the device what it gives in C.
#include "gpu_test.h"

#include "base/rng.h"
#include "brdf_probe.comp.spv.h"
#include "brdf_probe.h"
#include "gpu/frame.h"
#include "gpu/transfer.h"

enum { COUNT = 4096, OUTPUTS = sizeof(struct brdf_probe_out) / sizeof(float) };

static struct ng_gpu_buffer *make_buffer(struct ng_gpu *gpu, uint64_t size, enum ng_gpu_memory_kind kind)
{
    struct ng_gpu_buffer *b;
    struct ng_gpu_buffer_params params = {.name = "probe", .size = size, .memory = kind};
    assert_int_equal(ng_gpu_buffer_create(gpu, &params, &b), NG_OK);
    return b;
}

static void make_inputs(struct brdf_probe_in in[COUNT])
{
    struct ng_rng rng = ng_rng_make(1, 4);
    for (int i = 0; i < COUNT; i++)
        in[i] = (struct brdf_probe_in){.u1 = ng_rng_float(&rng),
                                       .u2 = ng_rng_float(&rng),
                                       .nv = ng_rng_range(&rng, 0.05f, 1),
                                       .roughness = ng_rng_range(&rng, 0.15f, 1.1f),
                                       .f0 = ng_rng_float(&rng),
                                       .albedo = ng_rng_float(&rng)};
}

static void run_probe(struct ng_gpu *gpu, const struct brdf_probe_in *in, struct brdf_probe_out *out)
{
    const struct ng_gpu_slot slots[] = {{.binding = 0, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
                                        {.binding = 1, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}};
    const struct ng_gpu_compute_params params = {.name = "brdf probe",
                                                 .shader = NG_SPIRV(ng_spv_brdf_probe_comp),
                                                 .slots = slots,
                                                 .slot_count = 2,
                                                 .push_size = 4};
    struct ng_gpu_pipeline *pipeline;
    assert_int_equal(ng_gpu_compute_create(gpu, &params, &pipeline), NG_OK);
    struct ng_gpu_buffer *source = make_buffer(gpu, COUNT * sizeof *in, NG_GPU_MEMORY_DEVICE);
    struct ng_gpu_buffer *target = make_buffer(gpu, COUNT * sizeof *out, NG_GPU_MEMORY_READBACK);
    assert_int_equal(ng_upload_buffer(source, 0, in, COUNT * sizeof *in), NG_OK);
    const struct ng_gpu_binding bindings[] = {{.binding = 0, .buffer = source},
                                              {.binding = 1, .buffer = target}};
    const uint32_t count = COUNT;
    struct ng_cmd *cmd;
    assert_int_equal(ng_immediate_begin(gpu, &cmd), NG_OK);
    assert_int_equal(ng_cmd_bind(cmd, pipeline, bindings, 2), NG_OK);
    ng_cmd_push(cmd, pipeline, &count, sizeof count);
    ng_cmd_dispatch_over(cmd, (uint32_t[]){COUNT, 1, 1}, (uint32_t[]){64, 1, 1});
    assert_int_equal(ng_immediate_end(gpu, &cmd), NG_OK);
    memcpy(out, target->mapped, COUNT * sizeof *out);
    ng_gpu_buffer_destroy(&source);
    ng_gpu_buffer_destroy(&target);
    ng_gpu_pipeline_destroy(&pipeline);
}

static void test_device_equals_c(void **state)
{
    NG_UNUSED(state);
    static struct brdf_probe_in in[COUNT];
    static struct brdf_probe_out out[COUNT];
    make_inputs(in);
    struct ng_gpu *gpu = gpu_test_begin();
    run_probe(gpu, in, out);
    gpu_test_end(gpu);
    for (int i = 0; i < COUNT; i++) {
        struct brdf_probe_out expected = brdf_probe(in[i]);
        const float *a = &out[i].hx, *b = &expected.hx;
        // Drivers may round sines, roots and products otherwise; D magnifies that near the peak of smooth
        // surfaces.
        for (int k = 0; k < OUTPUTS; k++)
            if (!(fabsf(a[k] - b[k]) <= 2e-3f * fabsf(b[k]) + 2e-4f))
                fail_msg("sample %d, output %d: %g on the device, %g in C", i, k, (double)a[k], (double)b[k]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_device_equals_c)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

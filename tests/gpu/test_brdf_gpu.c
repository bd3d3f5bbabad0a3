// The shared BRDF gives on the device what it gives in C.
#include "gpu_test.h"

#include "base/rng.h"
#include "brdf_probe.comp.spv.h"
#include "brdf_probe.h"
#include "gpu/transfer.h"

enum { COUNT = 4096, OUTPUTS = sizeof(struct brdf_probe_out) / sizeof(float) };

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
    struct ng_gpu_pipeline *pipeline = gpu_test_map(gpu, "brdf probe", NG_SPIRV(ng_spv_brdf_probe_comp), 4);
    struct ng_gpu_buffer *source = gpu_test_buffer(gpu, COUNT * sizeof *in, NG_GPU_MEMORY_DEVICE);
    struct ng_gpu_buffer *target = gpu_test_buffer(gpu, COUNT * sizeof *out, NG_GPU_MEMORY_READBACK);
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

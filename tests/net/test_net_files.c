// Networks that are none: each is refused with one line that says what is wrong. Mutations of a good one,
// checksum made right again, are refused or run; nothing crashes.
#include "test.h"

#include "made.h"

#include "base/file.h"
#include "base/rng.h"

#include <math.h>

static const struct {
    const char *find, *put, *says;
} wrong_programs[] = {
    {"\"op\":\"mean\"", "\"op\":\"median\"", "\"median\", which this program does not know"},
    {"\"vpl.offset\"", "\"vpl.offsets\"",
     "reads \"vpl.offsets\", which is neither an input nor made before it"},
    {"[\"z\",\"view", "[\"e\",\"view", "reads \"e\""},
    {"\"out\":\"b\"", "\"out\":\"a\"", "name is empty or taken"},
    {"\"out\":\"b\"", "\"out\":\"\"", "name is empty or taken"},
    {"\"out\":\"b\"", "\"out\":\"pixel.mask\"", "name is empty or taken"},
    {"\"out\":\"z\"", "\"out\":\"z\",\"out\":\"y\"", "has \"out\", which is unknown or there twice"},
    {"\"out\":\"z\"", "\"out\":\"z\",\"size\":3", "has \"size\", which is unknown or there twice"},
    {"\"out\":\"z\"", "\"out\":\"z\",\"heads\":3", "has \"heads\", which it does not take"},
    {",\"from\":1", "", "lacks \"from\""},
    {"\"from\":1", "\"from\":4", "takes channels 4 to 4 of 4"},
    {"\"to\":4", "\"to\":5", "takes channels 1 to 5 of 4"},
    {"\"from\":1", "\"from\":-1", "not a JSON array"},
    {"[\"a\"]", "[\"a\",\"z\"]", "reads"},
    {"[\"vpl.offset\",", "[\"vpl.offset\",\"texel.offset\",", "of a domain that it does not meet"},
    {"[\"vpl.offset\",", "[\"vpl.offset\",\"light.share\",", "rows of what only the gather knows"},
    {"{\"op\":\"mean\",\"in\":[\"a\"]", "{\"op\":\"mean\",\"in\":[\"light.color\"]", "which has no rows"},
    {"\"in\":[\"c\"]", "\"in\":[\"c\",\"b\"]", "of level 0 beside level 1"},
    {"{\"op\":\"up\",\"in\":[\"d\"]", "{\"op\":\"up\",\"in\":[\"b\"]", "leaves the levels"},
    {"{\"op\":\"up\",\"in\":[\"d\"]", "{\"op\":\"unpack\",\"in\":[\"c\"]", "not a multiple of 4"},
    {"{\"op\":\"pool\",\"in\":[\"b\"]", "{\"op\":\"pool\",\"in\":[\"z\"]", "which is not a picture"},
    {"\"in\":[\"f\",\"light.share\"]", "\"in\":[\"f\",\"light.color\"]", "has the weight \"light.color\""},
    {"\"in\":[\"f\",\"light.share\"]", "\"in\":[\"pixel.normal\"]", "which is not of a light"},
    {"\"heads\":3", "\"heads\":2", "among 2 heads"},
    {"\"heads\":3", "\"heads\":0", "among 0 heads"},
    {"\"sigmoid\"", "\"hardmax\"", "unknown gate"},
    {"\"act\":\"relu\"", "\"act\":\"gelu\"", "unknown act"},
    {"\"low\":0", "\"low\":1e4", "low above high"},
    {"\"high\":1e3", "\"high\":1e99", "not a JSON array"},
    {"\"high\":1e3", "\"high\":+1", "not a JSON array"},
    {"\"high\":1e3", "\"high\":0x10", "not a JSON array"},
    {"\"high\":1e3", "\"high\":1.", "not a JSON array"},
    {"\"out\":\"indirect\"", "\"out\":\"beauty\"", "makes no \"indirect\""},
    {"\"in\":[\"direct\"],\"scale\"", "\"in\":[\"pixel.mask\"],\"scale\"", "makes no \"indirect\""},
    {"\"channels\":4}", "\"channels\":5}", "has a tensor \"d.weight\" of another shape"},
    {"\"channels\":4}", "\"channels\":0}", "1 to 4096 can be"},
    {"\"channels\":4}", "\"channels\":5000}", "a number over 4096"},
    {"\"name\":\"d\"", "\"name\":\"h\"", "has no tensor \"h.weight\""},
    {"[\"z\",\"view.direction\"]", "[\"z\",\"z\"]", "of another shape"},
    {"\"op\":\"linear\",\"in\":[\"z\"", "\"op\":\"conv\",\"in\":[\"z\"", "of another shape"},
    {"-1.5e-3", "-1.5e-3}", "lacks \"out\""},
    {"}]", "]", "not a JSON array"},
};

static void test_file(char *path, size_t size)
{
    test_path(path, size, "net.safetensors");
}

static void assert_refused(const char *path, const char *says)
{
    struct test_log log;
    struct lf_net *net;
    test_log_begin(&log);
    ng_result result = lf_net_load(path, &net);
    test_log_end(&log);
    if (result != NG_ERROR_FORMAT || log.errors != 1 || net || !strstr(log.text, says))
        fail_msg("wanted \"%s\", got %s: %s", says, ng_result_text(result), log.text);
}

static void replace(const char *text, const char *find, const char *put, char *out, size_t size)
{
    const char *at = strstr(text, find);
    assert_non_null(at);
    assert_true((size_t)snprintf(out, size, "%.*s%s%s", (int)(at - text), text, put, at + strlen(find)) <
                size);
}

static void programs(void **state)
{
    NG_UNUSED(state);
    char path[512], program[4096];
    test_file(path, sizeof path);
    for (size_t i = 0; i < NG_COUNT(wrong_programs); i++) {
        replace(made_program, wrong_programs[i].find, wrong_programs[i].put, program, sizeof program);
        made_write(path, program, made_weights);
        assert_refused(path, wrong_programs[i].says);
    }
    made_write(path, "", "");
    assert_refused(path, "not a JSON array");
    made_write(path, "[]", "");
    assert_refused(path, "makes no \"unshadowed\"");
    made_write(path, made_program, "a 6 6, b 6 9, d 4 6 3, e 1 1");
    assert_refused(path, "no operation names its tensor \"e.weight\"");
}

static void too_many_operations(void **state)
{
    NG_UNUSED(state);
    const size_t size = 100 * (LF_MAX_OPS + 1);
    char path[512], *program = calloc(1, size + 8);
    size_t n = 1;
    assert_non_null(program);
    program[0] = '[';
    for (int i = 0; i <= LF_MAX_OPS; i++)
        n += (size_t)snprintf(program + n, size - n,
                              "%s{\"op\":\"abs\",\"in\":[\"pixel.mask\"],\"out\":\"v%d\"}", i ? "," : "", i);
    program[n] = ']';
    test_file(path, sizeof path);
    made_write(path, program, "");
    assert_refused(path, "more than 1024 operations");
    free(program);
}

static void write_with(const char *path, const char *key, const char *value, enum lf_dtype dtype,
                       float number)
{
    const uint64_t shape[] = {3, 3};
    const char *const keys[] = {"format", "version", "inputs", "program"};
    const char *const values[] = {
        "lightformer-net", "1", LF_INPUTS_VERSION,
        "[{\"op\":\"linear\",\"in\":[\"pixel.normal\"],\"out\":\"direct\",\"name\":\"a\","
        "\"channels\":3},{\"op\":\"abs\",\"in\":[\"direct\"],\"out\":\"unshadowed\"},"
        "{\"op\":\"abs\",\"in\":[\"direct\"],\"out\":\"indirect\"}]"};
    struct lf_tensors t = {0};
    float *weight = lf_tensors_add(&t, "a.weight", dtype, 2, shape);
    assert_true(weight && lf_tensors_add(&t, "a.bias", LF_F32, 1, shape));
    if (dtype == LF_F32)
        weight[4] = number;
    for (size_t i = 0; i < NG_COUNT(keys); i++)
        if (!key || strcmp(key, keys[i]) != 0)
            assert_int_equal(lf_tensors_note(&t, keys[i], values[i]), NG_OK);
        else if (value)
            assert_int_equal(lf_tensors_note(&t, key, value), NG_OK);
    assert_int_equal(lf_tensors_write(&t, path), NG_OK);
    lf_tensors_finish(&t);
}

static void files(void **state)
{
    NG_UNUSED(state);
    char path[512];
    struct lf_net *net;
    test_file(path, sizeof path);
    write_with(path, NULL, NULL, LF_F16, 0);
    assert_int_equal(lf_net_load(path, &net), NG_OK);
    lf_net_destroy(&net);
    lf_net_destroy(&net);
    write_with(path, NULL, NULL, LF_F32, NAN);
    assert_refused(path, "has a tensor \"a.weight\" with a number that is not finite");
    write_with(path, NULL, NULL, LF_F32, INFINITY);
    assert_refused(path, "not finite");
    write_with(path, NULL, NULL, LF_I32, 0);
    assert_refused(path, "of type I32, not F32 or F16");
    write_with(path, "version", "2", LF_F32, 0);
    assert_refused(path, "version \"2\"; this program reads version 1");
    write_with(path, "version", NULL, LF_F32, 0);
    assert_refused(path, "version");
    write_with(path, "inputs", "5", LF_F32, 0);
    assert_refused(path, "inputs of version \"5\", which this program no longer makes");
    write_with(path, "inputs", "99", LF_F32, 0);
    assert_refused(path, "inputs of version \"99\", newer than this program's");
    write_with(path, "inputs", NULL, LF_F32, 0);
    assert_refused(path, "inputs of version \"\"");
    write_with(path, "format", "lightformer-dataset", LF_F32, 0);
    assert_refused(path, "is no network");
    write_with(path, "program", NULL, LF_F32, 0);
    assert_refused(path, "without a program");
}

// ---- Mutations ------------------------------------------------------------------------------------------

static void mutate(struct ng_rng *rng, unsigned char *file, size_t from, size_t to)
{
    static const char alphabet[] = "{}[]\",:0123456789abcdefxyz.-e";
    uint32_t count = 1 + ng_rng_below(rng, 4);
    for (uint32_t i = 0; i < count; i++) {
        size_t at = from + ng_rng_below(rng, (uint32_t)(to - from));
        switch (ng_rng_below(rng, 4)) {
        case 0:
            file[at] = (unsigned char)alphabet[ng_rng_below(rng, sizeof alphabet - 1)];
            break;
        case 1:
            file[at] ^= (unsigned char)(1u << ng_rng_below(rng, 8));
            break;
        case 2:
            file[at] = file[from + ng_rng_below(rng, (uint32_t)(to - from))];
            break;
        default: { // a stretch from elsewhere
            size_t other = from + ng_rng_below(rng, (uint32_t)(to - from)), n = 1 + ng_rng_below(rng, 12);
            if (at + n < to && other + n < to)
                memmove(file + at, file + other, n);
        }
        }
    }
}

static bool loads_and_runs(const char *path)
{
    struct lf_net *net;
    struct made_scene scene;
    struct test_log log;
    test_log_begin(&log);
    ng_result result = lf_net_load(path, &net);
    test_log_end(&log);
    if (result != NG_OK) {
        assert_int_equal(result, NG_ERROR_FORMAT);
        assert_int_equal(log.errors, 1);
        assert_null(net);
        return false;
    }
    made_scene_init(&scene, 5, 3, 2, 1);
    struct made_picture p = made_run(net, &scene, LF_KERNEL_AUTO, 1, false);
    made_picture_finish(&p);
    made_scene_finish(&scene);
    lf_net_destroy(&net);
    return true;
}

// Without waiting for the disk, thousands of times.
static void write_plainly(const char *path, const void *data, size_t size)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static void mutations(void **state)
{
    NG_UNUSED(state);
    struct ng_rng rng = ng_rng_make(11, 4);
    char path[512];
    void *data;
    size_t size, loaded = 0;
    const size_t tries = 3000;
    test_file(path, sizeof path);
    made_write(path, made_program, made_weights);
    assert_true(loads_and_runs(path));
    assert_int_equal(ng_file_read(path, 0, &data, &size), NG_OK);
    unsigned char *copy = malloc(size);
    assert_non_null(copy);
    uint64_t header;
    memcpy(&header, data, sizeof header);
    for (size_t i = 0; i < tries; i++) {
        memcpy(copy, data, size);
        mutate(&rng, copy, MADE_HASH_AT + 17, i % 8 ? 8 + (size_t)header : size);
        assert_true(made_seal(copy, size));
        write_plainly(path, copy, size);
        loaded += loads_and_runs(path);
    }
    assert_true(loaded > 0 && loaded < tries / 2); // names and numbers may change; most of the rest may not
    free(copy);
    free(data);
}

static void kernels(void **state)
{
    NG_UNUSED(state);
    struct lf_net *net = made_net(made_program, made_weights);
    for (int i = LF_KERNEL_PLAIN; i <= LF_KERNEL_AMX; i++) {
        struct lf_net_executor *executor;
        struct test_log log;
        test_log_begin(&log);
        ng_result result = lf_net_executor_create(
            &(struct lf_net_executor_params){.net = net, .kernel = (enum lf_net_kernel)i}, &executor);
        test_log_end(&log);
        bool there = i == LF_KERNEL_PLAIN || lf_net_peak((enum lf_net_kernel)i, NULL) > 0;
        assert_int_equal(result, there ? NG_OK : NG_ERROR_UNSUPPORTED);
        assert_int_equal(log.errors, !there);
        if (there)
            assert_int_equal(lf_net_executor_kernel(executor), i);
        lf_net_executor_destroy(&executor);
        assert_null(executor);
    }
    lf_net_destroy(&net);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(programs), cmocka_unit_test(too_many_operations),
        cmocka_unit_test(files),    cmocka_unit_test(mutations),
        cmocka_unit_test(kernels),
    };
    return cmocka_run_group_tests_name("net_files", tests, NULL, NULL);
}

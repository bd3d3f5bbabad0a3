// Every operation against its definition, on every kernel that this CPU has; what must not change a picture;
// and a few closed forms that stand on their own.
#include "test.h"

#include "made.h"

#include "base/rng.h"

#include <math.h>

#define TAIL                                                                                                 \
    ",{\"op\":\"affine\",\"in\":[\"r\"],\"scale\":1,\"offset\":0,\"out\":\"direct\"}"                        \
    ",{\"op\":\"affine\",\"in\":[\"r\"],\"scale\":-2,\"offset\":0.25,\"out\":\"unshadowed\"}"                \
    ",{\"op\":\"abs\",\"in\":[\"r\"],\"out\":\"indirect\"}]"

// The bounds that README.md states, of made-up numbers of size 1.
#define FP32_BOUND 1e-10
#define BF16_BOUND 1e-3

static const struct {
    uint32_t width, height, lights;
} scenes[] = {{1, 1, 1}, {17, 3, 3}, {66, 35, 9}, {131, 2, 2}};

static const enum lf_net_kernel kernels[] = {LF_KERNEL_PLAIN, LF_KERNEL_AVX2, LF_KERNEL_AVX512,
                                             LF_KERNEL_BF16, LF_KERNEL_AMX};

static bool available(enum lf_net_kernel kernel)
{
    return kernel == LF_KERNEL_PLAIN || lf_net_peak(kernel, NULL) > 0;
}

static double bound_of(enum lf_net_kernel kernel)
{
    return kernel == LF_KERNEL_BF16 || kernel == LF_KERNEL_AMX ? BF16_BOUND : FP32_BOUND;
}

static void check_on(const char *program, const char *weights, const struct made_scene *scene)
{
    struct lf_net *net = made_net(program, weights);
    struct made_picture naive = made_naive(program, weights, scene);
    for (size_t k = 0; k < NG_COUNT(kernels); k++) {
        if (!available(kernels[k]))
            continue;
        struct made_picture p = made_run(net, scene, kernels[k], 2, false);
        double difference = made_difference(&p, &naive);
        if (!(difference <= bound_of(kernels[k])))
            fail_msg("%s, %u x %u, %u lights: differs by %g\n%s", lf_net_kernel_name(kernels[k]),
                     scene->width, scene->height, scene->lights, difference, program);
        made_picture_finish(&p);
    }
    made_picture_finish(&naive);
    lf_net_destroy(&net);
}

static void check(const char *program, const char *weights)
{
    for (size_t i = 0; i < NG_COUNT(scenes); i++) {
        struct made_scene scene;
        made_scene_init(&scene, scenes[i].width, scenes[i].height, scenes[i].lights, i);
        check_on(program, weights, &scene);
        made_scene_finish(&scene);
    }
}

// ---- Operations -----------------------------------------------------------------------------------------

static void elementwise(void **state)
{
    static const char *const names[] = {"relu", "leaky", "sigmoid", "softplus", "tanh",
                                        "exp",  "log",   "log1p",   "sqrt",     "abs"};
    NG_UNUSED(state);
    char program[1024];
    for (size_t i = 0; i < NG_COUNT(names); i++) {
        // Wide enough for every branch; log1p stays off its pole.
        bool pole = strcmp(names[i], "log1p") == 0;
        snprintf(program, sizeof program,
                 "[{\"op\":\"affine\",\"in\":[\"pixel.normal\"],\"scale\":%s,\"offset\":%s,\"out\":\"a\"},"
                 "{\"op\":\"%s\",\"in\":[\"a\"],\"out\":\"r\"}" TAIL,
                 pole ? "0.9" : "6", pole ? "0.5" : "0", names[i]);
        check(program, "");
    }
    check("[{\"op\":\"clamp\",\"in\":[\"pixel.normal\"],\"low\":-0.25,\"high\":0.5,\"out\":\"r\"}" TAIL, "");
}

static void pairwise(void **state)
{
    static const char *const names[] = {"add", "sub", "mul", "div", "min", "max"};
    static const char *const operands[] = {
        "\"pixel.normal\",\"pixel.view\"", "\"pixel.normal\",\"pixel.distance\"",
        "\"pixel.roughness\",\"pixel.normal\"", "\"frame.radiance\",\"pixel.normal\""};
    NG_UNUSED(state);
    char program[1024];
    for (size_t i = 0; i < NG_COUNT(names); i++)
        for (size_t k = 0; k < NG_COUNT(operands); k++) {
            snprintf(program, sizeof program, "[{\"op\":\"%s\",\"in\":[%s],\"out\":\"r\"}" TAIL, names[i],
                     operands[k]);
            check(program, "");
        }
}

static void across_channels(void **state)
{
    NG_UNUSED(state);
    check("[{\"op\":\"dot\",\"in\":[\"pixel.normal\",\"pixel.view\"],\"out\":\"a\"},"
          "{\"op\":\"length\",\"in\":[\"pixel.diffuse\"],\"out\":\"b\"},"
          "{\"op\":\"normalize\",\"in\":[\"pixel.specular\"],\"out\":\"c\"},"
          "{\"op\":\"slice\",\"in\":[\"c\"],\"from\":1,\"to\":2,\"out\":\"d\"},"
          "{\"op\":\"concat\",\"in\":[\"a\",\"b\",\"d\"],\"out\":\"r\"}" TAIL,
          "");
}

static void linears(void **state)
{
    NG_UNUSED(state);
    // Odd counts of channels, every act, chains, one operand alone and many together, a shared weight.
    check(
        "[{\"op\":\"linear\",\"in\":[\"pixel.normal\",\"pixel.distance\",\"pixel.diffuse\"],\"out\":\"a\","
        "\"name\":\"a\",\"channels\":13,\"act\":\"leaky\"},"
        "{\"op\":\"linear\",\"in\":[\"a\"],\"out\":\"b\",\"name\":\"b\",\"channels\":40,\"act\":\"relu\"},"
        "{\"op\":\"linear\",\"in\":[\"b\",\"a\",\"pixel.view\"],\"out\":\"c\",\"name\":\"c\",\"channels\":35,"
        "\"act\":\"tanh\"},"
        "{\"op\":\"linear\",\"in\":[\"c\"],\"out\":\"d\",\"name\":\"d\",\"channels\":34,\"act\":\"softplus\"}"
        ","
        "{\"op\":\"linear\",\"in\":[\"d\",\"b\"],\"out\":\"e\",\"name\":\"e\",\"channels\":70},"
        "{\"op\":\"linear\",\"in\":[\"e\"],\"out\":\"f\",\"name\":\"f\",\"channels\":3,\"act\":\"sigmoid\"},"
        "{\"op\":\"linear\",\"in\":[\"pixel.view\"],\"out\":\"g\",\"name\":\"g\",\"channels\":3},"
        "{\"op\":\"linear\",\"in\":[\"f\"],\"out\":\"h\",\"name\":\"g\",\"channels\":3},"
        "{\"op\":\"add\",\"in\":[\"g\",\"h\"],\"out\":\"r\"}" TAIL,
        "a 13 7, b 40 13, c 35 56, d 34 35, e 70 74, f 3 70, g 3 3");
}

static void mixed_domains(void **state)
{
    NG_UNUSED(state);
    check(
        "[{\"op\":\"linear\",\"in\":[\"frame.mean_power\",\"vpl.offset\",\"light.color\",\"vpl.power\"],"
        "\"out\":\"v\",\"name\":\"v\",\"channels\":9,\"act\":\"relu\"},"
        "{\"op\":\"mean\",\"in\":[\"v\"],\"out\":\"z\"},"
        "{\"op\":\"linear\",\"in\":[\"z\",\"pixel.normal\",\"frame.mean_power\",\"view.direction\",\"light."
        "kind\"],"
        "\"out\":\"a\",\"name\":\"a\",\"channels\":24,\"act\":\"leaky\"},"
        "{\"op\":\"linear\",\"in\":[\"a\",\"pixel.view\"],\"out\":\"b\",\"name\":\"b\",\"channels\":8},"
        "{\"op\":\"sum\",\"in\":[\"b\",\"light.share\"],\"out\":\"s\"},"
        "{\"op\":\"linear\",\"in\":[\"frame.radiance\",\"s\",\"pixel.diffuse\"],\"out\":\"c\",\"name\":\"c\","
        "\"channels\":16,\"act\":\"relu\"},"
        "{\"op\":\"linear\",\"in\":[\"c\",\"b\",\"z\"],\"out\":\"d\",\"name\":\"d\",\"channels\":6,\"act\":"
        "\"relu\"},"
        "{\"op\":\"mul\",\"in\":[\"d\",\"light.share\"],\"out\":\"e\"},"
        "{\"op\":\"sum\",\"in\":[\"e\"],\"out\":\"t\"},"
        "{\"op\":\"linear\",\"in\":[\"t\",\"c\"],\"out\":\"r\",\"name\":\"f\",\"channels\":3}" TAIL,
        "v 9 10, a 24 19, b 8 27, c 16 12, d 6 33, f 3 22");
}

static void rows(void **state)
{
    NG_UNUSED(state);
    // A mean behind a linear, one before an act, of texels in more than one tile; light to frame.
    check("[{\"op\":\"linear\",\"in\":[\"texel.offset\",\"texel.flux\",\"light.color\"],\"out\":\"a\","
          "\"name\":\"a\","
          "\"channels\":12,\"act\":\"relu\"},"
          "{\"op\":\"linear\",\"in\":[\"a\"],\"out\":\"b\",\"name\":\"b\",\"channels\":5},"
          "{\"op\":\"mean\",\"in\":[\"b\"],\"out\":\"c\"},"
          "{\"op\":\"mean\",\"in\":[\"a\"],\"out\":\"d\"},"
          "{\"op\":\"linear\",\"in\":[\"d\",\"c\"],\"out\":\"e\",\"name\":\"e\",\"channels\":5,\"act\":"
          "\"tanh\"},"
          "{\"op\":\"mul\",\"in\":[\"texel.normal\",\"texel.flux\"],\"out\":\"f\"},"
          "{\"op\":\"mean\",\"in\":[\"f\"],\"out\":\"g\"},"
          "{\"op\":\"sum\",\"in\":[\"e\",\"light.share\"],\"out\":\"h\"},"
          "{\"op\":\"linear\",\"in\":[\"light.share\",\"h\",\"g\"],\"out\":\"i\",\"name\":\"i\",\"channels\":"
          "4},"
          "{\"op\":\"sum\",\"in\":[\"i\"],\"out\":\"j\"},"
          "{\"op\":\"linear\",\"in\":[\"pixel.normal\",\"j\"],\"out\":\"r\",\"name\":\"r\",\"channels\":"
          "3}" TAIL,
          "a 12 9, b 5 12, e 5 17, i 4 9, r 3 7");
}

static void pictures(void **state)
{
    NG_UNUSED(state);
    check("[{\"op\":\"linear\",\"in\":[\"pixel.normal\",\"view.direction\"],\"out\":\"a\",\"name\":\"a\","
          "\"channels\":6},"
          "{\"op\":\"conv\",\"in\":[\"a\",\"view.occluder\",\"light.kind\"],\"out\":\"b\",\"name\":"
          "\"b\","
          "\"channels\":12,"
          "\"act\":\"relu\"},"
          "{\"op\":\"pool\",\"in\":[\"b\"],\"out\":\"c\"},"
          "{\"op\":\"pack\",\"in\":[\"b\"],\"out\":\"d\"},"
          "{\"op\":\"conv\",\"in\":[\"c\",\"d\"],\"out\":\"e\",\"name\":\"e\",\"channels\":20,\"act\":"
          "\"leaky\"},"
          "{\"op\":\"pool\",\"in\":[\"e\"],\"out\":\"f\"},"
          "{\"op\":\"conv\",\"in\":[\"f\"],\"out\":\"g\",\"name\":\"g\",\"channels\":21,\"act\":\"tanh\"},"
          "{\"op\":\"up\",\"in\":[\"g\"],\"out\":\"h\"},"
          "{\"op\":\"slice\",\"in\":[\"h\"],\"from\":1,\"to\":21,\"out\":\"i\"},"
          "{\"op\":\"add\",\"in\":[\"i\",\"e\"],\"out\":\"j\"},"
          "{\"op\":\"unpack\",\"in\":[\"j\"],\"out\":\"k\"},"
          "{\"op\":\"linear\",\"in\":[\"k\",\"b\"],\"out\":\"l\",\"name\":\"l\",\"channels\":4},"
          "{\"op\":\"sum\",\"in\":[\"l\"],\"out\":\"m\"},"
          "{\"op\":\"conv\",\"in\":[\"m\",\"pixel.view\",\"frame.radiance\"],\"out\":\"n\",\"name\":\"n\","
          "\"channels\":3},"
          "{\"op\":\"up\",\"in\":[\"j\"],\"out\":\"o\"},"
          "{\"op\":\"sum\",\"in\":[\"o\",\"light.share\"],\"out\":\"p\"},"
          "{\"op\":\"linear\",\"in\":[\"n\",\"p\"],\"out\":\"r\",\"name\":\"r\",\"channels\":3}" TAIL,
          "a 6 6, b 12 10 3, e 20 60 3, g 21 20 3, l 4 17, n 3 8 3, r 3 23");
}

static void of_inputs(void **state)
{
    NG_UNUSED(state);
    check("[{\"op\":\"pool\",\"in\":[\"pixel.normal\"],\"out\":\"a\"},{\"op\":\"pack\",\"in\":[\"view."
          "direction\"],"
          "\"out\":\"b\"},{\"op\":\"mul\",\"in\":[\"light.share\",\"b\"],\"out\":\"c\"},"
          "{\"op\":\"conv\",\"in\":[\"c\",\"a\"],\"out\":\"d\",\"name\":\"d\",\"channels\":5},"
          "{\"op\":\"sum\",\"in\":[\"d\"],\"out\":\"e\"},{\"op\":\"up\",\"in\":[\"e\"],\"out\":\"f\"},"
          "{\"op\":\"slice\",\"in\":[\"f\"],\"from\":2,\"to\":5,\"out\":\"r\"}" TAIL,
          "d 5 15 3");
}

static void attention(void **state)
{
    static const char *const gates[] = {"sigmoid", "softmax"}, *const weights[] = {"", ",\"positive\""};
    NG_UNUSED(state);
    char program[4096];
    for (size_t gate = 0; gate < 2; gate++)
        for (size_t weight = 0; weight < 2; weight++) {
            snprintf(
                program, sizeof program,
                "[{\"op\":\"linear\",\"in\":[\"pixel.normal\"],\"out\":\"q\",\"name\":\"q\",\"channels\":12},"
                "{\"op\":\"linear\",\"in\":[\"light.color\"],\"out\":\"k\",\"name\":\"k\",\"channels\":12},"
                "{\"op\":\"linear\",\"in\":[\"light.kind\"],\"out\":\"v\",\"name\":\"v\",\"channels\":8},"
                "{\"op\":\"linear\",\"in\":[\"view.direction\"],\"out\":\"kk\",\"name\":\"kk\",\"channels\":"
                "12},"
                "{\"op\":\"linear\",\"in\":[\"view.bounce\"],\"out\":\"vv\",\"name\":\"vv\","
                "\"channels\":6},"
                "{\"op\":\"abs\",\"in\":[\"light.share\"],\"out\":\"positive\"},"
                "{\"op\":\"attend\",\"in\":[\"q\",\"k\",\"v\"%s],\"heads\":4,\"gate\":\"%s\",\"out\":\"a\"},"
                "{\"op\":\"attend\",\"in\":[\"q\",\"kk\",\"vv\"%s],\"heads\":3,\"gate\":\"%s\",\"out\":\"b\"}"
                ","
                "{\"op\":\"linear\",\"in\":[\"a\",\"b\"],\"out\":\"r\",\"name\":\"r\",\"channels\":3}" TAIL,
                weights[weight], gates[gate], weights[weight], gates[gate]);
            check(program, "q 12 3, k 12 3, v 8 3, kk 12 3, vv 6 3, r 3 14");
        }
}

// ---- Programs that nobody wrote -------------------------------------------------------------------------

struct writer {
    struct ng_rng rng;
    char program[16384], weights[4096];
    struct {
        char name[32];
        uint32_t channels;
    } values[64];
    uint32_t count; // all of domain view, level 0
};

static void add_op(struct writer *w, const char *text, uint32_t channels)
{
    size_t n = strlen(w->program);
    snprintf(w->program + n, sizeof w->program - n, "%s%s\"out\":\"x%u\"}", n > 1 ? "," : "", text, w->count);
    snprintf(w->values[w->count].name, sizeof w->values[0].name, "x%u", w->count);
    w->values[w->count++].channels = channels;
}

static uint32_t pick(struct writer *w)
{
    return ng_rng_below(&w->rng, w->count);
}

static void add_product(struct writer *w, const char *op)
{
    uint32_t channels = 1 + ng_rng_below(&w->rng, 40), a = pick(w), b = pick(w), c = pick(w);
    static const char *const acts[] = {"none", "relu", "leaky", "tanh"};
    char text[512];
    size_t n = strlen(w->weights);
    snprintf(text, sizeof text,
             "{\"op\":\"%s\",\"in\":[\"%s\",\"%s\",\"light.color\",\"%s\"],\"name\":\"w%u\",\"channels\":%u,"
             "\"act\":\"%s\",",
             op, w->values[a].name, w->values[b].name, w->values[c].name, w->count, channels,
             acts[ng_rng_below(&w->rng, 4)]);
    snprintf(w->weights + n, sizeof w->weights - n, "%sw%u %u %u%s", n ? "," : "", w->count, channels,
             w->values[a].channels + w->values[b].channels + w->values[c].channels + 3,
             strcmp(op, "conv") == 0 ? " 3" : "");
    add_op(w, text, channels);
}

static void add_random(struct writer *w)
{
    uint32_t a = pick(w), b = pick(w), kind = ng_rng_below(&w->rng, 9);
    const char *x = w->values[a].name, *y = w->values[b].name;
    uint32_t n = w->values[a].channels;
    char text[512];
    switch (kind) {
    case 0:
        snprintf(text, sizeof text, "{\"op\":\"concat\",\"in\":[\"%s\",\"%s\",\"pixel.normal\"],", x, y);
        n += w->values[b].channels + 3;
        break;
    case 1:
        snprintf(text, sizeof text, "{\"op\":\"slice\",\"in\":[\"%s\"],\"from\":%u,\"to\":%u,", x, n / 2, n);
        n -= n / 2;
        break;
    case 2:
        snprintf(text, sizeof text, "{\"op\":\"mul\",\"in\":[\"%s\",\"pixel.roughness\"],", x);
        break;
    case 3:
        snprintf(text, sizeof text, "{\"op\":\"tanh\",\"in\":[\"%s\"],", x);
        break;
    case 4:
        snprintf(text, sizeof text, "{\"op\":\"sub\",\"in\":[\"%s\",\"%s\"],", x, x);
        break;
    case 5:
        add_product(w, "conv");
        return;
    default:
        add_product(w, "linear");
        return;
    }
    if (n < 120)
        add_op(w, text, n);
}

// Operands that come from anywhere before, values read by none, by many, across segments.
static void any_program(void **state)
{
    NG_UNUSED(state);
    for (uint64_t seed = 0; seed < 25; seed++) {
        struct writer w = {.rng = ng_rng_make(seed, 9), .program = "["};
        struct made_scene scene;
        add_op(&w, "{\"op\":\"concat\",\"in\":[\"view.direction\",\"pixel.view\"],", 6);
        while (w.count < 12)
            add_random(&w);
        size_t n = strlen(w.program);
        snprintf(
            w.program + n, sizeof w.program - n,
            ",{\"op\":\"linear\",\"in\":[\"x%u\",\"x%u\"],\"name\":\"s\",\"channels\":5,\"out\":\"last\"},"
            "{\"op\":\"sum\",\"in\":[\"last\",\"light.share\"],\"out\":\"sum\"},"
            "{\"op\":\"linear\",\"in\":[\"sum\",\"last\"],\"name\":\"u\",\"channels\":3,\"out\":\"again\"},"
            "{\"op\":\"sum\",\"in\":[\"again\"],\"out\":\"r\"}" TAIL,
            w.count - 1, w.count - 2);
        n = strlen(w.weights);
        snprintf(w.weights + n, sizeof w.weights - n, "%ss 5 %u, u 3 10", n ? "," : "",
                 w.values[w.count - 1].channels + w.values[w.count - 2].channels);
        made_scene_init(&scene, 1 + (uint32_t)(seed * 37 % 150), 1 + (uint32_t)(seed % 5), 2, seed);
        check_on(w.program, w.weights, &scene);
        made_scene_finish(&scene);
    }
}

// ---- What must not change a picture ---------------------------------------------------------------------

static const char *const whole_program =
    "[{\"op\":\"linear\",\"in\":[\"vpl.offset\",\"vpl.power\"],\"out\":\"v\",\"name\":\"v\",\"channels\":20,"
    "\"act\":\"relu\"},{\"op\":\"mean\",\"in\":[\"v\"],\"out\":\"z\"},"
    "{\"op\":\"linear\",\"in\":[\"texel.offset\",\"texel.flux\"],\"out\":\"t\",\"name\":\"t\",\"channels\":"
    "20,"
    "\"act\":\"relu\"},{\"op\":\"mean\",\"in\":[\"t\"],\"out\":\"k\"},"
    "{\"op\":\"linear\",\"in\":[\"view.direction\",\"pixel.normal\",\"z\"],\"out\":\"a\",\"name\":\"a\","
    "\"channels\":16,\"act\":\"leaky\"},{\"op\":\"pack\",\"in\":[\"a\"],\"out\":\"b\"},"
    "{\"op\":\"conv\",\"in\":[\"b\"],\"out\":\"c\",\"name\":\"c\",\"channels\":24,\"act\":\"leaky\"},"
    "{\"op\":\"up\",\"in\":[\"c\"],\"out\":\"d\"},"
    "{\"op\":\"linear\",\"in\":[\"d\",\"a\"],\"out\":\"e\",\"name\":\"e\",\"channels\":12,\"act\":"
    "\"sigmoid\"},"
    "{\"op\":\"linear\",\"in\":[\"pixel.normal\",\"pixel.view\"],\"out\":\"q\",\"name\":\"q\",\"channels\":"
    "20},"
    "{\"op\":\"abs\",\"in\":[\"light.share\"],\"out\":\"share\"},"
    "{\"op\":\"attend\",\"in\":[\"q\",\"k\",\"e\",\"share\"],\"heads\":4,\"gate\":\"softmax\",\"out\":\"f\"},"
    "{\"op\":\"sum\",\"in\":[\"e\",\"light.share\"],\"out\":\"g\"},"
    "{\"op\":\"linear\",\"in\":[\"f\",\"g\",\"pixel.diffuse\"],\"out\":\"r\",\"name\":\"r\",\"channels\":"
    "3}" TAIL;
static const char *const whole_weights = "v 20 6, t 20 6, a 16 26, c 24 64 3, e 12 40, q 20 6, r 3 27";

static void order_of_lights(void **state)
{
    NG_UNUSED(state);
    struct lf_net *net = made_net(whole_program, whole_weights);
    struct made_scene scene;
    made_scene_init(&scene, 45, 18, 9, 5);
    struct made_picture p = made_run(net, &scene, LF_KERNEL_PLAIN, 1, false);
    for (uint32_t i = 0; i < 4; i++) {
        struct lf_net_values values = scene.light[i];
        uint32_t vpls = scene.vpls[i], texels = scene.texels[i];
        scene.light[i] = scene.light[8 - i];
        scene.vpls[i] = scene.vpls[8 - i];
        scene.texels[i] = scene.texels[8 - i];
        scene.light[8 - i] = values;
        scene.vpls[8 - i] = vpls;
        scene.texels[8 - i] = texels;
    }
    struct made_picture q = made_run(net, &scene, LF_KERNEL_PLAIN, 1, false);
    assert_true(made_difference(&p, &q) < 1e-12);
    made_picture_finish(&p);
    made_picture_finish(&q);
    made_scene_finish(&scene);
    lf_net_destroy(&net);
}

static void no_light_is_black(void **state)
{
    NG_UNUSED(state);
    struct lf_net *net = made_net(whole_program, whole_weights);
    struct made_scene scene;
    made_scene_init(&scene, 17, 3, 0, 5);
    struct made_picture p = made_run(net, &scene, LF_KERNEL_AUTO, 2, false);
    for (int i = 0; i < 3; i++)
        for (size_t k = 0; k < p.count; k++)
            assert_true(p.of[i][k] == 0.0f);
    made_picture_finish(&p);
    made_scene_finish(&scene);
    lf_net_destroy(&net);
}

static void assert_same(const struct made_picture *a, const struct made_picture *b)
{
    for (int i = 0; i < 3; i++)
        assert_memory_equal(a->of[i], b->of[i], a->count * sizeof(float));
}

static void threads_and_repetition(void **state)
{
    NG_UNUSED(state);
    struct lf_net *net = made_net(whole_program, whole_weights);
    struct made_scene scene;
    made_scene_init(&scene, 150, 61, 3, 5);
    for (size_t k = 0; k < NG_COUNT(kernels); k++) {
        if (!available(kernels[k]))
            continue;
        struct made_picture p = made_run(net, &scene, kernels[k], 1, false);
        for (uint32_t threads = 2; threads <= 5; threads += 3) {
            struct made_picture q = made_run(net, &scene, kernels[k], threads, threads == 5);
            assert_same(&p, &q);
            made_picture_finish(&q);
        }
        made_picture_finish(&p);
    }
    made_scene_finish(&scene);
    lf_net_destroy(&net);
}

// One executor for pictures of one size after another: nothing of a larger one is left in a smaller one's
// border.
static void sizes_in_turn(void **state)
{
    static const uint32_t sizes[][2] = {{70, 33}, {17, 3}, {70, 33}, {1, 1}, {35, 66}};
    NG_UNUSED(state);
    struct lf_net *net = made_net(whole_program, whole_weights);
    struct lf_net_executor *executor;
    struct lf_net_encoding *encoding;
    assert_int_equal(lf_net_executor_create(&(struct lf_net_executor_params){.net = net}, &executor), NG_OK);
    assert_int_equal(lf_net_encoding_create(executor, &encoding), NG_OK);
    for (size_t i = 0; i < NG_COUNT(sizes); i++) {
        struct made_scene scene;
        made_scene_init(&scene, sizes[i][0], sizes[i][1], 1, i);
        struct made_picture fresh = made_run(net, &scene, LF_KERNEL_AUTO, 1, false);
        struct made_picture used = made_run(net, &scene, LF_KERNEL_AUTO, 1, false);
        const struct lf_net_light_inputs light = {&scene.light[0], scene.vpls[0], scene.texels[0]};
        const struct lf_net_picture frame = {scene.width, scene.height, &scene.frame};
        const struct lf_net_gathered gathered = {encoding, &scene.light[0]};
        const struct lf_net_radiance out = {used.of[0], used.of[1], used.of[2]};
        assert_int_equal(lf_net_encode_light(executor, encoding, &light), NG_OK);
        assert_int_equal(lf_net_encode_view(executor, encoding, &frame, &scene.light[0]), NG_OK);
        assert_int_equal(lf_net_gather(executor, &frame, &gathered, 1, &out), NG_OK);
        assert_same(&fresh, &used);
        made_picture_finish(&fresh);
        made_picture_finish(&used);
        made_scene_finish(&scene);
    }
    lf_net_encoding_destroy(&encoding);
    lf_net_executor_destroy(&executor);
    lf_net_destroy(&net);
}

// ---- Closed forms ---------------------------------------------------------------------------------------

// What a program makes of one pixel's column is compared with numbers written here, not with made_naive.
static struct made_picture run_small(const char *program, struct made_scene *scene)
{
    struct lf_net *net = made_net(program, "");
    struct made_picture p = made_run(net, scene, LF_KERNEL_PLAIN, 1, false);
    lf_net_destroy(&net);
    return p;
}

static struct lf_net_bytes bytes_of(const struct lf_net *net, bool compact)
{
    struct lf_net_executor *executor;
    assert_int_equal(
        lf_net_executor_create(
            &(struct lf_net_executor_params){.net = net, .kernel = LF_KERNEL_PLAIN, .compact = compact},
            &executor),
        NG_OK);
    struct lf_net_bytes bytes = lf_net_picture_bytes(executor, 256, 256);
    lf_net_executor_destroy(&executor);
    return bytes;
}

// Less memory, and nearly the same: of numbers of 16 bits, on any kernel, whatever the size.
static void compact_pictures(void **state)
{
    NG_UNUSED(state);
    struct lf_net *net = made_net(made_program, made_weights);
    struct made_scene s;
    made_scene_init(&s, 67, 35, 3, 11);
    for (int kernel = LF_KERNEL_PLAIN; kernel <= LF_KERNEL_AVX512; kernel++) {
        if (!available((enum lf_net_kernel)kernel))
            continue;
        struct made_picture exact = made_run(net, &s, (enum lf_net_kernel)kernel, 2, true);
        made_compact = true;
        struct made_picture compact = made_run(net, &s, (enum lf_net_kernel)kernel, 2, true);
        made_compact = false;
        double difference = made_difference(&compact, &exact);
        assert_true(difference > 0 && difference < 1e-5); // squared, of 11 bits, through several images
        made_picture_finish(&exact);
        made_picture_finish(&compact);
    }
    const struct lf_net_bytes wide = bytes_of(net, false), narrow = bytes_of(net, true);
    assert_true(narrow.encoding < wide.encoding * 3 / 4);
    assert_true(narrow.work <= wide.work);
    made_scene_finish(&s);
    lf_net_destroy(&net);
}

static void pack_and_back(void **state)
{
    NG_UNUSED(state);
    struct made_scene scene;
    made_scene_init(&scene, 37, 15, 1, 2);
    struct made_picture p = run_small("[{\"op\":\"pack\",\"in\":[\"pixel.diffuse\"],\"out\":\"a\"},"
                                      "{\"op\":\"pack\",\"in\":[\"a\"],\"out\":\"b\"},"
                                      "{\"op\":\"unpack\",\"in\":[\"b\"],\"out\":\"c\"},"
                                      "{\"op\":\"unpack\",\"in\":[\"c\"],\"out\":\"r\"}" TAIL,
                                      &scene);
    assert_memory_equal(p.of[1], scene.frame.of[LF_INPUT_PIXEL_DIFFUSE], p.count * sizeof(float));
    made_picture_finish(&p);
    made_scene_finish(&scene);
}

// A ramp of the coarse picture stays a ramp between its first and last pixel centres.
static void up_of_a_ramp(void **state)
{
    NG_UNUSED(state);
    struct made_scene scene;
    made_scene_init(&scene, 16, 4, 1, 2);
    float *ramp = (float *)scene.frame.of[LF_INPUT_PIXEL_DIFFUSE];
    for (uint32_t i = 0; i < 3 * 16 * 4; i++)
        ramp[i] = (float)(i % 16);
    struct made_picture p = run_small("[{\"op\":\"pool\",\"in\":[\"pixel.diffuse\"],\"out\":\"a\"},"
                                      "{\"op\":\"up\",\"in\":[\"a\"],\"out\":\"r\"}" TAIL,
                                      &scene);
    for (uint32_t x = 0; x < 16; x++)
        assert_true(fabsf(p.of[1][x] - fminf(fmaxf((float)x, 0.5f), 14.5f)) < 1e-5f);
    made_picture_finish(&p);
    made_scene_finish(&scene);
}

// Two equal lights: softmax says what one says, additive gates say it twice.
static void two_equal_lights(void **state)
{
    static const char *const format = "[{\"op\":\"attend\",\"in\":[\"pixel.normal\",\"light.color\",\"view."
                                      "bounce\"],\"heads\":3,\"gate\":\"%s\","
                                      "\"out\":\"r\"}" TAIL;
    NG_UNUSED(state);
    for (int softmax = 0; softmax < 2; softmax++) {
        char program[1024];
        struct made_scene scene;
        snprintf(program, sizeof program, format, softmax ? "softmax" : "sigmoid");
        made_scene_init(&scene, 9, 2, 1, 2);
        struct made_picture one = run_small(program, &scene);
        scene.lights = 2;
        scene.light[1] = scene.light[0];
        struct made_picture two = run_small(program, &scene);
        for (size_t i = 0; i < one.count; i++)
            assert_true(fabsf(two.of[1][i] - one.of[1][i] * (softmax ? 1 : 2)) < 1e-5f);
        scene.lights = 1;
        made_picture_finish(&one);
        made_picture_finish(&two);
        made_scene_finish(&scene);
    }
}

// A mean of no rows is zero, also where a linear with a bias was moved behind it.
static void no_rows(void **state)
{
    NG_UNUSED(state);
    struct lf_net *net =
        made_net("[{\"op\":\"linear\",\"in\":[\"vpl.power\",\"light.color\"],\"out\":\"a\",\"name\":\"a\","
                 "\"channels\":3},{\"op\":\"mean\",\"in\":[\"a\"],\"out\":\"b\"},"
                 "{\"op\":\"add\",\"in\":[\"b\",\"pixel.normal\"],\"out\":\"c\"},"
                 "{\"op\":\"sum\",\"in\":[\"c\"],\"out\":\"r\"}" TAIL,
                 "a 3 6");
    struct made_scene scene;
    made_scene_init(&scene, 8, 8, 1, 2);
    scene.vpls[0] = 0;
    struct made_picture p = made_run(net, &scene, LF_KERNEL_PLAIN, 2, false);
    assert_memory_equal(p.of[1], scene.frame.of[LF_INPUT_PIXEL_NORMAL], p.count * sizeof(float));
    made_picture_finish(&p);
    made_scene_finish(&scene);
    lf_net_destroy(&net);
}

static void what_is_read(void **state)
{
    NG_UNUSED(state);
    struct lf_net *net = made_net(whole_program, whole_weights);
    assert_true(lf_net_reads(net, LF_INPUT_VPL_OFFSET));
    assert_false(lf_net_reads(net, LF_INPUT_VPL_NORMAL));
    assert_int_equal(lf_net_parameters(net),
                     20 * 7 + 20 * 7 + 16 * 27 + 24 * 577 + 12 * 41 + 20 * 7 + 3 * 28);
    assert_string_equal(lf_net_note(net, "format"), "lightformer-net");
    assert_null(lf_net_note(net, "weather"));
    lf_net_destroy(&net);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(elementwise),
        cmocka_unit_test(pairwise),
        cmocka_unit_test(across_channels),
        cmocka_unit_test(linears),
        cmocka_unit_test(mixed_domains),
        cmocka_unit_test(rows),
        cmocka_unit_test(pictures),
        cmocka_unit_test(of_inputs),
        cmocka_unit_test(attention),
        cmocka_unit_test(any_program),
        cmocka_unit_test(order_of_lights),
        cmocka_unit_test(no_light_is_black),
        cmocka_unit_test(threads_and_repetition),
        cmocka_unit_test(sizes_in_turn),
        cmocka_unit_test(compact_pictures),
        cmocka_unit_test(pack_and_back),
        cmocka_unit_test(up_of_a_ramp),
        cmocka_unit_test(two_equal_lights),
        cmocka_unit_test(no_rows),
        cmocka_unit_test(what_is_read),
    };
    return cmocka_run_group_tests_name("net", tests, NULL, NULL);
}

#include "test.h"

#include "made.h"

#include "base/hash.h"
#include "base/jobs.h"
#include "base/rng.h"

#include <inttypes.h>
#include <math.h>

#define OK(call) assert_int_equal((call), NG_OK)

// ---- Networks -------------------------------------------------------------------------------------------

const char *const made_program =
    "[{\"op\":\"linear\",\"in\":[\"vpl.offset\",\"light.color\"],\"out\":\"a\",\"name\":\"a\",\"channels\":6,"
    "\"act\":\"relu\"},{\"op\":\"mean\",\"in\":[\"a\"],\"out\":\"z\"},"
    "{\"op\":\"linear\",\"in\":[\"z\",\"view.direction\"],\"out\":\"b\",\"name\":\"b\",\"channels\":6},"
    "{\"op\":\"pool\",\"in\":[\"b\"],\"out\":\"c\"},{\"op\":\"conv\",\"in\":[\"c\"],\"out\":\"d\",\"name\":"
    "\"d\","
    "\"channels\":4},{\"op\":\"up\",\"in\":[\"d\"],\"out\":\"e\"},{\"op\":\"slice\",\"in\":[\"e\"],\"from\":"
    "1,\"to\":4,"
    "\"out\":\"f\"},{\"op\":\"sum\",\"in\":[\"f\",\"light.share\"],\"out\":\"direct\"},"
    "{\"op\":\"attend\",\"in\":[\"pixel.normal\",\"light.kind\",\"f\"],\"heads\":3,\"gate\":\"sigmoid\","
    "\"out\":\"g\"},"
    "{\"op\":\"clamp\",\"in\":[\"g\"],\"low\":0,\"high\":1e3,\"out\":\"unshadowed\"},"
    "{\"op\":\"affine\",\"in\":[\"direct\"],\"scale\":0.5,\"offset\":-1.5e-3,\"out\":\"indirect\"}]";
const char *const made_weights = "a 6 6, b 6 9, d 4 6 3";

static void add_weights(struct lf_tensors *t, const char *name, uint64_t outputs, uint64_t inputs,
                        uint64_t side)
{
    const uint64_t shape[] = {outputs, inputs, side, side};
    char full[128];
    struct ng_rng rng = ng_rng_make(ng_hash_string(name), outputs);
    float scale = 1.5f / sqrtf((float)(inputs * side * side));
    snprintf(full, sizeof full, "%s.weight", name);
    float *weight = lf_tensors_add(t, full, LF_F32, side > 1 ? 4 : 2, shape);
    snprintf(full, sizeof full, "%s.bias", name);
    float *bias = lf_tensors_add(t, full, LF_F32, 1, shape);
    assert_true(weight && bias);
    for (uint64_t i = 0; i < outputs * inputs * side * side; i++)
        weight[i] = ng_rng_range(&rng, -scale, scale);
    for (uint64_t i = 0; i < outputs; i++)
        bias[i] = ng_rng_range(&rng, -0.5f, 0.5f);
}

void made_write(const char *path, const char *program, const char *weights)
{
    struct lf_tensors t = {0};
    char name[64];
    for (const char *at = weights; *at;) {
        uint64_t outputs, inputs, side = 1;
        int length = 0;
        assert_true(sscanf(at, " %63s %" SCNu64 " %" SCNu64 "%n", name, &outputs, &inputs, &length) == 3);
        at += length;
        if (sscanf(at, " %" SCNu64 "%n", &side, &length) == 1)
            at += length;
        add_weights(&t, name, outputs, inputs, side);
        at += strspn(at, ", ");
    }
    OK(lf_tensors_note(&t, "format", "lightformer-net"));
    OK(lf_tensors_note(&t, "version", "1"));
    OK(lf_tensors_note(&t, "inputs", LF_INPUTS_VERSION));
    OK(lf_tensors_note(&t, "program", program));
    OK(lf_tensors_write(&t, path));
    lf_tensors_finish(&t);
}

bool made_seal(unsigned char *file, size_t size)
{
    char digits[17];
    if (size < MADE_HASH_AT + 16)
        return false;
    memset(file + MADE_HASH_AT, '0', 16);
    snprintf(digits, sizeof digits, "%016" PRIx64, ng_hash_bytes(0, file, size));
    memcpy(file + MADE_HASH_AT, digits, 16);
    return true;
}

struct lf_net *made_net(const char *program, const char *weights)
{
    struct lf_net *net;
    char path[512];
    test_path(path, sizeof path, "made.safetensors");
    made_write(path, program, weights);
    OK(lf_net_load(path, &net));
    return net;
}

// ---- Inputs ---------------------------------------------------------------------------------------------

static size_t count_of(const struct made_scene *s, enum lf_net_domain domain, uint32_t light)
{
    switch (domain) {
    case LF_DOMAIN_VPL:
        return s->vpls[light];
    case LF_DOMAIN_TEXEL:
        return s->texels[light];
    case LF_DOMAIN_PIXEL:
    case LF_DOMAIN_VIEW:
        return (size_t)s->width * s->height;
    default:
        return 1;
    }
}

static bool is_of_light(enum lf_net_domain domain)
{
    return domain != LF_DOMAIN_FRAME && domain != LF_DOMAIN_PIXEL;
}

static const float *random_values(struct ng_rng *rng, size_t count)
{
    float *values = malloc(count * sizeof *values + 1);
    assert_non_null(values);
    for (size_t i = 0; i < count; i++)
        values[i] = ng_rng_range(rng, -1, 1);
    return values;
}

void made_scene_init(struct made_scene *s, uint32_t width, uint32_t height, uint32_t lights, uint64_t seed)
{
    struct ng_rng rng = ng_rng_make(seed, 3);
    *s = (struct made_scene){.width = width, .height = height, .lights = lights};
    for (uint32_t l = 0; l < lights; l++) {
        s->vpls[l] = 7 + 5 * l;
        s->texels[l] = 300 + l;
    }
    for (uint32_t i = 0; i < LF_INPUT_COUNT; i++) {
        const struct lf_net_input_info *info = &lf_net_inputs[i];
        if (!is_of_light(info->domain))
            s->frame.of[i] = random_values(&rng, info->channels * count_of(s, info->domain, 0));
        for (uint32_t l = 0; is_of_light(info->domain) && l < lights; l++)
            s->light[l].of[i] = random_values(&rng, info->channels * count_of(s, info->domain, l));
    }
}

void made_scene_finish(struct made_scene *s)
{
    for (uint32_t i = 0; i < LF_INPUT_COUNT; i++) {
        free((float *)s->frame.of[i]);
        for (uint32_t l = 0; is_of_light(lf_net_inputs[i].domain) && l < s->lights; l++)
            free((float *)s->light[l].of[i]);
    }
}

// ---- Pictures -------------------------------------------------------------------------------------------

static struct made_picture make_picture(const struct made_scene *s)
{
    struct made_picture p = {.count = (size_t)3 * s->width * s->height};
    for (int i = 0; i < 3; i++) {
        p.of[i] = malloc(p.count * sizeof *p.of[i]);
        assert_non_null(p.of[i]);
        for (size_t k = 0; k < p.count; k++)
            p.of[i][k] = NAN;
    }
    return p;
}

void made_picture_finish(struct made_picture *p)
{
    for (int i = 0; i < 3; i++)
        free(p->of[i]);
}

double made_difference(const struct made_picture *a, const struct made_picture *b)
{
    double worst = 0;
    for (int i = 0; i < 3; i++) {
        double difference = 0, size = 0;
        for (size_t k = 0; k < a->count; k++) {
            double d = (double)a->of[i][k] - (double)b->of[i][k];
            difference += d * d;
            size += (double)b->of[i][k] * (double)b->of[i][k];
        }
        double part = size > 0 ? difference / size : difference;
        if (!(part <= worst)) // nor a NaN
            worst = part;
    }
    return worst;
}

// ---- The executor ---------------------------------------------------------------------------------------

static void encode(struct lf_net_executor *executor, struct made_scene *s, uint32_t light, bool again,
                   struct lf_net_encoding **out)
{
    const struct lf_net_picture frame = {s->width, s->height, &s->frame};
    const struct lf_net_light_inputs inputs = {&s->light[light], s->vpls[light], s->texels[light]};
    for (uint32_t i = 0; i < LF_INPUT_COUNT; i++)
        if (lf_net_inputs[i].domain == LF_DOMAIN_FRAME)
            s->light[light].of[i] = s->frame.of[i];
    OK(lf_net_encoding_create(executor, out));
    OK(lf_net_encode_light(executor, *out, &inputs));
    for (int i = 0; i < 1 + again; i++)
        OK(lf_net_encode_view(executor, *out, &frame, &s->light[light]));
}

bool made_compact;

struct made_picture made_run(const struct lf_net *net, const struct made_scene *s, enum lf_net_kernel kernel,
                             uint32_t threads, bool again)
{
    struct lf_net_executor *executor;
    struct lf_net_encoding *encodings[MADE_LIGHTS];
    struct lf_net_gathered gathered[MADE_LIGHTS];
    struct made_scene scene = *s;
    struct ng_jobs *jobs;
    OK(ng_jobs_create(&(struct ng_jobs_params){threads}, &jobs));
    OK(lf_net_executor_create(
        &(struct lf_net_executor_params){.net = net, .jobs = jobs, .kernel = kernel, .compact = made_compact},
        &executor));
    for (uint32_t l = 0; l < s->lights; l++) {
        encode(executor, &scene, l, again, &encodings[l]);
        gathered[l] = (struct lf_net_gathered){encodings[l], &scene.light[l]};
    }
    struct made_picture p = make_picture(s);
    const struct lf_net_picture frame = {s->width, s->height, &scene.frame};
    const struct lf_net_radiance out = {p.of[0], p.of[1], p.of[2]};
    for (int i = 0; i < 1 + again; i++)
        OK(lf_net_gather(executor, &frame, gathered, s->lights, &out));
    for (uint32_t l = 0; l < s->lights; l++)
        lf_net_encoding_destroy(&encodings[l]);
    lf_net_executor_destroy(&executor);
    ng_jobs_destroy(&jobs);
    return p;
}

// ---- By definition --------------------------------------------------------------------------------------

// A value, whole: [light][channel][element].
struct whole {
    double *d;
    uint32_t lights, width, height;
    size_t count[MADE_LIGHTS], start[MADE_LIGHTS]; // elements; where a light begins
    uint32_t channels;
};

struct naive {
    const struct lf_net *net;
    const struct made_scene *scene;
    struct whole *values;
};

static struct whole make_whole(const struct naive *n, const struct lf_value *v)
{
    struct whole w = {.channels = v->channels, .lights = is_of_light(v->domain) ? n->scene->lights : 1};
    w.width = (n->scene->width + (1u << v->level) - 1) >> v->level;
    w.height = (n->scene->height + (1u << v->level) - 1) >> v->level;
    size_t total = 0;
    for (uint32_t l = 0; l < w.lights; l++) {
        w.count[l] = lf_is_picture(v->domain) ? (size_t)w.width * w.height : count_of(n->scene, v->domain, l);
        w.start[l] = total;
        total += w.count[l] * w.channels;
    }
    w.d = calloc(total + 1, sizeof *w.d);
    assert_non_null(w.d);
    return w;
}

static double *place(struct whole *w, uint32_t light, uint32_t channel, size_t element)
{
    return &w->d[w->start[light] + channel * w->count[light] + element];
}

// A number of a value that may be of a narrower domain.
static double get(const struct whole *w, uint32_t light, uint32_t channel, size_t element)
{
    uint32_t l = w->lights > 1 ? light : 0;
    return w
        ->d[w->start[l] + (w->channels > 1 ? channel : 0) * w->count[l] + (w->count[l] > 1 ? element : 0)];
}

static double apply(enum lf_op_kind kind, const struct lf_op *op, double x)
{
    switch (kind) {
    case LF_OP_AFFINE:
        return (double)op->scale * x + (double)op->offset;
    case LF_OP_CLAMP:
        return x < (double)op->low ? (double)op->low : x > (double)op->high ? (double)op->high : x;
    case LF_OP_RELU:
        return x > 0 ? x : 0;
    case LF_OP_LEAKY:
        return x > 0 ? x : 0.01 * x;
    case LF_OP_SIGMOID:
        return 1 / (1 + exp(-x));
    case LF_OP_SOFTPLUS:
        return log1p(exp(x));
    case LF_OP_TANH:
        return tanh(x);
    case LF_OP_EXP:
        return exp(x < 30 ? x : 30);
    case LF_OP_LOG:
        return log(x > 1e-12 ? x : 1e-12);
    case LF_OP_LOG1P:
        return log1p(x);
    case LF_OP_SQRT:
        return sqrt(x > 1e-12 ? x : 1e-12);
    case LF_OP_ABS:
        return fabs(x);
    default:
        return x;
    }
}

static double combine(enum lf_op_kind kind, double a, double b)
{
    switch (kind) {
    case LF_OP_ADD:
        return a + b;
    case LF_OP_SUB:
        return a - b;
    case LF_OP_MUL:
        return a * b;
    case LF_OP_DIV:
        return a / b;
    case LF_OP_MIN:
        return a < b ? a : b;
    default:
        return a > b ? a : b;
    }
}

// Channel k of the operands below one another.
static double joined(const struct naive *n, const struct lf_op *op, uint32_t light, uint32_t k,
                     size_t element)
{
    uint32_t i = 0;
    for (; k >= n->net->values.items[op->in[i]].channels; i++)
        k -= n->net->values.items[op->in[i]].channels;
    return get(&n->values[op->in[i]], light, k, element);
}

static uint32_t joined_channels(const struct naive *n, const struct lf_op *op)
{
    uint32_t sum = 0;
    for (uint32_t i = 0; i < op->in_count; i++)
        sum += n->net->values.items[op->in[i]].channels;
    return sum;
}

static double linear(const struct naive *n, const struct lf_op *op, uint32_t light, uint32_t channel,
                     size_t element)
{
    uint32_t inputs = joined_channels(n, op);
    double sum = (double)op->bias[channel];
    for (uint32_t k = 0; k < inputs; k++)
        sum += (double)op->weight[channel * inputs + k] * joined(n, op, light, k, element);
    return apply(op->act, op, sum);
}

static double conv(const struct naive *n, const struct lf_op *op, uint32_t light, uint32_t channel,
                   size_t element, const struct whole *out)
{
    uint32_t inputs = joined_channels(n, op);
    double sum = (double)op->bias[channel];
    int32_t x0 = (int32_t)(element % out->width), y0 = (int32_t)(element / out->width);
    for (uint32_t k = 0; k < inputs; k++)
        for (int32_t tap = 0; tap < 9; tap++) {
            int32_t x = x0 + tap % 3 - 1, y = y0 + tap / 3 - 1;
            if (x >= 0 && y >= 0 && x < (int32_t)out->width && y < (int32_t)out->height)
                sum += (double)op->weight[(channel * inputs + k) * 9 + (uint32_t)tap] *
                       joined(n, op, light, k, (size_t)y * out->width + (size_t)x);
        }
    return apply(op->act, op, sum);
}

static double dot(const struct naive *n, const struct lf_op *op, uint32_t b, uint32_t light, size_t element)
{
    double sum = 0;
    for (uint32_t c = 0; c < n->net->values.items[op->in[0]].channels; c++)
        sum += get(&n->values[op->in[0]], light, c, element) * get(&n->values[op->in[b]], light, c, element);
    return sum;
}

static double length(const struct naive *n, const struct lf_op *op, uint32_t light, size_t element)
{
    return sqrt(dot(n, op, 0, light, element) + 1e-12);
}

static double mean(const struct whole *in, uint32_t light, uint32_t channel)
{
    double sum = 0;
    for (size_t i = 0; i < in->count[light]; i++)
        sum += in->d[in->start[light] + channel * in->count[light] + i];
    return in->count[light] ? sum / (double)in->count[light] : 0;
}

static double resample(enum lf_op_kind kind, const struct whole *in, uint32_t light, uint32_t channel,
                       uint32_t x, uint32_t y)
{
    double sum = 0, count = 0;
    if (kind == LF_OP_UNPACK)
        return get(in, light, 4 * channel + 2 * (y % 2) + x % 2, (size_t)(y / 2) * in->width + x / 2);
    if (kind == LF_OP_PACK) {
        uint32_t fine_x = 2 * x + channel % 2, fine_y = 2 * y + channel / 2 % 2;
        bool inside = fine_x < in->width && fine_y < in->height;
        return inside ? get(in, light, channel / 4, (size_t)fine_y * in->width + fine_x) : 0;
    }
    if (kind == LF_OP_POOL) {
        for (uint32_t i = 0; i < 4; i++)
            if (2 * x + i % 2 < in->width && 2 * y + i / 2 < in->height) {
                sum += get(in, light, channel, (size_t)(2 * y + i / 2) * in->width + 2 * x + i % 2);
                count++;
            }
        return sum / count;
    }
    double u = (x + 0.5) / 2 - 0.5, v = (y + 0.5) / 2 - 0.5; // up
    for (int32_t i = 0; i < 4; i++) {
        int32_t cx = (int32_t)floor(u) + i % 2, cy = (int32_t)floor(v) + i / 2;
        double weight = (1 - fabs(u - cx)) * (1 - fabs(v - cy));
        cx = cx < 0 ? 0 : cx >= (int32_t)in->width ? (int32_t)in->width - 1 : cx;
        cy = cy < 0 ? 0 : cy >= (int32_t)in->height ? (int32_t)in->height - 1 : cy;
        sum += weight * get(in, light, channel, (size_t)cy * in->width + (size_t)cx);
    }
    return sum;
}

static double weight_of(const struct naive *n, const struct lf_op *op, uint32_t operand, uint32_t light)
{
    return op->in_count > operand ? get(&n->values[op->in[operand]], light, 0, 0) : 1;
}

static double sum_lights(const struct naive *n, const struct lf_op *op, uint32_t channel, size_t element)
{
    double sum = 0;
    for (uint32_t l = 0; l < n->scene->lights; l++)
        sum += weight_of(n, op, 1, l) * get(&n->values[op->in[0]], l, channel, element);
    return sum;
}

static double score(const struct naive *n, const struct lf_op *op, uint32_t head, uint32_t light,
                    size_t element)
{
    uint32_t size = n->net->values.items[op->in[0]].channels / op->heads;
    double sum = 0;
    for (uint32_t d = head * size; d < (head + 1) * size; d++)
        sum += get(&n->values[op->in[0]], 0, d, element) * get(&n->values[op->in[1]], light, d, element);
    return sum / sqrt(size);
}

static double attend(const struct naive *n, const struct lf_op *op, uint32_t channel, size_t element)
{
    const struct whole *value = &n->values[op->in[2]];
    uint32_t head = channel / (value->channels / op->heads);
    double sum = 0, total = 0;
    for (uint32_t l = 0; l < n->scene->lights; l++) {
        double a = score(n, op, head, l, element), w = weight_of(n, op, 3, l);
        a = w * (op->softmax ? exp(a) : 1 / (1 + exp(-a)));
        total += a;
        sum += a * get(value, l, channel, element);
    }
    return op->softmax ? sum / total : sum;
}

static double evaluate(const struct naive *n, const struct lf_op *op, uint32_t l, uint32_t c, size_t e,
                       const struct whole *out)
{
    const struct whole *a = &n->values[op->in[0]];
    switch (op->kind) {
    case LF_OP_LINEAR:
        return linear(n, op, l, c, e);
    case LF_OP_CONV:
        return conv(n, op, l, c, e, out);
    case LF_OP_CONCAT:
        return joined(n, op, l, c, e);
    case LF_OP_SLICE:
        return get(a, l, op->from + c, e);
    case LF_OP_DOT:
        return dot(n, op, 1, l, e);
    case LF_OP_LENGTH:
        return length(n, op, l, e);
    case LF_OP_NORMALIZE:
        return get(a, l, c, e) / length(n, op, l, e);
    case LF_OP_MEAN:
        return mean(a, l, c);
    case LF_OP_POOL:
    case LF_OP_PACK:
    case LF_OP_UP:
    case LF_OP_UNPACK:
        return resample(op->kind, a, l, c, (uint32_t)(e % out->width), (uint32_t)(e / out->width));
    case LF_OP_SUM:
        return sum_lights(n, op, c, e);
    case LF_OP_ATTEND:
        return attend(n, op, c, e);
    default:
        return op->in_count == 2 ? combine(op->kind, get(a, l, c, e), get(&n->values[op->in[1]], l, c, e))
                                 : apply(op->kind, op, get(a, l, c, e));
    }
}

static void take_inputs(struct naive *n)
{
    for (uint32_t i = 0; i < LF_INPUT_COUNT; i++) {
        struct whole *w = &n->values[i];
        *w = make_whole(n, &n->net->values.items[i]);
        for (uint32_t l = 0; l < w->lights; l++) {
            const float *from =
                is_of_light(lf_net_inputs[i].domain) ? n->scene->light[l].of[i] : n->scene->frame.of[i];
            for (size_t k = 0; k < w->count[l] * w->channels; k++)
                w->d[w->start[l] + k] = (double)from[k];
        }
    }
}

static void run_op(struct naive *n, const struct lf_op *op)
{
    struct whole w = make_whole(n, &n->net->values.items[op->out]);
    for (uint32_t l = 0; l < w.lights; l++)
        for (uint32_t c = 0; c < w.channels; c++)
            for (size_t e = 0; e < w.count[l]; e++)
                *place(&w, l, c, e) = evaluate(n, op, l, c, e, &w);
    n->values[op->out] = w;
}

struct made_picture made_naive(const char *program, const char *weights, const struct made_scene *s)
{
    struct lf_net net = {0};
    char path[512];
    test_path(path, sizeof path, "naive.safetensors");
    made_write(path, program, weights);
    OK(lf_tensors_read(path, &net.file));
    OK(lf_program_read(&net, path, program));
    struct naive n = {.net = &net, .scene = s, .values = calloc(net.values.count, sizeof *n.values)};
    assert_non_null(n.values);
    take_inputs(&n);
    for (size_t i = 0; i < net.ops.count; i++)
        run_op(&n, &net.ops.items[i]);
    struct made_picture p = make_picture(s);
    for (int i = 0; i < 3; i++)
        for (size_t k = 0; k < p.count; k++)
            p.of[i][k] = (float)n.values[net.outputs[i]].d[k];
    for (size_t i = 0; i < net.values.count; i++)
        free(n.values[i].d);
    free(n.values);
    ng_array_finish(&net.values);
    ng_array_finish(&net.ops);
    lf_tensors_finish(&net.file);
    return p;
}

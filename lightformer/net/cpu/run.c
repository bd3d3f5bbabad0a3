// A segment, tile by tile: fetches each code's operands and calls the kernel.
#include "lightformer/net/cpu/executor_internal.h"

#include "base/system.h"

#include <string.h>

// A tile at work.
struct tile {
    const struct lf_run *run;
    const struct lf_segment *segment;
    struct lf_worker *worker;
    uint32_t grid_width, grid_height;
    uint32_t x, y, width, valid, index, light;
};

uint32_t lf_level_size(uint32_t size, uint32_t level)
{
    return (uint32_t)(((uint64_t)size + (1u << level) - 1) >> level);
}

static float *rows_at(const struct tile *t, struct lf_place place)
{
    return place.buffer == UINT32_MAX ? NULL : t->worker->tile + (size_t)place.row * LF_ROW;
}

static uint32_t *packed_at(const struct tile *t, struct lf_place place)
{
    return (uint32_t *)rows_at(t, place);
}

static const struct lf_value *value_at(const struct tile *t, uint32_t value)
{
    return &t->run->executor->net->values.items[value];
}

static const struct lf_run_light *light_at(const struct tile *t, uint32_t light)
{
    return &t->run->executor->lights.items[light];
}

static const struct lf_image *image_at(const struct tile *t, uint32_t index)
{
    const struct lf_net_executor *e = t->run->executor;
    const struct lf_image_plan *plan = &e->plan.images.items[index];
    switch (plan->owner) {
    case LF_IMAGE_SHARED:
        return &e->shared.items[index];
    case LF_IMAGE_ENCODING:
        return &light_at(t, t->light)->images[plan->slot].image;
    case LF_IMAGE_LOCAL:
        return &t->worker->local[plan->slot].image;
    default:
        break;
    }
    return &e->by_light.images.items[(size_t)t->light * e->plan.image_counts[LF_IMAGE_LIGHT] + plan->slot]
                .image;
}

static float *vector_of(const struct tile *t, uint32_t value, uint32_t light)
{
    return lf_vector_of(t->run->executor, value, light);
}

static float weight_of(const struct tile *t, uint32_t value)
{
    return value == LF_NO_VALUE ? 1.0f : *vector_of(t, value, t->light);
}

// ---- Loads and stores -----------------------------------------------------------------------------------

static void load_input(const struct tile *t, const struct lf_code *code)
{
    float *out = rows_at(t, code->out);
    const struct lf_run *run = t->run;
    const struct lf_value *v = value_at(t, code->value);
    const struct lf_net_values *values =
        v->domain == LF_DOMAIN_PIXEL ? run->pixels : light_at(t, t->light)->inputs;
    const float *in = values ? values->of[v->input] : NULL;
    size_t plane = (size_t)t->grid_width * t->grid_height;
    for (uint32_t c = 0; c < v->channels; c++, out += LF_ROW) {
        if (in)
            memcpy(out, in + c * plane + (size_t)t->y * t->grid_width + t->x, t->valid * sizeof *out);
        memset(out + (in ? t->valid : 0), 0, (t->width - (in ? t->valid : 0)) * sizeof *out);
    }
}

static void load_vector(const struct tile *t, const struct lf_code *code)
{
    float *out = rows_at(t, code->out);
    memset(out, 0, (size_t)code->channels * LF_ROW * sizeof *out);
    for (uint32_t x = 0; x < t->valid; x++) {
        const float *vector = vector_of(t, code->value, t->x + x);
        for (uint32_t c = 0; c < code->channels; c++)
            out[(size_t)c * LF_ROW + x] = vector[c];
    }
}

static void store_vector(const struct tile *t, const struct lf_code *code)
{
    const struct lf_value *v = value_at(t, code->value);
    const float *in = rows_at(t, code->a);
    for (uint32_t x = 0; x < t->valid; x++) {
        float *vector = vector_of(t, code->value, t->x + x);
        for (uint32_t c = 0; c < v->channels; c++)
            vector[c] = in[(size_t)c * LF_ROW + x];
    }
}

static void spread(const struct tile *t, const struct lf_code *code)
{
    float *out = rows_at(t, code->out);
    const float *vector = vector_of(t, code->value, t->light);
    for (uint32_t c = 0; c < code->channels; c++, out += LF_ROW)
        for (uint32_t x = 0; x < t->width; x++)
            out[x] = vector[c];
}

static bool is_compact(const struct tile *t, const struct lf_code *code)
{
    return t->run->executor->plan.images.items[code->image].compact;
}

static void load_image(const struct tile *t, const struct lf_code *code)
{
    const struct lf_kernel *kernel = t->run->executor->kernel;
    const struct lf_image *image = image_at(t, code->image);
    (is_compact(t, code) ? kernel->expand : kernel->unpack)(lf_image_at(image, t->y, 0) + t->x, image->stride,
                                                            code->channels, t->width, rows_at(t, code->out));
}

// Rows of fp32, which packed ones are too where images are compact.
static void store_compact(const struct tile *t, const struct lf_code *code, const float *in)
{
    const struct lf_image *image = image_at(t, code->image);
    uint32_t pairs[LF_ROW];
    for (uint32_t c = 0; c < code->channels; c += 2, in += (size_t)2 * LF_ROW) {
        t->run->executor->kernel->compact(in, c + 1 < code->channels ? in + LF_ROW : NULL, t->width, pairs);
        memcpy(lf_image_at(image, t->y, c / 2) + t->x, pairs, t->valid * sizeof *pairs);
    }
}

static void load_packed(const struct tile *t, const struct lf_code *code)
{
    const struct lf_image *image = image_at(t, code->image);
    uint32_t *out = packed_at(t, code->packed);
    for (uint32_t row = 0; row < code->rows; row++, out += LF_ROW)
        memcpy(out, lf_image_at(image, t->y, row) + t->x, t->width * sizeof *out);
}

// What lies beyond the picture's edge stays zero.
static void store_packed(const struct tile *t, const struct lf_code *code)
{
    const struct lf_image *image = image_at(t, code->image);
    const uint32_t *in = packed_at(t, code->packed);
    if (is_compact(t, code)) {
        store_compact(t, code, rows_at(t, code->packed));
        return;
    }
    for (uint32_t row = 0; row < code->rows; row++, in += LF_ROW)
        memcpy(lf_image_at(image, t->y, row) + t->x, in, t->valid * sizeof *in);
}

static void store_image(const struct tile *t, const struct lf_code *code)
{
    const uint32_t group = t->run->executor->kernel->group;
    const struct lf_image *image = image_at(t, code->image);
    const float *in = rows_at(t, code->a);
    uint32_t packed[LF_ROW];
    if (is_compact(t, code)) {
        store_compact(t, code, in);
        return;
    }
    for (uint32_t row = 0; row < code->rows; row++) {
        const float *rows[2] = {in + (size_t)row * group * LF_ROW, in + ((size_t)row * group + 1) * LF_ROW};
        uint32_t count = code->channels - row * group;
        t->run->executor->kernel->pack(rows, count < group ? count : group, t->width, packed);
        memcpy(lf_image_at(image, t->y, row) + t->x, packed, t->valid * sizeof *packed);
    }
}

static void store_output(const struct tile *t, const struct lf_code *code)
{
    const struct lf_run *run = t->run;
    float *out = run->outputs[code->value];
    const float *in = rows_at(t, code->a);
    size_t plane = (size_t)t->grid_width * t->grid_height;
    for (uint32_t c = 0; out && c < code->channels; c++, in += LF_ROW)
        memcpy(out + c * plane + (size_t)t->y * t->grid_width + t->x, in, t->valid * sizeof *in);
}

static void reduce(const struct tile *t, const struct lf_code *code)
{
    const float *in = rows_at(t, code->a);
    float *sums = t->run->executor->sums.items + (size_t)t->index * t->segment->sums + code->list;
    for (uint32_t c = 0; c < code->channels; c++, in += LF_ROW) {
        sums[c] = 0;
        for (uint32_t x = 0; x < t->valid; x++)
            sums[c] += in[x];
    }
}

// ---- Arithmetic -----------------------------------------------------------------------------------------

static void pack(const struct tile *t, const struct lf_code *code)
{
    const struct lf_kernel *kernel = t->run->executor->kernel;
    const struct lf_place *list = t->run->executor->plan.lists.items + code->list;
    uint32_t *out = packed_at(t, code->packed);
    for (uint32_t i = 0; i < code->list_count; i += kernel->group, out += LF_ROW) {
        const float *rows[2] = {rows_at(t, list[i]), NULL};
        uint32_t count = kernel->group == 2 && i + 1 < code->list_count ? 2 : 1;
        if (count == 2)
            rows[1] = rows_at(t, list[i + 1]);
        kernel->pack(rows, count, t->width, out);
    }
}

static void multiply(const struct tile *t, const struct lf_code *code)
{
    const struct lf_net_executor *e = t->run->executor;
    const struct lf_product *p = &e->plan.products.items[code->product];
    struct lf_product_call call = {.weights = e->weights[code->product],
                                   .bias = e->biases[code->product],
                                   .outputs = p->outputs,
                                   .taps = p->taps,
                                   .rows = p->rows,
                                   .width = t->width,
                                   .stride = LF_ROW,
                                   .act = code->each,
                                   .out = rows_at(t, code->out),
                                   .packed = packed_at(t, code->packed)};
    if (p->constants.count)
        call.bias =
            e->light_biases.items + (p->by_light ? (size_t)t->light * e->plan.bias_floats : 0) + p->bias_at;
    call.in[0] = packed_at(t, code->a);
    if (p->taps == 9) {
        const struct lf_image *image = image_at(t, code->image);
        ptrdiff_t line = (ptrdiff_t)(image->rows * image->stride);
        call.stride = image->stride;
        for (int i = 0; i < 9; i++)
            call.in[i] = lf_image_at(image, t->y, 0) + t->x + (i / 3 - 1) * line + (i % 3 - 1);
    }
    e->kernel->product(&call);
}

static void clear(const struct tile *t, const struct lf_code *code)
{
    memset(rows_at(t, code->out), 0, (size_t)code->rows * LF_ROW * sizeof(float));
}

static void copy(const struct tile *t, const struct lf_code *code)
{
    memcpy(rows_at(t, code->out), rows_at(t, code->a), (size_t)code->rows * LF_ROW * sizeof(float));
}

static void each(const struct tile *t, const struct lf_code *code)
{
    const struct lf_op *op = code->op;
    bool affine = op->kind == LF_OP_AFFINE;
    struct lf_each_call call = {.op = code->each,
                                .a = rows_at(t, code->a),
                                .channels = code->channels,
                                .width = t->width,
                                .x = affine ? op->scale : op->low,
                                .y = affine ? op->offset : op->high,
                                .out = rows_at(t, code->out)};
    t->run->executor->kernel->each(&call);
}

static void pairwise(const struct tile *t, const struct lf_code *code)
{
    struct lf_pairwise_call call = {.op = code->each,
                                    .a = rows_at(t, code->a),
                                    .b = rows_at(t, code->b),
                                    .a_channels = code->channels,
                                    .b_channels = code->b_channels,
                                    .width = t->width,
                                    .out = rows_at(t, code->out)};
    t->run->executor->kernel->pairwise(&call);
}

// The dot of two values, or a value's length.
static void dot(const struct tile *t, const struct lf_code *code)
{
    const struct lf_kernel *kernel = t->run->executor->kernel;
    float *out = rows_at(t, code->out);
    bool length = code->each == LF_OP_LENGTH;
    kernel->dot(rows_at(t, code->a), rows_at(t, length ? code->a : code->b), code->channels, t->width, out);
    if (!length)
        return;
    struct lf_each_call root = {
        .op = LF_OP_AFFINE, .a = out, .channels = 1, .width = t->width, .x = 1, .y = 1e-12f, .out = out};
    kernel->each(&root);
    root.op = LF_OP_SQRT;
    kernel->each(&root);
}

static struct lf_attend_call attention(const struct tile *t, const struct lf_code *code)
{
    const struct lf_op *op = code->op;
    float *state = rows_at(t, code->packed);
    struct lf_attend_call call = {.query = rows_at(t, code->a),
                                  .key = rows_at(t, code->b),
                                  .value = rows_at(t, code->c),
                                  .softmax = op->softmax,
                                  .heads = op->heads,
                                  .key_channels = value_at(t, op->in[0])->channels,
                                  .value_channels = code->channels,
                                  .width = t->width,
                                  .sum = rows_at(t, code->out),
                                  .largest = state,
                                  .total = state ? state + (size_t)op->heads * LF_ROW : NULL};
    return call;
}

static void attend(const struct tile *t, const struct lf_code *code)
{
    struct lf_attend_call call = attention(t, code);
    call.key_is_vector = !call.key;
    call.value_is_vector = !call.value;
    if (call.key_is_vector)
        call.key = vector_of(t, code->op->in[1], t->light);
    if (call.value_is_vector)
        call.value = vector_of(t, code->op->in[2], t->light);
    call.weight = weight_of(t, code->value);
    t->run->executor->kernel->attend(&call);
}

static void attend_end(const struct tile *t, const struct lf_code *code)
{
    struct lf_attend_call call = attention(t, code);
    t->run->executor->kernel->attend_end(&call);
}

static void normalize(const struct tile *t, const struct lf_code *code)
{
    t->run->executor->kernel->normalize(rows_at(t, code->a), code->channels, t->width, rows_at(t, code->out));
}

static void resample(const struct tile *t, const struct lf_code *code)
{
    t->run->executor->kernel->resample(code->each, image_at(t, code->image), t->x, t->y, t->width,
                                       rows_at(t, code->out));
}

static void add_scaled(const struct tile *t, const struct lf_code *code)
{
    t->run->executor->kernel->add_scaled(rows_at(t, code->a), weight_of(t, code->value), code->channels,
                                         t->width, rows_at(t, code->out));
}

static void (*const run_code[LF_CODE_COUNT])(const struct tile *t, const struct lf_code *code) = {
    [LF_CODE_LOAD_INPUT] = load_input,
    [LF_CODE_LOAD_VECTOR] = load_vector,
    [LF_CODE_SPREAD] = spread,
    [LF_CODE_LOAD_IMAGE] = load_image,
    [LF_CODE_LOAD_PACKED] = load_packed,
    [LF_CODE_PACK] = pack,
    [LF_CODE_PRODUCT] = multiply,
    [LF_CODE_PAIRWISE] = pairwise,
    [LF_CODE_EACH] = each,
    [LF_CODE_COPY] = copy,
    [LF_CODE_DOT] = dot,
    [LF_CODE_NORMALIZE] = normalize,
    [LF_CODE_RESAMPLE] = resample,
    [LF_CODE_CLEAR] = clear,
    [LF_CODE_ADD_SCALED] = add_scaled,
    [LF_CODE_ATTEND] = attend,
    [LF_CODE_ATTEND_END] = attend_end,
    [LF_CODE_STORE_IMAGE] = store_image,
    [LF_CODE_STORE_PACKED] = store_packed,
    [LF_CODE_STORE_VECTOR] = store_vector,
    [LF_CODE_STORE_OUTPUT] = store_output,
    [LF_CODE_REDUCE] = reduce,
};

// ---- Tiles ----------------------------------------------------------------------------------------------

static uint64_t multiplications(const struct tile *t, const struct lf_code *code)
{
    const struct lf_op *op = code->op;
    if (code->kind == LF_CODE_PRODUCT) {
        const struct lf_product *p = &t->run->executor->plan.products.items[code->product];
        return (uint64_t)t->valid * p->outputs * p->weights_channels * p->taps;
    }
    if (code->kind == LF_CODE_ATTEND)
        return (uint64_t)t->valid * (value_at(t, op->in[0])->channels + code->channels);
    return 0;
}

static void note_figures(const struct tile *t, const struct lf_code *code, uint64_t ns)
{
    struct lf_figures *figures = &t->worker->figures[t->run->stage];
    bool conv = code->kind == LF_CODE_PRODUCT && code->op->kind == LF_OP_CONV;
    uint32_t kind = conv ? LF_FIGURE_CONV : (uint32_t)code->kind;
    figures->ns[kind] += ns;
    figures->tiles[kind]++;
    figures->multiplications[kind] += multiplications(t, code);
}

static void run_codes(const struct tile *t, uint32_t begin, uint32_t end)
{
    const struct lf_net_executor *e = t->run->executor;
    for (uint32_t i = begin; i < end; i++) {
        const struct lf_code *code = &e->plan.codes.items[i];
        uint64_t start = e->profiling ? ng_clock_ns() : 0;
        run_code[code->kind](t, code);
        if (e->profiling)
            note_figures(t, code, ng_clock_ns() - start);
    }
}

static void run_phases(struct tile *t)
{
    const struct lf_plan *plan = &t->run->executor->plan;
    t->width = (t->valid + LF_STEP - 1) / LF_STEP * LF_STEP;
    for (uint32_t i = t->segment->phase_begin; i < t->segment->phase_end; i++) {
        const struct lf_phase *phase = &plan->phases.items[i];
        t->light = 0;
        run_codes(t, phase->begin, phase->lights);
        for (; phase->lights < phase->end && t->light < t->run->light_count; t->light++)
            run_codes(t, phase->lights, phase->end);
    }
}

// Local images show the part that a tile covers. At the picture's edges what lies beyond must be zero.
static void move_local_images(const struct tile *t, uint32_t x, uint32_t y, bool at_edge)
{
    const struct lf_net_executor *e = t->run->executor;
    for (uint32_t i = 0; i < e->plan.image_counts[LF_IMAGE_LOCAL]; i++) {
        struct lf_stored_image *s = &t->worker->local[i];
        s->image.x0 = x;
        s->image.y0 = y;
        s->image.width = t->run->inner_width;
        s->image.height = t->run->inner_height;
        if (at_edge)
            memset(s->memory, 0, s->capacity);
    }
}

// The pixels of the finer level below a tile.
static void run_inner(const struct tile *t)
{
    const struct lf_run *run = t->run;
    struct tile inner = {
        .run = run, .worker = t->worker, .grid_width = run->inner_width, .grid_height = run->inner_height};
    uint32_t end = 2 * (t->x + t->valid), bottom = 2 * t->y + 2;
    bool at_edge = end > run->inner_width || bottom > run->inner_height;
    end = end < run->inner_width ? end : run->inner_width;
    bottom = bottom < run->inner_height ? bottom : run->inner_height;
    inner.segment = &run->executor->plan.segments.items[t->segment->inner];
    move_local_images(t, 2 * t->x, 2 * t->y, at_edge);
    for (inner.y = 2 * t->y; inner.y < bottom; inner.y++)
        for (inner.x = 2 * t->x; inner.x < end; inner.x += LF_TILE) {
            inner.valid = end - inner.x < LF_TILE ? end - inner.x : LF_TILE;
            run_phases(&inner);
        }
}

static void run_tiles(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    const struct lf_run *run = user;
    run->executor->kernel->begin();
    for (uint32_t i = begin; i < end; i++) {
        struct tile tile = {.run = run,
                            .segment = run->segment,
                            .worker = &run->executor->workers.items[worker],
                            .grid_width = run->width,
                            .grid_height = run->height,
                            .index = i};
        tile.x = i % run->tiles * run->tile;
        tile.y = i / run->tiles;
        tile.valid = run->width - tile.x < run->tile ? run->width - tile.x : run->tile;
        if (run->segment->inner != LF_NO_VALUE)
            run_inner(&tile);
        run_phases(&tile);
    }
    run->executor->kernel->end();
}

void lf_run_segment(struct lf_run *run)
{
    uint32_t count = run->tiles * run->height, threads = ng_jobs_threads(run->executor->jobs);
    uint32_t grain = count / (8 * threads);
    ng_jobs_for(run->executor->jobs, count, grain < 1 ? 1 : grain > 16 ? 16 : grain, run_tiles, run);
}

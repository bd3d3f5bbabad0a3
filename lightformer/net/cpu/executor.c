// Memory and order: what a stage needs is made to fit before it runs, then its segments run one after
// another, each over all threads.
#include "lightformer/net/cpu/executor_internal.h"

#include "base/cpu.h"
#include "base/log.h"

#include <stdlib.h>
#include <string.h>

// ---- Images ---------------------------------------------------------------------------------------------

static void finish_image(struct lf_stored_image *s)
{
    free(s->memory);
    *s = (struct lf_stored_image){0};
}

static void finish_store(struct lf_image_store *store)
{
    lf_memory_finish(&store->memory);
    ng_array_finish(&store->images);
}

// What was laid out in other memory, or in what has been given back since, is nowhere.
static void lend(struct lf_image_store *store, void *data, uint64_t size, bool fresh)
{
    if (fresh || store->memory.base != data || !store->memory.lent)
        store->width = 0;
    lf_memory_lend(&store->memory, data, size);
}

static size_t stride_of(uint32_t width)
{
    return 2 * LF_BORDER + ((size_t)width + LF_STEP - 1) / LF_STEP * LF_STEP;
}

static size_t bytes_of(uint32_t width, uint32_t height, uint32_t rows)
{
    const uint32_t slack = 4 * LF_TILE; // a tile reads past the last row
    return (((size_t)height + 2) * rows * stride_of(width) + slack) * sizeof(uint32_t);
}

// Of another size, all is zero again: the border must be.
static bool fit_image(struct lf_stored_image *s, const struct lf_image *shape)
{
    size_t bytes = bytes_of(shape->width, shape->height, shape->rows);
    bool same = s->image.width == shape->width && s->image.height == shape->height;
    if (s->memory && same && bytes <= s->capacity)
        return true;
    if (!s->memory || bytes > s->capacity) {
        finish_image(s);
        s->memory = aligned_alloc(64, (bytes + 63) / 64 * 64);
        if (!s->memory)
            return false;
        s->capacity = bytes;
    }
    memset(s->memory, 0, s->capacity);
    s->image = *shape;
    s->image.words = s->memory;
    s->image.stride = stride_of(shape->width);
    return true;
}

static uint32_t row_count(const struct lf_run *run, enum lf_net_domain domain)
{
    switch (domain) {
    case LF_DOMAIN_VPL:
        return run->vpl_count;
    case LF_DOMAIN_TEXEL:
        return run->texel_count;
    case LF_DOMAIN_LIGHT:
        return run->light_count;
    default:
        return 1;
    }
}

static bool is_of_rows(const struct lf_plan *plan, const struct lf_image_plan *image)
{
    return lf_is_rows(plan->net->values.items[image->value].domain);
}

// In the size that the stage's picture or rows have.
static struct lf_image shape_of(const struct lf_run *run, const struct lf_image_plan *image)
{
    const struct lf_value *v = &run->executor->plan.net->values.items[image->value];
    bool rows = lf_is_rows(v->domain);
    return (struct lf_image){.width = rows ? row_count(run, v->domain)
                                           : lf_level_size(run->picture_width, v->level),
                             .height = rows ? 1 : lf_level_size(run->picture_height, v->level),
                             .channels = v->channels,
                             .rows = image->rows};
}

static uint64_t image_bytes(const struct lf_plan *plan, const struct lf_image_plan *p, uint32_t width,
                            uint32_t height)
{
    const struct lf_value *v = &plan->net->values.items[p->value];
    return is_of_rows(plan, p)
               ? 0
               : bytes_of(lf_level_size(width, v->level), lf_level_size(height, v->level), p->rows);
}

// Of a picture: the largest image that has the slot.
static uint64_t slot_bytes(const struct lf_plan *plan, enum lf_image_owner owner, uint32_t slot,
                           uint32_t width, uint32_t height)
{
    uint64_t largest = 0;
    for (size_t i = 0; i < plan->images.count; i++) {
        const struct lf_image_plan *p = &plan->images.items[i];
        uint64_t bytes = p->owner == owner && p->slot == slot ? image_bytes(plan, p, width, height) : 0;
        largest = bytes > largest ? bytes : largest;
    }
    return largest;
}

static uint64_t store_bytes(const struct lf_plan *plan, enum lf_image_owner owner, uint32_t width,
                            uint32_t height)
{
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < plan->image_counts[owner]; i++)
        bytes += lf_memory_part(slot_bytes(plan, owner, i, width, height));
    return bytes;
}

// Memory for all images of an owner and a picture's size, zero throughout, unless it is that already.
static ng_result lay_out(struct lf_run *run, enum lf_image_owner owner, uint32_t lights,
                         struct lf_image_store *store)
{
    const struct lf_plan *plan = &run->executor->plan;
    uint32_t width = run->picture_width, height = run->picture_height, count = plan->image_counts[owner];
    if (store->width == width && store->height == height && store->lights >= lights)
        return NG_OK;
    store->width = 0;
    if (!ng_array_resize(&store->images, (size_t)lights * count))
        return ng_out_of_memory("the pictures of a network");
    NG_TRY(lf_memory_begin(&store->memory, lights * store_bytes(plan, owner, width, height),
                           "the pictures of a network"));
    for (uint32_t i = 0; i < lights * count; i++) {
        struct lf_stored_image *s = &store->images.items[i];
        s->capacity = slot_bytes(plan, owner, i % count, width, height);
        s->memory = lf_memory_take(&store->memory, s->capacity, 1);
        if (!s->memory)
            return ng_out_of_memory("the pictures of a network");
        memset(s->memory, 0, s->capacity);
    }
    store->width = width;
    store->height = height;
    store->lights = lights;
    return NG_OK;
}

// Where an image lies in the memory of its slot.
static struct lf_image place_image(const struct lf_run *run, const struct lf_image_plan *p,
                                   const struct lf_stored_image *slot)
{
    struct lf_image image = shape_of(run, p);
    image.words = slot->memory;
    image.stride = stride_of(image.width);
    return image;
}

// Pictures of one image a slot.
static ng_result fit_pictures(struct lf_run *run, enum lf_image_owner owner, uint32_t lights,
                              struct lf_image_store *store)
{
    const struct lf_plan *plan = &run->executor->plan;
    NG_TRY(lay_out(run, owner, lights, store));
    for (uint32_t light = 0; light < lights; light++)
        for (size_t i = 0; i < plan->images.count; i++) {
            const struct lf_image_plan *p = &plan->images.items[i];
            if (p->owner != owner || is_of_rows(plan, p))
                continue;
            struct lf_stored_image *s = &store->images.items[light * plan->image_counts[owner] + p->slot];
            s->image = place_image(run, p, s);
        }
    return NG_OK;
}

// The executor's own: those of rows, or those of pictures. A slot has room for the largest of its images.
static ng_result fit_shared(struct lf_run *run, bool rows)
{
    struct lf_net_executor *e = run->executor;
    if (!rows)
        NG_TRY(lay_out(run, LF_IMAGE_SHARED, 1, &e->work));
    for (size_t i = 0; i < e->plan.images.count; i++) {
        const struct lf_image_plan *p = &e->plan.images.items[i];
        struct lf_image shape = shape_of(run, p);
        if (rows && p->owner == LF_IMAGE_SHARED && is_of_rows(&e->plan, p) &&
            !fit_image(&e->rows.items[p->slot], &shape))
            return ng_out_of_memory("the encoding of a light");
    }
    for (size_t i = 0; i < e->plan.images.count; i++) {
        const struct lf_image_plan *p = &e->plan.images.items[i];
        if (p->owner == LF_IMAGE_SHARED && is_of_rows(&e->plan, p) == rows)
            e->shared.items[i] =
                place_image(run, p, rows ? &e->rows.items[p->slot] : &e->work.images.items[p->slot]);
    }
    return NG_OK;
}

// Above and below of images that begin with this segment: those that had their memory before may have written
// there, as they have another number of rows. Left and right they have the same border.
static void clear_edges(const struct lf_run *run, uint32_t segment)
{
    const struct lf_net_executor *e = run->executor;
    for (size_t i = 0; i < e->plan.images.count; i++) {
        const struct lf_image_plan *p = &e->plan.images.items[i];
        const struct lf_image *image = &e->shared.items[i];
        if (p->owner != LF_IMAGE_SHARED || p->first != segment || is_of_rows(&e->plan, p))
            continue;
        size_t line = image->rows * image->stride;
        memset(image->words, 0, line * sizeof *image->words);
        memset(image->words + ((size_t)image->height + 1) * line, 0, line * sizeof *image->words);
    }
}

// ---- Vectors and biases ---------------------------------------------------------------------------------

// The inputs of a domain that are vectors, to a block.
static void take_vectors(const struct lf_net_executor *e, enum lf_net_domain domain, bool gather,
                         const struct lf_net_values *values, float *block)
{
    for (uint32_t i = 0; i < LF_INPUT_COUNT; i++) {
        const struct lf_net_input_info *info = &lf_net_inputs[i];
        if (info->domain != domain || (domain == LF_DOMAIN_LIGHT && info->gather != gather))
            continue;
        float *out = block + e->plan.vectors.items[i];
        const float *in = values ? values->of[i] : NULL;
        for (uint32_t c = 0; c < info->channels; c++)
            out[c] = in ? in[c] : 0.0f;
    }
}

// What is the same in every column of a product is added to its bias, once a light.
static void find_bias(const struct lf_net_executor *e, const struct lf_product *p, uint32_t light, float *out)
{
    for (uint32_t n = 0; n < p->outputs; n++) {
        const float *weights = p->op->weight + (size_t)n * p->inputs;
        out[n] = p->op->bias[n];
        for (size_t i = 0; i < p->constants.count; i++) {
            const struct lf_constant *constant = &p->constants.items[i];
            const float *vector = lf_vector_of(e, constant->value, light);
            uint32_t channels = e->net->values.items[constant->value].channels;
            for (uint32_t k = 0; k < channels; k++)
                out[n] += weights[constant->column + k] * vector[k];
        }
    }
}

static void find_biases(const struct lf_run *run, const struct lf_segment *segment)
{
    struct lf_net_executor *e = run->executor;
    for (uint32_t i = segment->product_begin; i < segment->product_end; i++) {
        const struct lf_product *p = &e->plan.products.items[i];
        uint32_t count = p->by_light ? run->light_count : 1;
        for (uint32_t light = 0; p->constants.count && light < count; light++)
            find_bias(e, p, light, e->light_biases.items + (size_t)light * e->plan.bias_floats + p->bias_at);
    }
}

// Sums of tiles, in their order.
static void finish_reductions(const struct lf_run *run)
{
    struct lf_net_executor *e = run->executor;
    const struct lf_segment *s = run->segment;
    uint32_t tiles = run->tiles * run->height;
    for (uint32_t i = s->reduce_begin; i < s->reduce_end; i++) {
        const struct lf_reduction *r = &e->plan.reductions.items[i];
        float *out = lf_vector_of(e, r->value, 0);
        for (uint32_t c = 0; c < r->channels; c++) {
            double sum = 0;
            for (uint32_t tile = 0; tile < tiles; tile++)
                sum += e->sums.items[(size_t)tile * s->sums + r->at + c];
            out[c] = (float)(r->mean && run->width ? sum / run->width : sum);
        }
    }
}

// ---- Stages ---------------------------------------------------------------------------------------------

static void set_grid(struct lf_run *run)
{
    const struct lf_segment *s = run->segment;
    bool picture = s->domain == LF_DOMAIN_VIEW;
    run->width = picture ? lf_level_size(run->picture_width, s->level) : row_count(run, s->domain);
    run->height = picture ? lf_level_size(run->picture_height, s->level) : 1;
    run->inner_width = picture && s->level ? lf_level_size(run->picture_width, s->level - 1) : 0;
    run->inner_height = picture && s->level ? lf_level_size(run->picture_height, s->level - 1) : 0;
    run->tiles = (run->width + LF_TILE - 1) / LF_TILE;
    run->tile =
        run->tiles ? ((run->width + run->tiles - 1) / run->tiles + LF_STEP - 1) / LF_STEP * LF_STEP : 0;
}

// Where a linear was moved behind its mean: of no rows, the mean of its results is still 0.
static void clear_empty(const struct lf_run *run)
{
    const struct lf_net *net = run->executor->net;
    for (size_t i = 0; run->stage == LF_STAGE_LIGHT && i < net->ops.count; i++) {
        const struct lf_value *v = &net->values.items[net->ops.items[i].out];
        if (v->rows != LF_NO_VALUE && v->domain == LF_DOMAIN_LIGHT &&
            row_count(run, (enum lf_net_domain)v->rows) == 0)
            memset(lf_vector_of(run->executor, net->ops.items[i].out, 0), 0, v->channels * sizeof(float));
    }
}

static ng_result run_stage(struct lf_run *run)
{
    struct lf_net_executor *e = run->executor;
    for (uint32_t i = e->plan.stage_begin[run->stage]; i < e->plan.stage_begin[run->stage + 1]; i++) {
        run->segment = &e->plan.segments.items[i];
        if (run->segment->nested)
            continue;
        set_grid(run);
        size_t sums = (size_t)run->tiles * run->height * run->segment->sums;
        if (sums > e->sums.count && !ng_array_resize(&e->sums, sums))
            return ng_out_of_memory("the sums of a network");
        clear_edges(run, i);
        find_biases(run, run->segment);
        if (run->segment->inner != LF_NO_VALUE)
            find_biases(run, &e->plan.segments.items[run->segment->inner]);
        lf_run_segment(run);
        finish_reductions(run);
        clear_empty(run);
    }
    return NG_OK;
}

static bool fit_lights(struct lf_net_executor *e, uint32_t count)
{
    uint32_t blocks = count ? count : 1;
    return ng_array_resize(&e->lights, blocks) &&
           (e->vectors.count >= (size_t)blocks * e->plan.light_floats ||
            ng_array_resize(&e->vectors, (size_t)blocks * e->plan.light_floats)) &&
           (e->light_biases.count >= (size_t)blocks * e->plan.bias_floats ||
            ng_array_resize(&e->light_biases, (size_t)blocks * e->plan.bias_floats));
}

ng_result lf_net_encode_light(struct lf_net_executor *executor, struct lf_net_encoding *encoding,
                              const struct lf_net_light_inputs *inputs)
{
    NG_REQUIRE(encoding->executor == executor, "an encoding is used with the executor that made it");
    struct lf_run run = {.executor = executor,
                         .stage = LF_STAGE_LIGHT,
                         .pixels = inputs->values,
                         .light_count = 1,
                         .vpl_count = inputs->vpl_count,
                         .texel_count = inputs->texel_count};
    encoding->has_light = false;
    if (!fit_lights(executor, 1))
        return ng_out_of_memory("the encoding of a light");
    NG_TRY(fit_shared(&run, true));
    executor->lights.items[0] = (struct lf_run_light){.inputs = inputs->values, .vectors = encoding->vectors};
    take_vectors(executor, LF_DOMAIN_FRAME, false, inputs->values, executor->frame.items);
    take_vectors(executor, LF_DOMAIN_LIGHT, false, inputs->values, encoding->vectors);
    NG_TRY(run_stage(&run));
    encoding->has_light = true;
    return NG_OK;
}

ng_result lf_net_encode_view(struct lf_net_executor *executor, struct lf_net_encoding *encoding,
                             const struct lf_net_picture *frame, const struct lf_net_values *view)
{
    NG_REQUIRE(encoding->executor == executor, "an encoding is used with the executor that made it");
    NG_REQUIRE(encoding->has_light, "lf_net_encode_light comes before lf_net_encode_view");
    NG_REQUIRE(frame->width && frame->height, "a picture has pixels");
    struct lf_run run = {.executor = executor,
                         .stage = LF_STAGE_VIEW,
                         .pixels = frame->values,
                         .picture_width = frame->width,
                         .picture_height = frame->height,
                         .light_count = 1};
    encoding->has_view = false;
    if (!fit_lights(executor, 1))
        return ng_out_of_memory("the pictures of a light");
    NG_TRY(fit_pictures(&run, LF_IMAGE_ENCODING, 1, &encoding->images));
    NG_TRY(fit_shared(&run, false));
    executor->lights.items[0] = (struct lf_run_light){
        .inputs = view, .vectors = encoding->vectors, .images = encoding->images.images.items};
    take_vectors(executor, LF_DOMAIN_FRAME, false, frame->values, executor->frame.items);
    NG_TRY(run_stage(&run));
    encoding->has_view = true;
    encoding->width = frame->width;
    encoding->height = frame->height;
    return NG_OK;
}

static ng_result fit_gather(struct lf_run *run)
{
    struct lf_net_executor *e = run->executor;
    if (!fit_lights(e, run->light_count))
        return ng_out_of_memory("the gather of a frame");
    NG_TRY(fit_shared(run, false));
    return fit_pictures(run, LF_IMAGE_LIGHT, run->light_count, &e->by_light);
}

static void set_light(struct lf_net_executor *e, uint32_t light, const struct lf_net_gathered *gathered)
{
    float *vectors = e->vectors.items + (size_t)light * e->plan.light_floats;
    memcpy(vectors, gathered->encoding->vectors, e->plan.kept_floats * sizeof *vectors);
    take_vectors(e, LF_DOMAIN_LIGHT, true, gathered->values, vectors);
    e->lights.items[light] = (struct lf_run_light){
        .inputs = gathered->values, .vectors = vectors, .images = gathered->encoding->images.images.items};
}

static void clear_outputs(const struct lf_run *run)
{
    for (size_t i = 0; i < NG_COUNT(run->outputs); i++)
        if (run->outputs[i])
            memset(run->outputs[i], 0, (size_t)3 * run->picture_width * run->picture_height * sizeof(float));
}

ng_result lf_net_gather(struct lf_net_executor *executor, const struct lf_net_picture *frame,
                        const struct lf_net_gathered *lights, uint32_t light_count,
                        const struct lf_net_radiance *out)
{
    NG_REQUIRE(frame->width && frame->height, "a picture has pixels");
    struct lf_run run = {.executor = executor,
                         .stage = LF_STAGE_GATHER,
                         .pixels = frame->values,
                         .picture_width = frame->width,
                         .picture_height = frame->height,
                         .light_count = light_count,
                         .outputs = {out->unshadowed, out->direct, out->indirect}};
    if (light_count == 0) {
        clear_outputs(&run);
        return NG_OK;
    }
    bool pictures = executor->plan.image_counts[LF_IMAGE_ENCODING] > 0;
    for (uint32_t i = 0; i < light_count; i++) {
        const struct lf_net_encoding *e = lights[i].encoding;
        NG_REQUIRE(e->executor == executor, "an encoding is used with the executor that made it");
        NG_REQUIRE(e->has_light &&
                       (!pictures || (e->has_view && e->width == frame->width && e->height == frame->height)),
                   "light %u was encoded for pictures of this size", i);
    }
    NG_TRY(fit_gather(&run));
    take_vectors(executor, LF_DOMAIN_FRAME, true, frame->values, executor->frame.items);
    for (uint32_t i = 0; i < light_count; i++)
        set_light(executor, i, &lights[i]);
    return run_stage(&run);
}

// ---- Life -----------------------------------------------------------------------------------------------

static ng_result pack_weights(struct lf_net_executor *e)
{
    size_t count = e->plan.products.count;
    e->weights = calloc(count + 1, sizeof *e->weights);
    e->biases = calloc(count + 1, sizeof *e->biases);
    for (size_t i = 0; i < count && e->weights && e->biases; i++) {
        const struct lf_product *p = &e->plan.products.items[i];
        struct lf_weights_call call = {.op = p->op,
                                       .columns = p->columns.items,
                                       .outputs = p->outputs,
                                       .inputs = p->inputs,
                                       .taps = p->taps,
                                       .rows = p->rows};
        e->weights[i] = aligned_alloc(64, (e->kernel->weights_size(&call) + 63) / 64 * 64);
        e->biases[i] = calloc((p->outputs + LF_OUTPUTS - 1) / LF_OUTPUTS * LF_OUTPUTS, sizeof(float));
        if (!e->weights[i] || !e->biases[i])
            return ng_out_of_memory("the weights of a network");
        e->kernel->pack_weights(&call, e->weights[i]);
        memcpy(e->biases[i], p->op->bias, p->outputs * sizeof(float));
    }
    return e->weights && e->biases ? NG_OK : ng_out_of_memory("the weights of a network");
}

// Two rows of a finer level, as wide as a tile covers, and what is read around them.
static bool make_local_images(const struct lf_net_executor *e, struct lf_worker *worker)
{
    const struct lf_plan *plan = &e->plan;
    worker->local = calloc(plan->image_counts[LF_IMAGE_LOCAL] + 1, sizeof *worker->local);
    for (size_t i = 0; worker->local && i < plan->images.count; i++) {
        const struct lf_image_plan *p = &plan->images.items[i];
        const struct lf_image shape = {.width = 2 * LF_TILE,
                                       .height = 2,
                                       .channels = plan->net->values.items[p->value].channels,
                                       .rows = p->rows};
        if (p->owner == LF_IMAGE_LOCAL && !fit_image(&worker->local[p->slot], &shape))
            return false;
    }
    return worker->local;
}

static ng_result make_memory(struct lf_net_executor *e)
{
    bool ok = ng_array_resize(&e->workers, ng_jobs_threads(e->jobs)) &&
              ng_array_resize(&e->rows, e->plan.image_counts[LF_IMAGE_SHARED]) &&
              ng_array_resize(&e->shared, e->plan.images.count) &&
              ng_array_resize(&e->frame, e->plan.frame_floats);
    size_t tile = ((size_t)e->plan.rows + 1) * LF_ROW * sizeof(float);
    for (size_t i = 0; ok && i < e->workers.count; i++) {
        e->workers.items[i].tile = aligned_alloc(64, (tile + 63) / 64 * 64);
        ok = e->workers.items[i].tile;
        if (ok)
            memset(e->workers.items[i].tile, 0, tile);
        ok = ok && make_local_images(e, &e->workers.items[i]);
    }
    return ok ? NG_OK : ng_out_of_memory("a network's executor");
}

static ng_result find_kernel(enum lf_net_kernel wanted, const struct lf_kernel **out)
{
    enum lf_net_kernel id = wanted == LF_KERNEL_AUTO ? LF_KERNEL_AMX : wanted;
    *out = lf_kernel_find(id);
    while (wanted == LF_KERNEL_AUTO && !*out)
        *out = lf_kernel_find(--id);
    if (*out)
        return NG_OK;
    ng_log_error("the network kernel \"%s\" does not run on this CPU, or NG_ISA forbids it; leave the choice "
                 "to the program",
                 lf_net_kernel_name(wanted));
    return NG_ERROR_UNSUPPORTED;
}

ng_result lf_net_executor_create(const struct lf_net_executor_params *params, struct lf_net_executor **out)
{
    const struct lf_kernel *kernel;
    *out = NULL;
    NG_REQUIRE(params->net, "an executor has a network");
    NG_TRY(ng_cpu_check());
    NG_TRY(find_kernel(params->kernel, &kernel));
    struct lf_net_executor *e = calloc(1, sizeof *e);
    if (!e)
        return ng_out_of_memory("a network's executor");
    e->net = params->net;
    e->jobs = params->jobs;
    e->kernel = kernel;
    ng_result result = lf_plan_init(&e->plan, e->net, kernel, params->compact);
    if (result == NG_OK)
        result = make_memory(e);
    if (result == NG_OK)
        result = pack_weights(e);
    if (result != NG_OK)
        lf_net_executor_destroy(&e);
    *out = e;
    return result;
}

void lf_net_executor_destroy(struct lf_net_executor **executor)
{
    struct lf_net_executor *e = *executor;
    if (!e)
        return;
    for (size_t i = 0; i < e->plan.products.count; i++) {
        if (e->weights)
            free(e->weights[i]);
        if (e->biases)
            free(e->biases[i]);
    }
    free(e->weights);
    free(e->biases);
    for (size_t i = 0; i < e->workers.count; i++) {
        for (uint32_t k = 0; e->workers.items[i].local && k < e->plan.image_counts[LF_IMAGE_LOCAL]; k++)
            finish_image(&e->workers.items[i].local[k]);
        free(e->workers.items[i].local);
        free(e->workers.items[i].tile);
    }
    for (size_t i = 0; i < e->rows.count; i++)
        finish_image(&e->rows.items[i]);
    finish_store(&e->work);
    finish_store(&e->by_light);
    ng_array_finish(&e->workers);
    ng_array_finish(&e->rows);
    ng_array_finish(&e->shared);
    ng_array_finish(&e->frame);
    ng_array_finish(&e->vectors);
    ng_array_finish(&e->light_biases);
    ng_array_finish(&e->sums);
    ng_array_finish(&e->lights);
    lf_plan_finish(&e->plan);
    free(e);
    *executor = NULL;
}

bool lf_net_gather_reads(const struct lf_net_executor *executor, enum lf_net_input input)
{
    const struct lf_plan *plan = &executor->plan;
    for (uint32_t s = plan->stage_begin[LF_STAGE_GATHER]; s < plan->stage_begin[LF_STAGE_GATHER + 1]; s++) {
        const struct lf_segment *segment = &plan->segments.items[s];
        for (uint32_t c = segment->code_begin; c < segment->code_end; c++) {
            const struct lf_code *code = &plan->codes.items[c];
            if (code->kind == LF_CODE_LOAD_INPUT && code->value == (uint32_t)input)
                return true;
        }
    }
    return false;
}

struct lf_net_bytes lf_net_picture_bytes(const struct lf_net_executor *executor, uint32_t width,
                                         uint32_t height)
{
    const struct lf_plan *plan = &executor->plan;
    return (struct lf_net_bytes){.light = (plan->kept_floats + 1) * sizeof(float),
                                 .work = store_bytes(plan, LF_IMAGE_SHARED, width, height),
                                 .encoding = store_bytes(plan, LF_IMAGE_ENCODING, width, height),
                                 .gather = store_bytes(plan, LF_IMAGE_LIGHT, width, height)};
}

void lf_net_executor_lend(struct lf_net_executor *executor, void *work, uint64_t size, bool fresh)
{
    lend(&executor->work, work, size, fresh);
}

void lf_net_executor_lend_gather(struct lf_net_executor *executor, void *gather, uint64_t size, bool fresh)
{
    lend(&executor->by_light, gather, size, fresh);
}

void lf_net_encoding_lend_light(struct lf_net_encoding *encoding, void *vectors)
{
    encoding->vectors = vectors;
}

// One of two numbers that share a word, bf16 or compact, or all of it.
static float channel_of(uint32_t word, const struct lf_plan *plan, bool compact, uint32_t channel)
{
    uint32_t bits = compact            ? lf_compact_bits(channel % 2 ? word >> 16 : word & 0xffffu)
                    : plan->group == 1 ? word
                    : channel % 2      ? word & 0xffff0000u
                                       : word << 16;
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static bool is_compact(const struct lf_plan *plan, uint32_t slot)
{
    bool compact = false;
    for (size_t i = 0; i < plan->images.count; i++)
        if (plan->images.items[i].owner == LF_IMAGE_ENCODING && plan->images.items[i].slot == slot)
            compact = plan->images.items[i].compact;
    return compact;
}

bool lf_net_encoding_image(const struct lf_net_encoding *encoding, uint32_t index, uint32_t *width,
                           uint32_t *height, uint32_t *channels, float *out)
{
    const struct lf_image_store *store = &encoding->images;
    if (!encoding->has_view || index >= store->images.count)
        return false;
    const struct lf_image *image = &store->images.items[index].image;
    const struct lf_plan *plan = &encoding->executor->plan;
    bool compact = is_compact(plan, index);
    uint32_t group = compact ? 2 : plan->group;
    *width = image->width;
    *height = image->height;
    *channels = image->channels;
    for (uint32_t c = 0; out && c < image->channels; c++)
        for (uint32_t y = 0; y < image->height; y++) {
            const uint32_t *row = lf_image_at(image, y, c / group);
            for (uint32_t x = 0; x < image->width; x++)
                *out++ = channel_of(row[x], plan, compact, c);
        }
    return true;
}

void lf_net_encoding_lend(struct lf_net_encoding *encoding, void *pictures, uint64_t size, bool fresh)
{
    lend(&encoding->images, pictures, size, fresh);
}

enum lf_net_kernel lf_net_executor_kernel(const struct lf_net_executor *executor)
{
    return executor->kernel->id;
}

const char *lf_net_kernel_name(enum lf_net_kernel kernel)
{
    static const char *const names[] = {"auto", "plain", "avx2", "avx512", "bf16", "amx"};
    return names[kernel];
}

ng_result lf_net_encoding_create(struct lf_net_executor *executor, struct lf_net_encoding **out)
{
    struct lf_net_encoding *e = calloc(1, sizeof *e);
    if (e) {
        e->executor = executor;
        e->vectors = e->own_vectors = calloc(executor->plan.kept_floats + 1, sizeof *e->vectors);
        if (!e->vectors)
            lf_net_encoding_destroy(&e);
    }
    *out = e;
    return e ? NG_OK : ng_out_of_memory("the encoding of a light");
}

void lf_net_encoding_destroy(struct lf_net_encoding **encoding)
{
    struct lf_net_encoding *e = *encoding;
    if (!e)
        return;
    finish_store(&e->images);
    free(e->own_vectors);
    free(e);
    *encoding = NULL;
}

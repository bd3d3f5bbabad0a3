// Crops are chosen by the seed alone. The inputs of the network lie in memory as the network takes them, so
// that writing one is cutting crops out of its planes.
#include "lightformer/dataset/sample.h"

#include "base/half.h"
#include "base/jobs.h"
#include "base/log.h"
#include "base/rng.h"
#include "base/system.h"
#include "lightformer/clues/clues.h"
#include "lightformer/dataset/sampler.h"
#include "lightformer/reference/reference.h"
#include "render/snapshot.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *const lf_stage_names[LF_STAGES] = {"vary", "capture", "encode", "trace", "write"};

#define CROP_STREAM 0x63726f70u // of the seed's random numbers: far from those of variations

struct crop {
    uint32_t x, y;
};

struct lf_sample_writer {
    struct lf_pixel_clues *pixels;
    NG_ARRAY(struct lf_light_clues *) lights; // of the sample the first `used`
    uint32_t used;
};

struct job {
    struct lf_sample_writer *writer;
    const struct lf_sample *sample;
    const struct lf_gbuffer *gbuffer;
    const struct lf_sample_params *params;
    struct lf_tensors *out;
    struct crop *crops;
};

static size_t plane(const struct job *job)
{
    return (size_t)job->params->crop * job->params->crop;
}

// Adds "SEED/name".
static void *add(const struct job *job, const char *name, enum lf_dtype dtype, uint32_t rank,
                 const uint64_t *shape)
{
    char full[LF_TENSOR_NAME];
    snprintf(full, sizeof full, "%" PRIu64 "/%s", job->sample->seed, name);
    return lf_tensors_add(job->out, full, dtype, rank, shape);
}

static void *add_planes(const struct job *job, const char *name, enum lf_dtype dtype, uint32_t channels)
{
    const uint64_t shape[] = {job->params->crops, channels, job->params->crop, job->params->crop};
    return add(job, name, dtype, 4, shape);
}

static ng_result not_finite(const struct job *job, const char *what, uint32_t x, uint32_t y)
{
    ng_log_error(
        "%s is not finite at %u, %u (seed %" PRIu64
        "); look for lights or materials with absurd values, lightformer render --variation shows it",
        what, x, y, job->sample->seed);
    return NG_ERROR_FORMAT;
}

// ---- frame and crops -------------------------------------------------------------------------------------

// Of how many places the busiest is taken, for every second crop: rooms are mostly wall, and walls are soon
// learned.
#define CROP_CANDIDATES 6

// How many pixels of a crop have on their right a surface of another direction, or none.
static uint32_t edges_in(const struct job *job, const struct crop *crop)
{
    const struct lf_gbuffer *g = job->gbuffer;
    uint32_t edges = 0;
    for (uint32_t y = crop->y; y < crop->y + job->params->crop; y++)
        for (uint32_t x = crop->x; x + 1 < crop->x + job->params->crop; x++) {
            size_t i = 4 * ((size_t)y * job->params->size + x);
            const uint16_t *a = g->normal + i;
            float cosine = 0;
            for (size_t c = 0; c < 3; c++)
                cosine += ng_half_to_float(a[c]) * ng_half_to_float(a[4 + c]);
            edges += g->position[i + 3] > 0 && cosine < 0.95f;
        }
    return edges;
}

static struct crop random_crop(const struct lf_sample_params *p, struct ng_rng *rng)
{
    uint32_t x = ng_rng_below(rng, p->size - p->crop + 1);
    return (struct crop){x, ng_rng_below(rng, p->size - p->crop + 1)};
}

static struct crop busiest_crop(const struct job *job, struct ng_rng *rng)
{
    struct crop best = random_crop(job->params, rng);
    uint32_t most = edges_in(job, &best);
    for (int i = 1; i < CROP_CANDIDATES; i++) {
        struct crop c = random_crop(job->params, rng);
        uint32_t edges = edges_in(job, &c);
        if (edges > most) {
            most = edges;
            best = c;
        }
    }
    return best;
}

static ng_result choose_crops(struct job *job)
{
    const struct lf_sample_params *p = job->params;
    struct ng_rng rng = ng_rng_make(job->sample->seed, CROP_STREAM);
    int32_t *origin = add(job, "crop.origin", LF_I32, 2, (const uint64_t[]){p->crops, 2});
    if (!origin)
        return NG_ERROR_MEMORY;
    for (uint32_t i = 0; i < p->crops; i++) {
        struct crop *c = &job->crops[i];
        *c = i % 2 == 1 && p->crop < p->size ? busiest_crop(job, &rng) : random_crop(p, &rng);
        origin[i * 2] = (int32_t)c->x;
        origin[i * 2 + 1] = (int32_t)c->y;
    }
    return NG_OK;
}

static ng_result write_frame(const struct job *job)
{
    const struct ng_snapshot *s = job->sample->snapshot;
    const struct {
        const char *name;
        const float *values;
        uint64_t count;
    } rows[] = {
        {"scene.center", s->scene_center, 3},       {"scene.radius", &s->scene_radius, 1},
        {"camera.position", s->camera.position, 3}, {"camera.view", s->camera.view, 16},
        {"camera.fov_y", &s->camera.fov_y, 1},      {"time", (const float[]){(float)job->sample->time}, 1},
    };
    for (size_t i = 0; i < NG_COUNT(rows); i++) {
        float *to = add(job, rows[i].name, LF_F32, 1, &rows[i].count);
        if (!to)
            return NG_ERROR_MEMORY;
        memcpy(to, rows[i].values, rows[i].count * sizeof *to);
    }
    return NG_OK;
}

// The frame's pixel under pixel `i` of a crop.
static size_t frame_pixel(const struct job *job, const struct crop *c, size_t i)
{
    uint32_t crop = job->params->crop;
    return (size_t)(c->y + i / crop) * job->params->size + c->x + i % crop;
}

static ng_result write_emission(const struct job *job)
{
    float *to = add_planes(job, "gbuffer.emission", LF_F32, 3);
    size_t n = plane(job);
    if (!to)
        return NG_ERROR_MEMORY;
    for (uint32_t k = 0; k < job->params->crops; k++)
        for (size_t i = 0; i < n; i++) {
            const float *from = job->gbuffer->emission + 4 * frame_pixel(job, &job->crops[k], i);
            for (size_t c = 0; c < 3; c++) {
                to[(k * 3 + c) * n + i] = from[c];
                if (!isfinite(from[c]))
                    return not_finite(job, "gbuffer.emission",
                                      job->crops[k].x + (uint32_t)(i % job->params->crop),
                                      job->crops[k].y + (uint32_t)(i / job->params->crop));
            }
        }
    return NG_OK;
}

// ---- inputs of the network -------------------------------------------------------------------------------

// Clues for one more light.
static ng_result reserve_light(struct lf_sample_writer *w)
{
    if (w->used < w->lights.count)
        return NG_OK;
    struct lf_light_clues *clues;
    NG_TRY(lf_light_clues_create(&clues));
    if (ng_array_push(&w->lights, clues))
        return NG_OK;
    lf_light_clues_destroy(&clues);
    return ng_out_of_memory("the inputs of a light");
}

// Of the lights that shine.
static ng_result encode(const struct job *job)
{
    struct lf_sample_writer *w = job->writer;
    const struct ng_snapshot *s = job->sample->snapshot;
    const struct lf_clues_scene scene = {.tracer = job->sample->tracer, .jobs = job->params->jobs};
    const struct lf_clues_light_params params = {.vpl_count = job->params->vpls};
    NG_TRY(lf_clues_pixels(&scene,
                           &(struct lf_clues_pixels_params){.gbuffer = *job->gbuffer,
                                                            .width = job->params->size,
                                                            .height = job->params->size},
                           w->pixels));
    w->used = 0;
    for (uint32_t i = 0; i < s->light_count; i++) {
        if (!(ng_light_power(&s->lights[i].source) > 0))
            continue;
        NG_TRY(reserve_light(w));
        struct lf_light_clues *light = w->lights.items[w->used++];
        NG_TRY(lf_clues_light(&scene, i, &params, light));
        NG_TRY(lf_clues_view(&scene, w->pixels, light));
    }
    lf_clues_set_powers(s, w->pixels, w->lights.items, w->used);
    return lf_clues_arriving(&scene, w->pixels, w->lights.items, w->used);
}

struct input {
    enum lf_net_input id;
    const char *name;
    enum lf_net_domain domain;
    uint32_t channels;
};

static const struct input inputs[] = {
#define LF_INPUT(id, name, domain, channels, when) {LF_INPUT_##id, name, LF_DOMAIN_##domain, channels},
#include "lightformer/net/inputs.inc"
#undef LF_INPUT
};

// Halfs, but for what is once a frame or a light, for places, and for distances, whose differences matter.
static enum lf_dtype dtype_of(const struct input *input)
{
    static const enum lf_net_input precise[] = {LF_INPUT_PIXEL_POSITION, LF_INPUT_PIXEL_DISTANCE,
                                                LF_INPUT_VPL_OFFSET,     LF_INPUT_VPL_POSITION,
                                                LF_INPUT_TEXEL_OFFSET,   LF_INPUT_TEXEL_POSITION,
                                                LF_INPUT_VIEW_DISTANCE,  LF_INPUT_VIEW_SHADOW_DISTANCE};
    for (size_t i = 0; i < NG_COUNT(precise); i++)
        if (input->id == precise[i])
            return LF_F32;
    return input->domain == LF_DOMAIN_FRAME || input->domain == LF_DOMAIN_LIGHT ? LF_F32 : LF_F16;
}

static const struct lf_net_values *values_of(const struct job *job, uint32_t light)
{
    return lf_light_clues_values(job->writer->lights.items[light]);
}

static uint32_t rows_of(const struct job *job, const struct input *input, uint32_t light)
{
    const struct lf_light_clues *clues = job->writer->lights.items[light];
    return input->domain == LF_DOMAIN_VPL ? lf_light_clues_vpls(clues) : lf_light_clues_texels(clues);
}

// Number `index` of a tensor. Halfs end at 65504.
static void put(void *data, enum lf_dtype dtype, size_t index, float value)
{
    if (dtype == LF_F32)
        ((float *)data)[index] = value;
    else
        ((uint16_t *)data)[index] = ng_half_from_float(fminf(fmaxf(value, -65504), 65504));
}

static ng_result write_frame_input(const struct job *job, const struct input *input)
{
    float *to = add(job, input->name, LF_F32, 1, (const uint64_t[]){input->channels});
    if (!to)
        return NG_ERROR_MEMORY;
    memcpy(to, lf_pixel_clues_values(job->writer->pixels)->of[input->id], input->channels * sizeof *to);
    return NG_OK;
}

static ng_result write_light_input(const struct job *job, const struct input *input)
{
    float *to = add(job, input->name, LF_F32, 2, (const uint64_t[]){job->writer->used, input->channels});
    if (!to)
        return NG_ERROR_MEMORY;
    for (uint32_t l = 0; l < job->writer->used; l++)
        memcpy(to + (size_t)l * input->channels, values_of(job, l)->of[input->id],
               input->channels * sizeof *to);
    return NG_OK;
}

// As many rows as the light with most has. A light without extent has one direct VPL, which is repeated: its
// mean stays. Texels that others lack are zeros.
static ng_result write_rows(const struct job *job, const struct input *input)
{
    uint32_t most = 0;
    for (uint32_t l = 0; l < job->writer->used; l++)
        most = rows_of(job, input, l) > most ? rows_of(job, input, l) : most;
    enum lf_dtype dtype = dtype_of(input);
    void *to = add(job, input->name, dtype, 3, (const uint64_t[]){job->writer->used, input->channels, most});
    if (!to)
        return NG_ERROR_MEMORY;
    for (uint32_t l = 0; l < job->writer->used; l++) {
        size_t rows = rows_of(job, input, l), filled = input->domain == LF_DOMAIN_VPL ? most : rows;
        for (size_t c = 0; c < input->channels; c++)
            for (size_t i = 0; rows && i < filled; i++)
                put(to, dtype, ((size_t)l * input->channels + c) * most + i,
                    values_of(job, l)->of[input->id][c * rows + i % rows]);
    }
    return NG_OK;
}

// Crop `k` of planes of the frame (null: zeros), as planes from number `first` on.
static void cut(const struct job *job, uint32_t k, const float *planes, uint32_t channels,
                enum lf_dtype dtype, void *to, size_t first)
{
    size_t n = plane(job), all = (size_t)job->params->size * job->params->size;
    for (size_t c = 0; planes && c < channels; c++)
        for (size_t i = 0; i < n; i++)
            put(to, dtype, first + c * n + i, planes[c * all + frame_pixel(job, &job->crops[k], i)]);
}

static ng_result write_pixel_input(const struct job *job, const struct input *input)
{
    enum lf_dtype dtype = dtype_of(input);
    void *to = add_planes(job, input->name, dtype, input->channels);
    if (!to)
        return NG_ERROR_MEMORY;
    for (uint32_t k = 0; k < job->params->crops; k++)
        cut(job, k, lf_pixel_clues_values(job->writer->pixels)->of[input->id], input->channels, dtype, to,
            k * input->channels * plane(job));
    return NG_OK;
}

static ng_result write_view_input(const struct job *job, const struct input *input)
{
    uint32_t lights = job->writer->used, crop = job->params->crop;
    enum lf_dtype dtype = dtype_of(input);
    void *to = add(job, input->name, dtype, 5,
                   (const uint64_t[]){job->params->crops, lights, input->channels, crop, crop});
    if (!to)
        return NG_ERROR_MEMORY;
    for (uint32_t k = 0; k < job->params->crops; k++)
        for (uint32_t l = 0; l < lights; l++)
            cut(job, k, values_of(job, l)->of[input->id], input->channels, dtype, to,
                ((size_t)k * lights + l) * input->channels * plane(job));
    return NG_OK;
}

static ng_result write_inputs(const struct job *job)
{
    static ng_result (*const write[])(const struct job *, const struct input *) = {
        [LF_DOMAIN_FRAME] = write_frame_input, [LF_DOMAIN_LIGHT] = write_light_input,
        [LF_DOMAIN_VPL] = write_rows,          [LF_DOMAIN_TEXEL] = write_rows,
        [LF_DOMAIN_PIXEL] = write_pixel_input, [LF_DOMAIN_VIEW] = write_view_input,
    };
    for (size_t i = 0; i < NG_COUNT(inputs); i++)
        NG_TRY(write[inputs[i].domain](job, &inputs[i]));
    return NG_OK;
}

// ---- targets ---------------------------------------------------------------------------------------------

static ng_result take_layer(const struct job *job, const struct lf_reference *reference, const char *layer,
                            const char *name, uint32_t crop, float *floats, uint16_t *halfs)
{
    struct lf_layer from;
    size_t n = plane(job);
    NG_TRY(lf_reference_layer(reference, layer, &from));
    ng_result result = NG_OK;
    for (size_t i = 0; result == NG_OK && i < n; i++)
        for (size_t c = 0; result == NG_OK && c < 3; c++) {
            float value = ((const float *)from.pixels)[i * 3 + c];
            size_t to = (crop * 3 + c) * n + i;
            if (floats)
                floats[to] = value;
            else
                halfs[to] = ng_half_from_float(value);
            if (!isfinite(value))
                result = not_finite(job, name, job->crops[crop].x + (uint32_t)(i % job->params->crop),
                                    job->crops[crop].y + (uint32_t)(i / job->params->crop));
        }
    free(from.pixels);
    return result;
}

static ng_result trace_crop(const struct job *job, uint32_t crop, float *unshadowed, uint16_t *shadow,
                            float *indirect)
{
    const struct lf_sample_params *p = job->params;
    struct lf_reference_params params = {
        .width = p->size,
        .height = p->size,
        .region = {job->crops[crop].x, job->crops[crop].y, p->crop, p->crop},
        .depth = p->depth,
        .seed = job->sample->seed,
        .jobs = p->jobs,
    };
    struct lf_reference *reference;
    NG_TRY(lf_reference_create(&params, &reference));
    ng_result result = lf_reference_begin(reference, job->sample->tracer);
    if (result == NG_OK)
        result = lf_reference_run(reference, &(struct lf_reference_run_params){.samples = p->spp});
    if (result == NG_OK)
        result = take_layer(job, reference, "unshadowed", "target.unshadowed", crop, unshadowed, NULL);
    if (result == NG_OK)
        result = take_layer(job, reference, "shadow", "target.shadow", crop, NULL, shadow);
    if (result == NG_OK)
        result = take_layer(job, reference, "indirect", "target.indirect", crop, indirect, NULL);
    lf_reference_destroy(&reference);
    return result;
}

// "SEED/name" of the shard with targets, if it is of `bytes` bytes; else null.
static const void *find_target(const struct job *job, const char *name, uint64_t bytes)
{
    char full[LF_TENSOR_NAME];
    snprintf(full, sizeof full, "%" PRIu64 "/%s", job->sample->seed, name);
    const struct lf_tensor *found = lf_tensors_find(job->params->targets, full);
    return found && found->size == bytes ? found->data : NULL;
}

// Whether the shard with targets holds this picture: the same tensors that say what is seen, and from where.
static bool has_this_picture(const struct job *job)
{
    static const char *const names[] = {"crop.origin", "camera.position", "camera.view", "camera.fov_y",
                                        "time",        "scene.radius"};
    for (size_t i = 0; i < NG_COUNT(names); i++) {
        char full[LF_TENSOR_NAME];
        snprintf(full, sizeof full, "%" PRIu64 "/%s", job->sample->seed, names[i]);
        const struct lf_tensor *ours = lf_tensors_find(job->out, full);
        const void *theirs = ours ? find_target(job, names[i], ours->size) : NULL;
        if (!theirs || memcmp(ours->data, theirs, ours->size) != 0)
            return false;
    }
    return true;
}

// False if the shard with targets does not hold all of them.
static bool copy_targets(const struct job *job, float *unshadowed, uint16_t *shadow, float *indirect)
{
    if (!job->params->targets || !has_this_picture(job))
        return false;
    size_t n = 3 * plane(job) * job->params->crops;
    const void *from[] = {find_target(job, "target.unshadowed", n * sizeof *unshadowed),
                          find_target(job, "target.shadow", n * sizeof *shadow),
                          find_target(job, "target.indirect", n * sizeof *indirect)};
    if (!from[0] || !from[1] || !from[2])
        return false;
    memcpy(unshadowed, from[0], n * sizeof *unshadowed);
    memcpy(shadow, from[1], n * sizeof *shadow);
    memcpy(indirect, from[2], n * sizeof *indirect);
    return true;
}

static ng_result write_targets(const struct job *job)
{
    float *unshadowed = add_planes(job, "target.unshadowed", LF_F32, 3);
    uint16_t *shadow = unshadowed ? add_planes(job, "target.shadow", LF_F16, 3) : NULL;
    float *indirect = shadow ? add_planes(job, "target.indirect", LF_F32, 3) : NULL;
    if (!indirect)
        return NG_ERROR_MEMORY;
    if (copy_targets(job, unshadowed, shadow, indirect))
        return NG_OK;
    for (uint32_t k = 0; k < job->params->crops; k++)
        NG_TRY(trace_crop(job, k, unshadowed, shadow, indirect));
    return NG_OK;
}

// What pixels take is nearly everything.
double lf_sample_least_bytes(const struct lf_sample_params *params)
{
    uint32_t a_pixel = 3 * (3 * lf_dtype_size(LF_F32) + lf_dtype_size(LF_F16)); // targets and emission
    for (size_t i = 0; i < NG_COUNT(inputs); i++)
        if (inputs[i].domain == LF_DOMAIN_PIXEL || inputs[i].domain == LF_DOMAIN_VIEW)
            a_pixel += inputs[i].channels * lf_dtype_size(dtype_of(&inputs[i]));
    return (double)a_pixel * params->crop * params->crop * params->crops;
}

// ---- all of it -------------------------------------------------------------------------------------------

static ng_result timed(double *seconds, ng_result (*stage)(const struct job *), const struct job *job)
{
    uint64_t begin = ng_clock_ns();
    ng_result result = stage(job);
    *seconds += (double)(ng_clock_ns() - begin) * 1e-9;
    return result;
}

static ng_result copy_inputs(const struct job *job)
{
    NG_TRY(write_frame(job));
    NG_TRY(write_emission(job));
    return write_inputs(job);
}

ng_result lf_sample_writer_create(struct lf_sample_writer **out)
{
    *out = calloc(1, sizeof **out);
    if (!*out)
        return ng_out_of_memory("the inputs of a sample");
    ng_result result = lf_pixel_clues_create(&(*out)->pixels);
    if (result != NG_OK)
        lf_sample_writer_destroy(out);
    return result;
}

void lf_sample_writer_destroy(struct lf_sample_writer **writer)
{
    struct lf_sample_writer *w = *writer;
    *writer = NULL;
    if (!w)
        return;
    for (size_t i = 0; i < w->lights.count; i++)
        lf_light_clues_destroy(&w->lights.items[i]);
    ng_array_finish(&w->lights);
    lf_pixel_clues_destroy(&w->pixels);
    free(w);
}

ng_result lf_sample_write(struct lf_sample_writer *writer, const struct lf_sample *sample,
                          const struct lf_captured_frame *observation, const struct lf_sample_params *params,
                          struct lf_tensors *out, double spent[LF_STAGES])
{
    struct job job = {.writer = writer,
                      .sample = sample,
                      .gbuffer = &observation->gbuffer,
                      .params = params,
                      .out = out,
                      .crops = calloc(params->crops, sizeof *job.crops)};
    if (!job.crops)
        return ng_out_of_memory("the crops of a sample");
    ng_result result = choose_crops(&job);
    if (result == NG_OK)
        result = timed(&spent[LF_STAGE_ENCODE], encode, &job);
    if (result == NG_OK)
        result = timed(&spent[LF_STAGE_WRITE], copy_inputs, &job);
    if (result == NG_OK)
        result = timed(&spent[LF_STAGE_TRACE], write_targets, &job);
    free(job.crops);
    return result;
}

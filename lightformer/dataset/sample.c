// Crops are chosen by the seed alone. Pictures become planes, [channel][row][column], as convolutions want
// them; halfs of the G-buffer stay the halfs that they are.
#include "lightformer/dataset/sample.h"

#include "base/half.h"
#include "base/jobs.h"
#include "base/log.h"
#include "base/rng.h"
#include "base/system.h"
#include "lightformer/dataset/sampler.h"
#include "lightformer/reference/reference.h"
#include "render/frame.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *const lf_stage_names[LF_STAGES] = {"vary", "observe", "lookup", "trace", "write"};

#define CROP_STREAM 0x63726f70u // of the seed's random numbers: far from those of variations

struct crop {
    uint32_t x, y;
};

struct job {
    const struct lf_sample *sample;
    const struct lf_observation *observation;
    const struct lf_sample_params *params;
    struct lf_tensors *out;
    struct crop *crops;
};

static size_t plane(const struct job *job)
{
    return (size_t)job->params->crop * job->params->crop;
}

// Adds "SEED/name"; of crops where `crop_rank`: then [crops] comes first and [crop, crop] last.
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

static ng_result choose_crops(struct job *job)
{
    const struct lf_sample_params *p = job->params;
    struct ng_rng rng = ng_rng_make(job->sample->seed, CROP_STREAM);
    int32_t *origin = add(job, "crop.origin", LF_I32, 2, (const uint64_t[]){p->crops, 2});
    if (!origin)
        return NG_ERROR_MEMORY;
    for (uint32_t i = 0; i < p->crops; i++) {
        struct crop *c = &job->crops[i];
        c->x = ng_rng_below(&rng, p->size - p->crop + 1);
        c->y = ng_rng_below(&rng, p->size - p->crop + 1);
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

// ---- G-buffer --------------------------------------------------------------------------------------------

// The frame's pixel under pixel `i` of a crop.
static size_t frame_pixel(const struct job *job, const struct crop *c, size_t i)
{
    uint32_t crop = job->params->crop;
    return (size_t)(c->y + i / crop) * job->params->size + c->x + i % crop;
}

static ng_result write_positions(const struct job *job)
{
    float *position = add_planes(job, "gbuffer.position", LF_F32, 3);
    uint8_t *mask = position ? add_planes(job, "gbuffer.mask", LF_U8, 1) : NULL;
    size_t n = plane(job);
    if (!mask)
        return NG_ERROR_MEMORY;
    for (uint32_t k = 0; k < job->params->crops; k++)
        for (size_t i = 0; i < n; i++) {
            const float *from = job->observation->gbuffer.position + 4 * frame_pixel(job, &job->crops[k], i);
            for (size_t c = 0; c < 3; c++)
                position[(k * 3 + c) * n + i] = from[c];
            mask[k * n + i] = from[3] > 0;
            if (!isfinite(from[0] + from[1] + from[2]))
                return not_finite(job, "gbuffer.position",
                                  job->crops[k].x + (uint32_t)(i % job->params->crop),
                                  job->crops[k].y + (uint32_t)(i / job->params->crop));
        }
    return NG_OK;
}

// Some channels of a picture of halfs.
static ng_result write_halfs(const struct job *job, const char *name, const uint16_t *picture,
                             uint32_t first_channel, uint32_t channels)
{
    uint16_t *to = add_planes(job, name, LF_F16, channels);
    size_t n = plane(job);
    if (!to)
        return NG_ERROR_MEMORY;
    for (uint32_t k = 0; k < job->params->crops; k++)
        for (size_t i = 0; i < n; i++) {
            const uint16_t *from = picture + 4 * frame_pixel(job, &job->crops[k], i) + first_channel;
            for (size_t c = 0; c < channels; c++) {
                to[(k * channels + c) * n + i] = from[c];
                if ((from[c] & 0x7c00) == 0x7c00)
                    return not_finite(job, name, job->crops[k].x + (uint32_t)(i % job->params->crop),
                                      job->crops[k].y + (uint32_t)(i / job->params->crop));
            }
        }
    return NG_OK;
}

static ng_result write_gbuffer(const struct job *job)
{
    const struct lf_gbuffer *g = &job->observation->gbuffer;
    NG_TRY(write_positions(job));
    NG_TRY(write_halfs(job, "gbuffer.normal", g->normal, 0, 3));
    NG_TRY(write_halfs(job, "gbuffer.roughness", g->normal, 3, 1));
    NG_TRY(write_halfs(job, "gbuffer.diffuse", g->diffuse, 0, 3));
    NG_TRY(write_halfs(job, "gbuffer.specular", g->specular, 0, 3));
    return write_halfs(job, "gbuffer.emission", g->emission, 0, 3);
}

// ---- lights ----------------------------------------------------------------------------------------------

static ng_result write_proxies(const struct job *job)
{
    const struct lf_observation *o = job->observation;
    const uint64_t shape[] = {o->light_count, 3};
    float *power = add(job, "light.power", LF_F32, 2, shape);
    float *proxy = power ? add(job, "light.proxy", LF_F32, 2, shape) : NULL;
    float *look = proxy ? add(job, "light.look", LF_F32, 2, shape) : NULL;
    int32_t *kind = look ? add(job, "light.kind", LF_I32, 1, shape) : NULL;
    if (!kind)
        return NG_ERROR_MEMORY;
    for (size_t l = 0; l < o->light_count; l++) {
        memcpy(power + 3 * l, o->lights[l].power, 3 * sizeof *power);
        memcpy(proxy + 3 * l, o->lights[l].data.proxy, 3 * sizeof *proxy);
        memcpy(look + 3 * l, o->lights[l].data.look, 3 * sizeof *look);
        kind[l] = (int32_t)o->lights[l].data.vpl_kind;
    }
    return NG_OK;
}

static ng_result write_vpls(const struct job *job)
{
    const struct lf_observation *o = job->observation;
    const uint64_t shape[] = {o->light_count, o->vpl_count, 3};
    float *position = add(job, "vpl.position", LF_F32, 3, shape);
    float *normal = position ? add(job, "vpl.normal", LF_F32, 3, shape) : NULL;
    float *radiance = normal ? add(job, "vpl.radiance", LF_F32, 3, shape) : NULL;
    float *power = radiance ? add(job, "vpl.power", LF_F32, 3, shape) : NULL;
    float *pdf = power ? add(job, "vpl.pdf", LF_F32, 2, shape) : NULL;
    if (!pdf)
        return NG_ERROR_MEMORY;
    for (uint32_t l = 0; l < o->light_count; l++)
        for (uint32_t i = 0; i < o->vpl_count; i++) {
            const struct ng_light_sample *v = &o->lights[l].vpls[i];
            size_t at = (size_t)l * o->vpl_count + i;
            memcpy(position + 3 * at, v->position, sizeof v->position);
            memcpy(normal + 3 * at, v->normal, sizeof v->normal);
            memcpy(radiance + 3 * at, v->radiance, sizeof v->radiance);
            memcpy(power + 3 * at, v->power, sizeof v->power);
            pdf[at] = v->pdf;
            if (!isfinite(v->power[0] + v->power[1] + v->power[2] + v->pdf))
                return not_finite(job, "vpl.power of light, VPL", l, i);
        }
    return NG_OK;
}

static uint32_t most_views(const struct lf_observation *o)
{
    uint32_t most = 0;
    for (uint32_t l = 0; l < o->light_count; l++)
        most = o->lights[l].rsm_views > most ? o->lights[l].rsm_views : most;
    return most;
}

static ng_result write_rsm(const struct job *job)
{
    enum { TEXELS = NG_RSM_SIZE * NG_RSM_SIZE };
    const struct lf_observation *o = job->observation;
    const uint64_t views = most_views(o);
    const uint64_t shape[] = {o->light_count, views, 3, NG_RSM_SIZE, NG_RSM_SIZE};
    const uint64_t mask_shape[] = {o->light_count, views, NG_RSM_SIZE, NG_RSM_SIZE};
    float *position = add(job, "rsm.position", LF_F32, 5, shape);
    float *flux = position ? add(job, "rsm.flux", LF_F32, 5, shape) : NULL;
    uint16_t *normal = flux ? add(job, "rsm.normal", LF_F16, 5, shape) : NULL;
    uint8_t *mask = normal ? add(job, "rsm.mask", LF_U8, 4, mask_shape) : NULL;
    if (!mask)
        return NG_ERROR_MEMORY;
    for (uint32_t l = 0; l < o->light_count; l++)
        for (size_t v = 0; v < o->lights[l].rsm_views; v++)
            for (size_t i = 0; i < TEXELS; i++) {
                const struct lf_light_observation *light = &o->lights[l];
                size_t from = (v * TEXELS + i) * 4, view = l * views + v;
                mask[view * TEXELS + i] = light->position[from + 3] > 0;
                for (size_t c = 0; mask[view * TEXELS + i] && c < 3; c++) {
                    size_t to = (view * 3 + c) * TEXELS + i;
                    position[to] = light->position[from + c];
                    normal[to] = light->normal[from + c];
                    flux[to] = light->flux[from + c];
                    if (!isfinite(flux[to]))
                        return not_finite(job, "rsm.flux of light, texel", l, (uint32_t)(v * TEXELS + i));
                }
            }
    return NG_OK;
}

// ---- shadow lookups --------------------------------------------------------------------------------------

struct lookup {
    const struct job *job;
    float *out; // [crops][lights][2][crop][crop]
};

// One row of one crop for all lights.
static void look_up_rows(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct lookup *l = user;
    const struct job *job = l->job;
    const struct lf_observation *o = job->observation;
    size_t n = plane(job), crop = job->params->crop;
    for (size_t row = begin; row < end; row++) {
        size_t k = row / crop;
        for (size_t i = row % crop * crop; i < (row % crop + 1) * crop; i++) {
            const float *position = o->gbuffer.position + 4 * frame_pixel(job, &job->crops[k], i);
            for (size_t light = 0; position[3] > 0 && light < o->light_count; light++) {
                const struct lf_light_observation *seen = &o->lights[light];
                struct lf_depth_map map = {&seen->data, seen->depth, seen->depth_views, seen->face_size};
                struct lf_shadow s = lf_shadow_lookup(&map, position);
                float *to = l->out + (k * o->light_count + light) * 2 * n + i;
                to[0] = s.occluder;
                to[n] = s.receiver;
            }
        }
    }
}

static ng_result write_lookups(const struct job *job)
{
    const struct lf_sample_params *p = job->params;
    const uint64_t shape[] = {p->crops, job->observation->light_count, 2, p->crop, p->crop};
    struct lookup lookup = {job, add(job, "shadow.distance", LF_F32, 5, shape)};
    if (!lookup.out)
        return NG_ERROR_MEMORY;
    ng_jobs_for(p->jobs, p->crops * p->crop, 8, look_up_rows, &lookup);
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

static ng_result write_targets(const struct job *job)
{
    float *unshadowed = add_planes(job, "target.unshadowed", LF_F32, 3);
    uint16_t *shadow = unshadowed ? add_planes(job, "target.shadow", LF_F16, 3) : NULL;
    float *indirect = shadow ? add_planes(job, "target.indirect", LF_F32, 3) : NULL;
    if (!indirect)
        return NG_ERROR_MEMORY;
    for (uint32_t k = 0; k < job->params->crops; k++)
        NG_TRY(trace_crop(job, k, unshadowed, shadow, indirect));
    return NG_OK;
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
    NG_TRY(write_gbuffer(job));
    NG_TRY(write_proxies(job));
    NG_TRY(write_vpls(job));
    return write_rsm(job);
}

ng_result lf_sample_write(const struct lf_sample *sample, const struct lf_observation *observation,
                          const struct lf_sample_params *params, struct lf_tensors *out,
                          double spent[LF_STAGES])
{
    struct job job = {sample, observation, params, out, calloc(params->crops, sizeof *job.crops)};
    if (!job.crops)
        return ng_out_of_memory("the crops of a sample");
    ng_result result = choose_crops(&job);
    if (result == NG_OK)
        result = timed(&spent[LF_STAGE_WRITE], copy_inputs, &job);
    if (result == NG_OK)
        result = timed(&spent[LF_STAGE_LOOKUP], write_lookups, &job);
    if (result == NG_OK)
        result = timed(&spent[LF_STAGE_TRACE], write_targets, &job);
    free(job.crops);
    return result;
}

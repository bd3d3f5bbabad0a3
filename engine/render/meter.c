// The passes "meter/count", histograms of the picture, and "meter/expose", which makes one number of it.
#include "render/meter.h"

#include "base/log.h"
#include "gpu/command.h"
#include "render/frame.h"
#include "render/passes.h"
#include "render/scene_gpu.h"
#include "shaders/shared/meter.h"

#include "meter_count.comp.spv.h"
#include "meter_expose.comp.spv.h"

#include <stdlib.h>

#define GROUP 16 // of meter_count.comp, pixels a side

struct ng_meter {
    struct ng_gpu_pipeline *count, *expose;
};

static ng_result make_pipelines(struct ng_gpu *gpu, struct ng_meter *m)
{
    static const struct ng_gpu_slot count[] = {
        {.binding = 0, .type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
        {.binding = 1, .type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
        {.binding = 2, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
        {.binding = 3, .type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
        {.binding = 4, .type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
    };
    static const struct ng_gpu_slot expose[] = {
        {.binding = 0, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
        {.binding = 1, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
        {.binding = 2, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
        {.binding = 3, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
    };
    NG_TRY(ng_gpu_compute_create(gpu,
                                 &(struct ng_gpu_compute_params){.name = "meter/count",
                                                                 .shader = NG_SPIRV(ng_spv_meter_count_comp),
                                                                 .slots = count,
                                                                 .slot_count = NG_COUNT(count)},
                                 &m->count));
    return ng_gpu_compute_create(gpu,
                                 &(struct ng_gpu_compute_params){.name = "meter/expose",
                                                                 .shader = NG_SPIRV(ng_spv_meter_expose_comp),
                                                                 .slots = expose,
                                                                 .slot_count = NG_COUNT(expose)},
                                 &m->expose);
}

ng_result ng_meter_create(struct ng_gpu *gpu, struct ng_meter **out)
{
    struct ng_meter *m = calloc(1, sizeof *m);
    *out = NULL;
    if (!m)
        return ng_out_of_memory("the light meter");
    ng_result r = make_pipelines(gpu, m);
    if (r != NG_OK)
        ng_meter_destroy(&m);
    *out = m;
    return r;
}

void ng_meter_destroy(struct ng_meter **meter)
{
    struct ng_meter *m = *meter;
    *meter = NULL;
    if (!m)
        return;
    ng_gpu_pipeline_destroy(&m->count);
    ng_gpu_pipeline_destroy(&m->expose);
    free(m);
}

struct pass_data {
    const struct ng_meter *self;
    const struct ng_frame_info *frame;
    struct ng_graph_ref direct, indirect, emission, position, counts, before, after;
    float params[3]; // factor, adaptation, keeps
};

// Black where the method has no such light.
static struct ng_gpu_binding light(const struct ng_pass_context *ctx, struct ng_graph_ref image,
                                   uint32_t binding)
{
    const struct pass_data *d = ctx->data;
    return image.id ? ng_pass_texture(ctx, image, binding) : ng_scene_gpu_black(d->frame->scene, binding);
}

static ng_result count(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    const struct ng_gpu_binding bindings[] = {
        light(ctx, d->direct, 0),
        ng_pass_texture(ctx, d->emission, 1),
        {.binding = 2, .buffer = ng_pass_buffer(ctx, d->counts)},
        light(ctx, d->indirect, 3),
        ng_pass_texture(ctx, d->position, 4),
    };
    NG_TRY(ng_cmd_bind(ctx->cmd, d->self->count, bindings, NG_COUNT(bindings)));
    ng_cmd_dispatch_over(ctx->cmd, (uint32_t[]){d->frame->width, d->frame->height, 1},
                         (uint32_t[]){GROUP, GROUP, 1});
    return NG_OK;
}

static ng_result expose(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct ng_frame_range params;
    NG_TRY(ng_frame_put(ctx->gpu, d->params, sizeof d->params, &params));
    // Without a frame before, the parameters stand in for its exposure, and are not looked at.
    struct ng_gpu_binding before = ng_pass_range(&params, 1);
    if (d->before.id)
        before = (struct ng_gpu_binding){.binding = 1, .buffer = ng_pass_buffer(ctx, d->before)};
    const struct ng_gpu_binding bindings[] = {
        {.binding = 0, .buffer = ng_pass_buffer(ctx, d->counts)},
        before,
        {.binding = 2, .buffer = ng_pass_buffer(ctx, d->after)},
        ng_pass_range(&params, 3),
    };
    NG_TRY(ng_cmd_bind(ctx->cmd, d->self->expose, bindings, NG_COUNT(bindings)));
    ng_cmd_dispatch_over(ctx->cmd, (uint32_t[]){1, 1, 1}, (uint32_t[]){1, 1, 1});
    return NG_OK;
}

static struct ng_pass *add_pass(struct ng_graph *g, const char *name, ng_pass_fn run,
                                const struct pass_data *data)
{
    return ng_graph_add_pass(
        g, &(struct ng_pass_params){
               .name = name, .kind = NG_PASS_COMPUTE, .run = run, .data = data, .data_size = sizeof *data});
}

static struct ng_graph_ref declare_count(struct ng_graph *g, const struct pass_data *data)
{
    struct ng_pass *pass = add_pass(g, "meter/count", count, data);
    if (data->direct.id)
        ng_pass_read(pass, data->direct, NG_USE_SAMPLED);
    if (data->indirect.id)
        ng_pass_read(pass, data->indirect, NG_USE_SAMPLED);
    ng_pass_read(pass, data->emission, NG_USE_SAMPLED);
    ng_pass_read(pass, data->position, NG_USE_SAMPLED);
    return ng_pass_write(pass, data->counts, NG_USE_STORAGE_READ_WRITE);
}

struct ng_graph_ref ng_meter_declare(const struct ng_meter *m, struct ng_composer *composer,
                                     const struct ng_radiance *radiance, float adaptation, uint32_t averaged)
{
    static const struct ng_graph_buffer_params numbers = {.size =
                                                              2 * sizeof(float)}; // exposure, what was found
    struct ng_graph *g = ng_composer_graph(composer);
    const struct ng_gbuffer *gbuffer = ng_composer_get(composer, &ng_gbuffer_item, 0);
    struct pass_data data = {.self = m, .frame = ng_composer_get(composer, &ng_frame_item, 0)};
    data.direct = radiance->direct;
    data.indirect = radiance->indirect;
    data.emission = gbuffer->emission;
    data.position = gbuffer->position;
    data.counts =
        ng_graph_add_buffer(g, "meter/counts",
                            &(struct ng_graph_buffer_params){
                                .size = NG_METER_COUNTS * NG_METER_BINS * sizeof(uint32_t), .clear = true});
    data.after = ng_graph_add_buffer(g, "meter/exposure", &numbers);
    bool adapts = adaptation > 0 && adaptation<1, keeps = averaged> 1, valid = false;
    if (adapts || averaged)
        data.before = ng_graph_history_buffer(g, "meter/exposure", &numbers, &valid);
    if (!(adapts || keeps))
        data.before = (struct ng_graph_ref){0}; // it is kept for the next frame
    data.params[0] = data.frame->snapshot->camera.exposure;
    data.params[1] = adapts && valid ? adaptation : 1;
    data.params[2] = keeps && valid;

    if (!keeps)
        data.counts = declare_count(g, &data);
    struct ng_pass *pass = add_pass(g, "meter/expose", expose, &data);
    ng_pass_read(pass, data.counts, NG_USE_STORAGE_READ);
    if (data.before.id)
        ng_pass_read(pass, data.before, NG_USE_STORAGE_READ);
    return ng_pass_write(pass, data.after, NG_USE_STORAGE_WRITE);
}

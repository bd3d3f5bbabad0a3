// Radiance is averaged, before exposure and tone map, as a sensor does it: nothing is clamped. So the mean is
// that of the light, and an edge of a lamp is as wide as the lamp's light makes it.
#include "render/antialias.h"

#include "base/log.h"
#include "render/frame.h"
#include "render/passes.h"
#include "render/scene_gpu.h"

#include "antialias.frag.spv.h"

#include <stdlib.h>

struct ng_antialias {
    struct ng_gpu_pipeline *mean;
    uint32_t count; // of the last frame
};

ng_result ng_antialias_create(struct ng_gpu *gpu, struct ng_antialias **out)
{
    static const struct ng_gpu_slot slots[] = {
        {.binding = 0, .type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
        {.binding = 1, .type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
        {.binding = 2, .type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
        {.binding = 3, .type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
    };
    const struct ng_gpu_graphics_params params = {
        .name = "antialias",
        .fragment = NG_SPIRV(ng_spv_antialias_frag),
        .slots = slots,
        .slot_count = NG_COUNT(slots),
        .push_size = sizeof(float),
        .color_formats = {VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_R32G32_SFLOAT},
        .color_count = 2};
    *out = NULL;
    struct ng_antialias *a = calloc(1, sizeof *a);
    if (!a)
        return ng_out_of_memory("antialiasing");
    ng_result result = ng_fullscreen_create(gpu, &params, &a->mean);
    if (result != NG_OK)
        ng_antialias_destroy(&a);
    *out = a;
    return result;
}

void ng_antialias_destroy(struct ng_antialias **antialias)
{
    struct ng_antialias *a = *antialias;
    *antialias = NULL;
    if (!a)
        return;
    ng_gpu_pipeline_destroy(&a->mean);
    free(a);
}

struct pass_data {
    const struct ng_antialias *self;
    struct ng_scene_gpu *scene;
    struct ng_graph_ref beauty, position, mean_before, shares_before; // the last two: zero in the first
    float weight;
};

static struct ng_gpu_binding before(const struct ng_pass_context *ctx, struct ng_graph_ref ref,
                                    uint32_t binding)
{
    const struct pass_data *d = ctx->data;
    return ref.id ? ng_pass_texture(ctx, ref, binding) : ng_scene_gpu_black(d->scene, binding);
}

static ng_result average(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    const struct ng_gpu_binding bindings[] = {
        ng_pass_texture(ctx, d->beauty, 0),
        ng_pass_texture(ctx, d->position, 1),
        before(ctx, d->mean_before, 2),
        before(ctx, d->shares_before, 3),
    };
    NG_TRY(ng_cmd_bind(ctx->cmd, d->self->mean, bindings, NG_COUNT(bindings)));
    ng_cmd_push(ctx->cmd, d->self->mean, &d->weight, sizeof d->weight);
    vkCmdDraw(ctx->cmd->handle, 3, 1, 0, 0);
    return NG_OK;
}

ng_result ng_antialias_declare(struct ng_antialias *a, struct ng_composer *composer,
                               struct ng_graph_ref beauty, uint32_t count, struct ng_antialiased *out)
{
    struct ng_graph *g = ng_composer_graph(composer);
    const struct ng_frame_info *frame = ng_composer_get(composer, &ng_frame_item, 0);
    const struct ng_gbuffer *gbuffer = ng_composer_get(composer, &ng_gbuffer_item, 0);
    const struct ng_graph_image_params mean = {.format = VK_FORMAT_R32G32B32A32_SFLOAT,
                                               .width = frame->width,
                                               .height = frame->height},
                                       shares = {.format = VK_FORMAT_R32G32_SFLOAT,
                                                 .width = frame->width,
                                                 .height = frame->height};
    struct pass_data data = {.self = a,
                             .scene = frame->scene,
                             .beauty = beauty,
                             .position = gbuffer->position,
                             .weight = count > 1 && count == a->count ? 0 : 1.0f / (float)count};
    a->count = count;
    out->beauty = ng_graph_add_image(g, "beauty", &mean);
    out->shares = ng_graph_add_image(g, "beauty/shares", &shares);
    // Declared in the first frame, too, so that it is kept for the second one.
    bool valid[2];
    data.mean_before = ng_graph_history_image(g, "beauty", &mean, &valid[0]);
    data.shares_before = ng_graph_history_image(g, "beauty/shares", &shares, &valid[1]);
    if (count == 1)
        data.mean_before = data.shares_before = (struct ng_graph_ref){0};
    else
        NG_REQUIRE(valid[0] && valid[1], "picture %u of a mean follows picture %u", count, count - 1);
    struct ng_pass *pass = ng_graph_add_pass(g, &(struct ng_pass_params){.name = "antialias",
                                                                         .kind = NG_PASS_RASTER,
                                                                         .run = average,
                                                                         .data = &data,
                                                                         .data_size = sizeof data});
    ng_pass_read(pass, data.beauty, NG_USE_SAMPLED);
    ng_pass_read(pass, data.position, NG_USE_SAMPLED);
    if (data.mean_before.id)
        ng_pass_read(pass, data.mean_before, NG_USE_SAMPLED);
    if (data.shares_before.id)
        ng_pass_read(pass, data.shares_before, NG_USE_SAMPLED);
    out->beauty = ng_pass_write(pass, out->beauty, NG_USE_COLOR);
    out->shares = ng_pass_write(pass, out->shares, NG_USE_COLOR);
    return NG_OK;
}

// The passes "compose" and "tone map".
#include "render/display.h"

#include "base/log.h"
#include "render/frame.h"
#include "render/passes.h"
#include "render/scene_gpu.h"

#include "compose.frag.spv.h"
#include "tonemap.frag.spv.h"

#include <stdlib.h>

struct ng_display {
    struct ng_gpu *gpu;
    struct ng_gpu_pipeline *compose, *tonemap;
};

ng_result ng_display_create(struct ng_gpu *gpu, struct ng_display **out)
{
    static const struct ng_gpu_slot compose_slots[] = {
        {.binding = 0, .type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
        {.binding = 1, .type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
        {.binding = 2, .type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
    };
    static const struct ng_gpu_slot tonemap_slots[] = {
        {.binding = 0, .type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER},
        {.binding = 1, .type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
    };
    *out = NULL;
    struct ng_display *self = calloc(1, sizeof *self);
    if (!self)
        return ng_out_of_memory("the display");
    self->gpu = gpu;
    ng_result r = ng_fullscreen_create(
        gpu,
        &(struct ng_gpu_graphics_params){.name = "compose",

                                         .fragment = NG_SPIRV(ng_spv_compose_frag),
                                         .slots = compose_slots,
                                         .slot_count = NG_COUNT(compose_slots),
                                         .color_formats = {VK_FORMAT_R32G32B32A32_SFLOAT},
                                         .color_count = 1},
        &self->compose);
    if (r == NG_OK)
        r = ng_fullscreen_create(gpu,
                                 &(struct ng_gpu_graphics_params){.name = "tone map",

                                                                  .fragment = NG_SPIRV(ng_spv_tonemap_frag),
                                                                  .slots = tonemap_slots,
                                                                  .slot_count = NG_COUNT(tonemap_slots),
                                                                  .color_formats = {VK_FORMAT_R8G8B8A8_UNORM},
                                                                  .color_count = 1},
                                 &self->tonemap);
    if (r != NG_OK)
        ng_display_destroy(&self);
    *out = self;
    return r;
}

void ng_display_destroy(struct ng_display **display)
{
    struct ng_display *self = *display;
    if (!self)
        return;
    ng_gpu_pipeline_destroy(&self->compose);
    ng_gpu_pipeline_destroy(&self->tonemap);
    free(self);
    *display = NULL;
}

struct pass_data {
    const struct ng_display *self;
    const struct ng_frame_info *frame;
    struct ng_graph_ref direct, indirect, emission, beauty;
};

static ng_result compose(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    const struct ng_gpu_binding bindings[] = {ng_pass_texture(ctx, d->direct, 0),
                                              d->indirect.id ? ng_pass_texture(ctx, d->indirect, 1)
                                                             : ng_scene_gpu_black(d->frame->scene, 1),
                                              ng_pass_texture(ctx, d->emission, 2)};
    NG_TRY(ng_cmd_bind(ctx->cmd, d->self->compose, bindings, NG_COUNT(bindings)));
    vkCmdDraw(ctx->cmd->handle, 3, 1, 0, 0);
    return NG_OK;
}

static ng_result tone_map(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    const struct ng_gpu_binding bindings[] = {ng_scene_gpu_view(d->frame->scene, 0),
                                              ng_pass_texture(ctx, d->beauty, 1)};
    NG_TRY(ng_cmd_bind(ctx->cmd, d->self->tonemap, bindings, NG_COUNT(bindings)));
    vkCmdDraw(ctx->cmd->handle, 3, 1, 0, 0);
    return NG_OK;
}

static struct ng_graph_ref picture(struct ng_graph *g, const struct ng_frame_info *frame, const char *name,
                                   VkFormat format)
{
    return ng_graph_add_image(
        g, name,
        &(struct ng_graph_image_params){.format = format, .width = frame->width, .height = frame->height});
}

static struct ng_pass *add_pass(struct ng_graph *g, const char *name, ng_pass_fn run,
                                const struct pass_data *data)
{
    return ng_graph_add_pass(
        g, &(struct ng_pass_params){
               .name = name, .kind = NG_PASS_RASTER, .run = run, .data = data, .data_size = sizeof *data});
}

ng_result ng_display_declare(struct ng_display *display, struct ng_composer *composer,
                             struct ng_display_result *out)
{
    struct ng_graph *g = ng_composer_graph(composer);
    const struct ng_frame_info *frame = ng_composer_get(composer, &ng_frame_item, 0);
    const struct ng_gbuffer *gbuffer = ng_composer_get(composer, &ng_gbuffer_item, 0);
    const struct ng_radiance *radiance = ng_composer_get(composer, &ng_radiance_item, 0);
    if (!radiance) {
        ng_log_error("method \"%s\": nothing in this program computes it; use \"raster\"", frame->method);
        return NG_ERROR_NOT_FOUND;
    }
    struct pass_data data = {.self = display,
                             .frame = frame,
                             .direct = radiance->direct,
                             .indirect = radiance->indirect,
                             .emission = gbuffer->emission};
    struct ng_pass *pass = add_pass(g, "compose", compose, &data);
    ng_pass_read(pass, data.direct, NG_USE_SAMPLED);
    if (data.indirect.id)
        ng_pass_read(pass, data.indirect, NG_USE_SAMPLED);
    ng_pass_read(pass, data.emission, NG_USE_SAMPLED);
    data.beauty =
        ng_pass_write(pass, picture(g, frame, "beauty", VK_FORMAT_R32G32B32A32_SFLOAT), NG_USE_COLOR);

    pass = add_pass(g, "tone map", tone_map, &data);
    ng_pass_read(pass, data.beauty, NG_USE_SAMPLED);
    out->beauty = data.beauty;
    out->color = ng_pass_write(pass, picture(g, frame, "display", VK_FORMAT_R8G8B8A8_UNORM), NG_USE_COLOR);
    return NG_OK;
}

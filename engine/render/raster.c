// Two passes a light: "direct:<light>/visibility" finds how much of it each pixel sees,
// "direct:<light>/radiance" adds it to the sums of unshadowed and shadowed direct light.
#include "render/raster.h"
#include "base/log.h"

#include "render/environment.h"
#include "render/frame.h"
#include "render/light_gpu.h"
#include "render/passes.h"
#include "render/scene_gpu.h"

#include "direct.frag.spv.h"
#include "direct_environment.frag.spv.h"
#include "sky_visibility.frag.spv.h"
#include "visibility.frag.spv.h"

#include <stdio.h>
#include <stdlib.h>

const struct ng_item_type ng_radiance_item = {"radiance", sizeof(struct ng_radiance)};

struct ng_raster {
    struct ng_gpu *gpu;
    struct ng_gpu_pipeline *visibility, *sky_visibility, *direct, *environment;
};

#define TEXTURE(n)                                                                                           \
    {                                                                                                        \
        .binding = (n), .type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER                                    \
    }
#define BUFFER(n)                                                                                            \
    {                                                                                                        \
        .binding = (n), .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER                                            \
    }
#define VIEW                                                                                                 \
    {                                                                                                        \
        .binding = 0, .type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER                                              \
    }

static ng_result make_visibility(struct ng_gpu *gpu, struct ng_gpu_pipeline **out)
{
    static const struct ng_gpu_slot slots[] = {TEXTURE(1),
                                               TEXTURE(3),
                                               TEXTURE(4),
                                               TEXTURE(5),
                                               {.binding = 8, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}};
    return ng_fullscreen_create(gpu,
                                &(struct ng_gpu_graphics_params){.name = "visibility",
                                                                 .fragment = NG_SPIRV(ng_spv_visibility_frag),
                                                                 .slots = slots,
                                                                 .slot_count = NG_COUNT(slots),
                                                                 .color_formats = {VK_FORMAT_R16_SFLOAT},
                                                                 .color_count = 1},
                                out);
}

static ng_result make_sky_visibility(struct ng_gpu *gpu, struct ng_gpu_pipeline **out)
{
    static const struct ng_gpu_slot slots[] = {
        {.binding = 0, .type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER},
        TEXTURE(1),
        TEXTURE(2),
        TEXTURE(3),
        TEXTURE(4),
        TEXTURE(5),
        {.binding = 7, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
        {.binding = 8, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
        {.binding = 9, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
    };
    return ng_fullscreen_create(
        gpu,
        &(struct ng_gpu_graphics_params){.name = "sky visibility",
                                         .fragment = NG_SPIRV(ng_spv_sky_visibility_frag),
                                         .slots = slots,
                                         .slot_count = NG_COUNT(slots),
                                         .color_formats = {VK_FORMAT_R16_SFLOAT},
                                         .color_count = 1},
        out);
}

#define DIRECT_SLOTS VIEW, TEXTURE(1), TEXTURE(2), TEXTURE(3), TEXTURE(4), TEXTURE(5), BUFFER(8), BUFFER(9)

// Adds to the sums of unshadowed and of direct light.
static ng_result make_sum(struct ng_gpu *gpu, const struct ng_gpu_graphics_params *params,
                          struct ng_gpu_pipeline **out)
{
    struct ng_gpu_graphics_params p = *params;
    p.color_formats[0] = p.color_formats[1] = VK_FORMAT_R32G32B32A32_SFLOAT;
    p.color_count = 2;
    p.blend = NG_GPU_BLEND_ADD;
    return ng_fullscreen_create(gpu, &p, out);
}

static ng_result make_direct(struct ng_gpu *gpu, struct ng_gpu_pipeline **out)
{
    static const struct ng_gpu_slot slots[] = {DIRECT_SLOTS, BUFFER(10)};
    const struct ng_gpu_graphics_params params = {.name = "direct",
                                                  .fragment = NG_SPIRV(ng_spv_direct_frag),
                                                  .slots = slots,
                                                  .slot_count = NG_COUNT(slots)};
    return make_sum(gpu, &params, out);
}

static ng_result make_environment(struct ng_gpu *gpu, struct ng_gpu_pipeline **out)
{
    static const struct ng_gpu_slot slots[] = {DIRECT_SLOTS, TEXTURE(6)};
    const struct ng_gpu_graphics_params params = {.name = "direct environment",
                                                  .fragment = NG_SPIRV(ng_spv_direct_environment_frag),
                                                  .slots = slots,
                                                  .slot_count = NG_COUNT(slots),
                                                  .push_size = sizeof(struct ng_environment_push)};
    return make_sum(gpu, &params, out);
}

ng_result ng_raster_create(struct ng_gpu *gpu, struct ng_raster **out)
{
    *out = NULL;
    struct ng_raster *self = calloc(1, sizeof *self);
    if (!self)
        return ng_out_of_memory("the raster method");
    self->gpu = gpu;
    ng_result r = make_visibility(gpu, &self->visibility);
    if (r == NG_OK)
        r = make_sky_visibility(gpu, &self->sky_visibility);
    if (r == NG_OK)
        r = make_direct(gpu, &self->direct);
    if (r == NG_OK)
        r = make_environment(gpu, &self->environment);
    if (r != NG_OK)
        ng_raster_destroy(&self);
    *out = self;
    return r;
}

void ng_raster_destroy(struct ng_raster **raster)
{
    struct ng_raster *self = *raster;
    if (!self)
        return;
    ng_gpu_pipeline_destroy(&self->visibility);
    ng_gpu_pipeline_destroy(&self->sky_visibility);
    ng_gpu_pipeline_destroy(&self->direct);
    ng_gpu_pipeline_destroy(&self->environment);
    free(self);
    *raster = NULL;
}

struct pass_data {
    const struct ng_raster *self;
    const struct ng_frame_info *frame;
    const struct ng_gbuffer *gbuffer;
    const struct ng_light_maps *maps;
    struct ng_graph_ref visibility;
};

static ng_result draw(const struct ng_pass_context *ctx, const struct ng_gpu_pipeline *pipeline,
                      const struct ng_gpu_binding *bindings, uint32_t count)
{
    NG_TRY(ng_cmd_bind(ctx->cmd, pipeline, bindings, count));
    vkCmdDraw(ctx->cmd->handle, 3, 1, 0, 0);
    return NG_OK;
}

static ng_result find_visibility(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct ng_gpu_binding light[3];
    ng_light_gpu_bindings(d->maps->gpu, false, light);
    const struct ng_gpu_binding bindings[] = {
        ng_pass_texture(ctx, d->gbuffer->position, 1), ng_pass_texture(ctx, d->gbuffer->diffuse, 3),
        ng_pass_texture(ctx, d->gbuffer->specular, 4), ng_pass_texture(ctx, d->maps->depth, 5), light[1]};
    return draw(ctx, d->self->visibility, bindings, NG_COUNT(bindings));
}

static ng_result find_sky_visibility(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct ng_gpu_binding light[3];
    ng_light_gpu_bindings(d->maps->gpu, false, light);
    const struct ng_gpu_binding bindings[] = {ng_scene_gpu_view(d->frame->scene, 0),
                                              ng_pass_texture(ctx, d->gbuffer->position, 1),
                                              ng_pass_texture(ctx, d->gbuffer->normal, 2),
                                              ng_pass_texture(ctx, d->gbuffer->diffuse, 3),
                                              ng_pass_texture(ctx, d->gbuffer->specular, 4),
                                              ng_pass_texture(ctx, d->maps->sky, 5),
                                              ng_pass_range(&d->maps->gpu->sky_range, 7),
                                              light[1],
                                              light[2]};
    return draw(ctx, d->self->sky_visibility, bindings, NG_COUNT(bindings));
}

// An environment's map with all its levels, whatever sampling its file asks for.
static struct ng_gpu_binding filtered_map(const struct pass_data *d, const struct ng_snapshot_light *light,
                                          uint32_t binding)
{
    struct ng_gpu_binding map = ng_scene_gpu_image(d->frame->scene, light->image, binding);
    map.sampler = ng_gpu_sampler(
        d->self->gpu, &(struct ng_gpu_sampler_params){.mag_filter = VK_FILTER_LINEAR,
                                                      .min_filter = VK_FILTER_LINEAR,
                                                      .mip_filter = VK_SAMPLER_MIPMAP_MODE_LINEAR,
                                                      .address_v = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE});
    return map;
}

static ng_result add_light(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    const struct ng_snapshot_light *lit = &d->frame->snapshot->lights[d->maps->light];
    bool environment = ng_is_environment(lit);
    const struct ng_gpu_pipeline *pipeline = environment ? d->self->environment : d->self->direct;
    struct ng_gpu_binding light[3];
    ng_light_gpu_bindings(d->maps->gpu, false, light);
    const struct ng_gpu_binding bindings[] = {ng_scene_gpu_view(d->frame->scene, 0),
                                              ng_pass_texture(ctx, d->gbuffer->position, 1),
                                              ng_pass_texture(ctx, d->gbuffer->normal, 2),
                                              ng_pass_texture(ctx, d->gbuffer->diffuse, 3),
                                              ng_pass_texture(ctx, d->gbuffer->specular, 4),
                                              ng_pass_texture(ctx, d->visibility, 5),
                                              light[1],
                                              light[2],
                                              environment ? filtered_map(d, lit, 6)
                                                          : ng_pass_range(&d->maps->gpu->facet_range, 10)};
    NG_TRY(ng_cmd_bind(ctx->cmd, pipeline, bindings, NG_COUNT(bindings)));
    if (environment) {
        struct ng_environment_push push;
        ng_environment_push_of(lit, &push);
        ng_cmd_push(ctx->cmd, pipeline, &push, sizeof push);
    }
    vkCmdDraw(ctx->cmd->handle, 3, 1, 0, 0);
    return NG_OK;
}

static ng_result add_nothing(const struct ng_pass_context *ctx)
{
    NG_UNUSED(ctx);
    return NG_OK;
}

static struct ng_graph_ref sum_image(struct ng_graph *g, const struct ng_frame_info *frame, const char *name)
{
    return ng_graph_add_image(g, name,
                              &(struct ng_graph_image_params){.format = VK_FORMAT_R32G32B32A32_SFLOAT,
                                                              .width = frame->width,
                                                              .height = frame->height,
                                                              .clear = true});
}

static struct ng_pass *add_pass(struct ng_graph *g, const char *what, ng_pass_fn run,
                                const struct pass_data *data)
{
    char name[160];
    snprintf(name, sizeof name, "direct:%s%s", data->maps->name, what);
    struct ng_pass *pass = ng_graph_add_pass(
        g, &(struct ng_pass_params){
               .name = name, .kind = NG_PASS_RASTER, .run = run, .data = data, .data_size = sizeof *data});
    ng_pass_read(pass, data->gbuffer->position, NG_USE_SAMPLED);
    ng_pass_read(pass, data->gbuffer->diffuse, NG_USE_SAMPLED);
    ng_pass_read(pass, data->gbuffer->specular, NG_USE_SAMPLED);
    return pass;
}

static void declare_light(struct ng_graph *g, struct pass_data *data, struct ng_radiance *sum)
{
    char name[160];
    snprintf(name, sizeof name, "direct:%s/visibility", data->maps->name);
    bool sky = data->maps->gpu->sky_view_count;
    struct ng_pass *pass = add_pass(g, "/visibility", sky ? find_sky_visibility : find_visibility, data);
    if (sky)
        ng_pass_read(pass, data->gbuffer->normal, NG_USE_SAMPLED);
    ng_pass_read(pass, sky ? data->maps->sky : data->maps->depth, NG_USE_SAMPLED);
    data->visibility =
        ng_pass_write(pass,
                      ng_graph_add_image(g, name,
                                         &(struct ng_graph_image_params){.format = VK_FORMAT_R16_SFLOAT,
                                                                         .width = data->frame->width,
                                                                         .height = data->frame->height}),
                      NG_USE_COLOR);
    pass = add_pass(g, "/radiance", add_light, data);
    ng_pass_read(pass, data->gbuffer->normal, NG_USE_SAMPLED);
    ng_pass_read(pass, data->visibility, NG_USE_SAMPLED);
    sum->unshadowed = ng_pass_write(pass, sum->unshadowed, NG_USE_COLOR);
    sum->direct = ng_pass_write(pass, sum->direct, NG_USE_COLOR);
}

static ng_result consume(struct ng_composer *composer, void *user)
{
    struct pass_data data = {.self = user,
                             .frame = ng_composer_get(composer, &ng_frame_item, 0),
                             .gbuffer = ng_composer_get(composer, &ng_gbuffer_item, 0)};
    if (!ng_frame_wants(data.frame, "raster"))
        return NG_OK;
    struct ng_graph *g = ng_composer_graph(composer);
    struct ng_radiance out = {.method = "raster",
                              .unshadowed = sum_image(g, data.frame, "raster/unshadowed"),
                              .direct = sum_image(g, data.frame, "raster/direct")};
    size_t count = ng_composer_count(composer, &ng_light_maps_item);
    if (!count) { // a scene in the dark: the cleared sums are the result
        struct ng_pass *pass = ng_graph_add_pass(
            g, &(struct ng_pass_params){.name = "direct", .kind = NG_PASS_RASTER, .run = add_nothing});
        out.unshadowed = ng_pass_write(pass, out.unshadowed, NG_USE_COLOR);
        out.direct = ng_pass_write(pass, out.direct, NG_USE_COLOR);
    }
    for (size_t i = 0; i < count; i++) {
        data.maps = ng_composer_get(composer, &ng_light_maps_item, i);
        declare_light(g, &data, &out);
    }
    return ng_composer_publish(composer, &ng_radiance_item, &out);
}

struct ng_provider ng_raster_provider(struct ng_raster *raster)
{
    return (struct ng_provider){.name = "raster", .consume = consume, .user = raster};
}

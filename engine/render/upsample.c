// Passes "upsample/light", of the light's pixels, and "upsample", of the picture's.
#include "render/upsample.h"

#include "base/log.h"
#include "render/camera.h"
#include "render/frame.h"
#include "render/passes.h"
#include "render/scene_gpu.h"
#include "shaders/shared/upsample.h"

#include "demodulate.frag.spv.h"
#include "upsample.frag.spv.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define TEXTURE(n)                                                                                           \
    {                                                                                                        \
        .binding = (n), .type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER                                    \
    }

struct ng_upsample {
    struct ng_gpu_pipeline *demodulate, *upsample;
};

static ng_result create_pipelines(struct ng_gpu *gpu, struct ng_upsample *u)
{
    static const struct ng_gpu_slot parts[] = {TEXTURE(0), TEXTURE(1), TEXTURE(2), TEXTURE(3)};
    static const struct ng_gpu_slot guides[] = {
        TEXTURE(0), TEXTURE(1), TEXTURE(2),
        TEXTURE(3), TEXTURE(4), TEXTURE(5),
        TEXTURE(6), TEXTURE(7), {.binding = 8, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}};
    struct ng_gpu_graphics_params params = {.name = "demodulate",
                                            .fragment = NG_SPIRV(ng_spv_demodulate_frag),
                                            .slots = parts,
                                            .slot_count = NG_COUNT(parts),
                                            .color_formats = {VK_FORMAT_R32G32B32A32_SFLOAT},
                                            .color_count = 1};
    NG_TRY(ng_fullscreen_create(gpu, &params, &u->demodulate));
    params.name = "upsample";
    params.fragment = NG_SPIRV(ng_spv_upsample_frag);
    params.slots = guides;
    params.slot_count = NG_COUNT(guides);
    return ng_fullscreen_create(gpu, &params, &u->upsample);
}

ng_result ng_upsample_create(struct ng_gpu *gpu, struct ng_upsample **out)
{
    *out = NULL;
    struct ng_upsample *u = calloc(1, sizeof *u);
    if (!u)
        return ng_out_of_memory("upsampling");
    ng_result result = create_pipelines(gpu, u);
    if (result != NG_OK)
        ng_upsample_destroy(&u);
    *out = u;
    return result;
}

void ng_upsample_destroy(struct ng_upsample **upsample)
{
    struct ng_upsample *u = *upsample;
    *upsample = NULL;
    if (!u)
        return;
    ng_gpu_pipeline_destroy(&u->demodulate);
    ng_gpu_pipeline_destroy(&u->upsample);
    free(u);
}

enum { PARTS = 4, GUIDES = 8 };

struct pass_data {
    const struct ng_upsample *self;
    struct ng_scene_gpu *scene;
    struct ng_graph_ref images[GUIDES]; // zero: black
    struct ng_upsample_data shown;
};

static void bind_images(const struct ng_pass_context *ctx, uint32_t count, struct ng_gpu_binding *out)
{
    const struct pass_data *d = ctx->data;
    for (uint32_t i = 0; i < count; i++)
        out[i] = d->images[i].id ? ng_pass_texture(ctx, d->images[i], i) : ng_scene_gpu_black(d->scene, i);
}

static ng_result demodulate(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct ng_gpu_binding bindings[PARTS];
    bind_images(ctx, PARTS, bindings);
    NG_TRY(ng_cmd_bind(ctx->cmd, d->self->demodulate, bindings, PARTS));
    vkCmdDraw(ctx->cmd->handle, 3, 1, 0, 0);
    return NG_OK;
}

static ng_result upsample(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct ng_gpu_binding bindings[GUIDES + 1];
    struct ng_frame_range shown;
    NG_TRY(ng_frame_put(ctx->gpu, &d->shown, sizeof d->shown, &shown));
    bind_images(ctx, GUIDES, bindings);
    bindings[GUIDES] = ng_pass_range(&shown, GUIDES);
    NG_TRY(ng_cmd_bind(ctx->cmd, d->self->upsample, bindings, GUIDES + 1));
    vkCmdDraw(ctx->cmd->handle, 3, 1, 0, 0);
    return NG_OK;
}

static struct ng_graph_ref add_pass(struct ng_graph *g, const char *name, ng_pass_fn run,
                                    const struct pass_data *data, uint32_t count, struct ng_graph_ref to)
{
    struct ng_pass *pass = ng_graph_add_pass(
        g, &(struct ng_pass_params){
               .name = name, .kind = NG_PASS_RASTER, .run = run, .data = data, .data_size = sizeof *data});
    for (uint32_t i = 0; i < count; i++)
        if (data->images[i].id)
            ng_pass_read(pass, data->images[i], NG_USE_SAMPLED);
    return ng_pass_write(pass, to, NG_USE_COLOR);
}

static struct ng_graph_ref add_image(struct ng_graph *g, const char *name, uint32_t width, uint32_t height)
{
    return ng_graph_add_image(g, name,
                              &(struct ng_graph_image_params){
                                  .format = VK_FORMAT_R32G32B32A32_SFLOAT, .width = width, .height = height});
}

static struct ng_upsample_data describe(const struct ng_frame_info *f)
{
    const struct ng_snapshot_camera *camera = &f->snapshot->camera;
    float height = (float)f->height;
    struct ng_upsample_data d = {
        .scale = {(float)f->width / (float)f->picture[0], height / (float)f->picture[1]},
        .pixel = camera->orthographic ? 0 : 2 * tanf(camera->fov_y * 0.5f) / height,
        .pixel_at_eye = camera->orthographic ? camera->height / height : 0};
    memcpy(d.eye, camera->position, sizeof d.eye);
    return d;
}

struct ng_graph_ref ng_upsample_declare(const struct ng_upsample *u, struct ng_composer *composer,
                                        const struct ng_radiance *radiance)
{
    struct ng_graph *g = ng_composer_graph(composer);
    const struct ng_frame_info *f = ng_composer_get(composer, &ng_frame_item, 0);
    const struct ng_gbuffer *few = ng_composer_get(composer, &ng_gbuffer_item, 0),
                            *all = ng_composer_get(composer, &ng_gbuffer_picture_item, 0);
    struct pass_data data = {.self = u,
                             .scene = f->scene,
                             .images = {radiance->direct, radiance->indirect, few->diffuse, few->specular},
                             .shown = describe(f)};
    struct ng_graph_ref light = add_pass(g, "upsample/light", demodulate, &data, PARTS,
                                         add_image(g, "upsample/light", f->width, f->height));
    const struct ng_graph_ref guides[GUIDES] = {light,       few->position, few->normal,   all->position,
                                                all->normal, all->diffuse,  all->specular, all->emission};
    memcpy(data.images, guides, sizeof guides);
    return add_pass(g, "upsample", upsample, &data, GUIDES,
                    add_image(g, "beauty", f->picture[0], f->picture[1]));
}

// The passes "gbuffer", "gbuffer lamps" and "background".
#include "render/gbuffer.h"

#include "base/log.h"
#include "render/environment.h"
#include "render/frame.h"
#include "render/passes.h"
#include "render/scene_gpu.h"

#include "background.frag.spv.h"
#include "gbuffer_full.frag.spv.h"
#include "gbuffer_full.vert.spv.h"
#include "gbuffer_moving.frag.spv.h"
#include "gbuffer_moving.vert.spv.h"
#include "gbuffer_plain.frag.spv.h"
#include "gbuffer_plain.vert.spv.h"
#include "gbuffer_textured.frag.spv.h"
#include "gbuffer_textured.vert.spv.h"

#include <stdlib.h>
#include <string.h>

const struct ng_item_type ng_gbuffer_item = {"gbuffer", sizeof(struct ng_gbuffer)};
const struct ng_item_type ng_gbuffer_picture_item = {"gbuffer of the picture", sizeof(struct ng_gbuffer)};
const struct ng_item_type ng_gbuffer_behind_lamps_item = {"gbuffer behind lamps", sizeof(struct ng_gbuffer)};

static const struct {
    const char *name, *picture; // the latter of the picture's own
    VkFormat format;
} colors[NG_GBUFFER_COLORS] = {
    {"gbuffer/position", "picture/position", VK_FORMAT_R32G32B32A32_SFLOAT},
    {"gbuffer/normal", "picture/normal", VK_FORMAT_R16G16B16A16_SFLOAT},
    {"gbuffer/diffuse", "picture/diffuse", VK_FORMAT_R16G16B16A16_SFLOAT},
    {"gbuffer/specular", "picture/specular", VK_FORMAT_R16G16B16A16_SFLOAT},
    {"gbuffer/emission", "picture/emission", VK_FORMAT_R32G32B32A32_SFLOAT},
    {"gbuffer/motion", "picture/motion", VK_FORMAT_R32G32_SFLOAT},
    {"gbuffer/entity", "picture/entity", VK_FORMAT_R32_UINT},
};

struct ng_gbuffer_provider {
    struct ng_gpu *gpu;
    struct ng_gpu_pipeline *plain, *moving, *textured, *full, *background;
};

static const struct ng_gpu_slot scene_slots[] = {
    {.binding = 0, .type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER},
    {.binding = 1, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
    {.binding = 2, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
    NG_MATERIAL_SLOTS,
};

struct variant {
    const char *name;
    struct ng_spirv vertex, fragment;
    enum ng_vertex_streams streams;
    uint32_t slot_count;
};

static ng_result make_scene_pipeline(struct ng_gpu *gpu, const struct variant *v,
                                     struct ng_gpu_pipeline **out)
{
    struct ng_gpu_graphics_params p = {
        .name = v->name,
        .vertex = v->vertex,
        .fragment = v->fragment,
        .slots = scene_slots,
        .slot_count = v->slot_count,
        .dynamic_cull = true,
        .color_count = NG_GBUFFER_COLORS,
        .depth_format = VK_FORMAT_D32_SFLOAT,
        .depth_test = true,
        .depth_write = true,
    };
    for (int i = 0; i < NG_GBUFFER_COLORS; i++)
        p.color_formats[i] = colors[i].format;
    ng_scene_gpu_vertex_input(v->streams, &p);
    return ng_gpu_graphics_create(gpu, &p, out);
}

static ng_result make_scene_pipelines(struct ng_gbuffer_provider *g)
{
    const struct variant plain = {"gbuffer", NG_SPIRV(ng_spv_gbuffer_plain_vert),
                                  NG_SPIRV(ng_spv_gbuffer_plain_frag), NG_STREAMS_SURFACE, 3};
    const struct variant moving = {"gbuffer moving", NG_SPIRV(ng_spv_gbuffer_moving_vert),
                                   NG_SPIRV(ng_spv_gbuffer_moving_frag), NG_STREAMS_SURFACE_MOVING, 3};
    const struct variant textured = {"gbuffer textured", NG_SPIRV(ng_spv_gbuffer_textured_vert),
                                     NG_SPIRV(ng_spv_gbuffer_textured_frag),
                                     NG_STREAMS_SURFACE_TEXTURED_MOVING, NG_COUNT(scene_slots)};
    const struct variant full = {"gbuffer full", NG_SPIRV(ng_spv_gbuffer_full_vert),
                                 NG_SPIRV(ng_spv_gbuffer_full_frag), NG_STREAMS_SURFACE_FULL_MOVING,
                                 NG_COUNT(scene_slots)};
    NG_TRY(make_scene_pipeline(g->gpu, &plain, &g->plain));
    NG_TRY(make_scene_pipeline(g->gpu, &moving, &g->moving));
    NG_TRY(make_scene_pipeline(g->gpu, &textured, &g->textured));
    return make_scene_pipeline(g->gpu, &full, &g->full);
}

static ng_result make_background_pipeline(struct ng_gpu *gpu, struct ng_gpu_pipeline **out)
{
    static const struct ng_gpu_slot slots[] = {
        {.binding = 0, .type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER},
        {.binding = 1, .type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
    };
    return ng_fullscreen_create(
        gpu,
        &(struct ng_gpu_graphics_params){.name = "background",
                                         .fragment = NG_SPIRV(ng_spv_background_frag),
                                         .slots = slots,
                                         .slot_count = NG_COUNT(slots),
                                         .push_size = sizeof(struct ng_environment_push),
                                         .color_formats = {VK_FORMAT_R32G32B32A32_SFLOAT},
                                         .color_count = 1,
                                         .depth_format = VK_FORMAT_D32_SFLOAT,
                                         .depth_test = true},
        out);
}

ng_result ng_gbuffer_create(struct ng_gpu *gpu, struct ng_gbuffer_provider **out)
{
    *out = NULL;
    struct ng_gbuffer_provider *g = calloc(1, sizeof *g);
    if (!g)
        return ng_out_of_memory("the G-buffer");
    g->gpu = gpu;
    ng_result r = make_scene_pipelines(g);
    if (r == NG_OK)
        r = make_background_pipeline(gpu, &g->background);
    if (r != NG_OK)
        ng_gbuffer_destroy(&g);
    *out = g;
    return r;
}

void ng_gbuffer_destroy(struct ng_gbuffer_provider **provider)
{
    struct ng_gbuffer_provider *g = *provider;
    if (!g)
        return;
    ng_gpu_pipeline_destroy(&g->plain);
    ng_gpu_pipeline_destroy(&g->moving);
    ng_gpu_pipeline_destroy(&g->textured);
    ng_gpu_pipeline_destroy(&g->full);
    ng_gpu_pipeline_destroy(&g->background);
    free(g);
    *provider = NULL;
}

struct pass_data {
    const struct ng_gbuffer_provider *provider;
    const struct ng_frame_info *frame;
    enum ng_draw_lamps lamps;
    bool picture; // it is the picture's own
};

static struct ng_gpu_binding view_of(const struct pass_data *d)
{
    return d->picture ? ng_scene_gpu_picture_view(d->frame->scene, 0) : ng_scene_gpu_view(d->frame->scene, 0);
}

static ng_result draw_scene(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct ng_scene_gpu *scene = d->frame->scene;
    const struct ng_gpu_binding bindings[] = {view_of(d), ng_scene_gpu_instances(scene, 1),
                                              ng_scene_gpu_materials(scene, 2)};
    return ng_scene_gpu_draw(
        scene, ctx->cmd,
        &(struct ng_draw_params){.plain = {d->provider->plain, NG_STREAMS_SURFACE},
                                 .moving = {d->provider->moving, NG_STREAMS_SURFACE_MOVING},
                                 .textured = {d->provider->textured, NG_STREAMS_SURFACE_TEXTURED_MOVING},
                                 .full = {d->provider->full, NG_STREAMS_SURFACE_FULL_MOVING},
                                 .bindings = bindings,
                                 .binding_count = NG_COUNT(bindings),
                                 .view_projection = ng_scene_gpu_camera(scene),
                                 .mirrors = ng_scene_gpu_camera_mirrors(scene),
                                 .skip_light = NG_NONE,
                                 .cull_back = true,
                                 .lamps = d->lamps});
}

static ng_result draw_background(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct ng_scene_gpu *scene = d->frame->scene;
    const struct ng_snapshot_light *light = &d->frame->snapshot->lights[d->frame->snapshot->environment];
    const struct ng_gpu_binding bindings[] = {view_of(d), ng_scene_gpu_image(scene, light->image, 1)};
    NG_TRY(ng_cmd_bind(ctx->cmd, d->provider->background, bindings, NG_COUNT(bindings)));
    struct ng_environment_push push;
    ng_environment_push_of(light, &push);
    ng_cmd_push(ctx->cmd, d->provider->background, &push, sizeof push);
    vkCmdDraw(ctx->cmd->handle, 3, 1, 0, 0);
    return NG_OK;
}

static struct ng_graph_ref add_target(struct ng_graph *g, const struct ng_frame_info *frame, bool picture,
                                      const char *name, VkFormat format)
{
    return ng_graph_add_image(
        g, name,
        &(struct ng_graph_image_params){.format = format,
                                        .width = picture ? frame->picture[0] : frame->width,
                                        .height = picture ? frame->picture[1] : frame->height,
                                        .clear = true});
}

void ng_gbuffer_colors(struct ng_gbuffer *g, struct ng_graph_ref *out[NG_GBUFFER_COLORS])
{
    struct ng_graph_ref *const order[NG_GBUFFER_COLORS] = {
        &g->position, &g->normal, &g->diffuse, &g->specular, &g->emission, &g->motion, &g->entity};
    memcpy(out, order, sizeof order);
}

struct ng_graph_ref ng_gbuffer_add_color(struct ng_graph *g, int color, const struct ng_frame_info *frame,
                                         bool picture)
{
    return add_target(g, frame, picture, picture ? colors[color].picture : colors[color].name,
                      colors[color].format);
}

static struct ng_pass *add_pass(struct ng_graph *g, const char *name, ng_pass_fn run,
                                const struct pass_data *data)
{
    return ng_graph_add_pass(
        g, &(struct ng_pass_params){
               .name = name, .kind = NG_PASS_RASTER, .run = run, .data = data, .data_size = sizeof *data});
}

static void add_scene(struct ng_graph *g, const char *name, const struct pass_data *data,
                      struct ng_gbuffer *images)
{
    struct ng_graph_ref *order[NG_GBUFFER_COLORS];
    ng_gbuffer_colors(images, order);
    struct ng_pass *pass = add_pass(g, name, draw_scene, data);
    for (int i = 0; i < NG_GBUFFER_COLORS; i++) {
        if (!order[i]->id)
            *order[i] = ng_gbuffer_add_color(g, i, data->frame, data->picture);
        *order[i] = ng_pass_write(pass, *order[i], NG_USE_COLOR);
    }
    images->depth = ng_pass_write(pass, images->depth, NG_USE_DEPTH);
}

static ng_result produce(struct ng_composer *composer, void *user)
{
    struct ng_graph *g = ng_composer_graph(composer);
    const struct ng_frame_info *frame = ng_composer_get(composer, &ng_frame_item, 0);
    const struct pass_data data = {user, frame, NG_LAMPS_NOT, false};
    if (ng_composer_count(composer, &ng_gbuffer_behind_lamps_item))
        return NG_OK; // by another provider
    struct ng_gbuffer images = {.lamps = ng_snapshot_has_lamps(frame->snapshot)};
    images.depth = add_target(g, frame, false, "gbuffer/depth", VK_FORMAT_D32_SFLOAT); // reverse-Z: 0 is far
    add_scene(g, "gbuffer", &data, &images);
    return ng_composer_publish(composer, &ng_gbuffer_behind_lamps_item, &images);
}

static void add_background(struct ng_graph *g, const char *name, const struct pass_data *data,
                           struct ng_gbuffer *images)
{
    if (data->frame->snapshot->environment == NG_NONE)
        return;
    struct ng_pass *pass = add_pass(g, name, draw_background, data);
    ng_pass_read(pass, images->depth, NG_USE_DEPTH_READ);
    images->emission = ng_pass_write(pass, images->emission, NG_USE_COLOR);
}

static ng_result publish_picture(struct ng_composer *composer, struct pass_data data, bool lamps)
{
    struct ng_graph *g = ng_composer_graph(composer);
    struct ng_gbuffer images = {.lamps = lamps};
    data.picture = true;
    data.lamps = NG_LAMPS_NOT;
    images.depth = add_target(g, data.frame, true, "picture/depth", VK_FORMAT_D32_SFLOAT);
    add_scene(g, "gbuffer:picture", &data, &images);
    data.lamps = NG_LAMPS_ONLY;
    if (lamps)
        add_scene(g, "gbuffer lamps:picture", &data, &images);
    add_background(g, "background:picture", &data, &images);
    return ng_composer_publish(composer, &ng_gbuffer_picture_item, &images);
}

static ng_result consume(struct ng_composer *composer, void *user)
{
    struct ng_graph *g = ng_composer_graph(composer);
    const struct ng_frame_info *frame = ng_composer_get(composer, &ng_frame_item, 0);
    const struct ng_gbuffer *behind = ng_composer_get(composer, &ng_gbuffer_behind_lamps_item, 0);
    const struct pass_data data = {user, frame, NG_LAMPS_ONLY, false};
    if (!behind)
        return NG_ERROR_MEMORY; // logged where it could not be published
    if (ng_composer_count(composer, &ng_gbuffer_item))
        return NG_OK;
    struct ng_gbuffer images = *behind;
    if (images.lamps)
        add_scene(g, "gbuffer lamps", &data, &images);
    add_background(g, "background", &data, &images);
    NG_TRY(ng_composer_publish(composer, &ng_gbuffer_item, &images));
    return ng_frame_is_guided(frame) ? publish_picture(composer, data, images.lamps) : NG_OK;
}

struct ng_provider ng_gbuffer_provider(struct ng_gbuffer_provider *provider)
{
    return (struct ng_provider){
        .name = NG_GBUFFER_PROVIDER, .produce = produce, .consume = consume, .user = provider};
}

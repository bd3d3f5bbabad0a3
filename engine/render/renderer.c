// The frame: publish the snapshot, let the providers declare their passes, present, execute.
#include "render/renderer.h"
#include "render/renderer_internal.h"

#include "base/array.h"
#include "base/log.h"
#include "gpu/image.h"
#include "render/display.h"
#include "render/frame.h"
#include "render/gbuffer.h"
#include "render/raster.h"
#include "render/scene_gpu.h"

#include "bare.vert.spv.h"

#include <stdlib.h>
#include <string.h>

const struct ng_item_type ng_frame_item = {"frame", sizeof(struct ng_frame_info)};

#define MAX_LAYERS 32

struct scratch {
    char name[32];
    NG_ARRAY(unsigned char) bytes;
};

struct ng_renderer {
    struct ng_renderer_params params;
    struct ng_graph *graph;
    struct ng_composer *composer;
    struct ng_scene_gpu *scene;
    struct ng_gbuffer_provider *gbuffer;
    struct ng_light_maps_provider *light_maps;
    struct ng_raster *raster;
    struct ng_display *display;
    struct ng_gpu_pipeline *bare; // depth alone, for benchmarks
    struct ng_frame_info frame;

    // What the last frame was, for those who fetch its results.
    char method[32], layers[MAX_LAYERS][32];
    uint32_t layer_count;
    bool has_unshadowed, has_direct, has_indirect, shows[2];
    struct ng_snapshot_camera camera;
    NG_ARRAY(ng_entity) entities; // of the snapshot's instances
    struct scratch scratch[MAX_LAYERS];
};

static ng_result make_bare_pipeline(struct ng_renderer *r)
{
    static const struct ng_gpu_slot slots[] = {{.binding = 0, .type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER},
                                               {.binding = 1, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}};
    struct ng_gpu_graphics_params p = {.name = "bare depth",
                                       .vertex = NG_SPIRV(ng_spv_bare_vert),
                                       .slots = slots,
                                       .slot_count = NG_COUNT(slots),
                                       .dynamic_cull = true,
                                       .depth_format = VK_FORMAT_D32_SFLOAT,
                                       .depth_test = true,
                                       .depth_write = true};
    ng_scene_gpu_vertex_input(NG_STREAMS_POSITION, &p);
    return ng_gpu_graphics_create(r->params.gpu, &p, &r->bare);
}

static ng_result create_parts(struct ng_renderer *r)
{
    const struct ng_renderer_params *p = &r->params;
    NG_TRY(ng_graph_create(
        &(struct ng_graph_params){
            .gpu = p->gpu, .jobs = p->jobs, .no_culling = p->no_culling, .no_aliasing = p->no_aliasing},
        &r->graph));
    NG_TRY(ng_composer_create(r->graph, &r->composer));
    NG_TRY(ng_scene_gpu_create(p->gpu, &r->scene));
    NG_TRY(ng_gbuffer_create(p->gpu, &r->gbuffer));
    NG_TRY(ng_light_maps_create(&(struct ng_light_maps_params){.gpu = p->gpu,
                                                               .depth_budget = p->depth_budget,
                                                               .cascade_radius = p->cascade_radius,
                                                               .always = p->redraw_lights,
                                                               .bare_depth = p->bare_passes},
                                &r->light_maps));
    NG_TRY(ng_raster_create(p->gpu, &r->raster));
    NG_TRY(ng_display_create(p->gpu, &r->display));
    if (p->bare_passes)
        NG_TRY(make_bare_pipeline(r));
    const struct ng_provider providers[] = {ng_gbuffer_provider(r->gbuffer),
                                            ng_light_maps_provider(r->light_maps),
                                            ng_raster_provider(r->raster)};
    for (size_t i = 0; i < NG_COUNT(providers); i++)
        NG_TRY(ng_composer_register(r->composer, &providers[i]));
    return NG_OK;
}

ng_result ng_renderer_create(const struct ng_renderer_params *params, struct ng_renderer **out)
{
    NG_REQUIRE(params && params->gpu, "a renderer needs a GPU");
    *out = NULL;
    struct ng_renderer *r = calloc(1, sizeof *r);
    if (!r)
        return ng_out_of_memory("the renderer");
    r->params = *params;
    ng_result result = create_parts(r);
    if (result != NG_OK)
        ng_renderer_destroy(&r);
    *out = r;
    return result;
}

void ng_renderer_destroy(struct ng_renderer **renderer)
{
    struct ng_renderer *r = *renderer;
    if (!r)
        return;
    ng_gpu_pipeline_destroy(&r->bare);
    ng_display_destroy(&r->display);
    ng_raster_destroy(&r->raster);
    ng_light_maps_destroy(&r->light_maps);
    ng_gbuffer_destroy(&r->gbuffer);
    ng_scene_gpu_destroy(&r->scene);
    ng_composer_destroy(&r->composer);
    ng_graph_destroy(&r->graph);
    ng_array_finish(&r->entities);
    for (int i = 0; i < MAX_LAYERS; i++)
        ng_array_finish(&r->scratch[i].bytes);
    free(r);
    *renderer = NULL;
}

// ---- Passes ----------------------------------------------------------------------------------------------

struct pass_data {
    struct ng_renderer *r;
    struct ng_graph_ref from, to;
    uint32_t width, height; // of `to`
};

static ng_result draw_bare(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct ng_scene_gpu *scene = d->r->scene;
    const struct ng_gpu_binding bindings[] = {ng_scene_gpu_view(scene, 0), ng_scene_gpu_instances(scene, 1)};
    return ng_scene_gpu_draw(scene, ctx->cmd,
                             &(struct ng_draw_params){.plain = {d->r->bare, NG_STREAMS_POSITION},
                                                      .textured = {d->r->bare, NG_STREAMS_POSITION},
                                                      .depth_only = true,
                                                      .bindings = bindings,
                                                      .binding_count = NG_COUNT(bindings),
                                                      .view_projection = ng_scene_gpu_camera(scene),
                                                      .mirrors = ng_scene_gpu_camera_mirrors(scene),
                                                      .skip_light = NG_NONE,
                                                      .cull_back = true});
}

static void declare_bare(struct ng_renderer *r, const struct pass_data *data)
{
    struct ng_graph_ref depth =
        ng_graph_add_image(r->graph, "bare:camera/map",
                           &(struct ng_graph_image_params){.format = VK_FORMAT_D32_SFLOAT,
                                                           .width = r->frame.width,
                                                           .height = r->frame.height,
                                                           .clear = true});
    ng_pass_write(ng_graph_add_pass(r->graph, &(struct ng_pass_params){.name = "bare:camera",
                                                                       .kind = NG_PASS_RASTER,
                                                                       .run = draw_bare,
                                                                       .data = data,
                                                                       .data_size = sizeof *data,
                                                                       .flags = NG_PASS_SIDE_EFFECT}),
                  depth, NG_USE_DEPTH);
}

static ng_result blit(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    const struct ng_frame_info *f = &d->r->frame;
    const VkImageSubresourceLayers all = {.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT, .layerCount = 1};
    vkCmdBlitImage(ctx->cmd->handle, ng_pass_image(ctx, d->from)->handle, ng_pass_layout(ctx, d->from),
                   ng_pass_image(ctx, d->to)->handle, ng_pass_layout(ctx, d->to), 1,
                   &(VkImageBlit){.srcSubresource = all,
                                  .srcOffsets[1] = {(int32_t)f->picture[0], (int32_t)f->picture[1], 1},
                                  .dstSubresource = all,
                                  .dstOffsets[1] = {(int32_t)d->width, (int32_t)d->height, 1}},
                   f->picture[0] == d->width && f->picture[1] == d->height ? VK_FILTER_NEAREST
                                                                           : VK_FILTER_LINEAR);
    return NG_OK;
}

static void declare_present(struct ng_renderer *r, struct ng_gpu_image *target, struct ng_graph_ref display)
{
    struct pass_data data = {.r = r, .from = display, .width = target->width, .height = target->height};
    data.to =
        ng_graph_import_image(r->graph, "target", target,
                              &(struct ng_graph_import){.initial = NG_USE_NONE, .final = NG_USE_PRESENT});
    struct ng_pass *pass = ng_graph_add_pass(
        r->graph,
        &(struct ng_pass_params){
            .name = "present", .kind = NG_PASS_COPY, .run = blit, .data = &data, .data_size = sizeof data});
    ng_pass_read(pass, display, NG_USE_COPY_SRC);
    ng_pass_write(pass, data.to, NG_USE_COPY_DST);
}

// ---- A frame ---------------------------------------------------------------------------------------------

static void copy_name(char *to, size_t room, const char *from)
{
    size_t n = strlen(from);
    n = n < room ? n : room - 1;
    memcpy(to, from, n);
    to[n] = 0;
}

static ng_result remember_frame(struct ng_renderer *r, const struct ng_render_params *p)
{
    const struct ng_snapshot *s = p->snapshot;
    copy_name(r->method, sizeof r->method, r->frame.method);
    r->layer_count = p->layer_count;
    for (uint32_t i = 0; i < p->layer_count; i++)
        copy_name(r->layers[i], sizeof r->layers[i], p->layers[i]);
    r->camera = s->camera;
    if (!ng_array_resize(&r->entities, s->instance_count))
        return ng_out_of_memory("the renderer");
    for (uint32_t i = 0; i < s->instance_count; i++)
        r->entities.items[i] = s->instances[i].entity;
    return NG_OK;
}

static ng_result declare_frame(struct ng_renderer *r, const struct ng_render_params *p)
{
    struct pass_data data = {.r = r};
    ng_composer_begin(r->composer);
    for (uint32_t i = 0; i < p->layer_count; i++)
        NG_TRY(ng_layers_request(r->graph, r->frame.method, p->layers[i]));
    for (uint32_t i = 0; i < p->resource_count; i++)
        ng_graph_readback(r->graph, p->resources[i]);
    NG_TRY(ng_composer_publish(r->composer, &ng_frame_item, &r->frame));
    if (r->params.bare_passes)
        declare_bare(r, &data);
    NG_TRY(ng_composer_declare(r->composer));
    struct ng_display_result shown;
    NG_TRY(ng_display_declare(r->display, r->composer, &p->shown, p->adaptation, p->averaged, &shown));
    r->has_unshadowed = shown.radiance->unshadowed.id;
    r->has_direct = shown.radiance->direct.id;
    r->has_indirect = shown.radiance->indirect.id;
    memcpy(r->shows, shown.shows, sizeof r->shows);

    struct ng_graph_ref display = shown.color;
    if (p->overlay)
        display = p->overlay(p->overlay_user, r->graph, display);
    if (p->target)
        declare_present(r, p->target, display);
    return NG_OK;
}

static ng_result check_lights(const struct ng_snapshot *s)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < s->light_count; i++)
        count += s->lights[i].power > 0;
    if (count <= NG_MAX_LIGHTS)
        return NG_OK;
    ng_log_error("the scene has %u lights, at most %d can be drawn; switch some off, or use the path tracer",
                 count, NG_MAX_LIGHTS);
    return NG_ERROR_UNSUPPORTED;
}

ng_result ng_renderer_frame(struct ng_renderer *r, struct ng_cmd **cmd, const struct ng_render_params *p)
{
    NG_REQUIRE(p && p->snapshot && p->width && p->height, "a frame needs a snapshot and a size");
    NG_REQUIRE(p->layer_count <= MAX_LAYERS, "at most %d layers", MAX_LAYERS);
    bool guided = p->light_width && p->light_height;
    NG_REQUIRE(!guided || (!p->shown.comparison && !p->averaged), "light of fewer pixels is shown alone");
    r->frame = (struct ng_frame_info){.gpu = r->params.gpu,
                                      .snapshot = p->snapshot,
                                      .scene = r->scene,
                                      .width = guided ? p->light_width : p->width,
                                      .height = guided ? p->light_height : p->height,
                                      .picture = {p->width, p->height},
                                      .method = p->method ? p->method : "raster",
                                      .other_method = p->shown.comparison ? p->shown.other_method : NULL};
    NG_TRY(check_lights(p->snapshot));
    NG_TRY(remember_frame(r, p));
    NG_TRY(ng_scene_gpu_update(r->scene, p->snapshot, r->frame.width, r->frame.height));
    if (ng_frame_is_guided(&r->frame))
        NG_TRY(ng_scene_gpu_add_picture(r->scene, p->width, p->height));
    NG_TRY(declare_frame(r, p));
    ng_graph_abandon_when(r->graph, p->abandon, p->abandon_user);
    return ng_graph_execute(r->graph, cmd);
}

bool ng_renderer_shows(const struct ng_renderer *r, uint32_t side)
{
    return side < NG_COUNT(r->shows) && r->shows[side];
}

struct ng_composer *ng_renderer_composer(struct ng_renderer *r)
{
    return r->composer;
}

struct ng_graph *ng_renderer_graph(struct ng_renderer *r)
{
    return r->graph;
}

// ---- For layers.c ----------------------------------------------------------------------------------------

bool ng_renderer_was_requested(const struct ng_renderer *r, const char *layer)
{
    for (uint32_t i = 0; i < r->layer_count; i++)
        if (strcmp(r->layers[i], layer) == 0)
            return true;
    return false;
}

bool ng_renderer_has_radiance(const struct ng_renderer *r, const char *part)
{
    return strcmp(part, "unshadowed") == 0 ? r->has_unshadowed
           : strcmp(part, "direct") == 0   ? r->has_direct
                                           : r->has_indirect;
}

const char *ng_renderer_method(const struct ng_renderer *r)
{
    return r->method;
}

const struct ng_snapshot_camera *ng_renderer_camera(const struct ng_renderer *r)
{
    return &r->camera;
}

ng_entity ng_renderer_entity(const struct ng_renderer *r, uint32_t index)
{
    for (size_t i = 0; i < r->entities.count; i++)
        if (ng_entity_index(r->entities.items[i]) == index)
            return r->entities.items[i];
    return (ng_entity){0};
}

void *ng_renderer_scratch(struct ng_renderer *r, const char *name, size_t size)
{
    for (int i = 0; i < MAX_LAYERS; i++) {
        struct scratch *s = &r->scratch[i];
        if (s->name[0] && strcmp(s->name, name) != 0)
            continue;
        copy_name(s->name, sizeof s->name, name);
        return ng_array_resize(&s->bytes, size) ? s->bytes.items : NULL;
    }
    return NULL;
}

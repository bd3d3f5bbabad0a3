// Each light's images are persistent resources of the graph, and their passes have keys: what the light's
// views show. So the graph draws them when that has changed.
#include "render/light_maps.h"

#include "base/array.h"
#include "base/hash.h"
#include "base/log.h"
#include "base/printable.h"
#include "graph/key.h"
#include "render/frame.h"
#include "render/index_map.h"
#include "render/light_gpu.h"
#include "render/passes.h"
#include "render/scene_gpu.h"

#include "depth_full.frag.spv.h"
#include "depth_full.vert.spv.h"
#include "depth_masked.frag.spv.h"
#include "depth_masked.vert.spv.h"
#include "depth_opaque.vert.spv.h"
#include "observe_full.frag.spv.h"
#include "observe_full.vert.spv.h"
#include "observe_plain.frag.spv.h"
#include "observe_plain.vert.spv.h"
#include "observe_textured.frag.spv.h"
#include "observe_textured.vert.spv.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_FACE  1024u
#define MIN_FACE  64u
// A sky has many faces. They are half as wide if a texel is not wider than this, metres.
#define SKY_TEXEL 0.05f

const struct ng_item_type ng_light_maps_item = {"light maps", sizeof(struct ng_light_maps)};

struct map_name {
    char text[NG_TEXT_SIZE + 16];
};

// A light of this frame.
struct observed {
    struct ng_light_gpu gpu;
    struct ng_light_maps maps;
    struct map_name name;
};

struct ng_light_maps_provider {
    struct ng_light_maps_params params;
    struct ng_gpu_pipeline *depth, *depth_masked, *depth_full;
    struct ng_gpu_pipeline *surface, *surface_textured, *surface_full;
    NG_ARRAY(struct observed) lights;
    struct ng_index_map names; // hashes of this frame's: how often each was asked for
};

// ---- Pipelines -------------------------------------------------------------------------------------------

struct variant {
    const char *name;
    struct ng_spirv vertex, fragment;
    enum ng_vertex_streams streams;
    bool textured;
};

static ng_result make_depth(struct ng_gpu *gpu, const struct variant *v, struct ng_gpu_pipeline **out)
{
    static const struct ng_gpu_slot slots[] = {
        {.binding = 0, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
        {.binding = 1, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
        {.binding = 2, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
        NG_MATERIAL_SLOTS,
    };
    struct ng_gpu_graphics_params p = {
        .name = v->name,
        .vertex = v->vertex,
        .fragment = v->fragment,
        .slots = slots,
        .slot_count = v->textured ? NG_COUNT(slots) : 3,
        .push_size = sizeof(uint32_t),
        .dynamic_cull = true,
        .depth_format = VK_FORMAT_D32_SFLOAT,
        .depth_test = true,
        .depth_write = true,
    };
    ng_scene_gpu_vertex_input(v->streams, &p);
    return ng_gpu_graphics_create(gpu, &p, out);
}

static ng_result make_surface(struct ng_gpu *gpu, const struct variant *v, struct ng_gpu_pipeline **out)
{
    static const struct ng_gpu_slot slots[] = {
        {.binding = 1, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
        {.binding = 2, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
        {.binding = 7, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
        {.binding = 8, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
        {.binding = 9, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
        NG_MATERIAL_SLOTS,
    };
    struct ng_gpu_graphics_params p = {
        .name = v->name,
        .vertex = v->vertex,
        .fragment = v->fragment,
        .slots = slots,
        .slot_count = v->textured ? NG_COUNT(slots) : 5,
        .push_size = sizeof(uint32_t),
        .dynamic_cull = true,
        .color_formats = {VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_R16G16B16A16_SFLOAT,
                          VK_FORMAT_R32G32B32A32_SFLOAT},
        .color_count = 3,
        .depth_format = VK_FORMAT_D32_SFLOAT,
        .depth_test = true,
        .depth_write = true,
    };
    ng_scene_gpu_vertex_input(v->streams, &p);
    return ng_gpu_graphics_create(gpu, &p, out);
}

static ng_result make_pipelines(struct ng_light_maps_provider *self)
{
    const struct variant depth = {
        "light depth", NG_SPIRV(ng_spv_depth_opaque_vert), {0}, NG_STREAMS_POSITION, false};
    const struct variant depth_masked = {"light depth masked", NG_SPIRV(ng_spv_depth_masked_vert),
                                         NG_SPIRV(ng_spv_depth_masked_frag), NG_STREAMS_POSITION_UV, true};
    const struct variant depth_full = {"light depth full", NG_SPIRV(ng_spv_depth_full_vert),
                                       NG_SPIRV(ng_spv_depth_full_frag), NG_STREAMS_POSITION_FULL, true};
    const struct variant surface = {"light surface", NG_SPIRV(ng_spv_observe_plain_vert),
                                    NG_SPIRV(ng_spv_observe_plain_frag), NG_STREAMS_SURFACE, false};
    const struct variant surface_textured = {"light surface textured", NG_SPIRV(ng_spv_observe_textured_vert),
                                             NG_SPIRV(ng_spv_observe_textured_frag),
                                             NG_STREAMS_SURFACE_TEXTURED, true};
    const struct variant surface_full = {"light surface full", NG_SPIRV(ng_spv_observe_full_vert),
                                         NG_SPIRV(ng_spv_observe_full_frag), NG_STREAMS_SURFACE_FULL, true};
    struct ng_gpu *gpu = self->params.gpu;
    NG_TRY(make_depth(gpu, &depth, &self->depth));
    NG_TRY(make_depth(gpu, &depth_masked, &self->depth_masked));
    NG_TRY(make_depth(gpu, &depth_full, &self->depth_full));
    NG_TRY(make_surface(gpu, &surface, &self->surface));
    NG_TRY(make_surface(gpu, &surface_textured, &self->surface_textured));
    return make_surface(gpu, &surface_full, &self->surface_full);
}

ng_result ng_light_maps_create(const struct ng_light_maps_params *params, struct ng_light_maps_provider **out)
{
    *out = NULL;
    struct ng_light_maps_provider *self = calloc(1, sizeof *self);
    if (!self)
        return ng_out_of_memory("the lights of a frame");
    self->params = *params;
    if (!self->params.depth_budget)
        self->params.depth_budget = (uint64_t)192 << 20;
    if (!(self->params.cascade_radius > 0))
        self->params.cascade_radius = 40.0f;
    ng_result r = make_pipelines(self);
    if (r != NG_OK)
        ng_light_maps_destroy(&self);
    *out = self;
    return r;
}

void ng_light_maps_destroy(struct ng_light_maps_provider **provider)
{
    struct ng_light_maps_provider *self = *provider;
    if (!self)
        return;
    ng_gpu_pipeline_destroy(&self->depth);
    ng_gpu_pipeline_destroy(&self->depth_masked);
    ng_gpu_pipeline_destroy(&self->depth_full);
    ng_gpu_pipeline_destroy(&self->surface);
    ng_gpu_pipeline_destroy(&self->surface_textured);
    ng_gpu_pipeline_destroy(&self->surface_full);
    ng_array_finish(&self->lights);
    ng_index_map_finish(&self->names);
    free(self);
    *provider = NULL;
}

// ---- Passes ----------------------------------------------------------------------------------------------

struct pass_data {
    struct ng_light_maps_provider *self;
    const struct ng_frame_info *frame;
    struct observed *light;
};

// Draws one layer of a depth map: view number `layer` of the buffer `views`.
static ng_result draw_depth_layer(const struct ng_pass_context *ctx, const struct ng_frame_range *views,
                                  uint32_t layer, const struct ng_light_view_data *view)
{
    const struct pass_data *d = ctx->data;
    struct ng_scene_gpu *scene = d->frame->scene;
    const struct ng_gpu_binding bindings[] = {ng_pass_range(views, 0), ng_scene_gpu_instances(scene, 1),
                                              ng_scene_gpu_materials(scene, 2)};
    return ng_scene_gpu_draw(
        scene, ctx->cmd,
        &(struct ng_draw_params){.plain = {d->self->depth, NG_STREAMS_POSITION},
                                 .textured = {d->self->depth_masked, NG_STREAMS_POSITION_UV},
                                 .full = {d->self->depth_full, NG_STREAMS_POSITION_FULL},
                                 .depth_only = true,
                                 .bindings = bindings,
                                 .binding_count = NG_COUNT(bindings),
                                 .push = &layer,
                                 .push_size = sizeof layer,
                                 .view_projection = view->view_projection,
                                 .skip_light = d->light->gpu.data.index});
}

static ng_result draw_depth(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    const struct ng_light_gpu *light = &d->light->gpu;
    for (uint32_t layer = 0; layer < light->depth_view_count; layer++)
        NG_TRY(draw_depth_layer(ctx, &light->depth_view_range, layer, &light->depth_views[layer]));
    return NG_OK;
}

static ng_result draw_sky(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    const struct ng_light_gpu *light = &d->light->gpu;
    for (uint32_t layer = 0; layer < light->sky_view_count; layer++) {
        struct ng_light_view_data view;
        ng_light_gpu_sky_view(light, d->frame->snapshot, layer, &view);
        NG_TRY(draw_depth_layer(ctx, &light->sky_range, layer, &view));
    }
    return NG_OK;
}

static ng_result draw_surface(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct ng_scene_gpu *scene = d->frame->scene;
    const struct ng_light_gpu *light = &d->light->gpu;
    struct ng_gpu_binding bindings[5] = {ng_scene_gpu_instances(scene, 1), ng_scene_gpu_materials(scene, 2)};
    ng_light_gpu_bindings(light, true, bindings + 2);
    for (uint32_t layer = 0; layer < light->rsm_view_count; layer++)
        NG_TRY(ng_scene_gpu_draw(
            scene, ctx->cmd,
            &(struct ng_draw_params){.plain = {d->self->surface, NG_STREAMS_SURFACE},
                                     .textured = {d->self->surface_textured, NG_STREAMS_SURFACE_TEXTURED},
                                     .full = {d->self->surface_full, NG_STREAMS_SURFACE_FULL},
                                     .bindings = bindings,
                                     .binding_count = NG_COUNT(bindings),
                                     .push = &layer,
                                     .push_size = sizeof layer,
                                     .view_projection = light->rsm_views[layer].view_projection,
                                     .skip_light = light->data.index}));
    return NG_OK;
}

// ---- A frame ---------------------------------------------------------------------------------------------

uint32_t ng_light_maps_face_size(uint64_t budget, uint32_t faces)
{
    uint32_t size = MAX_FACE;
    while (size > MIN_FACE && (uint64_t)size * size * 4 * faces > budget)
        size /= 2;
    return size;
}

static uint64_t hash_name(const char *name)
{
    return ng_hash_string(name) | 1; // never 0
}

// Names of lights are people's; passes and images need unique ones. A name that was asked for n times goes on
// with the number n + 1, so that thousands of one name do not search for theirs.
static ng_result name_light(struct ng_light_maps_provider *self, size_t index, const char *wanted)
{
    char *name = self->lights.items[index].name.text, shown[NG_TEXT_SIZE];
    size_t room = sizeof self->lights.items[index].name;
    snprintf(shown, sizeof shown, "%s", wanted[0] ? wanted : "light");
    ng_make_printable(shown); // passes are listed by name
    snprintf(name, room, "%s", shown);
    uint32_t n = ng_index_map_get(&self->names, hash_name(shown));
    for (n = n == UINT32_MAX ? 1 : n; ng_index_map_get(&self->names, hash_name(name)) != UINT32_MAX;)
        snprintf(name, room, "%s#%u", shown, ++n);
    return ng_index_map_set(&self->names, hash_name(shown), n) &&
                   ng_index_map_set(&self->names, hash_name(name), 1)
               ? NG_OK
               : ng_out_of_memory("the lights of a frame");
}

static uint64_t key_of_views(const struct ng_frame_info *frame, const struct ng_light_gpu *l,
                             const struct ng_light_view_data *views, uint32_t count)
{
    uint64_t key = ng_key_add_bytes(NG_KEY, views, count * sizeof *views);
    for (uint32_t i = 0; i < count; i++) {
        struct ng_seen_params seen = {.skip_light = l->data.index};
        memcpy(seen.view_projection, views[i].view_projection, sizeof seen.view_projection);
        key = ng_key_add(key, ng_scene_gpu_seen(frame->scene, &seen));
    }
    return key;
}

static struct ng_graph_ref persistent(struct ng_graph *g, const char *light, const char *what,
                                      VkFormat format, uint32_t size, uint32_t layers)
{
    char name[160];
    snprintf(name, sizeof name, "rsm:%s/%s", light, what);
    return ng_graph_persistent_image(
        g, name,
        &(struct ng_graph_image_params){
            .format = format, .width = size, .height = size, .layers = layers, .array = true, .clear = true},
        NULL);
}

static struct ng_pass *add_pass(struct ng_graph *g, const struct pass_data *data, const char *group,
                                const char *what, ng_pass_fn run, uint32_t flags, uint64_t key)
{
    char name[160];
    snprintf(name, sizeof name, "%s:%s/%s", group, data->light->name.text, what);
    return ng_graph_add_pass(g, &(struct ng_pass_params){.name = name,
                                                         .kind = NG_PASS_RASTER,
                                                         .run = run,
                                                         .data = data,
                                                         .data_size = sizeof *data,
                                                         .flags = flags,
                                                         .key = key});
}

static uint32_t map_flags(const struct pass_data *data)
{
    return data->self->params.always ? NG_PASS_SIDE_EFFECT : NG_PASS_ON_DEMAND;
}

static void declare_bare_depth(struct ng_graph *g, const struct pass_data *data)
{
    char name[160];
    snprintf(name, sizeof name, "bare:%s/map", data->light->name.text);
    struct ng_graph_ref map =
        ng_graph_add_image(g, name,
                           &(struct ng_graph_image_params){.format = VK_FORMAT_D32_SFLOAT,
                                                           .width = data->light->maps.face_size,
                                                           .height = data->light->maps.face_size,
                                                           .layers = data->light->maps.depth_views,
                                                           .array = true,
                                                           .clear = true});
    ng_pass_write(add_pass(g, data, "bare", "depth", draw_depth, NG_PASS_SIDE_EFFECT, 0), map, NG_USE_DEPTH);
}

static void declare_depth(struct ng_graph *g, const struct pass_data *data)
{
    struct ng_light_maps *m = &data->light->maps;
    const struct ng_light_gpu *l = &data->light->gpu;
    uint64_t key = key_of_views(data->frame, l, l->depth_views, l->depth_view_count);
    struct ng_pass *pass = add_pass(g, data, "rsm", "depth", draw_depth, map_flags(data), key);
    m->depth = persistent(g, m->name, "depth", VK_FORMAT_D32_SFLOAT, m->face_size, m->depth_views);
    m->depth = ng_pass_write(pass, m->depth, NG_USE_DEPTH);
}

static bool sky_is_halved(const struct ng_snapshot *s)
{
    return 2 * s->scene_radius <= 0.5f * MAX_FACE * SKY_TEXEL;
}

// What shows in all views together, each of which sees all of the scene's sphere.
static uint64_t key_of_sky(const struct ng_frame_info *frame, const struct ng_light_gpu *l)
{
    const struct ng_snapshot *s = frame->snapshot;
    struct ng_seen_params all = {.view_projection = {[15] = 1}, .skip_light = l->data.index};
    uint64_t key = ng_key_add(NG_KEY, ng_scene_gpu_seen(frame->scene, &all));
    key = ng_key_add_bytes(key, s->scene_center, sizeof s->scene_center);
    key = ng_key_add_bytes(key, &s->scene_radius, sizeof s->scene_radius);
    return ng_key_add_bytes(key, l->vpls, l->sky_view_count * sizeof *l->vpls);
}

static void declare_sky(struct ng_graph *g, const struct pass_data *data)
{
    struct ng_light_maps *m = &data->light->maps;
    const struct ng_light_gpu *l = &data->light->gpu;
    uint32_t size = sky_is_halved(data->frame->snapshot) ? m->face_size / 2 : m->face_size;
    struct ng_pass *pass =
        add_pass(g, data, "rsm", "sky", draw_sky, map_flags(data), key_of_sky(data->frame, l));
    m->sky = persistent(g, m->name, "sky", VK_FORMAT_D32_SFLOAT, size, l->sky_view_count);
    m->sky = ng_pass_write(pass, m->sky, NG_USE_DEPTH);
}

static void declare_surface(struct ng_graph *g, const struct pass_data *data)
{
    struct ng_light_maps *m = &data->light->maps;
    const struct ng_light_gpu *l = &data->light->gpu;
    uint64_t key = ng_key_add(key_of_views(data->frame, l, l->rsm_views, l->rsm_view_count),
                              data->frame->snapshot->lights[m->light].version);
    struct ng_pass *pass = add_pass(g, data, "rsm", "surface", draw_surface, map_flags(data), key);
    struct {
        struct ng_graph_ref *ref;
        const char *what;
        VkFormat format;
    } maps[] = {{&m->position, "position", VK_FORMAT_R32G32B32A32_SFLOAT},
                {&m->normal, "normal", VK_FORMAT_R16G16B16A16_SFLOAT},
                {&m->flux, "flux", VK_FORMAT_R32G32B32A32_SFLOAT}};
    for (size_t i = 0; i < NG_COUNT(maps); i++) {
        *maps[i].ref = persistent(g, m->name, maps[i].what, maps[i].format, NG_RSM_SIZE, m->rsm_views);
        *maps[i].ref = ng_pass_write(pass, *maps[i].ref, NG_USE_COLOR);
    }
    char name[160];
    snprintf(name, sizeof name, "rsm:%s/surface depth", m->name);
    ng_pass_write(pass,
                  ng_graph_add_image(g, name,
                                     &(struct ng_graph_image_params){.format = VK_FORMAT_D32_SFLOAT,
                                                                     .width = NG_RSM_SIZE,
                                                                     .height = NG_RSM_SIZE,
                                                                     .layers = m->rsm_views,
                                                                     .array = true,
                                                                     .clear = true}),
                  NG_USE_DEPTH);
}

// Fills self->lights with the lights that are on.
static ng_result observe_lights(struct ng_light_maps_provider *self, const struct ng_frame_info *frame)
{
    const struct ng_snapshot *s = frame->snapshot;
    uint32_t faces = 0;
    size_t count = 0;
    ng_index_map_clear(&self->names);
    if (!ng_array_resize(&self->lights, s->light_count))
        return ng_out_of_memory("the lights of a frame");
    for (uint32_t i = 0; i < s->light_count; i++) {
        if (!(s->lights[i].power > 0))
            continue;
        struct observed *o = &self->lights.items[count];
        ng_light_gpu_observe(s, i, &s->lights[i].source, (float)frame->width / (float)frame->height,
                             self->params.cascade_radius, &o->gpu);
        if (!o->gpu.depth_view_count || !o->gpu.data.vpl_count)
            continue;
        NG_TRY(name_light(self, count, s->lights[i].name));
        faces += o->gpu.depth_view_count;
        faces += sky_is_halved(s) ? o->gpu.sky_view_count / 4 : o->gpu.sky_view_count;
        count++;
    }
    self->lights.count = count;
    uint32_t face_size = ng_light_maps_face_size(self->params.depth_budget, faces);
    for (size_t i = 0; i < count; i++) {
        struct observed *o = &self->lights.items[i];
        ng_light_gpu_set_face_size(&o->gpu, face_size);
        o->maps = (struct ng_light_maps){.light = o->gpu.data.index,
                                         .name = o->name.text,
                                         .depth_views = o->gpu.depth_view_count,
                                         .rsm_views = o->gpu.rsm_view_count,
                                         .face_size = face_size,
                                         .gpu = &o->gpu};
    }
    return NG_OK;
}

static ng_result produce(struct ng_composer *composer, void *user)
{
    struct ng_light_maps_provider *self = user;
    struct ng_graph *g = ng_composer_graph(composer);
    struct pass_data data = {.self = self, .frame = ng_composer_get(composer, &ng_frame_item, 0)};
    NG_TRY(observe_lights(self, data.frame));
    for (size_t i = 0; i < self->lights.count; i++) {
        data.light = &self->lights.items[i];
        NG_TRY(ng_light_gpu_record(self->params.gpu, data.frame->snapshot, &data.light->gpu));
        declare_depth(g, &data);
        if (data.light->gpu.sky_view_count)
            declare_sky(g, &data);
        declare_surface(g, &data);
        if (self->params.bare_depth)
            declare_bare_depth(g, &data);
        NG_TRY(ng_composer_publish(composer, &ng_light_maps_item, &data.light->maps));
    }
    return NG_OK;
}

struct ng_provider ng_light_maps_provider(struct ng_light_maps_provider *provider)
{
    return (struct ng_provider){.name = "light maps", .produce = produce, .user = provider};
}

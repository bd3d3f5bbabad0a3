// The passes "compose", which makes a method's beauty, and "tone map", which makes what is shown of one layer
// or of two. Where the device draws on the CPU, and what is shown was made there, the host does the same
// (display_kernels.h): nothing is copied to the device for it.
#include "render/display.h"

#include "base/jobs.h"
#include "base/log.h"
#include "gpu/device.h"
#include "render/antialias.h"
#include "render/display_kernels.h"
#include "render/frame.h"
#include "render/meter.h"
#include "render/passes.h"
#include "render/scene_gpu.h"
#include "render/upsample.h"

#include "average.frag.spv.h"
#include "compose.frag.spv.h"
#include "tonemap.frag.spv.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// What a layer is made of.
enum source { BEAUTY, UNSHADOWED, DIRECT, INDIRECT, EMISSION, DIFFUSE, SPECULAR, NORMAL, NONE };

static const struct shown_layer {
    const char *name;
    enum source source, divisor;
    uint32_t encoding; // NG_SHOWN_*
} layers[] = {
    {"beauty", BEAUTY, NONE, NG_SHOWN_BEAUTY},           {"direct", DIRECT, NONE, NG_SHOWN_RADIANCE},
    {"unshadowed", UNSHADOWED, NONE, NG_SHOWN_RADIANCE}, {"shadow", DIRECT, UNSHADOWED, NG_SHOWN_RATIO},
    {"indirect", INDIRECT, NONE, NG_SHOWN_RADIANCE},     {"emission", EMISSION, NONE, NG_SHOWN_RADIANCE},
    {"albedo", DIFFUSE, NONE, NG_SHOWN_PLAIN},           {"specular", SPECULAR, NONE, NG_SHOWN_PLAIN},
    {"normal", NORMAL, NONE, NG_SHOWN_DIRECTION},        {"roughness", NORMAL, NONE, NG_SHOWN_W},
};

const char *ng_display_layer(uint32_t index)
{
    return index < NG_COUNT(layers) ? layers[index].name : NULL;
}

static const struct shown_layer *find_layer(const char *name)
{
    for (size_t i = 0; i < NG_COUNT(layers); i++)
        if (strcmp(layers[i].name, name) == 0)
            return &layers[i];
    return NULL;
}

struct ng_display {
    struct ng_gpu *gpu;
    struct ng_gpu_pipeline *compose, *average, *tonemap;
    struct ng_meter *meter;
    struct ng_antialias *antialias;
    struct ng_upsample *upsample;
};

#define TEXTURE(n)                                                                                           \
    {                                                                                                        \
        .binding = (n), .type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER                                    \
    }

static ng_result make_compose(struct ng_gpu *gpu, struct ng_gpu_pipeline **out)
{
    static const struct ng_gpu_slot slots[] = {TEXTURE(0), TEXTURE(1), TEXTURE(2)};
    return ng_fullscreen_create(
        gpu,
        &(struct ng_gpu_graphics_params){.name = "compose",
                                         .fragment = NG_SPIRV(ng_spv_compose_frag),
                                         .slots = slots,
                                         .slot_count = NG_COUNT(slots),
                                         .color_formats = {VK_FORMAT_R32G32B32A32_SFLOAT},
                                         .color_count = 1},
        out);
}

static ng_result make_average(struct ng_gpu *gpu, struct ng_gpu_pipeline **out)
{
    static const struct ng_gpu_slot slots[] = {TEXTURE(0)};
    return ng_fullscreen_create(
        gpu,
        &(struct ng_gpu_graphics_params){.name = "average",
                                         .fragment = NG_SPIRV(ng_spv_average_frag),
                                         .slots = slots,
                                         .slot_count = NG_COUNT(slots),
                                         .push_size = sizeof(int32_t),
                                         .color_formats = {VK_FORMAT_R32G32B32A32_SFLOAT},
                                         .color_count = 1},
        out);
}

static ng_result make_tonemap(struct ng_gpu *gpu, struct ng_gpu_pipeline **out)
{
    static const struct ng_gpu_slot slots[] = {TEXTURE(1),
                                               TEXTURE(2),
                                               TEXTURE(3),
                                               TEXTURE(4),
                                               {.binding = 5, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
                                               {.binding = 6, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
                                               TEXTURE(7)};
    return ng_fullscreen_create(gpu,
                                &(struct ng_gpu_graphics_params){.name = "tone map",
                                                                 .fragment = NG_SPIRV(ng_spv_tonemap_frag),
                                                                 .slots = slots,
                                                                 .slot_count = NG_COUNT(slots),
                                                                 .color_formats = {VK_FORMAT_R8G8B8A8_UNORM},
                                                                 .color_count = 1},
                                out);
}

ng_result ng_display_create(struct ng_gpu *gpu, struct ng_display **out)
{
    *out = NULL;
    struct ng_display *self = calloc(1, sizeof *self);
    if (!self)
        return ng_out_of_memory("the display");
    self->gpu = gpu;
    ng_result r = make_compose(gpu, &self->compose);
    if (r == NG_OK)
        r = make_average(gpu, &self->average);
    if (r == NG_OK)
        r = make_tonemap(gpu, &self->tonemap);
    if (r == NG_OK)
        r = ng_meter_create(gpu, &self->meter);
    if (r == NG_OK)
        r = ng_antialias_create(gpu, &self->antialias);
    if (r == NG_OK)
        r = ng_upsample_create(gpu, &self->upsample);
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
    ng_gpu_pipeline_destroy(&self->average);
    ng_gpu_pipeline_destroy(&self->tonemap);
    ng_meter_destroy(&self->meter);
    ng_antialias_destroy(&self->antialias);
    ng_upsample_destroy(&self->upsample);
    free(self);
    *display = NULL;
}

static struct ng_graph_ref picture(struct ng_graph *g, const struct ng_frame_info *frame, const char *name,
                                   VkFormat format)
{
    return ng_graph_add_image(g, name,
                              &(struct ng_graph_image_params){
                                  .format = format, .width = frame->picture[0], .height = frame->picture[1]});
}

// A texture of the pass, or black for what there is not.
static struct ng_gpu_binding texture_or_black(const struct ng_pass_context *ctx, struct ng_scene_gpu *scene,
                                              struct ng_graph_ref ref, uint32_t binding)
{
    return ref.id ? ng_pass_texture(ctx, ref, binding) : ng_scene_gpu_black(scene, binding);
}

static void read_if_any(struct ng_pass *pass, struct ng_graph_ref ref, bool on_host)
{
    if (ref.id)
        ng_pass_read(pass, ref, on_host ? NG_USE_HOST_READ : NG_USE_SAMPLED);
}

static struct ng_pass *add_pass(struct ng_graph *g, const char *name, bool on_host, ng_pass_fn run,
                                const void *data, size_t size)
{
    return ng_graph_add_pass(g, &(struct ng_pass_params){.name = name,
                                                         .kind = on_host ? NG_PASS_CPU : NG_PASS_RASTER,
                                                         .run = run,
                                                         .data = data,
                                                         .data_size = size});
}

// A map for the kernels, or black for what there is not.
static struct ng_display_map map_of(const struct ng_pass_context *ctx, struct ng_graph_ref ref)
{
    if (!ref.id)
        return (struct ng_display_map){0};
    struct ng_graph_memory m = ng_pass_memory(ctx, ref);
    return m.format == VK_FORMAT_R32G32B32A32_SFLOAT ? (struct ng_display_map){.floats = m.data}
                                                     : (struct ng_display_map){.halfs = m.data};
}

#define PIXELS_A_JOB (1u << 14)

// ---- Beauty ----------------------------------------------------------------------------------------------

struct compose_data {
    const struct ng_display *self;
    struct ng_scene_gpu *scene;
    struct ng_graph_ref direct, indirect, emission, beauty;
};

static ng_result compose(const struct ng_pass_context *ctx)
{
    const struct compose_data *d = ctx->data;
    const struct ng_gpu_binding bindings[] = {texture_or_black(ctx, d->scene, d->direct, 0),
                                              texture_or_black(ctx, d->scene, d->indirect, 1),
                                              ng_pass_texture(ctx, d->emission, 2)};
    NG_TRY(ng_cmd_bind(ctx->cmd, d->self->compose, bindings, NG_COUNT(bindings)));
    vkCmdDraw(ctx->cmd->handle, 3, 1, 0, 0);
    return NG_OK;
}

struct sum {
    struct ng_display_map parts[3];
    float *out;
};

static void add_up(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    const struct sum *s = user;
    NG_UNUSED(worker);
    ng_display_kernels_of(0)->compose(s->parts, begin, end, s->out);
}

static ng_result compose_on_host(const struct ng_pass_context *ctx)
{
    const struct compose_data *d = ctx->data;
    const struct ng_graph_memory out = ng_pass_memory(ctx, d->beauty);
    struct sum sum = {{map_of(ctx, d->direct), map_of(ctx, d->indirect), map_of(ctx, d->emission)}, out.data};
    ng_jobs_for(ctx->jobs, out.width * out.height, PIXELS_A_JOB, add_up, &sum);
    return NG_OK;
}

// Whether the device is a CPU, and both were made on the host. Shaders that somebody replaced are looked at.
static bool is_on_host(const struct ng_frame_info *frame, const struct ng_gbuffer *gbuffer,
                       const struct ng_radiance *radiance)
{
    return gbuffer->on_host && radiance->on_host && !frame->gpu->shaders;
}

// The beauty of a method, under the names given.
static struct ng_graph_ref declare_compose(const struct ng_display *self, struct ng_composer *composer,
                                           const struct ng_radiance *radiance, const char *pass_name,
                                           const char *image_name)
{
    struct ng_graph *g = ng_composer_graph(composer);
    const struct ng_frame_info *frame = ng_composer_get(composer, &ng_frame_item, 0);
    const struct ng_gbuffer *gbuffer = ng_composer_get(composer, &ng_gbuffer_item, 0);
    struct compose_data data = {.self = self,
                                .scene = frame->scene,
                                .direct = radiance->direct,
                                .indirect = radiance->indirect,
                                .emission = gbuffer->emission,
                                .beauty = picture(g, frame, image_name, VK_FORMAT_R32G32B32A32_SFLOAT)};
    bool on_host = is_on_host(frame, gbuffer, radiance);
    struct ng_pass *pass =
        add_pass(g, pass_name, on_host, on_host ? compose_on_host : compose, &data, sizeof data);
    read_if_any(pass, data.direct, on_host);
    read_if_any(pass, data.indirect, on_host);
    read_if_any(pass, data.emission, on_host);
    return ng_pass_write(pass, data.beauty, on_host ? NG_USE_HOST_WRITE : NG_USE_COLOR);
}

// ---- What is shown ---------------------------------------------------------------------------------------

// One side of a comparison, or the whole picture.
struct side {
    struct ng_graph_ref map, divisor; // zero: there is none
    uint32_t encoding;
    bool complete; // there is all that the layer is made of
};

struct tonemap_data {
    const struct ng_display *self;
    struct ng_scene_gpu *scene;
    struct side left, right;
    struct ng_graph_ref position; // position or shares; zero: neither a background nor what is unlit is shown
    struct ng_graph_ref exposure; // zero: the number, not what a meter found
    float fixed_exposure;
    struct ng_display_data shown;
    struct ng_graph_ref display; // written
};

static ng_result tone_map(const struct ng_pass_context *ctx)
{
    const struct tonemap_data *d = ctx->data;
    struct ng_frame_range shown, fixed;
    NG_TRY(ng_frame_put(ctx->gpu, &d->shown, sizeof d->shown, &shown));
    NG_TRY(ng_frame_put(ctx->gpu, &d->fixed_exposure, sizeof d->fixed_exposure, &fixed));
    struct ng_gpu_binding exposure = ng_pass_range(&fixed, 6);
    if (d->exposure.id)
        exposure = (struct ng_gpu_binding){.binding = 6, .buffer = ng_pass_buffer(ctx, d->exposure)};
    const struct ng_gpu_binding bindings[] = {texture_or_black(ctx, d->scene, d->left.map, 1),
                                              texture_or_black(ctx, d->scene, d->left.divisor, 2),
                                              texture_or_black(ctx, d->scene, d->right.map, 3),
                                              texture_or_black(ctx, d->scene, d->right.divisor, 4),
                                              ng_pass_range(&shown, 5),
                                              exposure,
                                              texture_or_black(ctx, d->scene, d->position, 7)};
    NG_TRY(ng_cmd_bind(ctx->cmd, d->self->tonemap, bindings, NG_COUNT(bindings)));
    vkCmdDraw(ctx->cmd->handle, 3, 1, 0, 0);
    return NG_OK;
}

static void show(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    ng_display_kernels_of(0)->show(user, begin, end);
}

static ng_result tone_map_on_host(const struct ng_pass_context *ctx)
{
    const struct tonemap_data *d = ctx->data;
    const struct ng_graph_memory out = ng_pass_memory(ctx, d->display);
    struct ng_display_picture picture = {.shown = d->shown,
                                         .exposure = d->fixed_exposure,
                                         .left = map_of(ctx, d->left.map),
                                         .left_divisor = map_of(ctx, d->left.divisor),
                                         .right = map_of(ctx, d->right.map),
                                         .right_divisor = map_of(ctx, d->right.divisor),
                                         .position = map_of(ctx, d->position),
                                         .width = out.width,
                                         .out = out.data};
    if (d->exposure.id)
        memcpy(&picture.exposure, ng_pass_memory(ctx, d->exposure).data, sizeof picture.exposure);
    ng_jobs_for(ctx->jobs, out.width * out.height, PIXELS_A_JOB, show, &picture);
    return NG_OK;
}

static struct side make_side(const struct shown_layer *layer, const struct ng_gbuffer *gbuffer,
                             const struct ng_radiance *radiance, struct ng_graph_ref beauty)
{
    const struct ng_graph_ref sources[NONE + 1] = {
        [BEAUTY] = beauty,
        [UNSHADOWED] = radiance->unshadowed,
        [DIRECT] = radiance->direct,
        [INDIRECT] = radiance->indirect,
        [EMISSION] = gbuffer->emission,
        [DIFFUSE] = gbuffer->diffuse,
        [SPECULAR] = gbuffer->specular,
        [NORMAL] = gbuffer->normal,
    };
    struct ng_graph_ref map = sources[layer->source], divisor = sources[layer->divisor];
    bool complete = map.id && (layer->divisor == NONE || divisor.id);
    return (struct side){map, divisor, layer->encoding, complete};
}

// ---- Means, for a difference of what has noise -----------------------------------------------------------

static uint32_t cell_of(const struct ng_shown *shown)
{
    return shown->comparison == NG_COMPARE_DIFFERENCE && shown->cell > 1 ? shown->cell : 1;
}

struct average_data {
    const struct ng_display *self;
    struct ng_graph_ref map;
    int32_t cell;
};

static ng_result average(const struct ng_pass_context *ctx)
{
    const struct average_data *d = ctx->data;
    const struct ng_gpu_binding bindings[] = {ng_pass_texture(ctx, d->map, 0)};
    NG_TRY(ng_cmd_bind(ctx->cmd, d->self->average, bindings, NG_COUNT(bindings)));
    ng_cmd_push(ctx->cmd, d->self->average, &d->cell, sizeof d->cell);
    vkCmdDraw(ctx->cmd->handle, 3, 1, 0, 0);
    return NG_OK;
}

// Nothing has no mean.
static struct ng_graph_ref declare_average(const struct ng_display *self, struct ng_composer *composer,
                                           const char *name, struct ng_graph_ref map, uint32_t cell)
{
    struct ng_graph *g = ng_composer_graph(composer);
    const struct ng_frame_info *frame = ng_composer_get(composer, &ng_frame_item, 0);
    if (!map.id)
        return map;
    struct ng_graph_ref mean =
        ng_graph_add_image(g, name,
                           &(struct ng_graph_image_params){.format = VK_FORMAT_R32G32B32A32_SFLOAT,
                                                           .width = (frame->width + cell - 1) / cell,
                                                           .height = (frame->height + cell - 1) / cell});
    struct average_data data = {self, map, (int32_t)cell};
    struct ng_pass *pass = ng_graph_add_pass(
        g,
        &(struct ng_pass_params){
            .name = name, .kind = NG_PASS_RASTER, .run = average, .data = &data, .data_size = sizeof data});
    ng_pass_read(pass, map, NG_USE_SAMPLED);
    return ng_pass_write(pass, mean, NG_USE_COLOR);
}

static void average_sides(const struct ng_display *self, struct ng_composer *composer, struct side *left,
                          struct side *right, uint32_t cell)
{
    left->map = declare_average(self, composer, "mean:left", left->map, cell);
    left->divisor = declare_average(self, composer, "mean:left divisor", left->divisor, cell);
    right->map = declare_average(self, composer, "mean:right", right->map, cell);
    right->divisor = declare_average(self, composer, "mean:right divisor", right->divisor, cell);
}

static struct ng_graph_ref declare_tone_map(const struct ng_display *self, struct ng_composer *composer,
                                            const struct ng_shown *shown, const struct side *left,
                                            const struct side *right, struct ng_graph_ref exposure,
                                            struct ng_graph_ref shares, bool on_host)
{
    struct ng_graph *g = ng_composer_graph(composer);
    const struct ng_frame_info *frame = ng_composer_get(composer, &ng_frame_item, 0);
    const struct ng_gbuffer *gbuffer = ng_composer_get(composer, &ng_gbuffer_item, 0);
    const struct ng_gbuffer *whole = ng_composer_get(composer, &ng_gbuffer_picture_item, 0),
                            *seen = whole ? whole : gbuffer;
    const struct ng_snapshot_camera *camera = &frame->snapshot->camera;
    const float *background = camera->background;
    bool looks =
        background[0] > 0 || background[1] > 0 || background[2] > 0 || ng_snapshot_has_unlit(frame->snapshot);
    struct tonemap_data data = {.self = self,
                                .scene = frame->scene,
                                .left = *left,
                                .right = *right,
                                .position = !looks      ? (struct ng_graph_ref){0}
                                            : shares.id ? shares
                                                        : seen->position,
                                .exposure = exposure,
                                .fixed_exposure = camera->exposure,
                                .shown = {.encoding = left->encoding,
                                          .other_encoding = right->encoding,
                                          .comparison = shown->comparison,
                                          .divider = shown->divider * (float)frame->picture[0],
                                          .cell = (float)cell_of(shown),
                                          .averaged = looks && shares.id,
                                          .background = {background[0], background[1], background[2]}},
                                .display = picture(g, frame, "display", VK_FORMAT_R8G8B8A8_UNORM)};
    struct ng_pass *pass =
        add_pass(g, "tone map", on_host, on_host ? tone_map_on_host : tone_map, &data, sizeof data);
    read_if_any(pass, left->map, on_host);
    read_if_any(pass, left->divisor, on_host);
    read_if_any(pass, right->map, on_host);
    read_if_any(pass, right->divisor, on_host);
    read_if_any(pass, data.position, on_host);
    if (exposure.id)
        ng_pass_read(pass, exposure, on_host ? NG_USE_HOST_READ : NG_USE_STORAGE_READ);
    return ng_pass_write(pass, data.display, on_host ? NG_USE_HOST_WRITE : NG_USE_COLOR);
}

// ---- The frame -------------------------------------------------------------------------------------------

static ng_result find_radiance(struct ng_composer *composer, const char *method,
                               const struct ng_radiance **out)
{
    const struct ng_radiance *radiance;
    for (size_t i = 0; (radiance = ng_composer_get(composer, &ng_radiance_item, i)); i++) {
        if (strcmp(radiance->method, method) == 0) {
            *out = radiance;
            return NG_OK;
        }
    }
    ng_log_error("method \"%s\": nothing in this program computes it; use \"raster\"", method);
    return NG_ERROR_NOT_FOUND;
}

static ng_result choose_layer(const char *name, const struct shown_layer **out)
{
    *out = find_layer(name);
    if (*out)
        return NG_OK;
    ng_log_error("layer \"%s\" cannot be shown", name);
    return NG_ERROR_NOT_FOUND;
}

ng_result ng_display_declare(struct ng_display *self, struct ng_composer *composer,
                             const struct ng_shown *shown, float adaptation, uint32_t averaged,
                             struct ng_display_result *out)
{
    const struct ng_frame_info *frame = ng_composer_get(composer, &ng_frame_item, 0);
    const struct ng_gbuffer *gbuffer = ng_composer_get(composer, &ng_gbuffer_item, 0);
    const char *name = shown->layer ? shown->layer : "beauty";
    const struct shown_layer *layer;
    NG_TRY(choose_layer(name, &layer));
    NG_TRY(find_radiance(composer, frame->method, &out->radiance));
    struct ng_antialiased mean = {{0}, {0}};
    bool guided = ng_frame_is_guided(frame);
    NG_REQUIRE(!guided || strcmp(name, "beauty") == 0, "of light of fewer pixels beauty is shown");
    out->beauty = guided ? ng_upsample_declare(self->upsample, composer, out->radiance)
                         : declare_compose(self, composer, out->radiance, "compose",
                                           averaged ? "beauty/frame" : "beauty");
    if (averaged) {
        NG_TRY(ng_antialias_declare(self->antialias, composer, out->beauty, averaged, &mean));
        out->beauty = mean.beauty;
    }
    struct side left = make_side(layer, gbuffer, out->radiance, out->beauty),
                right = {.encoding = left.encoding};
    bool on_host = !guided && !averaged && is_on_host(frame, gbuffer, out->radiance);

    if (shown->comparison) {
        const char *other_method = frame->other_method ? frame->other_method : frame->method;
        const struct ng_radiance *radiance;
        NG_TRY(choose_layer(shown->other_layer ? shown->other_layer : name, &layer));
        NG_TRY(find_radiance(composer, other_method, &radiance));
        struct ng_graph_ref beauty = out->beauty;
        if (radiance != out->radiance)
            beauty = declare_compose(self, composer, radiance, "compose:other", "beauty:other");
        right = make_side(layer, gbuffer, radiance, beauty);
        on_host = on_host && radiance->on_host;
    }
    out->shows[0] = left.complete;
    out->shows[1] = right.complete;
    struct ng_graph_ref exposure = {0};
    if (frame->snapshot->camera.auto_exposure)
        exposure = ng_meter_declare(self->meter, composer, out->radiance, adaptation, averaged);
    if (cell_of(shown) > 1) {
        average_sides(self, composer, &left, &right, cell_of(shown));
        on_host = false; // means are the device's
    }
    out->color = declare_tone_map(self, composer, shown, &left, &right, exposure, mean.shares, on_host);
    return NG_OK;
}

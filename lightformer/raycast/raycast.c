// The passes "gbuffer" and "gbuffer lamps", under the names that the rasterizer's have.
#include "lightformer/raycast/raycast.h"

#include "base/log.h"
#include "gpu/device.h"
#include "lightformer/raycast/picture.h"
#include "lightformer/trace/ray_scene.h"
#include "render/frame.h"
#include "render/gbuffer.h"

#include <stdlib.h>

#define PROVIDER "gbuffer by rays"

struct lf_raycast {
    struct lf_raycast_params params;
    struct ng_composer *composer; // null: in none
};

ng_result lf_raycast_create(const struct lf_raycast_params *params, struct lf_raycast **out)
{
    *out = calloc(1, sizeof **out);
    if (!*out)
        return ng_out_of_memory("the G-buffer by rays");
    (*out)->params = *params;
    return NG_OK;
}

void lf_raycast_destroy(struct lf_raycast **raycast)
{
    struct lf_raycast *self = *raycast;
    *raycast = NULL;
    if (!self)
        return;
    lf_raycast_leave(self);
    free(self);
}

// ---- The passes ------------------------------------------------------------------------------------------

struct pass_data {
    const struct lf_raycast *self;
    const struct ng_frame_info *frame;
    const struct lf_ray_scene *rays;
    struct ng_gbuffer images;
    bool lamps, picture; // lamps alone; of the picture, not of light
};

static ng_result draw(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    const struct lf_raycast_job job = {
        .tracer = d->rays->tracer,
        .jobs = d->self->params.jobs,
        .picture = {.width = d->picture ? d->frame->picture[0] : d->frame->width,
                    .height = d->picture ? d->frame->picture[1] : d->frame->height,
                    .position = ng_pass_memory(ctx, d->images.position).data,
                    .normal = ng_pass_memory(ctx, d->images.normal).data,
                    .diffuse = ng_pass_memory(ctx, d->images.diffuse).data,
                    .specular = ng_pass_memory(ctx, d->images.specular).data,
                    .emission = ng_pass_memory(ctx, d->images.emission).data,
                    .motion = ng_pass_memory(ctx, d->images.motion).data,
                    .entity = ng_pass_memory(ctx, d->images.entity).data},
    };
    if (!lf_tracer_snapshot(job.tracer))
        return NG_ERROR_MEMORY; // logged there
    if (d->lamps)
        lf_raycast_draw_lamps(&job);
    else
        lf_raycast_draw(&job);
    return NG_OK;
}

// ---- A frame ---------------------------------------------------------------------------------------------

static void add_pass(struct ng_graph *g, const char *name, struct pass_data *data)
{
    struct ng_graph_ref *images[NG_GBUFFER_COLORS];
    ng_gbuffer_colors(&data->images, images);
    for (int i = 0; i < NG_GBUFFER_COLORS && !data->lamps; i++)
        *images[i] = ng_gbuffer_add_color(g, i, data->frame, data->picture);
    struct ng_pass *pass = ng_graph_add_pass(
        g, &(struct ng_pass_params){
               .name = name, .kind = NG_PASS_CPU, .run = draw, .data = data, .data_size = sizeof *data});
    ng_pass_read(pass, data->rays->updated, NG_USE_HOST_READ);
    for (int i = 0; i < NG_GBUFFER_COLORS; i++)
        *images[i] =
            ng_pass_write(pass, *images[i], data->lamps ? NG_USE_HOST_READ_WRITE : NG_USE_HOST_WRITE);
}

static bool is_cpu(const struct ng_frame_info *frame)
{
    return frame->gpu->properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
}

static bool draws(const struct lf_raycast *self, const struct ng_frame_info *frame)
{
    bool wanted = !self->params.method || ng_frame_wants(frame, self->params.method);
    return wanted &&
           (self->params.use == LF_RAYCAST_RAYS || (self->params.use == LF_RAYCAST_AUTO && is_cpu(frame)));
}

static ng_result produce(struct ng_composer *composer, void *user)
{
    struct pass_data data = {.self = user,
                             .frame = ng_composer_get(composer, &ng_frame_item, 0),
                             .rays = ng_composer_get(composer, &lf_ray_scene_item, 0)};
    if (!data.rays || !draws(data.self, data.frame))
        return NG_OK;
    data.images.lamps = ng_snapshot_has_lamps(data.frame->snapshot);
    data.images.on_host = is_cpu(data.frame);
    add_pass(ng_composer_graph(composer), "gbuffer", &data);
    return ng_composer_publish(composer, &ng_gbuffer_behind_lamps_item, &data.images);
}

static ng_result publish_picture(struct ng_composer *composer, struct pass_data data, bool lamps)
{
    data.picture = true;
    data.lamps = false;
    data.images = (struct ng_gbuffer){.lamps = lamps};
    add_pass(ng_composer_graph(composer), "gbuffer:picture", &data);
    data.lamps = true;
    if (lamps)
        add_pass(ng_composer_graph(composer), "gbuffer lamps:picture", &data);
    return ng_composer_publish(composer, &ng_gbuffer_picture_item, &data.images);
}

static ng_result consume(struct ng_composer *composer, void *user)
{
    struct pass_data data = {.self = user,
                             .frame = ng_composer_get(composer, &ng_frame_item, 0),
                             .rays = ng_composer_get(composer, &lf_ray_scene_item, 0),
                             .lamps = true};
    const struct ng_gbuffer *behind = ng_composer_get(composer, &ng_gbuffer_behind_lamps_item, 0);
    if (!data.rays || !draws(data.self, data.frame) || !behind)
        return NG_OK;
    data.images = *behind;
    if (behind->lamps)
        add_pass(ng_composer_graph(composer), "gbuffer lamps", &data);
    NG_TRY(ng_composer_publish(composer, &ng_gbuffer_item, &data.images));
    return ng_frame_is_guided(data.frame) ? publish_picture(composer, data, behind->lamps) : NG_OK;
}

ng_result lf_raycast_join(struct lf_raycast *self, struct ng_composer *composer)
{
    NG_REQUIRE(!self->composer, "the G-buffer by rays is in a composer already");
    const struct ng_provider provider = {.name = PROVIDER,
                                         .produce = produce,
                                         .consume = consume,
                                         .user = self,
                                         .before = NG_GBUFFER_PROVIDER};
    NG_TRY(lf_ray_scene_register(composer, &provider, 0));
    self->composer = composer;
    return NG_OK;
}

void lf_raycast_leave(struct lf_raycast *raycast)
{
    if (raycast->composer)
        lf_ray_scene_unregister(raycast->composer, PROVIDER);
    raycast->composer = NULL;
}

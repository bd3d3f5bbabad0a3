// The passes: what each does, and which of them a frame needs.
//
// The encodings themselves live on the host and are no resources of the graph. One small buffer for each
// light, and one for each other pass, stands for them: so the graph knows the order, and leaves out what
// nobody gathers.
#include "lightformer/encode/encoder_internal.h"

#include "lightformer/trace/tracer.h"
#include "render/light_gpu.h"

#include <stdio.h>

// ---- What they do ----------------------------------------------------------------------------------------

struct pass_data {
    struct lf_encoder_inputs in;
    struct lf_shining light;
};

static struct lf_encode_scene scene_of(const struct lf_encoder *self)
{
    return (struct lf_encode_scene){
        .tracer = self->tracer, .jobs = self->params.jobs, .reads = self->reads, .view = self->view};
}

static ng_result update_trace(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    d->in.self->counters.trace++;
    NG_TRY(lf_tracer_update(d->in.self->tracer, d->in.frame->snapshot));
    d->in.self->traced = true;
    return NG_OK;
}

// A pass whose input failed, which that one logged, fails too: it must not leave its key behind.
static ng_result need(bool made)
{
    return made ? NG_OK : NG_ERROR_NOT_FOUND;
}

static const void *pixels_of(const struct ng_pass_context *ctx, struct ng_graph_ref image)
{
    return ng_pass_memory(ctx, image).data;
}

static ng_result see_screen(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct lf_encoder *self = d->in.self;
    struct lf_encode_scene scene = scene_of(self);
    const struct lf_encode_pixels_params params = {
        .gbuffer = {.position = pixels_of(ctx, d->in.gbuffer->position),
                    .normal = pixels_of(ctx, d->in.gbuffer->normal),
                    .diffuse = pixels_of(ctx, d->in.gbuffer->diffuse),
                    .specular = pixels_of(ctx, d->in.gbuffer->specular)},
        .width = d->in.frame->width,
        .height = d->in.frame->height,
        .mirror_rays = self->params.mirror_rays,
    };
    self->counters.screen++;
    self->screen_key = 0;
    NG_TRY(need(self->traced));
    NG_TRY(lf_encode_pixels(&scene, &params, self->pixels));
    self->screen_key = d->in.screen_key;
    return NG_OK;
}

// Where the maps of this frame lie; their memory is another in each frame.
static const struct lf_light_observation *observe_maps(const struct ng_pass_context *ctx,
                                                       const struct lf_shining *light)
{
    const struct ng_light_maps *maps = light->maps;
    light->slot->maps = (struct lf_light_observation){
        .light = maps->light,
        .data = maps->gpu->data,
        .rsm_views = maps->rsm_views,
        .position = pixels_of(ctx, maps->position),
        .normal = pixels_of(ctx, maps->normal),
        .flux = pixels_of(ctx, maps->flux),
        .depth_views = maps->depth_views,
        .face_size = maps->face_size,
        .depth = pixels_of(ctx, maps->depth),
    };
    return &light->slot->maps;
}

static ng_result observe_light(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    const struct lf_encoder_params *p = &d->in.self->params;
    struct lf_slot *slot = d->light.slot;
    struct lf_encode_scene scene = scene_of(d->in.self);
    struct lf_encode_light_params params = {.vpl_count = p->vpl_count};
    if (p->rsm == LF_RSM_MAPS)
        params.maps = observe_maps(ctx, &d->light);
    d->in.self->counters.rsm++;
    slot->rsm_key = 0;
    NG_TRY(need(d->in.self->traced));
    NG_TRY(lf_encode_light(&scene, d->light.maps->light, &params, slot->clues));
    slot->rsm_key = d->light.rsm_key;
    return NG_OK;
}

static ng_result weigh_powers(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct lf_encoder *self = d->in.self;
    self->counters.powers++;
    self->powers_key = 0;
    NG_TRY(need(self->screen_key == d->in.screen_key));
    for (size_t i = 0; i < self->shining.count; i++)
        NG_TRY(need(self->shining.items[i].slot->rsm_key == self->shining.items[i].rsm_key));
    lf_encode_powers(d->in.frame->snapshot, self->pixels, self->clues.items, (uint32_t)self->clues.count);
    self->powers_key = d->in.powers_key;
    return NG_OK;
}

// The values of the frame and of the light side by side: the network takes them as one.
static struct lf_net_values join_values(const struct lf_encoder *self, const struct lf_slot *slot)
{
    struct lf_net_values joined = *lf_light_clues_values(slot->clues);
    const struct lf_net_values *pixels = lf_pixel_clues_values(self->pixels);
    for (int i = 0; i < LF_INPUT_COUNT; i++)
        if (lf_net_inputs[i].domain == LF_DOMAIN_FRAME)
            joined.of[i] = pixels->of[i];
    return joined;
}

static ng_result encode_points(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct lf_slot *slot = d->light.slot;
    const struct lf_net_values values = join_values(d->in.self, slot);
    const struct lf_net_light_inputs inputs = {.values = &values,
                                               .vpl_count = lf_light_clues_vpls(slot->clues),
                                               .texel_count = lf_light_clues_texels(slot->clues)};
    d->in.self->counters.points++;
    slot->points_key = 0;
    NG_TRY(need(slot->rsm_key == d->light.rsm_key && d->in.self->powers_key == d->in.powers_key));
    NG_TRY(lf_net_encode_light(d->in.self->params.executor, slot->encoding, &inputs));
    slot->points_key = d->light.points_key;
    return NG_OK;
}

static ng_result find_clues(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct lf_slot *slot = d->light.slot;
    struct lf_encode_scene scene = scene_of(d->in.self);
    if (d->in.self->params.rsm == LF_RSM_MAPS)
        (void)observe_maps(ctx, &d->light);
    d->in.self->counters.clues++;
    d->in.self->viewed = NULL;
    NG_TRY(need(d->in.self->traced && slot->rsm_key == d->light.rsm_key &&
                d->in.self->screen_key == d->in.screen_key));
    NG_TRY(lf_encode_view(&scene, d->in.self->pixels, slot->clues));
    d->in.self->viewed = slot;
    return NG_OK;
}

static ng_result encode_view(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct lf_slot *slot = d->light.slot;
    const struct lf_net_picture frame = {.width = d->in.frame->width,
                                         .height = d->in.frame->height,
                                         .values = lf_pixel_clues_values(d->in.self->pixels)};
    d->in.self->counters.view++;
    slot->view_key = 0;
    NG_TRY(need(slot->points_key == d->light.points_key && d->in.self->viewed == slot));
    NG_TRY(lf_net_encode_view(d->in.self->params.executor, slot->encoding, &frame,
                              lf_light_clues_values(slot->clues)));
    NG_TRY(lf_light_clues_keep(slot->clues, d->in.self->gather));
    slot->view_key = d->light.view_key;
    return NG_OK;
}

// ---- How they are declared --------------------------------------------------------------------------------

// A frame under declaration. Tokens are zero where nothing is redone.
struct declaration {
    struct ng_graph *graph;
    struct pass_data data;
    struct ng_graph_ref trace, screen, powers;
    struct ng_graph_ref view; // the memory that all lights use: one after another
};

static struct ng_pass *add_pass(struct declaration *d, const char *name, ng_pass_fn run)
{
    return ng_graph_add_pass(
        d->graph,
        &(struct ng_pass_params){
            .name = name, .kind = NG_PASS_CPU, .run = run, .data = &d->data, .data_size = sizeof d->data});
}

static struct ng_pass *add_light_pass(struct declaration *d, const char *what, ng_pass_fn run)
{
    char name[160];
    snprintf(name, sizeof name, "encode:%s/%s", d->data.light.maps->name, what);
    return add_pass(d, name, run);
}

static void wait_for(struct ng_pass *pass, struct ng_graph_ref token)
{
    if (token.id)
        ng_pass_read(pass, token, NG_USE_HOST_READ);
}

// The pass leaves its mark: what it made is there once the returned token can be read.
static struct ng_graph_ref mark(struct declaration *d, struct ng_pass *pass, struct ng_graph_ref token,
                                const char *name)
{
    if (token.id)
        return ng_pass_write(pass, token, NG_USE_HOST_READ_WRITE);
    token = ng_graph_add_buffer(d->graph, name, &(struct ng_graph_buffer_params){.size = sizeof(uint32_t)});
    return ng_pass_write(pass, token, NG_USE_HOST_WRITE);
}

static void mark_light(struct declaration *d, struct ng_pass *pass)
{
    char name[160];
    snprintf(name, sizeof name, "encode:%s", d->data.light.maps->name);
    d->data.light.token = mark(d, pass, d->data.light.token, name);
}

static void read_maps(const struct declaration *d, struct ng_pass *pass)
{
    const struct ng_light_maps *maps = d->data.light.maps;
    if (d->data.in.self->params.rsm != LF_RSM_MAPS)
        return;
    ng_pass_read(pass, maps->position, NG_USE_HOST_READ);
    ng_pass_read(pass, maps->normal, NG_USE_HOST_READ);
    ng_pass_read(pass, maps->flux, NG_USE_HOST_READ);
    ng_pass_read(pass, maps->depth, NG_USE_HOST_READ);
}

static void declare_trace(struct declaration *d)
{
    d->trace = mark(d, add_pass(d, "trace:update", update_trace), (struct ng_graph_ref){0}, "trace:scene");
}

static void declare_screen(struct declaration *d)
{
    struct ng_pass *pass = add_pass(d, "screen", see_screen);
    wait_for(pass, d->trace);
    const struct ng_gbuffer *g = d->data.in.gbuffer;
    const struct ng_graph_ref images[] = {g->position, g->normal, g->diffuse, g->specular};
    for (size_t i = 0; i < NG_COUNT(images); i++)
        ng_pass_read(pass, images[i], NG_USE_HOST_READ);
    d->screen = mark(d, pass, (struct ng_graph_ref){0}, "screen");
}

static void declare_rsm(struct declaration *d)
{
    struct ng_pass *pass = add_light_pass(d, "rsm", observe_light);
    wait_for(pass, d->trace);
    read_maps(d, pass);
    mark_light(d, pass);
}

static void declare_powers(struct declaration *d)
{
    struct lf_encoder *self = d->data.in.self;
    struct ng_pass *pass = add_pass(d, "powers", weigh_powers);
    wait_for(pass, d->screen);
    for (size_t i = 0; i < self->shining.count; i++)
        wait_for(pass, self->shining.items[i].token);
    d->powers = mark(d, pass, (struct ng_graph_ref){0}, "powers");
}

static void declare_points(struct declaration *d)
{
    struct ng_pass *pass = add_light_pass(d, "points", encode_points);
    wait_for(pass, d->powers);
    mark_light(d, pass);
}

static void declare_clues(struct declaration *d)
{
    struct ng_pass *pass = add_light_pass(d, "clues", find_clues);
    wait_for(pass, d->trace);
    wait_for(pass, d->screen);
    read_maps(d, pass);
    d->view = mark(d, pass, d->view, "encode:view memory");
    mark_light(d, pass);
}

static void declare_view(struct declaration *d)
{
    struct ng_pass *pass = add_light_pass(d, "view", encode_view);
    wait_for(pass, d->powers);
    wait_for(pass, d->screen);
    wait_for(pass, d->view);
    mark_light(d, pass);
}

// Whether rays are needed.
static bool any_traced(const struct lf_encoder *self, uint64_t screen)
{
    bool stale = self->params.always || self->screen_key != screen;
    for (size_t i = 0; i < self->shining.count && !stale; i++) {
        const struct lf_shining *light = &self->shining.items[i];
        stale = light->slot->rsm_key != light->rsm_key || light->slot->view_key != light->view_key;
    }
    return stale;
}

// What the powers do not need; returns with the light's token.
static void declare_first_half(struct declaration *d, struct lf_shining *light)
{
    bool always = d->data.in.self->params.always;
    d->data.light = *light;
    if (always || light->slot->rsm_key != light->rsm_key)
        declare_rsm(d);
    *light = d->data.light;
}

static void declare_second_half(struct declaration *d, struct lf_shining *light)
{
    const struct lf_slot *slot = light->slot;
    bool always = d->data.in.self->params.always;
    d->data.light = *light;
    if (always || slot->points_key != light->points_key)
        declare_points(d);
    if (always || slot->view_key != light->view_key) {
        declare_clues(d);
        declare_view(d);
    }
    *light = d->data.light;
}

struct ng_graph_ref lf_encoder_declare(struct ng_graph *graph, const struct lf_encoder_inputs *in)
{
    struct lf_encoder *self = in->self;
    struct declaration d = {.graph = graph, .data = {.in = *in}};
    bool always = self->params.always;
    self->traced = false;
    if (any_traced(self, in->screen_key))
        declare_trace(&d);
    if (always || self->screen_key != in->screen_key)
        declare_screen(&d);
    for (size_t i = 0; i < self->shining.count; i++)
        declare_first_half(&d, &self->shining.items[i]);
    if (always || self->powers_key != in->powers_key)
        declare_powers(&d);
    for (size_t i = 0; i < self->shining.count; i++)
        declare_second_half(&d, &self->shining.items[i]);
    return d.powers;
}

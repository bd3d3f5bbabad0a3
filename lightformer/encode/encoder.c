// Every part of an encoding has a key: a hash of all that the part is made from. A pass is declared where the
// key differs from that of the last result, and leaves its key behind when it has succeeded. What a part
// depends on is written in one place each: screen_key, light_key, points_key, view_key.
//
// The encodings themselves live on the host and are no resources of the graph. One small buffer for each
// light, and one for each other pass, stands for them: so the graph knows the order, and leaves out what
// nobody gathers.
#include "lightformer/encode/encoder.h"

#include "base/array.h"
#include "base/hash.h"
#include "base/log.h"
#include "base/system.h"
#include "lightformer/trace/tracer.h"
#include "render/frame.h"
#include "render/light_gpu.h"
#include "render/scene_gpu.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Floats a pixel that do not depend on the network, at most. Of the device: G-buffer, images of radiance,
// what is composed of them, and their copies, 74. Of the screen: planes 31, the grid 5, reflections 40,
// hemispheres 6. Clues of one light 28, radiance as the network writes it 9; some to spare.
#define FLOATS_A_PIXEL           198
// Of each light besides what the gather reads: what rays show of it, the grid.
#define FLOATS_A_PIXEL_AND_LIGHT 6

const struct ng_item_type lf_screen_item = {"screen", sizeof(struct lf_screen)};
const struct ng_item_type lf_embedding_item = {"embedding", sizeof(struct lf_embedding)};

// What is kept of a light from frame to frame, on or off. A key of 0: nothing of that part.
struct slot {
    ng_entity entity;
    const struct ng_light_type *type; // an entity may have lights of several types
    struct lf_light_clues *clues;
    struct lf_net_encoding *encoding;
    uint64_t rsm_key, points_key, view_key;
    struct lf_light_observation maps; // LF_RSM_MAPS: what the clues look into
    bool listed;                      // the snapshot of this frame has it
};

// A light that shines in this frame, and what it should be made from.
struct shining {
    struct slot *slot;
    const struct ng_light_maps *maps;
    uint64_t rsm_key, points_key, view_key;
    struct ng_graph_ref token;
};

struct lf_encoder {
    struct lf_encoder_params params;
    uint64_t reads;  // inputs of the network
    uint64_t gather; // view inputs that the gather reads
    struct lf_view_memory *view;
    const struct slot *viewed; // whose clues lie there; null: nobody's
    struct lf_tracer *tracer;
    struct lf_pixel_clues *pixels;
    NG_ARRAY(struct slot *) slots; // each from calloc: passes hold their addresses
    NG_ARRAY(struct shining) shining;
    NG_ARRAY(struct lf_light_clues *) clues; // of the lights that shine, for the powers
    bool traced;                             // the tracer is at this frame's snapshot
    uint64_t screen_key, powers_key;
    uint64_t most, refused; // bytes that were found to fit; what was refused last
    struct lf_encoder_counters counters;
};

// ---- Objects ---------------------------------------------------------------------------------------------

ng_result lf_encoder_create(const struct lf_encoder_params *params, struct lf_encoder **out)
{
    *out = NULL;
    NG_REQUIRE(params->net && params->executor && params->method,
               "an encoder needs a network, an executor and the name of a method");
    struct lf_encoder *self = calloc(1, sizeof *self);
    if (!self)
        return ng_out_of_memory("the encodings of lights");
    self->params = *params;
    self->reads = lf_encode_reads(params->net);
    for (int i = 0; i < LF_INPUT_COUNT; i++)
        self->gather |= (uint64_t)lf_net_gather_reads(params->executor, (enum lf_net_input)i) << i;
    ng_result result = lf_tracer_create(&self->tracer);
    if (result == NG_OK)
        result = lf_pixel_clues_create(&self->pixels);
    if (result == NG_OK)
        result = lf_view_memory_create(&self->view);
    if (result != NG_OK)
        lf_encoder_destroy(&self);
    *out = self;
    return result;
}

static void destroy_slot(struct slot *slot)
{
    lf_net_encoding_destroy(&slot->encoding);
    lf_light_clues_destroy(&slot->clues);
    free(slot);
}

void lf_encoder_destroy(struct lf_encoder **encoder)
{
    struct lf_encoder *self = *encoder;
    *encoder = NULL;
    if (!self)
        return;
    for (size_t i = 0; i < self->slots.count; i++)
        destroy_slot(self->slots.items[i]);
    ng_array_finish(&self->slots);
    ng_array_finish(&self->shining);
    ng_array_finish(&self->clues);
    lf_view_memory_destroy(&self->view);
    lf_pixel_clues_destroy(&self->pixels);
    lf_tracer_destroy(&self->tracer);
    free(self);
}

void lf_encoder_redo_always(struct lf_encoder *encoder, bool always)
{
    encoder->params.always = always;
}

struct lf_encoder_counters lf_encoder_counters_of(const struct lf_encoder *encoder)
{
    return encoder->counters;
}

static bool is_slot_of(const struct slot *slot, const struct ng_snapshot_light *light)
{
    return ng_entity_same(slot->entity, light->entity) && slot->type == light->source.type;
}

static ng_result add_slot(struct lf_encoder *self, const struct ng_snapshot_light *light, struct slot **out)
{
    struct slot *slot = calloc(1, sizeof *slot);
    if (!slot)
        return ng_out_of_memory("the encoding of a light");
    *slot = (struct slot){.entity = light->entity, .type = light->source.type};
    ng_result result = lf_light_clues_create(&slot->clues);
    if (result == NG_OK)
        result = lf_net_encoding_create(self->params.executor, &slot->encoding);
    if (result == NG_OK && !ng_array_push(&self->slots, slot))
        result = ng_out_of_memory("the encoding of a light");
    if (result != NG_OK)
        destroy_slot(slot);
    else
        *out = slot;
    return result;
}

static ng_result find_slot(struct lf_encoder *self, const struct ng_snapshot_light *light, struct slot **out)
{
    for (size_t i = 0; i < self->slots.count; i++)
        if (is_slot_of(self->slots.items[i], light)) {
            *out = self->slots.items[i];
            return NG_OK;
        }
    return add_slot(self, light, out);
}

// A light that is off may come back, one that is gone does not.
static void drop_gone(struct lf_encoder *self, const struct ng_snapshot *s)
{
    for (size_t i = self->slots.count; i-- > 0;) {
        bool listed = false;
        for (uint32_t k = 0; k < s->light_count && !listed; k++)
            listed = is_slot_of(self->slots.items[i], &s->lights[k]);
        if (listed)
            continue;
        destroy_slot(self->slots.items[i]);
        ng_array_swap_remove(&self->slots, i);
    }
}

// ---- Keys ------------------------------------------------------------------------------------------------

static bool reads(const struct lf_encoder *self, enum lf_net_input input)
{
    return self->reads >> input & 1;
}

static uint64_t nonzero(uint64_t hash)
{
    return hash ? hash : 1;
}

// Emission other than that of lights, which only mirror rays meet: versions of instances leave it out.
static uint64_t hash_emission(const struct ng_snapshot *s)
{
    uint64_t hash = 0;
    for (uint32_t i = 0; i < s->instance_count; i++) {
        const struct ng_snapshot_material *m = &s->materials[s->instances[i].material];
        if (s->instances[i].light != NG_NONE)
            continue;
        hash = ng_hash_bytes(hash, m->emission, sizeof m->emission);
        hash = ng_hash_combine(hash, m->emissive_image);
    }
    return hash;
}

// Camera, and everything that it or a mirror ray may meet.
static uint64_t screen_key(const struct lf_encoder *self, const struct ng_frame_info *frame)
{
    const struct ng_snapshot *s = frame->snapshot;
    const float numbers[] = {s->camera.fov_y,       s->camera.near_plane,  s->scene_radius,
                             s->scene_center[0],    s->scene_center[1],    s->scene_center[2],
                             s->camera.position[0], s->camera.position[1], s->camera.position[2]};
    uint64_t hash = ng_hash_combine(s->geometry_version, (uint64_t)frame->width << 32 | frame->height);
    hash = ng_hash_bytes(hash, numbers, sizeof numbers);
    hash = ng_hash_bytes(hash, s->camera.view, sizeof s->camera.view);
    if (reads(self, LF_INPUT_PIXEL_MIRROR_EMISSION))
        hash = ng_hash_combine(hash, hash_emission(s));
    return nonzero(hash);
}

static uint64_t hash_source(const struct ng_light_source *unit)
{
    const uint64_t words[] = {unit->type->component,
                              unit->image.width,
                              unit->image.height,
                              unit->image.format,
                              unit->image.repeat_u,
                              unit->image.repeat_v,
                              (uintptr_t)unit->image.pixels,
                              unit->triangle_count,
                              unit->mirrored,
                              unit->double_sided};
    uint64_t hash = ng_hash_bytes(0, words, sizeof words);
    hash = ng_hash_bytes(hash, unit->params, sizeof unit->params);
    hash = ng_hash_bytes(hash, unit->matrix, sizeof unit->matrix);
    hash = ng_hash_bytes(hash, unit->scene_center, sizeof unit->scene_center);
    hash = ng_hash_bytes(hash, &unit->scene_radius, sizeof unit->scene_radius);
    return ng_hash_bytes(hash, unit->emission, sizeof unit->emission);
}

// The emitter but for its power, and everything inside of its views.
static uint64_t rsm_key(const struct ng_frame_info *frame, uint32_t light)
{
    const struct ng_snapshot *s = frame->snapshot;
    struct ng_snapshot_light unit = s->lights[light];
    ng_light_unit(&s->lights[light].source, &unit.source);
    struct ng_snapshot alone = *s;
    alone.lights = &unit;
    alone.light_count = 1;
    struct ng_light_gpu views;
    ng_light_gpu_observe(&alone, 0, 1, INFINITY, &views);

    uint64_t hash = hash_source(&unit.source);
    for (uint32_t i = 0; i < s->instance_count; i++)
        if (s->instances[i].light == light)
            hash = ng_hash_combine(hash, s->instances[i].version);
    for (uint32_t v = 0; v < views.rsm_view_count; v++)
        hash =
            ng_hash_combine(hash, ng_scene_gpu_seen(frame->scene, views.rsm_views[v].view_projection, light));
    return nonzero(hash);
}

// Of networks that know the power itself (`paper`) more depends on it than the gather.
static uint64_t points_key(const struct lf_encoder *self, const struct ng_snapshot *s,
                           const struct shining *light)
{
    uint64_t hash = light->rsm_key;
    if (reads(self, LF_INPUT_LIGHT_POWER))
        hash = ng_hash_combine(hash, s->lights[light->maps->light].version);
    for (uint32_t i = 0; i < s->light_count && reads(self, LF_INPUT_FRAME_MEAN_POWER); i++)
        hash = ng_hash_bytes(hash, &s->lights[i].power, sizeof s->lights[i].power);
    return nonzero(hash);
}

static uint64_t powers_key(const struct lf_encoder *self, const struct ng_snapshot *s, uint64_t screen)
{
    uint64_t hash = screen;
    for (uint32_t i = 0; i < s->light_count; i++)
        hash = ng_hash_bytes(hash, &s->lights[i].power, sizeof s->lights[i].power);
    for (size_t i = 0; i < self->shining.count; i++)
        hash = ng_hash_combine(hash, self->shining.items[i].points_key);
    return nonzero(hash);
}

// ---- Passes ----------------------------------------------------------------------------------------------

struct pass_data {
    struct lf_encoder *self;
    const struct ng_frame_info *frame;
    const struct ng_gbuffer *gbuffer;
    struct shining light;
    uint64_t screen_key, powers_key;
};

static struct lf_encode_scene scene_of(const struct lf_encoder *self)
{
    return (struct lf_encode_scene){
        .tracer = self->tracer, .jobs = self->params.jobs, .reads = self->reads, .view = self->view};
}

static ng_result update_trace(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    d->self->counters.trace++;
    NG_TRY(lf_tracer_update(d->self->tracer, d->frame->snapshot));
    d->self->traced = true;
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
    struct lf_encoder *self = d->self;
    struct lf_encode_scene scene = scene_of(self);
    const struct lf_encode_pixels_params params = {
        .gbuffer = {.position = pixels_of(ctx, d->gbuffer->position),
                    .normal = pixels_of(ctx, d->gbuffer->normal),
                    .diffuse = pixels_of(ctx, d->gbuffer->diffuse),
                    .specular = pixels_of(ctx, d->gbuffer->specular)},
        .width = d->frame->width,
        .height = d->frame->height,
        .mirror_rays = self->params.mirror_rays,
    };
    self->counters.screen++;
    self->screen_key = 0;
    NG_TRY(need(self->traced));
    NG_TRY(lf_encode_pixels(&scene, &params, self->pixels));
    self->screen_key = d->screen_key;
    return NG_OK;
}

// Where the maps of this frame lie; their memory is another in each frame.
static const struct lf_light_observation *observe_maps(const struct ng_pass_context *ctx,
                                                       const struct shining *light)
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
    const struct lf_encoder_params *p = &d->self->params;
    struct slot *slot = d->light.slot;
    struct lf_encode_scene scene = scene_of(d->self);
    struct lf_encode_light_params params = {.vpl_count = p->vpl_count};
    if (p->rsm == LF_RSM_MAPS)
        params.maps = observe_maps(ctx, &d->light);
    d->self->counters.rsm++;
    slot->rsm_key = 0;
    NG_TRY(need(d->self->traced));
    NG_TRY(lf_encode_light(&scene, d->light.maps->light, &params, slot->clues));
    slot->rsm_key = d->light.rsm_key;
    return NG_OK;
}

static ng_result weigh_powers(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct lf_encoder *self = d->self;
    self->counters.powers++;
    self->powers_key = 0;
    NG_TRY(need(self->screen_key == d->screen_key));
    for (size_t i = 0; i < self->shining.count; i++)
        NG_TRY(need(self->shining.items[i].slot->rsm_key == self->shining.items[i].rsm_key));
    lf_encode_powers(d->frame->snapshot, self->pixels, self->clues.items, (uint32_t)self->clues.count);
    self->powers_key = d->powers_key;
    return NG_OK;
}

// The values of the frame and of the light side by side: the network takes them as one.
static struct lf_net_values join_values(const struct lf_encoder *self, const struct slot *slot)
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
    struct slot *slot = d->light.slot;
    const struct lf_net_values values = join_values(d->self, slot);
    const struct lf_net_light_inputs inputs = {.values = &values,
                                               .vpl_count = lf_light_clues_vpls(slot->clues),
                                               .texel_count = lf_light_clues_texels(slot->clues)};
    d->self->counters.points++;
    slot->points_key = 0;
    NG_TRY(need(slot->rsm_key == d->light.rsm_key && d->self->powers_key == d->powers_key));
    NG_TRY(lf_net_encode_light(d->self->params.executor, slot->encoding, &inputs));
    slot->points_key = d->light.points_key;
    return NG_OK;
}

static ng_result find_clues(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct slot *slot = d->light.slot;
    struct lf_encode_scene scene = scene_of(d->self);
    if (d->self->params.rsm == LF_RSM_MAPS)
        (void)observe_maps(ctx, &d->light);
    d->self->counters.clues++;
    d->self->viewed = NULL;
    NG_TRY(
        need(d->self->traced && slot->rsm_key == d->light.rsm_key && d->self->screen_key == d->screen_key));
    NG_TRY(lf_encode_view(&scene, d->self->pixels, slot->clues));
    d->self->viewed = slot;
    return NG_OK;
}

static ng_result encode_view(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct slot *slot = d->light.slot;
    const struct lf_net_picture frame = {.width = d->frame->width,
                                         .height = d->frame->height,
                                         .values = lf_pixel_clues_values(d->self->pixels)};
    d->self->counters.view++;
    slot->view_key = 0;
    NG_TRY(need(slot->points_key == d->light.points_key && d->self->viewed == slot));
    NG_TRY(lf_net_encode_view(d->self->params.executor, slot->encoding, &frame,
                              lf_light_clues_values(slot->clues)));
    NG_TRY(lf_light_clues_keep(slot->clues, d->self->gather));
    slot->view_key = d->light.view_key;
    return NG_OK;
}

// ---- Declaration -----------------------------------------------------------------------------------------

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
    if (d->data.self->params.rsm != LF_RSM_MAPS)
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
    const struct ng_gbuffer *g = d->data.gbuffer;
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
    struct lf_encoder *self = d->data.self;
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

// ---- A frame ---------------------------------------------------------------------------------------------

// Fills self->shining from the list of maps: it has all lights that shine, under names of their own.
static ng_result list_lights(struct lf_encoder *self, struct ng_composer *composer,
                             const struct ng_frame_info *frame, uint64_t screen)
{
    size_t count = ng_composer_count(composer, &ng_light_maps_item);
    drop_gone(self, frame->snapshot);
    if (!ng_array_resize(&self->shining, count) || !ng_array_resize(&self->clues, count))
        return ng_out_of_memory("the encodings of lights");
    for (size_t i = 0; i < count; i++) {
        struct shining *light = &self->shining.items[i];
        *light = (struct shining){.maps = ng_composer_get(composer, &ng_light_maps_item, i)};
        NG_TRY(find_slot(self, &frame->snapshot->lights[light->maps->light], &light->slot));
        light->rsm_key = rsm_key(frame, light->maps->light);
        light->points_key = points_key(self, frame->snapshot, light);
        light->view_key = ng_hash_combine(light->points_key, screen);
        lf_light_clues_follow(light->slot->clues, frame->snapshot, light->maps->light);
        self->clues.items[i] = light->slot->clues;
    }
    return NG_OK;
}

// Bytes for pictures of a size, about.
static uint64_t bytes_needed(const struct lf_encoder *self, const struct ng_frame_info *frame,
                             uint32_t lights)
{
    uint64_t pixels = (uint64_t)frame->width * frame->height, kept = 0;
    for (int i = 0; i < LF_INPUT_COUNT; i++)
        if (lf_net_inputs[i].domain == LF_DOMAIN_VIEW && self->gather >> i & 1)
            kept += lf_net_inputs[i].channels;
    return pixels * (FLOATS_A_PIXEL + lights * (FLOATS_A_PIXEL_AND_LIGHT + kept)) * sizeof(float) +
           lf_net_executor_bytes(self->params.executor, frame->width, frame->height, lights);
}

// Refuses, once, what would not fit; the next frame that does is drawn again. What was drawn before fits.
static ng_result check_memory(struct lf_encoder *self, const struct ng_frame_info *frame, uint32_t lights)
{
    const double gib = 1 << 30;
    uint64_t needed = bytes_needed(self, frame, lights), what = ng_hash_combine(needed, lights);
    if (needed <= self->most) {
        self->refused = 0;
        return NG_OK;
    }
    uint64_t limit = self->params.memory_limit;
    if (!limit)
        limit = ng_system_available_memory() + self->most; // what there is becomes larger, it is not doubled
    if (needed <= limit) {
        self->most = needed;
        self->refused = 0;
        return NG_OK;
    }
    if (self->refused != what)
        ng_log_error("%s: %ux%u pixels and %u lights need %.1f GiB of memory, and there are %.1f; make the "
                     "picture smaller",
                     self->params.method, frame->width, frame->height, lights, (double)needed / gib,
                     (double)limit / gib);
    self->refused = what;
    return NG_ERROR_MEMORY;
}

// Whether rays are needed.
static bool any_traced(const struct lf_encoder *self, uint64_t screen)
{
    bool stale = self->params.always || self->screen_key != screen;
    for (size_t i = 0; i < self->shining.count && !stale; i++) {
        const struct shining *light = &self->shining.items[i];
        stale = light->slot->rsm_key != light->rsm_key || light->slot->view_key != light->view_key;
    }
    return stale;
}

// What the powers do not need; returns with the light's token.
static void declare_first_half(struct declaration *d, struct shining *light)
{
    bool always = d->data.self->params.always;
    d->data.light = *light;
    if (always || light->slot->rsm_key != light->rsm_key)
        declare_rsm(d);
    *light = d->data.light;
}

static void declare_second_half(struct declaration *d, struct shining *light)
{
    const struct slot *slot = light->slot;
    bool always = d->data.self->params.always;
    d->data.light = *light;
    if (always || slot->points_key != light->points_key)
        declare_points(d);
    if (always || slot->view_key != light->view_key) {
        declare_clues(d);
        declare_view(d);
    }
    *light = d->data.light;
}

static void declare_passes(struct declaration *d)
{
    struct lf_encoder *self = d->data.self;
    bool always = self->params.always;
    self->traced = false;
    if (any_traced(self, d->data.screen_key))
        declare_trace(d);
    if (always || self->screen_key != d->data.screen_key)
        declare_screen(d);
    for (size_t i = 0; i < self->shining.count; i++)
        declare_first_half(d, &self->shining.items[i]);
    if (always || self->powers_key != d->data.powers_key)
        declare_powers(d);
    for (size_t i = 0; i < self->shining.count; i++)
        declare_second_half(d, &self->shining.items[i]);
}

static ng_result publish(struct ng_composer *composer, const struct declaration *d)
{
    const struct lf_encoder *self = d->data.self;
    const struct lf_screen screen = {.clues = self->pixels,
                                     .width = d->data.frame->width,
                                     .height = d->data.frame->height,
                                     .version = d->data.powers_key,
                                     .made = &self->powers_key,
                                     .ready = d->powers};
    NG_TRY(ng_composer_publish(composer, &lf_screen_item, &screen));
    for (size_t i = 0; i < self->shining.count; i++) {
        const struct shining *light = &self->shining.items[i];
        const struct lf_embedding embedding = {.light = light->maps->light,
                                               .encoding = light->slot->encoding,
                                               .clues = light->slot->clues,
                                               .version = light->view_key,
                                               .made = &light->slot->view_key,
                                               .ready = light->token};
        NG_TRY(ng_composer_publish(composer, &lf_embedding_item, &embedding));
    }
    return NG_OK;
}

static ng_result produce(struct ng_composer *composer, void *user)
{
    struct lf_encoder *self = user;
    const struct ng_frame_info *frame = ng_composer_get(composer, &ng_frame_item, 0);
    if (!ng_frame_wants(frame, self->params.method))
        return NG_OK;
    uint64_t screen = screen_key(self, frame);
    NG_TRY(check_memory(self, frame, (uint32_t)ng_composer_count(composer, &ng_light_maps_item)));
    NG_TRY(list_lights(self, composer, frame, screen));
    struct declaration d = {.graph = ng_composer_graph(composer),
                            .data = {.self = self,
                                     .frame = frame,
                                     .gbuffer = ng_composer_get(composer, &ng_gbuffer_item, 0),
                                     .screen_key = screen,
                                     .powers_key = powers_key(self, frame->snapshot, screen)}};
    declare_passes(&d);
    return publish(composer, &d);
}

struct ng_provider lf_encoder_provider(struct lf_encoder *encoder)
{
    return (struct ng_provider){.name = "encode", .produce = produce, .user = encoder};
}

// The provider: what is kept of each light from frame to frame, and what a frame publishes.
#include "lightformer/encode/encoder_internal.h"

#include "base/hash.h"
#include "base/log.h"
#include "base/system.h"
#include "lightformer/trace/tracer.h"

#include <stdlib.h>

// Floats a pixel besides inputs and images of the network. Of the device: G-buffer, images of radiance, what
// is composed of them, and their copies, 74; radiance as the network writes it, 9.
#define FLOATS_A_PIXEL 83

const struct ng_item_type lf_screen_item = {"screen", sizeof(struct lf_screen)};
const struct ng_item_type lf_embedding_item = {"embedding", sizeof(struct lf_embedding)};

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
    if (result == NG_OK) {
        lf_tracer_limit_memory(self->tracer, params->memory_limit);
        result = lf_pixel_clues_create(&self->pixels);
    }
    if (result == NG_OK)
        result = lf_view_memory_create(&self->view);
    if (result != NG_OK)
        lf_encoder_destroy(&self);
    *out = self;
    return result;
}

static void destroy_slot(struct lf_slot *slot)
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

static bool is_slot_of(const struct lf_slot *slot, const struct ng_snapshot_light *light)
{
    return ng_entity_same(slot->entity, light->entity) && slot->type == light->source.type;
}

static ng_result add_slot(struct lf_encoder *self, const struct ng_snapshot_light *light,
                          struct lf_slot **out)
{
    struct lf_slot *slot = calloc(1, sizeof *slot);
    if (!slot)
        return ng_out_of_memory("the encoding of a light");
    *slot = (struct lf_slot){.entity = light->entity, .type = light->source.type};
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

static ng_result find_slot(struct lf_encoder *self, const struct ng_snapshot_light *light,
                           struct lf_slot **out)
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
        struct lf_shining *light = &self->shining.items[i];
        *light = (struct lf_shining){.maps = ng_composer_get(composer, &ng_light_maps_item, i)};
        NG_TRY(find_slot(self, &frame->snapshot->lights[light->maps->light], &light->slot));
        light->rsm_key = lf_encoder_rsm_key(frame, light->maps->light);
        light->points_key = lf_encoder_points_key(self, frame->snapshot, light);
        light->view_key = ng_hash_combine(light->points_key, screen);
        lf_light_clues_follow(light->slot->clues, frame->snapshot, light->maps->light);
        self->clues.items[i] = light->slot->clues;
    }
    return NG_OK;
}

// Bytes for pictures of a size, at most. Layers and files that are made of them come on top.
static uint64_t bytes_needed(const struct lf_encoder *self, const struct ng_frame_info *frame,
                             uint32_t lights)
{
    const struct lf_encode_bytes inputs =
        lf_encode_bytes(frame->width, frame->height, self->params.mirror_rays);
    uint64_t pixels = (uint64_t)frame->width * frame->height, kept = 0;
    for (int i = 0; i < LF_INPUT_COUNT; i++)
        if (lf_net_inputs[i].domain == LF_DOMAIN_VIEW && self->gather >> i & 1)
            kept += lf_net_inputs[i].channels;
    return pixels * (FLOATS_A_PIXEL + lights * kept) * sizeof(float) + inputs.pixels + inputs.view +
           lights * inputs.light +
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

static ng_result publish(struct ng_composer *composer, const struct lf_encoder_inputs *in,
                         struct ng_graph_ref powers)
{
    const struct lf_encoder *self = in->self;
    const struct lf_screen screen = {.clues = self->pixels,
                                     .width = in->frame->width,
                                     .height = in->frame->height,
                                     .version = in->powers_key,
                                     .made = &self->powers_key,
                                     .ready = powers};
    NG_TRY(ng_composer_publish(composer, &lf_screen_item, &screen));
    for (size_t i = 0; i < self->shining.count; i++) {
        const struct lf_shining *light = &self->shining.items[i];
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
    uint64_t screen = lf_encoder_screen_key(self, frame);
    NG_TRY(check_memory(self, frame, (uint32_t)ng_composer_count(composer, &ng_light_maps_item)));
    NG_TRY(list_lights(self, composer, frame, screen));
    const struct lf_encoder_inputs in = {.self = self,
                                         .frame = frame,
                                         .gbuffer = ng_composer_get(composer, &ng_gbuffer_item, 0),
                                         .screen_key = screen,
                                         .powers_key = lf_encoder_powers_key(self, frame->snapshot, screen)};
    return publish(composer, &in, lf_encoder_declare(ng_composer_graph(composer), &in));
}

struct ng_provider lf_encoder_provider(struct lf_encoder *encoder)
{
    return (struct ng_provider){.name = "encode", .produce = produce, .user = encoder};
}

// The provider: what is kept of each light from frame to frame, and what a frame publishes.
#include "lightformer/encode/encoder_internal.h"

#include "base/hash.h"
#include "base/log.h"
#include "base/system.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Floats a pixel besides inputs and images of the network. Of the device: G-buffer, images of radiance, what
// is composed of them, and their copies, 74; radiance as the network writes it, 9. Where all is made and
// shown on the host, most of the G-buffer lies where the clues of lights come later; what is left are
// emission, two images of radiance, their sum, what a display shows, and what a light meter has of it on the
// device, 29.
#define RADIANCE_FLOATS 9
#define DEVICE_FLOATS   74
#define HOST_FLOATS     29

#define PROVIDER "encode"

const struct ng_item_type lf_encoded_pixels_item = {"pixel clues", sizeof(struct lf_encoded_pixels)};
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
    self->reads = lf_clues_reads(params->net);
    for (int i = 0; i < LF_INPUT_COUNT; i++)
        self->gather |= (uint64_t)lf_net_gather_reads(params->executor, (enum lf_net_input)i) << i;
    ng_result result = lf_pixel_clues_create(&self->pixels);
    if (result != NG_OK)
        lf_encoder_destroy(&self);
    *out = self;
    return result;
}

static void destroy_kept(struct lf_kept_light *kept)
{
    lf_net_encoding_destroy(&kept->encoding);
    lf_light_clues_destroy(&kept->clues);
    free(kept);
}

void lf_encoder_destroy(struct lf_encoder **encoder)
{
    struct lf_encoder *self = *encoder;
    *encoder = NULL;
    if (!self)
        return;
    lf_encoder_leave(self);
    for (size_t i = 0; i < self->kept.count; i++)
        destroy_kept(self->kept.items[i]);
    ng_array_finish(&self->kept);
    ng_array_finish(&self->active);
    ng_array_finish(&self->clues);
    lf_pixel_clues_destroy(&self->pixels);
    free(self);
}

struct lf_encoder_counters lf_encoder_counters_of(const struct lf_encoder *encoder)
{
    return encoder->counters;
}

static bool is_kept(const struct lf_kept_light *kept, const struct ng_snapshot_light *light)
{
    return ng_entity_same(kept->entity, light->entity) && kept->type == light->source.type;
}

static bool is_taken(const struct lf_encoder *self, const char *name)
{
    for (size_t i = 0; i < self->kept.count; i++)
        if (strcmp(self->kept.items[i]->name, name) == 0)
            return true;
    return false;
}

// `name`: the light's in this frame. One that had it before may still have buffers of that name.
static void name_buffers(const struct lf_encoder *self, const char *name, struct lf_kept_light *kept)
{
    snprintf(kept->name, sizeof kept->name, "%s", name);
    if (is_taken(self, name))
        snprintf(kept->name, sizeof kept->name, "%s@%" PRIx64 ".%s", name, kept->entity.id, kept->type->name);
}

static ng_result add_kept(struct lf_encoder *self, const struct ng_snapshot_light *light, const char *name,
                          struct lf_kept_light **out)
{
    struct lf_kept_light *kept = calloc(1, sizeof *kept);
    if (!kept)
        return ng_out_of_memory("the encoding of a light");
    *kept = (struct lf_kept_light){.entity = light->entity, .type = light->source.type};
    name_buffers(self, name, kept);
    ng_result result = lf_light_clues_create(&kept->clues);
    if (result == NG_OK)
        result = lf_net_encoding_create(self->params.executor, &kept->encoding);
    if (result == NG_OK && !ng_array_push(&self->kept, kept))
        result = ng_out_of_memory("the encoding of a light");
    if (result != NG_OK)
        destroy_kept(kept);
    else
        *out = kept;
    return result;
}

static ng_result find_kept(struct lf_encoder *self, const struct ng_snapshot_light *light, const char *name,
                           struct lf_kept_light **out)
{
    for (size_t i = 0; i < self->kept.count; i++)
        if (is_kept(self->kept.items[i], light)) {
            *out = self->kept.items[i];
            return NG_OK;
        }
    return add_kept(self, light, name, out);
}

// A light that is off may come back, one that is gone does not.
static void drop_gone(struct lf_encoder *self, const struct ng_snapshot *s)
{
    for (size_t i = self->kept.count; i-- > 0;) {
        bool listed = false;
        for (uint32_t k = 0; k < s->light_count && !listed; k++)
            listed = is_kept(self->kept.items[i], &s->lights[k]);
        if (listed)
            continue;
        destroy_kept(self->kept.items[i]);
        ng_array_swap_remove(&self->kept, i);
    }
}

static void mark_all_dark(struct lf_encoder *self)
{
    for (size_t i = 0; i < self->kept.count; i++)
        self->kept.items[i]->active = false;
}

// ---- A frame ---------------------------------------------------------------------------------------------

// Fills self->active from the list of maps: it has all lights that shine, under names of their own.
static ng_result list_lights(struct lf_encoder *self, struct ng_composer *composer,
                             const struct ng_frame_info *frame)
{
    size_t count = ng_composer_count(composer, &ng_light_maps_item);
    drop_gone(self, frame->snapshot);
    mark_all_dark(self);
    if (!ng_array_resize(&self->active, count) || !ng_array_resize(&self->clues, count))
        return ng_out_of_memory("the encodings of lights");
    for (size_t i = 0; i < count; i++) {
        struct lf_active_light *light = &self->active.items[i];
        *light = (struct lf_active_light){.maps = ng_composer_get(composer, &ng_light_maps_item, i)};
        NG_TRY(
            find_kept(self, &frame->snapshot->lights[light->maps->light], light->maps->name, &light->kept));
        lf_light_clues_follow(light->kept->clues, frame->snapshot, light->maps->light);
        self->clues.items[i] = light->kept->clues;
        light->kept->active = true;
    }
    return NG_OK;
}

// Bytes for pictures of a size, at most. Layers and files that are made of them come on top.
static uint64_t bytes_needed(const struct lf_encoder *self, const struct ng_frame_info *frame, bool on_host,
                             uint32_t lights)
{
    const uint64_t floats = RADIANCE_FLOATS + (on_host ? HOST_FLOATS : DEVICE_FLOATS);
    uint32_t width = frame->width, height = frame->height, rays = self->params.reflection_rays;
    const struct lf_clues_bytes clues = lf_clues_bytes(width, height, rays);
    const struct lf_net_bytes net = lf_net_picture_bytes(self->params.executor, width, height);
    uint64_t bytes = width * height * floats * sizeof(float) + lf_clues_view_bytes(width, height) + net.work;
    for (int i = 0; i < LF_PIXEL_PARTS; i++)
        bytes += clues.pixels[i];
    return bytes + lights * (lf_clues_hits_bytes(width, height, rays) +
                             lf_clues_kept_bytes(width, height, self->gather) + net.encoding + net.gather);
}

// Refuses, once, what would not fit; the next frame that does is drawn again. What was drawn before fits.
static ng_result check_memory(struct lf_encoder *self, const struct ng_frame_info *frame, bool on_host,
                              uint32_t lights)
{
    const double gib = 1 << 30;
    uint64_t needed = bytes_needed(self, frame, on_host, lights), what = ng_hash_combine(needed, lights);
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

static ng_result publish(struct ng_composer *composer, const struct lf_encoder_inputs *in)
{
    const struct lf_encoder *self = in->self;
    const struct lf_encoded_pixels pixels = {.clues = self->pixels,
                                             .width = in->frame->width,
                                             .height = in->frame->height,
                                             .buffers = in->pixels,
                                             .work = in->work,
                                             .powers_key = lf_encoder_powers_key(in->frame->snapshot)};
    NG_TRY(ng_composer_publish(composer, &lf_encoded_pixels_item, &pixels));
    for (size_t i = 0; i < self->active.count; i++) {
        const struct lf_active_light *light = &self->active.items[i];
        const struct lf_embedding embedding = {.light = light->maps->light,
                                               .encoding = light->kept->encoding,
                                               .clues = light->kept->clues,
                                               .buffers = light->buffers};
        NG_TRY(ng_composer_publish(composer, &lf_embedding_item, &embedding));
    }
    return NG_OK;
}

// Frames of another method leave what there is.
static void keep(struct lf_encoder *self, struct ng_graph *graph, const struct ng_frame_info *frame)
{
    drop_gone(self, frame->snapshot);
    self->active.count = 0;
    mark_all_dark(self);
    struct ng_frame_info last = *frame;
    last.width = self->width;
    last.height = self->height;
    if (self->width)
        lf_encoder_keep(graph, &(struct lf_encoder_inputs){.self = self, .frame = &last});
}

static ng_result produce(struct ng_composer *composer, void *user)
{
    struct lf_encoder *self = user;
    const struct ng_frame_info *frame = ng_composer_get(composer, &ng_frame_item, 0);
    if (!ng_frame_wants(frame, self->params.method)) {
        keep(self, ng_composer_graph(composer), frame);
        return NG_OK;
    }
    self->width = frame->width;
    self->height = frame->height;
    const struct ng_gbuffer *gbuffer = ng_composer_get(composer, &ng_gbuffer_behind_lamps_item, 0);
    NG_TRY(check_memory(self, frame, gbuffer->on_host,
                        (uint32_t)ng_composer_count(composer, &ng_light_maps_item)));
    NG_TRY(list_lights(self, composer, frame));
    lf_clues_set_powers(frame->snapshot, self->pixels, self->clues.items, (uint32_t)self->clues.count);
    struct lf_encoder_inputs in = {.self = self,
                                   .frame = frame,
                                   .gbuffer = gbuffer,
                                   .rays = ng_composer_get(composer, &lf_ray_scene_item, 0)};
    if (!in.rays)
        return NG_ERROR_MEMORY; // logged there
    lf_encoder_declare(ng_composer_graph(composer), &in);
    return publish(composer, &in);
}

ng_result lf_encoder_join(struct lf_encoder *self, struct ng_composer *composer)
{
    NG_REQUIRE(!self->composer, "the encoder is in a composer already");
    const struct ng_provider provider = {.name = PROVIDER, .produce = produce, .user = self};
    NG_TRY(lf_ray_scene_register(composer, &provider, self->params.memory_limit));
    self->composer = composer;
    return NG_OK;
}

void lf_encoder_leave(struct lf_encoder *self)
{
    if (self->composer)
        lf_ray_scene_unregister(self->composer, PROVIDER);
    self->composer = NULL;
}

// The network writes planes, which last; the renderer takes images of four channels, made of those planes
// that a frame asks for, on all threads. Where is no surface a network has learned nothing, and whatever it
// says is no light; nor is what is no finite number. Lamps reflect nothing (render/snapshot.h), and the
// network knows what is behind them.
#include "lightformer/gather/gather.h"

#include "base/array.h"
#include "base/jobs.h"
#include "base/log.h"
#include "graph/key.h"
#include "lightformer/encode/encoder.h"
#include "lightformer/net/net.h"
#include "render/frame.h"

#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { UNSHADOWED, DIRECT, INDIRECT, PART_COUNT };

static const char *const part_names[PART_COUNT] = {"unshadowed", "direct", "indirect"};

struct lf_gather {
    struct lf_gather_params params;
    NG_ARRAY(struct lf_net_gathered) lights;
    NG_ARRAY(struct lf_embedding) embeddings; // what the lights are of
    uint64_t runs;
    bool warned; // of values that are not finite
};

ng_result lf_gather_create(const struct lf_gather_params *params, struct lf_gather **out)
{
    *out = NULL;
    NG_REQUIRE(params->executor && params->method, "a gather needs an executor and the name of a method");
    struct lf_gather *self = calloc(1, sizeof *self);
    if (!self)
        return ng_out_of_memory("the gather of lights");
    self->params = *params;
    *out = self;
    return NG_OK;
}

void lf_gather_destroy(struct lf_gather **gather)
{
    struct lf_gather *self = *gather;
    *gather = NULL;
    if (!self)
        return;
    ng_array_finish(&self->lights);
    ng_array_finish(&self->embeddings);
    free(self);
}

uint64_t lf_gather_runs(const struct lf_gather *gather)
{
    return gather->runs;
}

// ---- The pass --------------------------------------------------------------------------------------------

struct pass_data {
    struct lf_gather *self;
    const struct lf_encoded_pixels *pixels;
    struct ng_graph_ref planes;  // [PART_COUNT][3][height][width], as the network writes them
    struct lf_net_work by_light; // images of the gather for each light
    // Of the pass that makes an image:
    int part;
    struct ng_graph_ref image;
    struct ng_graph_ref lamps; // where w is 1 a lamp hides the rest; zero: there is none
};

struct interleave {
    const float *planes, *mask;
    const float *lamps; // [size][4], or null
    float *texels;
    size_t size;        // of a plane
    atomic_bool *wrong; // set where a value is not finite
};

static void interleave(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct interleave *job = user;
    bool wrong = false;
    for (size_t i = begin; i < end; i++) {
        bool shown = job->mask[i] > 0 && !(job->lamps && job->lamps[i * 4 + 3] > 0);
        for (size_t c = 0; c < 3; c++) {
            float value = shown ? job->planes[c * job->size + i] : 0;
            wrong |= !isfinite(value);
            job->texels[i * 4 + c] = isfinite(value) ? value : 0;
        }
        job->texels[i * 4 + 3] = 1;
    }
    if (wrong)
        atomic_store(job->wrong, true);
}

static void warn(struct lf_gather *self)
{
    if (!self->warned)
        ng_log_warn(
            "%s: the network gave values that are not finite, which are drawn black; train it anew or "
            "choose other --weights",
            self->params.method);
    self->warned = true;
}

static void lend(const struct ng_pass_context *ctx, const struct pass_data *d)
{
    struct lf_gather *self = d->self;
    struct ng_graph_memory work = ng_pass_memory(ctx, d->pixels->work.memory);
    lf_lend_pixels(ctx, &d->pixels->buffers, d->pixels->clues);
    lf_lend_arriving(ctx, &d->pixels->buffers, d->pixels->clues);
    lf_net_executor_lend(self->params.executor, work.data, work.size, d->pixels->work.fresh);
    for (size_t i = 0; i < self->embeddings.count; i++) {
        const struct lf_embedding *e = &self->embeddings.items[i];
        lf_lend_embedding(ctx, &e->buffers, false, e->clues, e->encoding);
    }
    if (!d->by_light.memory.id)
        return;
    struct ng_graph_memory by_light = ng_pass_memory(ctx, d->by_light.memory);
    lf_net_executor_lend_gather(self->params.executor, by_light.data, by_light.size, d->by_light.fresh);
}

static ng_result run(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct lf_gather *self = d->self;
    const struct lf_net_picture frame = {.width = d->pixels->width,
                                         .height = d->pixels->height,
                                         .values = lf_pixel_clues_values(d->pixels->clues)};
    size_t pixels = (size_t)frame.width * frame.height;
    float *planes = ng_pass_memory(ctx, d->planes).data, *part[PART_COUNT];
    for (size_t i = 0; i < PART_COUNT; i++)
        part[i] = planes + i * 3 * pixels;
    const struct lf_net_radiance out = {part[UNSHADOWED], part[DIRECT], part[INDIRECT]};
    self->runs++;
    lend(ctx, d);
    return lf_net_gather(self->params.executor, &frame, self->lights.items, (uint32_t)self->lights.count,
                         &out);
}

static ng_result make_image(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    uint32_t pixels = d->pixels->width * d->pixels->height;
    const float *planes = ng_pass_memory(ctx, d->planes).data;
    atomic_bool wrong = false;
    lf_lend_pixels(ctx, &d->pixels->buffers, d->pixels->clues);
    struct interleave job = {.planes = planes + (size_t)d->part * 3 * pixels,
                             .mask = lf_pixel_clues_values(d->pixels->clues)->of[LF_INPUT_PIXEL_MASK],
                             .lamps = d->lamps.id ? ng_pass_memory(ctx, d->lamps).data : NULL,
                             .texels = ng_pass_memory(ctx, d->image).data,
                             .size = pixels,
                             .wrong = &wrong};
    ng_jobs_for(d->self->params.jobs, pixels, 1u << 14, interleave, &job);
    if (wrong)
        warn(d->self);
    return NG_OK;
}

// ---- A frame ---------------------------------------------------------------------------------------------

static void declare_buffers(const struct lf_gather *self, struct ng_graph *g, struct pass_data *data)
{
    uint32_t width = data->pixels->width, height = data->pixels->height;
    char name[64];
    snprintf(name, sizeof name, "%s/planes", self->params.method);
    uint64_t floats = (uint64_t)PART_COUNT * 3 * width * height;
    data->planes = ng_graph_persistent_buffer(
        g, name, &(struct ng_graph_buffer_params){.size = floats * sizeof(float)}, NULL);
    uint64_t bytes = self->lights.count * lf_net_picture_bytes(self->params.executor, width, height).gather;
    bool valid = false;
    if (bytes)
        data->by_light.memory = ng_graph_persistent_buffer(
            g, "network/gather", &(struct ng_graph_buffer_params){.size = bytes, .scratch = true}, &valid);
    data->by_light.fresh = !valid;
}

static ng_result list_lights(struct lf_gather *self, struct ng_composer *composer)
{
    size_t count = ng_composer_count(composer, &lf_embedding_item);
    if (!ng_array_resize(&self->lights, count) || !ng_array_resize(&self->embeddings, count))
        return ng_out_of_memory("the gather of lights");
    for (size_t i = 0; i < count; i++) {
        const struct lf_embedding *e = ng_composer_get(composer, &lf_embedding_item, i);
        self->embeddings.items[i] = *e;
        self->lights.items[i] =
            (struct lf_net_gathered){.encoding = e->encoding, .values = lf_light_clues_kept(e->clues)};
    }
    return NG_OK;
}

static void declare_pass(struct lf_gather *self, struct ng_composer *composer, struct pass_data *data)
{
    struct ng_graph *g = ng_composer_graph(composer);
    declare_buffers(self, g, data);
    struct ng_pass *pass = ng_graph_add_pass(g, &(struct ng_pass_params){.name = "gather",
                                                                         .kind = NG_PASS_CPU,
                                                                         .run = run,
                                                                         .data = data,
                                                                         .data_size = sizeof *data,
                                                                         .flags = NG_PASS_ON_DEMAND,
                                                                         .key = data->pixels->powers_key});
    lf_read_pixels(pass, &data->pixels->buffers);
    ng_pass_read(pass, data->pixels->buffers.parts[LF_PIXEL_ARRIVING], NG_USE_HOST_READ);
    for (size_t i = 0; i < self->embeddings.count; i++) {
        const struct lf_light_buffers *b = &self->embeddings.items[i].buffers;
        const struct ng_graph_ref refs[] = {b->light, b->embedding, b->kept};
        for (size_t k = 0; k < NG_COUNT(refs); k++)
            if (refs[k].id)
                ng_pass_read(pass, refs[k], NG_USE_HOST_READ);
    }
    ng_pass_write(pass, data->pixels->work.memory, NG_USE_HOST_WRITE);
    data->planes = ng_pass_write(pass, data->planes, NG_USE_HOST_WRITE);
    if (data->by_light.memory.id)
        ng_pass_write(pass, data->by_light.memory, NG_USE_HOST_WRITE);
}

static struct ng_graph_ref declare_image(struct ng_composer *composer, const struct pass_data *gathered,
                                         int part)
{
    struct ng_graph *g = ng_composer_graph(composer);
    const struct ng_gbuffer *gbuffer = ng_composer_get(composer, &ng_gbuffer_item, 0);
    struct pass_data data = *gathered;
    char name[64];
    snprintf(name, sizeof name, "%s/%s", data.self->params.method, part_names[part]);
    data.part = part;
    data.image = ng_graph_add_image(g, name,
                                    &(struct ng_graph_image_params){.format = VK_FORMAT_R32G32B32A32_SFLOAT,
                                                                    .width = data.pixels->width,
                                                                    .height = data.pixels->height});
    if (gbuffer && gbuffer->lamps)
        data.lamps = gbuffer->emission;
    struct ng_pass *pass = ng_graph_add_pass(g, &(struct ng_pass_params){.name = name,
                                                                         .kind = NG_PASS_CPU,
                                                                         .run = make_image,
                                                                         .data = &data,
                                                                         .data_size = sizeof data,
                                                                         .flags = NG_PASS_ON_DEMAND,
                                                                         .key = NG_KEY});
    ng_pass_read(pass, data.planes, NG_USE_HOST_READ);
    lf_read_pixels(pass, &data.pixels->buffers);
    if (data.lamps.id)
        ng_pass_read(pass, data.lamps, NG_USE_HOST_READ);
    return ng_pass_write(pass, data.image, NG_USE_HOST_WRITE);
}

static ng_result consume(struct ng_composer *composer, void *user)
{
    struct lf_gather *self = user;
    struct pass_data data = {.self = self, .pixels = ng_composer_get(composer, &lf_encoded_pixels_item, 0)};
    if (!data.pixels)
        return NG_OK;
    NG_TRY(list_lights(self, composer));
    declare_pass(self, composer, &data);
    struct ng_radiance radiance = {.method = self->params.method,
                                   .unshadowed = declare_image(composer, &data, UNSHADOWED),
                                   .direct = declare_image(composer, &data, DIRECT),
                                   .indirect = declare_image(composer, &data, INDIRECT),
                                   .on_host = true};
    return ng_composer_publish(composer, &ng_radiance_item, &radiance);
}

struct ng_provider lf_gather_provider(struct lf_gather *gather)
{
    return (struct ng_provider){.name = "gather", .consume = consume, .user = gather};
}

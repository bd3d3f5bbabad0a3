// The network writes planes, the renderer takes images of four channels: one copy in between, on all threads.
// Where is no surface a network has learned nothing, and whatever it says is no light; nor is what is no
// finite number.
#include "lightformer/gather/gather.h"

#include "base/array.h"
#include "base/hash.h"
#include "base/jobs.h"
#include "base/log.h"
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
    NG_ARRAY(float) planes[PART_COUNT];       // [3][height][width]
    uint64_t gathered;                        // hash of what the images are of; 0: of nothing
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
    for (int i = 0; i < PART_COUNT; i++)
        ng_array_finish(&self->planes[i]);
    free(self);
}

void lf_gather_redo_always(struct lf_gather *gather, bool always)
{
    gather->params.always = always;
}

uint64_t lf_gather_runs(const struct lf_gather *gather)
{
    return gather->runs;
}

// ---- The pass --------------------------------------------------------------------------------------------

struct pass_data {
    struct lf_gather *self;
    const struct lf_screen *screen;
    struct ng_graph_ref images[PART_COUNT];
    uint64_t key;
};

// Whether the passes before this one made what they were to make; if not, they said so.
static bool is_encoded(const struct lf_gather *self, const struct lf_screen *screen)
{
    bool made = *screen->made == screen->version;
    for (size_t i = 0; i < self->embeddings.count; i++)
        made &= *self->embeddings.items[i].made == self->embeddings.items[i].version;
    return made;
}

static ng_result reserve_planes(struct lf_gather *self, const struct lf_screen *screen)
{
    for (int i = 0; i < PART_COUNT; i++)
        if (!ng_array_resize(&self->planes[i], (size_t)screen->width * screen->height * 3))
            return ng_out_of_memory("the gather of lights");
    return NG_OK;
}

struct interleave {
    const float *planes, *mask;
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
        for (size_t c = 0; c < 3; c++) {
            float value = job->mask[i] > 0 ? job->planes[c * job->size + i] : 0;
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

static ng_result run(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct lf_gather *self = d->self;
    const struct lf_net_picture frame = {.width = d->screen->width,
                                         .height = d->screen->height,
                                         .values = lf_pixel_clues_values(d->screen->clues)};
    self->runs++;
    self->gathered = 0;
    if (!is_encoded(self, d->screen))
        return NG_ERROR_NOT_FOUND;
    NG_TRY(reserve_planes(self, d->screen));
    const struct lf_net_radiance out = {self->planes[UNSHADOWED].items, self->planes[DIRECT].items,
                                        self->planes[INDIRECT].items};
    NG_TRY(
        lf_net_gather(self->params.executor, &frame, self->lights.items, (uint32_t)self->lights.count, &out));
    uint32_t pixels = frame.width * frame.height;
    atomic_bool wrong = false;
    for (int i = 0; i < PART_COUNT; i++) {
        struct interleave job = {.planes = self->planes[i].items,
                                 .mask = frame.values->of[LF_INPUT_PIXEL_MASK],
                                 .texels = ng_pass_memory(ctx, d->images[i]).data,
                                 .size = pixels,
                                 .wrong = &wrong};
        ng_jobs_for(self->params.jobs, pixels, 1u << 14, interleave, &job);
    }
    if (wrong)
        warn(self);
    self->gathered = d->key;
    return NG_OK;
}

// ---- A frame ---------------------------------------------------------------------------------------------

static bool declare_images(struct lf_gather *self, struct ng_graph *g, struct pass_data *data)
{
    bool all_valid = true;
    for (int i = 0; i < PART_COUNT; i++) {
        char name[64];
        bool valid;
        snprintf(name, sizeof name, "%s/%s", self->params.method, part_names[i]);
        data->images[i] =
            ng_graph_persistent_image(g, name,
                                      &(struct ng_graph_image_params){.format = VK_FORMAT_R32G32B32A32_SFLOAT,
                                                                      .width = data->screen->width,
                                                                      .height = data->screen->height},
                                      &valid);
        all_valid &= valid;
    }
    return all_valid;
}

static ng_result list_lights(struct lf_gather *self, struct ng_composer *composer, uint64_t *key)
{
    size_t count = ng_composer_count(composer, &lf_embedding_item);
    if (!ng_array_resize(&self->lights, count) || !ng_array_resize(&self->embeddings, count))
        return ng_out_of_memory("the gather of lights");
    for (size_t i = 0; i < count; i++) {
        const struct lf_embedding *e = ng_composer_get(composer, &lf_embedding_item, i);
        self->embeddings.items[i] = *e;
        self->lights.items[i] =
            (struct lf_net_gathered){.encoding = e->encoding, .values = lf_light_clues_values(e->clues)};
        *key = ng_hash_combine(*key, e->version);
    }
    return NG_OK;
}

static void declare_pass(struct ng_composer *composer, struct pass_data *data)
{
    struct ng_pass *pass =
        ng_graph_add_pass(ng_composer_graph(composer), &(struct ng_pass_params){.name = "gather",
                                                                                .kind = NG_PASS_CPU,
                                                                                .run = run,
                                                                                .data = data,
                                                                                .data_size = sizeof *data,
                                                                                .flags = NG_PASS_ON_DEMAND});
    if (data->screen->ready.id)
        ng_pass_read(pass, data->screen->ready, NG_USE_HOST_READ);
    for (size_t i = 0; i < ng_composer_count(composer, &lf_embedding_item); i++) {
        const struct lf_embedding *e = ng_composer_get(composer, &lf_embedding_item, i);
        if (e->ready.id)
            ng_pass_read(pass, e->ready, NG_USE_HOST_READ);
    }
    for (int i = 0; i < PART_COUNT; i++)
        data->images[i] = ng_pass_write(pass, data->images[i], NG_USE_HOST_WRITE);
}

static ng_result consume(struct ng_composer *composer, void *user)
{
    struct lf_gather *self = user;
    struct pass_data data = {.self = self, .screen = ng_composer_get(composer, &lf_screen_item, 0)};
    if (!data.screen)
        return NG_OK;
    data.key = data.screen->version;
    NG_TRY(list_lights(self, composer, &data.key));
    bool valid = declare_images(self, ng_composer_graph(composer), &data);
    if (!valid || self->gathered != data.key || self->params.always)
        declare_pass(composer, &data);
    struct ng_radiance radiance = {.method = self->params.method,
                                   .unshadowed = data.images[UNSHADOWED],
                                   .direct = data.images[DIRECT],
                                   .indirect = data.images[INDIRECT]};
    return ng_composer_publish(composer, &ng_radiance_item, &radiance);
}

struct ng_provider lf_gather_provider(struct lf_gather *gather)
{
    return (struct ng_provider){.name = "gather", .consume = consume, .user = gather};
}

// Found by its provider's name in the composer: so methods share it without knowing of each other.
#include "lightformer/trace/ray_scene.h"

#include "base/array.h"
#include "base/log.h"
#include "render/frame.h"
#include "render/gbuffer.h"

#include <stdlib.h>
#include <string.h>

#define NAME "trace"

const struct ng_item_type lf_ray_scene_item = {"ray scene", sizeof(struct lf_ray_scene)};

struct user {
    const char *name; // the provider's
    uint64_t memory_limit;
};

struct owner {
    struct lf_tracer *tracer;
    NG_ARRAY(struct user) users;
};

struct pass_data {
    struct lf_tracer *tracer;
    const struct ng_snapshot *snapshot;
};

// A failure is none of the frame's: whoever traces finds no snapshot, and knows what that means for its
// picture.
static ng_result update(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    ng_result result = lf_tracer_update(d->tracer, d->snapshot);
    NG_UNUSED(result);
    return NG_OK;
}

static ng_result produce(struct ng_composer *composer, void *user)
{
    const struct owner *self = user;
    const struct ng_frame_info *frame = ng_composer_get(composer, &ng_frame_item, 0);
    const struct pass_data data = {self->tracer, frame->snapshot};
    struct ng_graph *g = ng_composer_graph(composer);
    struct ng_pass *pass = ng_graph_add_pass(g, &(struct ng_pass_params){.name = "trace:update",
                                                                         .kind = NG_PASS_CPU,
                                                                         .run = update,
                                                                         .data = &data,
                                                                         .data_size = sizeof data});
    const struct lf_ray_scene rays = {
        .tracer = self->tracer,
        .updated = ng_pass_write(pass, ng_graph_add_token(g, "trace:scene"), NG_USE_HOST_WRITE)};
    return ng_composer_publish(composer, &lf_ray_scene_item, &rays);
}

// ---- Those who trace -------------------------------------------------------------------------------------

static struct owner *find(const struct ng_composer *composer)
{
    const struct ng_provider *p = ng_composer_find(composer, NAME);
    return p && p->produce == produce ? p->user : NULL;
}

static void destroy(struct owner *self)
{
    lf_tracer_destroy(&self->tracer);
    ng_array_finish(&self->users);
    free(self);
}

static ng_result make(struct ng_composer *composer, struct owner **out)
{
    struct owner *self = calloc(1, sizeof *self);
    if (!self)
        return ng_out_of_memory("the ray scene");
    ng_result result = lf_tracer_create(&self->tracer);
    if (result == NG_OK)
        result = ng_composer_register(
            composer, &(struct ng_provider){.name = NAME,
                                            .produce = produce,
                                            .user = self,
                                            .before = NG_GBUFFER_PROVIDER}); // it may trace, too
    if (result != NG_OK)
        destroy(self);
    else
        *out = self;
    return result;
}

static void follow_users(struct ng_composer *composer, struct owner *self)
{
    uint64_t least = 0;
    for (size_t i = 0; i < self->users.count; i++) {
        uint64_t limit = self->users.items[i].memory_limit;
        least = limit && (!least || limit < least) ? limit : least;
    }
    lf_tracer_limit_memory(self->tracer, least);
    if (self->users.count)
        return;
    ng_composer_unregister(composer, NAME);
    destroy(self);
}

ng_result lf_ray_scene_register(struct ng_composer *composer, const struct ng_provider *provider,
                                uint64_t memory_limit)
{
    struct owner *self = find(composer);
    if (!self)
        NG_TRY(make(composer, &self));
    ng_result result = ng_composer_register(composer, provider);
    if (result == NG_OK && !ng_array_push(&self->users, (struct user){provider->name, memory_limit})) {
        ng_composer_unregister(composer, provider->name);
        result = ng_out_of_memory("the ray scene");
    }
    follow_users(composer, self);
    return result;
}

void lf_ray_scene_unregister(struct ng_composer *composer, const char *name)
{
    struct owner *self = find(composer);
    ng_composer_unregister(composer, name);
    for (size_t i = 0; self && i < self->users.count; i++)
        if (strcmp(self->users.items[i].name, name) == 0) {
            ng_array_swap_remove(&self->users, i);
            follow_users(composer, self);
            return;
        }
}

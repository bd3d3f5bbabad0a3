// The buffers and passes of a frame. All are declared in every frame; their keys (graph/key.h) tell the graph
// which have to run.
//
// The objects of clues.h and net.h hold what their arrays mean, and the graph's buffers hold the arrays:
// every pass lends them to the objects before it uses them.
#include "lightformer/encode/encoder_internal.h"

#include "graph/key.h"
#include "lightformer/net/memory.h"
#include "render/light_gpu.h"

#include <stdio.h>
#include <string.h>

// ---- What they do ----------------------------------------------------------------------------------------

struct pass_data {
    struct lf_encoder_inputs in;
    struct lf_active_light light;
};

static bool is_abandoned(const void *ctx)
{
    return ng_pass_is_abandoned(ctx);
}

static ng_result find_scene(const struct ng_pass_context *ctx, const struct lf_encoder_inputs *in,
                            struct lf_clues_scene *out)
{
    const struct lf_encoder *self = in->self;
    *out = (struct lf_clues_scene){.tracer = in->rays->tracer,
                                   .jobs = self->params.jobs,
                                   .reads = self->reads,
                                   .abandon = is_abandoned,
                                   .abandon_user = ctx};
    return lf_tracer_snapshot(out->tracer) ? NG_OK : NG_ERROR_MEMORY; // logged there
}

static const void *memory_of(const struct ng_pass_context *ctx, struct ng_graph_ref ref)
{
    return ng_pass_memory(ctx, ref).data;
}

static void lend_part(const struct ng_pass_context *ctx, const struct lf_pixel_buffers *buffers,
                      enum lf_pixel_part part, struct lf_pixel_clues *clues)
{
    struct ng_graph_memory m = ng_pass_memory(ctx, buffers->parts[part]);
    lf_pixel_clues_lend(clues, part, m.data, m.size);
}

void lf_lend_pixels(const struct ng_pass_context *ctx, const struct lf_pixel_buffers *buffers,
                    struct lf_pixel_clues *clues)
{
    for (int i = 0; i < LF_PIXEL_ARRIVING; i++)
        lend_part(ctx, buffers, (enum lf_pixel_part)i, clues);
}

void lf_lend_arriving(const struct ng_pass_context *ctx, const struct lf_pixel_buffers *buffers,
                      struct lf_pixel_clues *clues)
{
    lend_part(ctx, buffers, LF_PIXEL_ARRIVING, clues);
}

static void lend_light(const struct ng_pass_context *ctx, enum lf_light_part part, struct ng_graph_ref ref,
                       struct lf_light_clues *clues)
{
    struct ng_graph_memory m = ng_pass_memory(ctx, ref);
    lf_light_clues_lend(clues, part, m.data, m.size);
}

void lf_lend_embedding(const struct ng_pass_context *ctx, const struct lf_light_buffers *b, bool fresh,
                       struct lf_light_clues *clues, struct lf_net_encoding *encoding)
{
    struct ng_graph_memory pictures = ng_pass_memory(ctx, b->embedding);
    lf_net_encoding_lend_light(encoding, ng_pass_memory(ctx, b->light).data);
    lf_net_encoding_lend(encoding, pictures.data, pictures.size, fresh);
    if (b->kept.id)
        lend_light(ctx, LF_LIGHT_KEPT, b->kept, clues);
}

static ng_result find_pixel_clues(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct lf_encoder *self = d->in.self;
    struct lf_clues_scene scene;
    NG_TRY(find_scene(ctx, &d->in, &scene));
    const struct ng_gbuffer *behind = d->in.gbuffer;
    const struct lf_clues_pixels_params params = {
        .gbuffer = {.position = memory_of(ctx, behind->position),
                    .normal = memory_of(ctx, behind->normal),
                    .diffuse = memory_of(ctx, behind->diffuse),
                    .specular = memory_of(ctx, behind->specular)},
        .width = d->in.frame->width,
        .height = d->in.frame->height,
        .reflection_rays = self->params.reflection_rays,
    };
    self->counters.pixels++;
    lf_lend_pixels(ctx, &d->in.pixels, self->pixels);
    return lf_clues_pixels(&scene, &params, self->pixels);
}

static ng_result find_arriving(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct lf_encoder *self = d->in.self;
    struct lf_clues_scene scene;
    NG_TRY(find_scene(ctx, &d->in, &scene));
    self->counters.arriving++;
    lf_lend_pixels(ctx, &d->in.pixels, self->pixels);
    lf_lend_arriving(ctx, &d->in.pixels, self->pixels);
    for (size_t i = 0; i < self->active.count; i++)
        lend_light(ctx, LF_LIGHT_HITS, self->active.items[i].buffers.hits, self->active.items[i].kept->clues);
    return lf_clues_arriving(&scene, self->pixels, self->clues.items, (uint32_t)self->clues.count);
}

// Where the maps of this frame lie; their memory is another in each frame.
static const struct lf_captured_light *captured_maps(const struct ng_pass_context *ctx,
                                                     const struct lf_active_light *light)
{
    const struct ng_light_maps *maps = light->maps;
    light->kept->maps = (struct lf_captured_light){
        .light = maps->light,
        .data = maps->gpu->data,
        .rsm_views = maps->rsm_views,
        .position = memory_of(ctx, maps->position),
        .normal = memory_of(ctx, maps->normal),
        .flux = memory_of(ctx, maps->flux),
        .depth_views = maps->depth_views,
        .face_size = maps->face_size,
        .depth = memory_of(ctx, maps->depth),
    };
    return &light->kept->maps;
}

static ng_result find_light_clues(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    const struct lf_encoder_params *p = &d->in.self->params;
    struct lf_clues_scene scene;
    NG_TRY(find_scene(ctx, &d->in, &scene));
    struct lf_clues_light_params params = {.vpl_count = p->vpl_count, .observed = d->light.maps->gpu};
    if (p->rsm == LF_RSM_MAPS)
        params.maps = captured_maps(ctx, &d->light);
    d->in.self->counters.rsm++;
    lend_light(ctx, LF_LIGHT_RSM, d->light.buffers.rsm, d->light.kept->clues);
    return lf_clues_light(&scene, d->light.maps->light, &params, d->light.kept->clues);
}

// The values of the frame and of the light side by side: the network takes them as one.
static struct lf_net_values join_values(const struct lf_encoder *self, const struct lf_kept_light *kept)
{
    struct lf_net_values joined = *lf_light_clues_values(kept->clues);
    const struct lf_net_values *pixels = lf_pixel_clues_values(self->pixels);
    for (int i = 0; i < LF_INPUT_COUNT; i++)
        if (lf_net_inputs[i].domain == LF_DOMAIN_FRAME)
            joined.of[i] = pixels->of[i];
    return joined;
}

static ng_result encode_light(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct lf_kept_light *kept = d->light.kept;
    lend_light(ctx, LF_LIGHT_RSM, d->light.buffers.rsm, kept->clues);
    lf_net_encoding_lend_light(kept->encoding, ng_pass_memory(ctx, d->light.buffers.light).data);
    const struct lf_net_values values = join_values(d->in.self, kept);
    const struct lf_net_light_inputs inputs = {.values = &values,
                                               .vpl_count = lf_light_clues_vpls(kept->clues),
                                               .texel_count = lf_light_clues_texels(kept->clues)};
    d->in.self->counters.light++;
    return lf_net_encode_light(d->in.self->params.executor, kept->encoding, &inputs);
}

static ng_result find_view_clues(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct lf_clues_scene scene;
    NG_TRY(find_scene(ctx, &d->in, &scene));
    struct lf_light_clues *clues = d->light.kept->clues;
    if (d->in.self->params.rsm == LF_RSM_MAPS)
        (void)captured_maps(ctx, &d->light);
    d->in.self->counters.clues++;
    lf_lend_pixels(ctx, &d->in.pixels, d->in.self->pixels);
    lend_light(ctx, LF_LIGHT_RSM, d->light.buffers.rsm, clues);
    lend_light(ctx, LF_LIGHT_VIEW, d->light.clues, clues);
    lend_light(ctx, LF_LIGHT_HITS, d->light.buffers.hits, clues);
    return lf_clues_view(&scene, d->in.self->pixels, clues);
}

static ng_result encode_view(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct lf_encoder *self = d->in.self;
    struct lf_kept_light *kept = d->light.kept;
    const struct lf_net_picture frame = {.width = d->in.frame->width,
                                         .height = d->in.frame->height,
                                         .values = lf_pixel_clues_values(self->pixels)};
    struct ng_graph_memory work = ng_pass_memory(ctx, d->in.work.memory);
    self->counters.view++;
    lf_lend_pixels(ctx, &d->in.pixels, self->pixels);
    lf_lend_embedding(ctx, &d->light.buffers, d->light.fresh, kept->clues, kept->encoding);
    lf_net_executor_lend(self->params.executor, work.data, work.size, d->in.work.fresh);
    NG_TRY(lf_net_encode_view(self->params.executor, kept->encoding, &frame,
                              lf_light_clues_values(kept->clues)));
    return lf_light_clues_keep(kept->clues, self->gather);
}

// ---- Buffers ---------------------------------------------------------------------------------------------

// A network may hold nothing there, but a buffer has a size.
static uint64_t at_least_a_line(uint64_t bytes)
{
    return bytes ? bytes : LF_MEMORY_ALIGNMENT;
}

static struct ng_graph_ref persistent(struct ng_graph *g, const char *group, const char *what, uint64_t bytes,
                                      bool *valid)
{
    char name[160];
    snprintf(name, sizeof name, "%s/%s", group, what);
    return ng_graph_persistent_buffer(g, name, &(struct ng_graph_buffer_params){.size = bytes}, valid);
}

static void declare_light_buffers(struct ng_graph *g, const struct lf_encoder_inputs *in, const char *light,
                                  uint32_t views, struct lf_light_buffers *out, bool *valid)
{
    const struct lf_encoder *self = in->self;
    uint32_t width = in->frame->width, height = in->frame->height;
    const struct lf_net_bytes net = lf_net_picture_bytes(self->params.executor, width, height);
    uint64_t kept = lf_clues_kept_bytes(width, height, self->gather);
    char group[96];
    snprintf(group, sizeof group, "encode:%s", light);
    out->rsm = persistent(g, group, "rsm", lf_clues_rsm_bytes(self->params.vpl_count, views), NULL);
    out->hits =
        persistent(g, group, "hits", lf_clues_hits_bytes(width, height, self->params.reflection_rays), NULL);
    out->light = persistent(g, group, "light", net.light, NULL);
    out->embedding = persistent(g, group, "embedding", at_least_a_line(net.encoding), valid);
    if (kept)
        out->kept = persistent(g, group, "kept", kept, NULL);
}

// What is off may come on again: its buffers live as long as they are declared.
static void keep_dark_lights(struct ng_graph *g, const struct lf_encoder_inputs *in)
{
    struct lf_encoder *self = in->self;
    for (size_t i = 0; i < self->kept.count; i++) {
        struct lf_light_buffers buffers;
        bool valid;
        if (!self->kept.items[i]->active)
            declare_light_buffers(g, in, self->kept.items[i]->name, self->kept.items[i]->views, &buffers,
                                  &valid);
    }
}

static void declare_buffers(struct ng_graph *g, struct lf_encoder_inputs *in)
{
    static const char *const parts[LF_PIXEL_PARTS] = {"pixels", "grid", "reflections", "arriving"};
    struct lf_encoder *self = in->self;
    uint32_t width = in->frame->width, height = in->frame->height;
    const struct lf_clues_bytes bytes = lf_clues_bytes(width, height, self->params.reflection_rays);
    const struct lf_net_bytes net = lf_net_picture_bytes(self->params.executor, width, height);
    bool valid;
    for (int i = 0; i < LF_PIXEL_PARTS; i++)
        in->pixels.parts[i] = persistent(g, "clues", parts[i], bytes.pixels[i], NULL);
    in->work.memory = ng_graph_persistent_buffer(
        g, "network/work",
        &(struct ng_graph_buffer_params){.size = at_least_a_line(net.work), .scratch = true}, &valid);
    in->work.fresh = !valid;
    for (size_t i = 0; i < self->active.count; i++) {
        struct lf_active_light *light = &self->active.items[i];
        struct lf_kept_light *kept = light->kept;
        kept->views = light->maps->rsm_views;
        declare_light_buffers(g, in, kept->name, kept->views, &light->buffers, &valid);
        light->fresh = !valid;
    }
    keep_dark_lights(g, in);
}

// ---- Passes ----------------------------------------------------------------------------------------------

struct declaration {
    struct ng_graph *graph;
    struct lf_encoder_inputs *in;
    struct lf_active_light *light; // of the passes of a light
};

static struct ng_pass *add_pass(const struct declaration *d, const char *name, ng_pass_fn run, uint64_t key)
{
    const struct pass_data data = {.in = *d->in, .light = d->light ? *d->light : (struct lf_active_light){0}};
    return ng_graph_add_pass(d->graph, &(struct ng_pass_params){.name = name,
                                                                .kind = NG_PASS_CPU,
                                                                .run = run,
                                                                .data = &data,
                                                                .data_size = sizeof data,
                                                                .flags = NG_PASS_ON_DEMAND,
                                                                .key = key});
}

static struct ng_pass *add_light_pass(const struct declaration *d, const char *what, ng_pass_fn run,
                                      uint64_t key)
{
    char name[160];
    snprintf(name, sizeof name, "encode:%s/%s", d->light->maps->name, what);
    return add_pass(d, name, run, key);
}

static void read(struct ng_pass *pass, struct ng_graph_ref ref)
{
    if (ref.id)
        ng_pass_read(pass, ref, NG_USE_HOST_READ);
}

static void write(struct ng_pass *pass, struct ng_graph_ref *ref)
{
    if (ref->id)
        *ref = ng_pass_write(pass, *ref, NG_USE_HOST_WRITE);
}

void lf_read_pixels(struct ng_pass *pass, const struct lf_pixel_buffers *buffers)
{
    for (int i = 0; i < LF_PIXEL_ARRIVING; i++)
        read(pass, buffers->parts[i]);
}

// The key of the pass says what of the maps matters.
static void read_maps(const struct declaration *d, struct ng_pass *pass)
{
    const struct ng_light_maps *maps = d->light->maps;
    const struct ng_graph_ref images[] = {maps->position, maps->normal, maps->flux, maps->depth};
    for (size_t i = 0; d->in->self->params.rsm == LF_RSM_MAPS && i < NG_COUNT(images); i++)
        ng_pass_read_as(pass, images[i], NG_USE_HOST_READ, NG_KEY);
}

static void declare_pixel_clues(struct declaration *d)
{
    const struct ng_gbuffer *g = d->in->gbuffer;
    const struct ng_graph_ref images[] = {g->position, g->normal, g->diffuse, g->specular};
    struct ng_pass *pass =
        add_pass(d, "clues:pixels", find_pixel_clues, lf_encoder_pixels_key(d->in->self, d->in->frame));
    read(pass, d->in->rays->updated);
    for (size_t i = 0; i < NG_COUNT(images); i++)
        ng_pass_read_as(pass, images[i], NG_USE_HOST_READ, NG_KEY); // the key of the pass holds all of it
    for (int i = 0; i < LF_PIXEL_ARRIVING; i++)
        write(pass, &d->in->pixels.parts[i]);
}

// Of all lights, so after them.
static void declare_arriving(struct declaration *d)
{
    struct ng_graph_ref *arriving = &d->in->pixels.parts[LF_PIXEL_ARRIVING];
    struct ng_pass *pass =
        add_pass(d, "clues:arriving", find_arriving, lf_encoder_powers_key(d->in->frame->snapshot));
    lf_read_pixels(pass, &d->in->pixels);
    for (size_t i = 0; i < d->in->self->active.count; i++)
        read(pass, d->in->self->active.items[i].buffers.hits);
    write(pass, arriving);
}

static void declare_rsm(struct declaration *d)
{
    struct ng_pass *pass =
        add_light_pass(d, "rsm", find_light_clues, lf_encoder_rsm_key(d->in->self, d->in->frame, d->light));
    read(pass, d->in->rays->updated);
    read_maps(d, pass);
    write(pass, &d->light->buffers.rsm);
}

static void declare_light(struct declaration *d)
{
    struct ng_pass *pass =
        add_light_pass(d, "light", encode_light,
                       lf_encoder_light_key(d->in->self, d->in->frame->snapshot, d->light->maps->light));
    read(pass, d->light->buffers.rsm);
    write(pass, &d->light->buffers.light);
}

static void declare_clues(struct declaration *d)
{
    char name[160];
    uint64_t bytes = lf_clues_view_bytes(d->in->frame->width, d->in->frame->height);
    snprintf(name, sizeof name, "encode:%s/clues", d->light->kept->name);
    d->light->clues = ng_graph_add_buffer(d->graph, name, &(struct ng_graph_buffer_params){.size = bytes});
    struct ng_pass *pass =
        add_light_pass(d, "clues", find_view_clues, lf_encoder_clues_key(d->in->frame->snapshot));
    read(pass, d->in->rays->updated);
    lf_read_pixels(pass, &d->in->pixels);
    read(pass, d->light->buffers.rsm);
    read_maps(d, pass);
    write(pass, &d->light->clues);
    write(pass, &d->light->buffers.hits);
}

static void declare_view(struct declaration *d)
{
    struct ng_pass *pass = add_light_pass(d, "view", encode_view, NG_KEY);
    lf_read_pixels(pass, &d->in->pixels);
    read(pass, d->light->clues);
    read(pass, d->light->buffers.light);
    write(pass, &d->in->work.memory);
    write(pass, &d->light->buffers.embedding);
    write(pass, &d->light->buffers.kept);
}

void lf_encoder_keep(struct ng_graph *graph, struct lf_encoder_inputs *in)
{
    declare_buffers(graph, in);
}

void lf_encoder_declare(struct ng_graph *graph, struct lf_encoder_inputs *in)
{
    struct declaration d = {.graph = graph, .in = in};
    declare_buffers(graph, in);
    declare_pixel_clues(&d);
    for (size_t i = 0; i < in->self->active.count; i++) {
        d.light = &in->self->active.items[i];
        declare_rsm(&d);
        declare_light(&d);
        declare_clues(&d);
        declare_view(&d);
    }
    d.light = NULL;
    declare_arriving(&d);
}

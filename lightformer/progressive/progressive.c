// The picture is cut into regions, each an lf_reference of its own, so that a slice of time is a few regions
// and a pass may take as many frames as it needs. What they found lies in three images on the host, which one
// CPU pass of the graph hands to the renderer.
#include "lightformer/progressive/progressive.h"

#include "base/array.h"
#include "base/log.h"
#include "base/system.h"
#include "graph/key.h"
#include "lightformer/reference/reference.h"
#include "lightformer/trace/ray_scene.h"
#include "render/frame.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define METHOD      "reference"
#define REGION      64u // pixels a side: some milliseconds of tracing
#define PREVIEW     4u  // a preview's pixel covers so many, each way
#define SHORT_SLICE 0.03
#define LONG_SLICE  0.25

enum { UNSHADOWED, DIRECT, INDIRECT, PART_COUNT };

static const char *const part_names[PART_COUNT] = {"unshadowed", "direct", "indirect"};

struct region {
    struct lf_region place;
    struct lf_reference *reference;
    uint64_t picture; // that its samples are of
};

struct lf_progressive {
    struct lf_progressive_params params;
    struct ng_composer *composer;   // null: in none
    const struct lf_tracer *tracer; // the renderer's
    struct lf_reference *preview;
    NG_ARRAY(struct region) regions;    // in rows from the top
    NG_ARRAY(float) images[PART_COUNT]; // [height][width][4]
    uint32_t width, height;             // of all of these
    uint64_t picture;                   // key of what the picture shows; 0: of nothing
    uint32_t next;                      // region whose turn it is
    bool failed;                        // nothing more comes of this picture
    uint64_t slice_end_ns;              // of the last frame's slice
    struct lf_progressive_stats stats;
};

ng_result lf_progressive_create(const struct lf_progressive_params *params, struct lf_progressive **out)
{
    *out = NULL;
    struct lf_progressive *p = calloc(1, sizeof *p);
    if (!p)
        return ng_out_of_memory("the progressive reference");
    p->params = *params;
    *out = p;
    return NG_OK;
}

static void forget_size(struct lf_progressive *p)
{
    for (size_t i = 0; i < p->regions.count; i++)
        lf_reference_destroy(&p->regions.items[i].reference);
    lf_reference_destroy(&p->preview);
    p->regions.count = 0;
    p->width = p->height = 0;
}

void lf_progressive_destroy(struct lf_progressive **progressive)
{
    struct lf_progressive *p = *progressive;
    *progressive = NULL;
    if (!p)
        return;
    lf_progressive_leave(p);
    ng_array_finish(&p->regions);
    for (int i = 0; i < PART_COUNT; i++)
        ng_array_finish(&p->images[i]);
    free(p);
}

struct lf_progressive_stats lf_progressive_stats_of(const struct lf_progressive *p)
{
    return p->stats;
}

// ---- What the picture is of ------------------------------------------------------------------------------

// All that radiance follows from.
static uint64_t key_of(const struct ng_frame_info *frame)
{
    const struct ng_snapshot *s = frame->snapshot;
    const uint64_t words[] = {frame->width,        frame->height,  s->geometry_version,
                              s->emission_version, s->environment, s->light_count};
    const float lens[] = {s->camera.fov_y, s->camera.height, s->camera.near_plane, s->scene_radius};
    uint64_t key = ng_key_add_bytes(NG_KEY, words, sizeof words);
    key = ng_key_add_bytes(key, lens, sizeof lens);
    key = ng_key_add_bytes(key, s->camera.view, sizeof s->camera.view);
    for (uint32_t i = 0; i < s->light_count; i++)
        key = ng_key_add(key, s->lights[i].version);
    return key;
}

// ---- Regions ---------------------------------------------------------------------------------------------

static ng_result add_region(struct lf_progressive *p, const struct lf_reference_params *params)
{
    struct region region = {.place = params->region};
    NG_TRY(lf_reference_create(params, &region.reference));
    if (ng_array_push(&p->regions, region))
        return NG_OK; // it owns the reference now
    lf_reference_destroy(&region.reference);
    return ng_out_of_memory("the progressive reference");
}

static uint32_t least(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

static ng_result take_size(struct lf_progressive *p, uint32_t width, uint32_t height)
{
    forget_size(p);
    for (int i = 0; i < PART_COUNT; i++)
        if (!ng_array_resize(&p->images[i], (size_t)width * height * 4))
            return ng_out_of_memory("the progressive reference");
    struct lf_reference_params params = {.width = (width + PREVIEW - 1) / PREVIEW,
                                         .height = (height + PREVIEW - 1) / PREVIEW,
                                         .seed = p->params.seed,
                                         .jobs = p->params.jobs};
    NG_TRY(lf_reference_create(&params, &p->preview));
    params.width = width;
    params.height = height;
    for (uint32_t y = 0; y < height; y += REGION)
        for (uint32_t x = 0; x < width; x += REGION) {
            params.region = (struct lf_region){x, y, least(REGION, width - x), least(REGION, height - y)};
            NG_TRY(add_region(p, &params));
        }
    p->width = width;
    p->height = height;
    return NG_OK;
}

// Adds samples until a reference has as many, and counts what that took.
static ng_result trace(struct lf_progressive *p, struct lf_reference *reference, uint32_t samples)
{
    struct lf_reference_stats before = lf_reference_stats_of(reference);
    NG_TRY(lf_reference_run(reference, &(struct lf_reference_run_params){.samples = samples}));
    struct lf_reference_stats after = lf_reference_stats_of(reference);
    p->stats.rays += after.rays - before.rays;
    p->stats.seconds += after.seconds - before.seconds;
    return NG_OK;
}

// Copies a layer into a place of an image, `scale` pixels for one of the layer's.
static void paint(struct lf_progressive *p, int part, const struct lf_region *place,
                  const struct lf_layer *layer, uint32_t scale)
{
    const float *from = layer->pixels;
    for (uint32_t y = 0; y < place->height; y++) {
        float *to = &p->images[part].items[((size_t)(place->y + y) * p->width + place->x) * 4];
        const float *row = from + (size_t)(y / scale) * layer->width * 3;
        for (uint32_t x = 0; x < place->width; x++) {
            memcpy(to + (size_t)x * 4, row + (size_t)(x / scale) * 3, 3 * sizeof *to);
            to[(size_t)x * 4 + 3] = 1;
        }
    }
}

static ng_result show(struct lf_progressive *p, const struct lf_reference *reference,
                      const struct lf_region *place, uint32_t scale)
{
    for (int i = 0; i < PART_COUNT; i++) {
        struct lf_layer layer;
        NG_TRY(lf_reference_layer(reference, part_names[i], &layer));
        paint(p, i, place, &layer, scale);
        free(layer.pixels);
    }
    return NG_OK;
}

static ng_result refine(struct lf_progressive *p, struct region *region)
{
    if (region->picture != p->picture) {
        NG_TRY(lf_reference_begin(region->reference, p->tracer));
        region->picture = p->picture;
    }
    NG_TRY(trace(p, region->reference, p->stats.samples + 1));
    return show(p, region->reference, &region->place, 1);
}

static ng_result preview(struct lf_progressive *p)
{
    NG_TRY(lf_reference_begin(p->preview, p->tracer));
    NG_TRY(trace(p, p->preview, 1));
    return show(p, p->preview, &(struct lf_region){.width = p->width, .height = p->height}, PREVIEW);
}

// ---- A frame ---------------------------------------------------------------------------------------------

static bool is_due(const struct lf_progressive *p)
{
    return !p->failed && (!p->params.samples || p->stats.samples < p->params.samples);
}

static void forget_picture(struct lf_progressive *p, uint64_t picture)
{
    p->picture = picture;
    p->stats = (struct lf_progressive_stats){0};
    p->next = 0;
    p->failed = false;
}

// Half of the time, as long as a person does not notice.
static double choose_slice(const struct lf_progressive *p, uint64_t now)
{
    double rest = (double)(now - p->slice_end_ns) * 1e-9;
    return p->params.slice > 0 ? p->params.slice : fmin(fmax(rest, SHORT_SLICE), LONG_SLICE);
}

// One slice: at least one region, so that there is progress however slow the machine.
static ng_result advance(struct lf_progressive *p, const struct ng_pass_context *ctx)
{
    uint64_t now = ng_clock_ns(), end = now + (uint64_t)(choose_slice(p, now) * 1e9);
    while (is_due(p)) {
        NG_TRY(refine(p, &p->regions.items[p->next]));
        if (++p->next == p->regions.count) {
            p->next = 0;
            p->stats.samples++;
        }
        if (ng_clock_ns() >= end || ng_pass_is_abandoned(ctx))
            break;
    }
    return NG_OK;
}

static ng_result follow(struct lf_progressive *p, const struct ng_pass_context *ctx,
                        const struct ng_frame_info *frame)
{
    uint64_t picture = key_of(frame);
    bool begins = picture != p->picture;
    if (begins)
        forget_picture(p, picture);
    if (!lf_tracer_snapshot(p->tracer))
        return NG_ERROR_MEMORY;
    if (p->width != frame->width || p->height != frame->height)
        NG_TRY(take_size(p, frame->width, frame->height));
    return begins ? preview(p) : advance(p, ctx);
}

struct pass_data {
    struct lf_progressive *self;
    const struct ng_frame_info *frame;
    const struct lf_ray_scene *rays;
    struct ng_graph_ref images[PART_COUNT];
};

static ng_result run(const struct ng_pass_context *ctx)
{
    const struct pass_data *d = ctx->data;
    struct lf_progressive *p = d->self;
    p->tracer = d->rays->tracer;
    p->failed |= follow(p, ctx, d->frame) != NG_OK; // logged there; what was found so far stays
    p->slice_end_ns = ng_clock_ns();
    p->stats.resting = !is_due(p);
    for (int i = 0; i < PART_COUNT; i++) {
        struct ng_graph_memory memory = ng_pass_memory(ctx, d->images[i]);
        if (p->images[i].count * sizeof(float) == memory.size)
            memcpy(memory.data, p->images[i].items, memory.size);
        else // there was no memory for this size
            memset(memory.data, 0, memory.size);
    }
    return NG_OK;
}

static ng_result consume(struct ng_composer *composer, void *user)
{
    struct lf_progressive *p = user;
    struct pass_data data = {.self = p,
                             .frame = ng_composer_get(composer, &ng_frame_item, 0),
                             .rays = ng_composer_get(composer, &lf_ray_scene_item, 0)};
    if (!ng_frame_wants(data.frame, METHOD))
        return NG_OK;
    if (!data.rays)
        return NG_ERROR_MEMORY; // logged there
    struct ng_graph *g = ng_composer_graph(composer);
    uint64_t picture = key_of(data.frame);
    bool rests = picture == p->picture && !is_due(p);
    for (int i = 0; i < PART_COUNT; i++) {
        char name[32];
        snprintf(name, sizeof name, METHOD "/%s", part_names[i]);
        data.images[i] =
            ng_graph_persistent_image(g, name,
                                      &(struct ng_graph_image_params){.format = VK_FORMAT_R32G32B32A32_SFLOAT,
                                                                      .width = data.frame->width,
                                                                      .height = data.frame->height},
                                      NULL);
    }
    struct ng_pass *pass = ng_graph_add_pass(g, &(struct ng_pass_params){.name = METHOD "/trace",
                                                                         .kind = NG_PASS_CPU,
                                                                         .run = run,
                                                                         .data = &data,
                                                                         .data_size = sizeof data,
                                                                         .key = rests ? picture : 0});
    ng_pass_read(pass, data.rays->updated, NG_USE_HOST_READ);
    for (int i = 0; i < PART_COUNT; i++)
        data.images[i] = ng_pass_write(pass, data.images[i], NG_USE_HOST_WRITE);
    struct ng_radiance radiance = {.method = METHOD,
                                   .unshadowed = data.images[UNSHADOWED],
                                   .direct = data.images[DIRECT],
                                   .indirect = data.images[INDIRECT],
                                   .on_host = true};
    return ng_composer_publish(composer, &ng_radiance_item, &radiance);
}

ng_result lf_progressive_join(struct lf_progressive *p, struct ng_composer *composer)
{
    NG_REQUIRE(!p->composer, "the progressive reference is in a composer already");
    const struct ng_provider provider = {.name = METHOD, .consume = consume, .user = p};
    NG_TRY(lf_ray_scene_register(composer, &provider, 0));
    p->composer = composer;
    return NG_OK;
}

void lf_progressive_leave(struct lf_progressive *p)
{
    if (!p->composer)
        return;
    lf_ray_scene_unregister(p->composer, METHOD);
    p->composer = NULL;
    forget_size(p); // what was begun with a tracer that may be gone
    p->picture = 0;
}

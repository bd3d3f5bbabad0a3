#include "view_studio.h"
#include "scene_file.h"
#include "view_tier.h"

#include "app/clip_menu.h"
#include "app/stage.h"
#include "app/watch.h"
#include "base/log.h"
#include "base/system.h"
#include "components/camera.h"
#include "components/components.h"
#include "components/name.h"
#include "lightformer/methods/methods.h"
#include "lightformer/net/net.h"
#include "lightformer/neural/neural.h"
#include "scene/world.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define ADAPTATION_S      0.4f // in which the exposure goes most of the way to where it should be
#define SAMPLES_OF_A_MEAN 1024.0f
#define MOST_CELL         24.0f

struct view_studio {
    struct view_studio_params params;
    struct ng_stage *stage; // null: nothing has been opened yet
    struct ng_clip_menu *clips;
    char scene[4096];    // path of what is on the stage
    const char *weights; // of the network, as asked for; null: the scene's own
    const char *clip;    // that plays, as asked for of the scene
    struct lf_method *methods[LF_METHODS];
    struct ng_camera lens; // of the scene's camera that it is like
    NG_ARRAY(ng_entity) cameras;
    struct ng_camera_controller home;
    struct ng_exposure exposure;
    uint32_t opening, looks;               // of orders that were followed
    bool fresh;                            // no picture of this scene has been made
    struct view_tier tiers[LF_METHODS][2]; // by method, and whether light is upsampled
    bool moved;                            // the last picture was of something that did
    bool failed;
    uint64_t pictures;       // so far
    NG_ARRAY(uint64_t) runs; // of each pass, before this frame
};

ng_result view_studio_create(const struct view_studio_params *params, struct view_studio **out)
{
    struct view_studio *s = calloc(1, sizeof *s);
    *out = s;
    if (!s)
        return ng_out_of_memory("the view");
    s->params = *params;
    s->weights = params->weights;
    s->clip = params->opening->clip;
    return NG_OK;
}

static void close_methods(struct view_studio *s)
{
    for (uint32_t i = 0; i < LF_METHODS; i++)
        lf_method_destroy(&s->methods[i]);
}

void view_studio_destroy(struct view_studio **studio)
{
    struct view_studio *s = *studio;
    *studio = NULL;
    if (!s)
        return;
    ng_clip_menu_destroy(&s->clips);
    close_methods(s);
    ng_stage_destroy(&s->stage);
    ng_array_finish(&s->cameras);
    ng_array_finish(&s->runs);
    free(s);
}

struct ng_gpu *view_studio_gpu(const struct view_studio *s)
{
    return s->stage ? s->stage->gpu : NULL;
}

void view_frame_finish(struct view_frame *f)
{
    ng_array_finish(&f->pixels);
    ng_array_finish(&f->passes);
    ng_array_finish(&f->clips);
    ng_array_finish(&f->cameras);
    ng_pick_finish(&f->pick);
}

// ---- A scene
// -----------------------------------------------------------------------------------------------

// All methods are at hand; without weights for it the neural one shows nothing, unless it was asked for.
static ng_result open_methods(struct view_studio *s, bool first)
{
    const struct view_studio_params *p = &s->params;
    struct lf_method_params params = {.composer = ng_renderer_composer(s->stage->renderer),
                                      .jobs = s->stage->jobs,
                                      .scene = s->scene,
                                      .weights = s->weights,
                                      .samples = p->samples};
    for (uint32_t i = 0; i < LF_METHODS; i++) {
        params.name = lf_method_name(i);
        params.optional = !first || (i != p->method && !(p->compares && i == p->other));
        NG_TRY(lf_method_create(&params, &s->methods[i]));
    }
    return NG_OK;
}

static void watch_file(void *user, const char *path)
{
    // Without memory for it, it is not watched.
    (void)ng_watch_add(((struct view_studio *)user)->params.watch, path);
}

// Besides the files that the document names.
static void watch_scene(struct view_studio *s, const char *scene, const char *weights)
{
    char found[4096];
    watch_file(s, scene);
    if (weights || lf_neural_find_weights(scene, found, sizeof found))
        watch_file(s, weights ? weights : found);
}

// Exposure is the camera's here, so that it can be changed.
static struct ng_stage_params stage_params(struct view_studio *s, const char *scene)
{
    struct ng_stage_params params = {.scene = scene,
                                     .device = s->params.device,
                                     .threads = s->params.threads,
                                     .file = watch_file,
                                     .user = s};
    opening_apply(s->params.opening, &params);
    s->exposure = params.exposure;
    params.exposure = (struct ng_exposure){0};
    return params;
}

static ng_result list_cameras(struct view_studio *s)
{
    const struct ng_world *world = s->stage->world;
    ng_entity root = s->stage->scene.root;
    s->cameras.count = 0;
    for (ng_entity e = root; !ng_entity_is_null(e); e = ng_world_next_below(world, root, e))
        if (ng_world_has(world, e, NG_CAMERA) && !ng_array_push(&s->cameras, e))
            return ng_out_of_memory("the list of cameras");
    return NG_OK;
}

// Ours becomes like a camera of the scene, and `home` what that sees.
static void look_through(struct view_studio *s, ng_entity model)
{
    const struct ng_world *world = s->stage->world;
    if (!pose_look(world, s->stage->scene.root, model, &s->home))
        return;
    s->lens = *(const struct ng_camera *)ng_world_get(world, model, NG_CAMERA);
    if (s->exposure.mode != NG_EXPOSURE_CAMERA) {
        s->lens.auto_exposure = s->exposure.mode == NG_EXPOSURE_AUTO;
        s->lens.exposure = s->lens.auto_exposure ? 1 : s->exposure.factor;
    }
}

// What belongs to the scene on the stage, which has not run yet.
static ng_result begin_scene(struct view_studio *s, double time, bool first)
{
    watch_scene(s, s->scene, s->weights);
    NG_TRY(open_methods(s, first));
    NG_TRY(ng_clip_menu_create(s->stage->world, s->stage->assets, s->stage->scene.root, &s->clips));
    NG_TRY(ng_stage_seek(s->stage, time, NULL)); // places the scene's cameras
    NG_TRY(list_cameras(s));
    look_through(s, s->stage->scene.camera);
    return NG_OK;
}

// Whether a scene's network, if it has one, can be read.
static bool has_good_weights(const char *scene, const char *weights)
{
    char found[4096];
    struct lf_net *net = NULL;
    if (!weights && lf_neural_find_weights(scene, found, sizeof found))
        weights = found;
    bool good = !weights || lf_net_load(weights, &net) == NG_OK;
    lf_net_destroy(&net);
    return good;
}

static ng_result open_first(struct view_studio *s, const struct view_order *order)
{
    struct ng_stage_params params = stage_params(s, order->scene);
    NG_TRY(ng_stage_create(&params, &s->stage));
    memcpy(s->scene, order->scene, sizeof s->scene);
    s->fresh = true;
    return begin_scene(s, order->time, true);
}

// Instead of the scene that is there. What cannot be loaded changes nothing, and is tried again when its
// files change.
static ng_result open_another(struct view_studio *s, const struct view_order *order)
{
    bool again = strcmp(order->scene, s->scene) == 0;
    const char *weights = again ? s->weights : NULL, *clip = again ? s->clip : NULL;
    struct ng_stage *next = NULL;
    struct ng_stage_params params = stage_params(s, order->scene);
    params.no_device = true;
    params.clip = clip;
    ng_watch_clear(s->params.watch);
    s->failed = scene_file_check(order->scene) != NG_OK || !has_good_weights(order->scene, weights) ||
                ng_stage_create(&params, &next) != NG_OK;
    if (s->failed) {
        watch_scene(s, order->scene, weights);
        return NG_OK;
    }
    close_methods(s);
    ng_clip_menu_destroy(&s->clips);
    NG_TRY(ng_stage_adopt(s->stage, &next));
    memcpy(s->scene, order->scene, sizeof s->scene);
    s->weights = weights;
    s->clip = clip;
    s->fresh = s->fresh || !again;
    return begin_scene(s, order->time, false);
}

// ---- A picture
// ---------------------------------------------------------------------------------------------

// Whether this picture is seen from `home`, wherever the order has the camera.
static bool follow_scene(struct view_studio *s, const struct view_order *order)
{
    if (order->looks != s->looks && order->camera < s->cameras.count)
        look_through(s, s->cameras.items[order->camera]);
    return s->fresh || order->looks != s->looks;
}

static void follow_clip(struct view_studio *s, uint32_t clip)
{
    bool known = clip >= NG_CLIPS_FIRST || ng_clip_menu_name(s->clips, clip);
    if (known && ng_clip_menu_choice(s->clips) != clip)
        ng_clip_menu_play(s->clips, clip);
}

// Our own, so that neither a parent nor an animation moves it. Where the order wants it, or `home`; returns
// where it is then.
static struct pose place_camera(struct view_studio *s, const struct view_order *order, bool home)
{
    struct ng_camera_controller c = s->home;
    struct ng_camera lens = s->lens;
    const char *first = s->pictures ? NULL : s->params.pose;
    const struct pose wanted = first ? pose_read(first) : order->pose;
    if (first || !home)
        pose_take(&wanted, &c);
    lens.exposure *= exp2f(order->stops);
    const struct ng_free_camera camera = pose_camera(&c, &lens);
    ng_stage_look(s->stage, &camera);
    return pose_of(&c);
}

// Of both sides: one path tracer serves them.
static struct lf_method_progress progress_of(const struct view_studio *s, const struct view_order *order)
{
    struct lf_method_progress all = {0};
    for (uint32_t i = 0; i < (order->comparison ? VIEW_SIDES : 1u); i++) {
        uint32_t method = order->sides[i].method;
        struct lf_method_progress p = lf_method_progress_of(s->methods[method]);
        all.unfinished |= p.unfinished;
        all.samples = p.samples ? p.samples : all.samples;
    }
    return all;
}

// So many pixels a side that a cell has samples enough for a mean; 1: a pixel has.
static uint32_t choose_cell(const struct view_studio *s, const struct view_order *order)
{
    struct lf_method_progress p = progress_of(s, order);
    bool traces = p.unfinished || p.samples;
    if (order->comparison != NG_COMPARE_DIFFERENCE || !traces)
        return 1;
    return (uint32_t)ceilf(fminf(sqrtf(SAMPLES_OF_A_MEAN / fmaxf((float)p.samples, 1)), MOST_CELL));
}

static bool is_progressive(const struct view_order *order)
{
    bool any = false;
    for (uint32_t i = 0; i < (order->comparison ? VIEW_SIDES : 1u); i++)
        any |= lf_method_info(order->sides[i].method)->progressive;
    return any;
}

bool view_order_antialiases(const struct view_order *order)
{
    return !order->comparison && !is_progressive(order) &&
           strcmp(ng_display_layer(order->sides[VIEW_LEFT].layer), "beauty") == 0;
}

// Where a picture can be antialiased light can be upsampled, too.
static struct view_tier *tier_of(struct view_studio *s, const struct view_order *order)
{
    bool upsamples = view_order_antialiases(order);
    struct view_tier *tier = &s->tiers[order->sides[VIEW_LEFT].method][upsamples];
    tier->upsamples = upsamples;
    return tier;
}

// A path tracer has a preview of its own.
static uint32_t choose_level(struct view_studio *s, const struct view_drawing *d)
{
    return d->moving && !is_progressive(d->order) ? tier_of(s, d->order)->level : 0;
}

static void learn_level(struct view_studio *s, const struct view_drawing *d, uint32_t level, double ms)
{
    if (d->moving)
        view_tier_add(tier_of(s, d->order), level, ms);
    else if (s->moved || s->fresh)
        view_tier_add_whole(tier_of(s, d->order), ms);
    s->moved = d->moving;
}

static ng_result draw(struct view_studio *s, const struct view_drawing *d, const struct view_pixels *pixels,
                      uint32_t cell)
{
    static const char *const layers[] = {"display"};
    const struct view_order *o = d->order;
    bool upsampled = memcmp(pixels->light, pixels->picture, sizeof pixels->light) != 0;
    const struct ng_stage_frame frame = {
        .time = o->time,
        .still = d->jumped || s->fresh,
        .width = pixels->picture[0],
        .height = pixels->picture[1],
        .light_width = upsampled ? pixels->light[0] : 0,
        .light_height = upsampled ? pixels->light[1] : 0,
        .method = lf_method_name(o->sides[VIEW_LEFT].method),
        .shown = {.layer = ng_display_layer(o->sides[VIEW_LEFT].layer),
                  .comparison = o->comparison,
                  .other_layer = ng_display_layer(o->sides[VIEW_RIGHT].layer),
                  .other_method = lf_method_name(o->sides[VIEW_RIGHT].method),
                  .divider = o->divider,
                  .cell = cell},
        .layers = layers,
        .layer_count = NG_COUNT(layers),
        .resources = ng_pick_resources,
        .resource_count = NG_COUNT(ng_pick_resources),
        .adaptation = 1 - expf(-d->seconds / ADAPTATION_S),
        .averaged = d->averaged,
        .abandon = d->abandon,
        .abandon_user = d->user,
    };
    return ng_stage_draw(s->stage, &frame);
}

// ---- What there is to say of it
// ----------------------------------------------------------------------------

// What a side shows and how far it has come: "reference, direct: 12 spp, 1.4 s, 20.1 million rays".
static void describe_side(const struct view_studio *s, const struct view_order *order, uint32_t side,
                          char *out, size_t size)
{
    const struct view_side *v = &order->sides[side];
    const char *layer = ng_display_layer(v->layer);
    char progress[128];
    lf_method_describe(s->methods[v->method], progress, sizeof progress);
    bool plain = strcmp(layer, "beauty") == 0, has = ng_renderer_shows(s->stage->renderer, side);
    snprintf(out, size, "%s%s%s%s%s%s", lf_method_name(v->method), plain ? "" : ", ", plain ? "" : layer,
             has ? "" : " (does not compute it)", progress[0] ? ": " : "", progress);
}

static ng_result list_passes(struct view_studio *s, struct view_frame *f)
{
    size_t count;
    const struct ng_pass_stats *passes = ng_graph_stats(ng_renderer_graph(s->stage->renderer), &count);
    f->passes.count = 0;
    for (size_t i = 0; i < count; i++) {
        struct view_pass pass = {.cpu_ms = passes[i].cpu_ms, .gpu_ms = passes[i].gpu_ms};
        snprintf(pass.name, sizeof pass.name, "%s", passes[i].name);
        bool ran = i >= s->runs.count || passes[i].runs != s->runs.items[i];
        if (ran && !ng_array_push(&f->passes, pass))
            return ng_out_of_memory("the list of passes");
    }
    if (!ng_array_resize(&s->runs, count))
        return ng_out_of_memory("the list of passes");
    for (size_t i = 0; i < count; i++)
        s->runs.items[i] = passes[i].runs;
    return NG_OK;
}

static ng_result list_choices(const struct view_studio *s, struct view_frame *f)
{
    const char *name;
    f->clips.count = f->cameras.count = 0;
    for (uint32_t i = 0; (name = ng_clip_menu_name(s->clips, i)); i++) {
        struct view_clip clip = {.duration = ng_clip_menu_duration(s->clips, i),
                                 .plays = ng_clip_menu_plays(s->clips, i)};
        snprintf(clip.name, sizeof clip.name, "%s", name);
        if (!ng_array_push(&f->clips, clip))
            return ng_out_of_memory("the list of clips");
    }
    for (size_t i = 0; i < s->cameras.count; i++) {
        const struct ng_name *n = ng_world_get(s->stage->world, s->cameras.items[i], NG_NAME);
        struct view_camera camera = {0};
        snprintf(camera.name, sizeof camera.name, "%s", n ? n->text : "");
        if (!ng_array_push(&f->cameras, camera))
            return ng_out_of_memory("the list of cameras");
    }
    return NG_OK;
}

static ng_result copy_pixels(const struct view_studio *s, struct view_frame *f)
{
    const uint8_t *pixels;
    NG_TRY(ng_renderer_display(s->stage->renderer, &pixels, &f->width, &f->height));
    if (!ng_array_resize(&f->pixels, (size_t)f->width * f->height * 4))
        return ng_out_of_memory("the picture");
    memcpy(f->pixels.items, pixels, f->pixels.count);
    ng_pick_remember(&f->pick, ng_renderer_graph(s->stage->renderer), s->stage->snapshot);
    return NG_OK;
}

static ng_result fill_frame(struct view_studio *s, const struct view_order *order, struct view_frame *f)
{
    NG_TRY(copy_pixels(s, f));
    NG_TRY(list_passes(s, f));
    NG_TRY(list_choices(s, f));
    for (uint32_t i = 0; i < VIEW_SIDES; i++)
        describe_side(s, order, i, f->sides[i], sizeof f->sides[i]);
    f->order = *order;
    memcpy(f->scene, s->scene, sizeof f->scene);
    f->scene_hash = s->stage->scene.hash;
    f->failed = s->failed;
    f->home = s->home;
    f->duration = (double)s->stage->scene.duration;
    f->auto_exposure = s->lens.auto_exposure;
    f->unfinished = progress_of(s, order).unfinished;
    f->samples = progress_of(s, order).samples;
    f->weights = s->weights;
    f->world_ms = s->stage->world_ms;
    f->extract_ms = s->stage->extract_ms;
    return NG_OK;
}

static void describe_tier(const struct view_drawing *d, const struct view_pixels *p, struct view_frame *f)
{
    const double share = (double)p->light[0] * p->light[1] / ((double)d->order->width * d->order->height);
    char light[64] = "";
    f->whole = p->light[0] == d->order->width && p->light[1] == d->order->height;
    memcpy(f->light, p->light, sizeof f->light);
    if (p->light[0] != p->picture[0] || p->light[1] != p->picture[1])
        snprintf(light, sizeof light, ", light %u x %u", p->light[0], p->light[1]);
    if (!f->whole)
        snprintf(f->tier, sizeof f->tier, "moving: %u x %u%s, %.0f %% of the pixels", f->width, f->height,
                 light, 100 * share);
    else if (d->averaged > 1)
        snprintf(f->tier, sizeof f->tier, "antialiased: %u pictures", d->averaged);
    else
        snprintf(f->tier, sizeof f->tier, "full resolution");
}

static ng_result make(struct view_studio *s, const struct view_drawing *d, struct view_frame *f)
{
    const struct view_order *order = d->order;
    if (order->opening != s->opening)
        NG_TRY(s->stage ? open_another(s, order) : open_first(s, order));
    s->opening = order->opening;
    bool home = follow_scene(s, order);
    follow_clip(s, order->clip);
    struct pose pose = place_camera(s, order, home);
    uint64_t start = ng_clock_ns();
    uint32_t cell = choose_cell(s, order), level = choose_level(s, d);
    const struct view_pixels pixels =
        view_tier_pixels(tier_of(s, order), level, (const uint32_t[]){order->width, order->height});
    NG_TRY(draw(s, d, &pixels, cell));
    NG_TRY(fill_frame(s, order, f));
    f->cell = cell;
    describe_tier(d, &pixels, f);
    f->averaged = d->averaged;
    f->ms = (double)(ng_clock_ns() - start) * 1e-6;
    learn_level(s, d, level, f->ms);
    f->from_home = home;
    f->order.pose = pose;
    s->looks = order->looks;
    s->fresh = false;
    s->pictures++;
    return NG_OK;
}

void view_studio_draw(struct view_studio *s, const struct view_drawing *drawing, struct view_frame *frame)
{
    frame->result = make(s, drawing, frame);
}

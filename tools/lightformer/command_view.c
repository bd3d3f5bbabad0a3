// lightformer view: a scene in a window, with a person's hands on camera and clock.
#include "commands.h"
#include "opening.h"
#include "scene_file.h"
#include "view_panels.h"
#include "view_picture.h"

#include "app/camera_controller.h"
#include "app/clip_menu.h"
#include "app/pick.h"
#include "app/playback.h"
#include "app/shader_reload.h"
#include "app/stage.h"
#include "app/watch.h"
#include "app/window.h"
#include "app/worker.h"
#include "base/file.h"
#include "base/log.h"
#include "base/result.h"
#include "base/system.h"
#include "components/camera.h"
#include "components/components.h"
#include "components/name.h"
#include "components/placement.h"
#include "components/scene_scale.h"
#include "editor/ui.h"
#include "gpu/device.h"
#include "lightformer/net/net.h"
#include "lightformer/neural/neural.h"
#include "scene/world.h"

#include <math.h>
#include <string.h>

struct view {
    const char *scene, *device, *weights, *shaders;
    uint32_t threads, method, layer, comparison, other, samples, frames;
    struct cli_size size;
    struct opening opening;
};

static const struct cli_option options[] = {
    CLI_SCENE(struct view),
    CLI_PIXELS(struct view, "960x720"),
    CLI_METHOD(struct view, method_view_option),
    CLI_WEIGHTS(struct view),
    {.name = "--layer",
     .kind = CLI_CHOICE,
     .offset = offsetof(struct view, layer),
     .value = "NAME",
     .fallback = "beauty",
     .choice = ng_display_layer,
     .doc = "what is shown"},
    {.name = "--compare",
     .kind = CLI_CHOICE,
     .offset = offsetof(struct view, comparison),
     .value = "HOW",
     .fallback = "alone",
     .choice = view_comparison_name,
     .doc = "with another method"},
    {.name = "--other",
     .kind = CLI_CHOICE,
     .offset = offsetof(struct view, other),
     .value = "NAME",
     .fallback = "reference",
     .choice = method_view_name,
     .doc = "the method to compare with"},
    {.name = "--spp",
     .kind = CLI_COUNT,
     .offset = offsetof(struct view, samples),
     .value = "N",
     .fallback = "0",
     .max = 1000000,
     .doc = "reference: rests after so many paths a pixel; 0: never"},
    {.name = "--frames",
     .kind = CLI_COUNT,
     .offset = offsetof(struct view, frames),
     .value = "N",
     .fallback = "0",
     .max = 1e9,
     .doc = "quits after so many frames; 0: never"},
    {.name = "--shaders",
     .kind = CLI_TEXT,
     .flags = CLI_READS,
     .offset = offsetof(struct view, shaders),
     .value = "FOLDER",
     .doc = "for work on engine/shaders: draws with those of a folder, anew when they change"},
    CLI_OPENING(struct view),
    CLI_THREADS(struct view),
    CLI_DEVICE(struct view),
};

static const char keys[] = VIEW_PICTURE_KEYS "left drag     orbit about what is under the pointer\n"
                                             "right drag    look around\n"
                                             "middle drag   slide\n"
                                             "wheel         nearer to it, farther; while flying: speed\n"
                                             "W A S D       fly; E up, Q down, Shift faster\n"
                                             "F, Shift+F    all of what is under the pointer; of the scene\n"
                                             "R             back to where the camera was\n"
                                             "Space         play, pause\n"
                                             "Left, Right   scrub a tenth of a second; Home: to the start\n"
                                             "F1            these keys\n"
                                             "F2, F3, F5    what to show; what each pass takes; clips\n"
                                             "F4            hide the captions\n"
                                             "drop a file   view it instead\n"
                                             "Escape        quit";

#define SCRUB_S          0.1
#define ADAPTATION_S     0.4f // in which the exposure goes most of the way to where it should be
#define TITLE_INTERVAL_S 0.25
#define LISTEN_S         0.1 // at a time
#define FRAME_SMOOTHING  0.1 // weight of the newest frame in the time that is shown

struct viewer {
    const struct view *args;
    struct ng_window *window;
    struct ng_stage *stage;
    struct ng_ui *ui;
    struct ng_watch *watch;           // on the scene's files and weights
    struct ng_shader_reload *shaders; // null: those built in
    struct ng_clip_menu *clips;
    char wanted[4096];                            // path of what was asked for last
    char scene[4096];                             // path of what is shown
    const char *weights;                          // of the network, as asked for; null: the scene's own
    bool opened;                                  // a scene has been shown
    bool failed;                                  // what was opened or changed last could not be loaded
    void *methods[METHOD_MAX];                    // states, in the order of method_of
    struct ng_camera_controller controller, home; // now; as the scene has it
    struct ng_pick pick;                          // in the last frame
    struct ng_worker *worker;                     // draws frames
    float seconds;                                // that the frame at work follows the last one by
    ng_result drawn;                              // of the frame at work
    struct ng_playback playback;
    ng_entity camera; // our own, so that neither a parent nor an animation moves it
    struct view_picture picture;
    struct view_times times;
    double frame_ms;
    double title_age_s;
    uint32_t frames;
    bool show_keys, show_choices, show_times, show_clips, hide_captions;
};

static const char camera_name[] = "lightformer:view";

static float scene_radius(const struct ng_world *world, ng_entity root)
{
    const struct ng_scene_scale *scale = ng_world_get(world, root, NG_SCENE_SCALE);
    return scale ? scale->radius : 1;
}

// A camera like the scene's own, free to move, there or where the last one was.
static ng_result create_camera(struct viewer *v, bool stay)
{
    struct ng_world *world = v->stage->world;
    ng_entity model = v->stage->scene.camera;
    const struct ng_placement *placement = ng_world_get(world, model, NG_PLACEMENT);
    struct ng_camera lens = *(const struct ng_camera *)ng_world_get(world, model, NG_CAMERA);
    bool parallel = lens.projection == NG_PROJECTION_ORTHOGRAPHIC;
    ng_camera_controller_look(&v->home, placement->matrix, scene_radius(world, v->stage->scene.root));
    ng_camera_controller_see(&v->home, parallel ? lens.height : 2 * tanf(lens.fov_y / 2), parallel);
    if (!stay)
        v->controller = v->home;
    else if (!parallel || v->controller.parallel != parallel) // else it stays as near, too
        ng_camera_controller_see(&v->controller, v->home.lens, parallel);

    struct ng_name name;
    memcpy(name.text, camera_name, sizeof camera_name);
    struct ng_transform transform = ng_camera_controller_transform(&v->controller);
    v->camera = ng_entity_create(world);
    NG_TRY(ng_world_add(world, v->camera, NG_NAME, &name));
    NG_TRY(ng_world_add(world, v->camera, NG_CAMERA, &lens));
    return ng_world_add(world, v->camera, NG_TRANSFORM, &transform);
}

// All methods are at hand; without weights for it the neural one shows nothing, unless it was asked for.
static ng_result open_methods(struct viewer *v)
{
    const struct view *args = v->args;
    struct method_params params = {
        .stage = v->stage, .scene = v->scene, .weights = v->weights, .samples = args->samples};
    const struct method *m;
    for (uint32_t i = 0; (m = method_of(METHOD_VIEW, i)); i++) {
        params.optional = v->opened || (i != args->method && !(args->comparison && i == args->other));
        NG_TRY(method_open(m, &params, &v->methods[i]));
    }
    return NG_OK;
}

static void close_methods(struct viewer *v)
{
    const struct method *m;
    for (uint32_t i = 0; (m = method_of(METHOD_VIEW, i)); i++)
        method_close(m, &v->methods[i]);
}

// ---- What is shown ---------------------------------------------------------------------------------------

static void watch_file(void *user, const char *path)
{
    (void)ng_watch_add(((struct viewer *)user)->watch, path); // without memory for it, it is not watched
}

// Besides the files that the document names.
static void watch_scene(struct viewer *v, const char *scene, const char *weights)
{
    char found[4096];
    watch_file(v, scene);
    if (weights || lf_neural_find_weights(scene, found, sizeof found))
        watch_file(v, weights ? weights : found);
}

static struct ng_stage_params stage_params(struct viewer *v, const char *scene)
{
    const struct view *args = v->args;
    struct ng_stage_params params = {
        .scene = scene, .device = args->device, .threads = args->threads, .file = watch_file, .user = v};
    opening_apply(&args->opening, &params);
    return params;
}

// What belongs to the scene on the stage, which has not run yet.
static ng_result begin_scene(struct viewer *v, bool again)
{
    watch_scene(v, v->scene, v->weights);
    NG_TRY(open_methods(v));
    NG_TRY(ng_clip_menu_create(v->stage->world, v->stage->assets, v->stage->scene.root, &v->clips));
    double time = again ? v->playback.time : 0;
    v->playback.duration = (double)v->stage->scene.duration;
    ng_playback_seek(&v->playback, time);
    NG_TRY(ng_stage_seek(v->stage, v->playback.time, NULL)); // places the scene's camera
    NG_TRY(create_camera(v, again));
    v->opened = true;
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

// Shows the scene that is wanted. What cannot be loaded changes nothing, and is tried again when its files
// change.
static ng_result open_wanted(struct viewer *v)
{
    bool again = strcmp(v->wanted, v->scene) == 0;
    const char *weights = again ? v->weights : NULL;
    struct ng_stage *next = NULL;
    struct ng_stage_params params = stage_params(v, v->wanted);
    params.no_device = true;
    ng_watch_clear(v->watch);
    v->failed = scene_file_check(v->wanted) != NG_OK || !has_good_weights(v->wanted, weights) ||
                ng_stage_create(&params, &next) != NG_OK;
    if (v->failed) {
        watch_scene(v, v->wanted, weights);
        return NG_OK;
    }
    close_methods(v);
    ng_clip_menu_destroy(&v->clips);
    NG_TRY(ng_stage_adopt(v->stage, &next));
    memcpy(v->scene, v->wanted, sizeof v->scene);
    v->weights = weights;
    return begin_scene(v, again);
}

static ng_result follow_files(struct viewer *v)
{
    const char *dropped = v->window->dropped;
    if (v->shaders)
        ng_shader_reload_update(v->shaders, v->stage->gpu);
    if (dropped)
        snprintf(v->wanted, sizeof v->wanted, "%s", dropped);
    return dropped || ng_watch_changed(v->watch) ? open_wanted(v) : NG_OK;
}

static void draw(void *user);
static void wake(void *user);

static ng_result open_viewer(struct viewer *v)
{
    const struct view *args = v->args;
    struct ng_window_params window = {
        .title = ng_path_name(args->scene), .width = args->size.width, .height = args->size.height};
    NG_TRY(scene_file_check(args->scene));
    if (!ng_file_exists(args->scene)) { // better known before there is a window
        ng_log_error("%s: cannot open: there is no such file", args->scene);
        return NG_ERROR_NOT_FOUND;
    }
    if (args->shaders)
        NG_TRY(ng_shader_reload_create(args->shaders, &v->shaders));
    NG_TRY(ng_window_create(&window, &v->window));
    NG_TRY(ng_watch_create(&v->watch));
    snprintf(v->scene, sizeof v->scene, "%s", args->scene);
    memcpy(v->wanted, v->scene, sizeof v->wanted);
    v->weights = args->weights;
    struct ng_stage_params stage = stage_params(v, v->scene);
    stage.window = v->window;
    NG_TRY(ng_stage_create(&stage, &v->stage));
    struct ng_ui_params ui = {.gpu = v->stage->gpu, .format = VK_FORMAT_R8G8B8A8_UNORM};
    NG_TRY(ng_ui_create(&ui, &v->ui));
    uint32_t other = args->other != args->method ? args->other : args->method == 0; // itself shows nothing
    v->picture = (struct view_picture){
        .sides = {{args->method, args->layer}, {other, args->layer}},
        .comparison = args->comparison,
        .divider = 0.5f,
    };
    v->playback.playing = true;
    NG_TRY(ng_worker_create(&(struct ng_worker_params){draw, wake, v}, &v->worker));
    return begin_scene(v, false);
}

static void toggle(bool *shown, unsigned pressed)
{
    *shown ^= pressed % 2;
}

// What a drag or a step of the wheel at (x, y) of the window is about.
static void take_point(struct viewer *v, const float at[2])
{
    float world[3], width = (float)v->window->width, height = (float)v->window->height;
    if (ng_pick_point(&v->pick, at[0], at[1], world))
        ng_camera_controller_take(&v->controller, world);
    else if (width > 0 && height > 0)
        ng_camera_controller_take_nothing(&v->controller, 2 * at[0] / width - 1, 2 * at[1] / height - 1,
                                          width / height);
}

static void frame_thing(struct viewer *v, const struct ng_input *input)
{
    float center[3], radius, aspect = (float)v->window->width / fmaxf((float)v->window->height, 1);
    bool thing = !input->down[NG_KEY_SHIFT] &&
                 ng_pick_thing(&v->pick, input->pointer[0], input->pointer[1], center, &radius);
    if (thing)
        ng_camera_controller_frame(&v->controller, center, radius, aspect);
    else if (v->pick.radius > 0)
        ng_camera_controller_frame(&v->controller, v->pick.center, v->pick.radius, aspect);
}

static void steer(struct viewer *v, const struct ng_input *input)
{
    if (input->pressed['R'])
        v->controller = v->home;
    if (input->pressed['F'])
        frame_thing(v, input);
    for (int b = 0; b < NG_BUTTON_COUNT; b++)
        if (input->clicked[b] && b != NG_BUTTON_RIGHT)
            take_point(v, input->grip[b]);
    if (input->scroll != 0 && !ng_camera_controller_flies(input))
        take_point(v, input->pointer);
    ng_camera_controller_update(&v->controller, input, (float)v->window->height);
}

static void react(struct viewer *v, float seconds)
{
    const struct ng_input *input = &v->window->input;
    if (input->pressed[NG_KEY_ESCAPE])
        ng_window_close(v->window);
    toggle(&v->show_keys, input->pressed[NG_KEY_F1]);
    toggle(&v->show_choices, input->pressed[NG_KEY_F1 + 1]);
    toggle(&v->show_times, input->pressed[NG_KEY_F1 + 2]);
    toggle(&v->hide_captions, input->pressed[NG_KEY_F1 + 3]);
    toggle(&v->show_clips, input->pressed[NG_KEY_F1 + 4]);

    ng_playback_advance(&v->playback, (double)seconds);
    toggle(&v->playback.playing, input->pressed[' ']);
    int scrubs = input->pressed[NG_KEY_RIGHT] - input->pressed[NG_KEY_LEFT];
    if (scrubs)
        ng_playback_scrub(&v->playback, SCRUB_S * scrubs);
    if (input->pressed[NG_KEY_HOME])
        ng_playback_seek(&v->playback, 0);

    bool on_ui = ng_ui_has_pointer(v->ui);
    view_picture_react(&v->picture, input, on_ui ? 0 : v->window->width);
    if (!on_ui && !v->picture.dragging)
        steer(v, input);
}

// A parallel view shows more from farther away only if it is made to.
static ng_result zoom_camera(struct viewer *v)
{
    struct ng_camera lens = *(const struct ng_camera *)ng_world_get(v->stage->world, v->camera, NG_CAMERA);
    if (!v->controller.parallel || v->controller.lens == lens.height)
        return NG_OK;
    lens.height = v->controller.lens;
    return ng_world_set(v->stage->world, v->camera, NG_CAMERA, &lens);
}

static ng_result move_camera(struct viewer *v)
{
    struct ng_transform transform = ng_camera_controller_transform(&v->controller);
    NG_TRY(zoom_camera(v));
    return ng_world_set(v->stage->world, v->camera, NG_TRANSFORM, &transform);
}

// What a side shows and how far it has come: "reference, direct: 12 spp, 1.4 s, 20.1 million rays". Of two
// sides the one that keys change has a mark.
static void describe_side(const struct viewer *v, uint32_t side, char *out, size_t size)
{
    const struct view_picture *p = &v->picture;
    const struct view_side *s = &p->sides[side];
    const struct method *m = method_of(METHOD_VIEW, s->method);
    const char *layer = ng_display_layer(s->layer);
    char progress[128];
    method_describe(m, v->methods[s->method], progress, sizeof progress);
    bool marked = p->comparison && p->active == side, plain = strcmp(layer, "beauty") == 0;
    bool has = ng_renderer_shows(v->stage->renderer, side);
    snprintf(out, size, "%s%s%s%s%s%s%s", marked ? "> " : "", m->name, plain ? "" : ", ", plain ? "" : layer,
             has ? "" : " (does not compute it)", progress[0] ? ": " : "", progress);
}

static void draw_captions(struct viewer *v)
{
    const float edge = 6, line = 20;
    uint32_t comparison = v->picture.comparison;
    char text[256];
    if (v->failed || (v->shaders && ng_shader_reload_failed(v->shaders)))
        ng_ui_caption(v->ui, edge, edge, "what is in the file now cannot be shown: see the terminal");
    describe_side(v, VIEW_LEFT, text, sizeof text);
    ng_ui_caption(v->ui, edge, -edge, "%s", text);
    if (!comparison)
        return;
    describe_side(v, VIEW_RIGHT, text, sizeof text);
    ng_ui_caption(v->ui, -edge, -edge - line, "%s", text); // higher, since both may be long
    if (comparison == NG_COMPARE_DIFFERENCE)
        ng_ui_caption(v->ui, -edge, edge, "orange: left is brighter; blue: darker; full colour: by %.0f %%",
                      100 * (double)NG_DIFFERENCE_FULL);
}

static struct ng_graph_ref draw_ui(void *user, struct ng_graph *graph, struct ng_graph_ref display)
{
    struct viewer *v = user;
    if (v->show_keys) {
        if (ng_ui_window_begin(v->ui, "Keys", 40, 40))
            ng_ui_text(v->ui, "%s", keys);
        ng_ui_window_end(v->ui);
    }
    if (v->show_choices)
        view_panel_picture(v->ui, &v->picture);
    if (v->show_times)
        view_panel_times(v->ui, &v->times, v->stage, v->frame_ms, v->show_choices);
    if (v->show_clips)
        view_panel_clips(v->ui, v->clips);
    if (!v->hide_captions)
        draw_captions(v);
    return ng_ui_add_pass(v->ui, graph, display);
}

// On the worker's thread.
static void draw(void *user)
{
    struct viewer *v = user;
    struct ng_stage_frame frame = {
        .time = v->playback.time,
        .still = v->playback.jumped,
        .camera = camera_name,
        .method = view_picture_method(&v->picture),
        .shown = view_picture_shown(&v->picture),
        .overlay = draw_ui,
        .overlay_user = v,
        .adaptation = 1 - expf(-v->seconds / ADAPTATION_S),
        .resources = ng_pick_resources,
        .resource_count = NG_COUNT(ng_pick_resources),
    };
    v->drawn = ng_stage_draw(v->stage, &frame);
    if (v->drawn == NG_OK)
        ng_pick_remember(&v->pick, ng_renderer_graph(v->stage->renderer), v->stage->snapshot);
}

static void wake(void *user)
{
    ng_window_wake(((struct viewer *)user)->window);
}

// A frame is drawn by another thread, so that what a person does meanwhile comes in when it happens.
static ng_result draw_and_listen(struct viewer *v, float seconds)
{
    struct ng_ui_frame ui = {v->window->width, v->window->height, seconds, &v->window->input};
    ng_ui_begin(v->ui, &ui);
    v->seconds = seconds;
    ng_worker_begin(v->worker);
    while (ng_worker_is_busy(v->worker))
        ng_window_pump(v->window, LISTEN_S);
    return v->drawn;
}

static void show_title(struct viewer *v, double seconds)
{
    v->frame_ms += FRAME_SMOOTHING * (seconds * 1e3 - v->frame_ms);
    v->title_age_s += seconds;
    if (v->title_age_s < TITLE_INTERVAL_S)
        return;
    v->title_age_s = 0;
    char title[1024], sides[VIEW_SIDES][256];
    for (uint32_t i = 0; i < VIEW_SIDES; i++)
        describe_side(v, i, sides[i], sizeof sides[i]);
    bool both = v->picture.comparison;
    // The number of frames is for those who wait until what they did can be seen (tests/view).
    snprintf(title, sizeof title, "%s - %.1f ms - %s%s%s - %s at %.2f s - frame %u", ng_path_name(v->scene),
             v->frame_ms, sides[VIEW_LEFT], both ? " | " : "", both ? sides[VIEW_RIGHT] : "",
             v->playback.playing ? "playing" : "paused", v->playback.time, v->frames);
    ng_window_set_title(v->window, title);
}

static ng_result loop(struct viewer *v)
{
    uint64_t before = ng_clock_ns();
    while (!v->window->closed && !(v->args->frames && v->frames == v->args->frames)) {
        ng_window_poll(v->window);
        uint64_t now = ng_clock_ns();
        double seconds = (double)(now - before) * 1e-9;
        before = now;
        NG_TRY(follow_files(v));
        react(v, (float)seconds);
        show_title(v, seconds);
        if (v->window->width == 0 || v->window->height == 0) {
            ng_window_wait(v->window, TITLE_INTERVAL_S);
            continue;
        }
        NG_TRY(move_camera(v));
        NG_TRY(draw_and_listen(v, (float)seconds));
        v->frames++;
    }
    return NG_OK;
}

static void close_viewer(struct viewer *v)
{
    ng_worker_destroy(&v->worker);
    ng_shader_reload_destroy(&v->shaders);
    ng_pick_finish(&v->pick);
    ng_watch_destroy(&v->watch);
    ng_clip_menu_destroy(&v->clips);
    view_times_finish(&v->times);
    ng_ui_destroy(&v->ui);
    close_methods(v);
    ng_stage_destroy(&v->stage);
    ng_window_destroy(&v->window);
}

static int run(const void *args)
{
    struct view values = *(const struct view *)args;
    if (!opening_check(&values.opening, "view"))
        return CLI_USAGE;
    values.method = method_choose(METHOD_VIEW, values.method, values.scene, values.weights);
    struct viewer v = {.args = &values};
    ng_result result = open_viewer(&v);
    if (result == NG_OK)
        result = loop(&v);
    close_viewer(&v);
    return result == NG_OK ? CLI_DONE : CLI_FAILED;
}

const struct cli_command cli_view_command = {
    .name = "view",
    .summary = "Shows a scene in a window; F1 lists the keys.",
    .notes = keys,
    .options = options,
    .option_count = NG_COUNT(options),
    .values_size = sizeof(struct view),
    .run = run,
};

// lightformer view: a scene in a window, with a person's hands on camera and clock.
#include "commands.h"
#include "opening.h"
#include "scene_file.h"
#include "view_panels.h"
#include "view_rate.h"
#include "view_shot.h"
#include "view_studio.h"

#include "app/clip_menu.h"
#include "app/playback.h"
#include "app/screen.h"
#include "app/shader_reload.h"
#include "app/watch.h"
#include "app/window.h"
#include "app/worker.h"
#include "base/file.h"
#include "base/log.h"
#include "base/result.h"
#include "base/system.h"
#include "editor/ui.h"
#include "lightformer/methods/methods.h"
#include "render/display.h"

#include <math.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <string.h>

struct view {
    const char *scene, *device, *weights, *shaders, *pose;
    uint32_t threads, method, layer, comparison, other, samples, frames, averaged;
    double time;
    struct cli_size size;
    struct opening opening;
};

static const struct cli_option options[] = {
    CLI_SCENE(struct view),
    CLI_PIXELS(struct view, "960x720"),
    CLI_METHOD(struct view, method_option),
    CLI_WEIGHTS(struct view),
    {.name = "--layer",
     .kind = CLI_CHOICE,
     .flags = CLI_PICTURE,
     .offset = offsetof(struct view, layer),
     .value = "NAME",
     .fallback = "beauty",
     .choice = ng_display_layer,
     .doc = "what is shown"},
    {.name = "--compare",
     .kind = CLI_CHOICE,
     .flags = CLI_PICTURE,
     .offset = offsetof(struct view, comparison),
     .value = "HOW",
     .fallback = "alone",
     .choice = view_comparison_name,
     .doc = "with another method"},
    {.name = "--other",
     .kind = CLI_CHOICE,
     .flags = CLI_PICTURE,
     .offset = offsetof(struct view, other),
     .value = "NAME",
     .fallback = "reference",
     .choice = lf_method_name,
     .doc = "the method to compare with"},
    {.name = "--spp",
     .kind = CLI_COUNT,
     .flags = CLI_PICTURE,
     .offset = offsetof(struct view, samples),
     .value = "N",
     .fallback = "0",
     .max = 1000000,
     .doc = "reference: rests after so many paths a pixel; 0: never"},
    {.name = "--aa",
     .kind = CLI_COUNT,
     .offset = offsetof(struct view, averaged),
     .value = "N",
     .fallback = "33",
     .min = 1,
     .max = 100000,
     .doc = "at rest: pictures that are averaged, as far as they fit into 3 s; 1: none"},
    {.name = "--time",
     .kind = CLI_REAL,
     .flags = CLI_PICTURE,
     .offset = offsetof(struct view, time),
     .value = "S",
     .max = 1e6,
     .doc = "seconds into the animation, where it is paused; if not given it plays"},
    CLI_POSE(struct view),
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

static const char keys[] =
    VIEW_PICTURE_KEYS "left drag     orbit about what is under the pointer\n"
                      "right drag    look around\n"
                      "middle drag   slide\n"
                      "wheel         nearer to it, farther; while flying: speed\n"
                      "W A S D       fly; E up, Q down, Shift faster\n"
                      "F, Shift+F    all of what is under the pointer; of the scene\n"
                      "R             back to where the camera was\n"
                      "Space         play, pause\n"
                      "Left, Right   scrub a tenth of a second; Home: to the start\n"
                      "F1            these keys\n"
                      "F2, F3, F5    what to show; what each pass takes; cameras and clips\n"
                      "F4            hide the captions\n"
                      "F11           full screen\n"
                      "F12           write the picture to NAME.0001.png, .0002 ...\n"
                      "- = 0         darker, brighter, as the scene has it\n"
                      "V             the next camera of the scene\n"
                      "drop a file   view it instead\n"
                      "save a file   scene, pictures, network: shown anew as they change\n"
                      "Escape        quit";

#define SCRUB_S          0.1
#define STILL_S          3.0        // after which a picture at rest is as smooth as it gets
#define STOPS            (1.0f / 3) // a step of the exposure
#define MOST_STOPS       16.0f
#define ADAPTED_S        2.5 // after which the exposure may as well be where it should be
#define TITLE_INTERVAL_S 0.25
#define LISTEN_S         0.25 // at a time, where nothing happens
#define FLIGHT_S         0.016
#define NEWS_S           3.0 // that a word about what a key has done stays
#define SETTLING         3   // redraws after something happened: Dear ImGui measures first

// The window's thread: it listens, steers, and says what is over the picture. Pictures are made in the studio
// by one worker, and shown by another, which may wait for the display. What they work with is ours while they
// are not busy.
struct viewer {
    const struct view *args;
    struct ng_window *window;
    struct ng_screen *screen;
    struct ng_ui *ui;
    struct ng_watch *watch;           // on the scene's files and weights
    struct ng_shader_reload *shaders; // null: those built in
    struct ng_worker *worker;
    struct view_studio *studio;
    struct view_order order; // what is wanted now
    struct view_frame shown; // what is on the screen
    struct ng_camera_controller controller;
    // Of the last step of the wheel: where the pointer was, and the camera after it.
    struct {
        float at[2];
        struct pose pose;
        bool any;
    } wheel;
    struct ng_playback playback;
    struct view_picture picture;
    struct view_rate rate;
    // Seconds: this poll's, when the order last changed, when one was handed in, when the first whole picture
    // of something at rest was.
    double now, changed, handed, rested;
    // Of the worker:
    struct view_order begun;
    struct view_frame made;
    bool jumped, moves;      // of what was begun: its time did; its camera is not where it was
    bool moving;             // it may have fewer pixels
    uint32_t averaged;       // pictures
    float seconds;           // since the one before
    bool begun_any, waiting; // something was begun, and what came of it has not been looked at
    bool again;              // what came of it is no picture, or shaders have changed since
    atomic_bool abandon;     // it is not wanted any more
    // On the screen:
    struct ng_worker *presenter;
    struct ng_screen_showing showing;
    ng_result presented;
    struct ng_input input; // of all polls since the user interface was last drawn
    double since_shown;
    bool jumps;       // the time has jumped since the last order was handed in
    uint32_t shots;   // to take of the next whole picture
    uint32_t redraws; // still to do
    uint32_t frames, mark;
    double title_set;
    char title[1024];
    char news[300]; // what a key has done that the picture does not tell
    double news_until;
    bool show_keys, show_choices, show_times, show_clips, hide_captions;
};

static bool is_shown(const struct viewer *v)
{
    return v->shown.width > 0;
}

static bool is_loading(const struct viewer *v)
{
    return !is_shown(v) || v->order.opening != v->shown.order.opening;
}

// ---- Orders
// ------------------------------------------------------------------------------------------------

static void write_order(struct viewer *v)
{
    struct view_order *o = &v->order;
    o->pose = pose_of(&v->controller);
    o->width = v->window->width;
    o->height = v->window->height;
    o->time = v->playback.time;
    memcpy(o->sides, v->picture.sides, sizeof o->sides);
    o->comparison = v->picture.comparison;
    o->divider = v->picture.divider;
}

static bool same_sides(const struct view_side *a, const struct view_side *b)
{
    for (int i = 0; i < VIEW_SIDES; i++)
        if (a[i].method != b[i].method || a[i].layer != b[i].layer)
            return false;
    return true;
}

// A clip that plays makes the next picture another one, but the one at work none that nobody wants.
static bool differs_in_more_than_time(const struct view_order *a, const struct view_order *b)
{
    return strcmp(a->scene, b->scene) != 0 || a->opening != b->opening || a->camera != b->camera ||
           a->looks != b->looks || a->clip != b->clip || !pose_same(&a->pose, &b->pose) ||
           a->stops != b->stops || a->width != b->width || a->height != b->height ||
           !same_sides(a->sides, b->sides) || a->comparison != b->comparison || a->divider != b->divider;
}

static bool same_order(const struct view_order *a, const struct view_order *b)
{
    return a->time == b->time && !differs_in_more_than_time(a, b);
}

static bool asks_for_frames(const struct viewer *v)
{
    return v->args->frames > 0;
}

// The exposure follows with time, though nothing else changes. Its last step is all of what is left.
static bool adapts(const struct viewer *v)
{
    return v->shown.auto_exposure && v->handed < v->changed + ADAPTED_S;
}

// Whether the light in two pictures is the same, pixel by pixel, however it is exposed.
static bool same_light(const struct view_order *a, const struct view_order *b)
{
    struct view_order exposed = *a;
    exposed.stops = b->stops;
    return same_order(&exposed, b);
}

// Pictures that are averaged in what is shown, to which one of the order can be added.
static uint32_t count_averaged(const struct viewer *v)
{
    bool goes_on = !v->again && v->shown.whole && same_light(&v->order, &v->begun);
    return goes_on && view_order_antialiases(&v->order) ? v->shown.averaged : 0;
}

// As many as there is time for.
static bool has_time_to_average(const struct viewer *v)
{
    return v->shown.averaged < v->args->averaged && v->now + v->shown.ms * 1e-3 <= v->rested + STILL_S;
}

static bool wants_picture(const struct viewer *v)
{
    if (!v->window->width || !v->window->height)
        return false;
    bool smoother = count_averaged(v) && has_time_to_average(v);
    return !v->begun_any || v->again || asks_for_frames(v) || !same_order(&v->order, &v->begun) ||
           v->shown.unfinished || !v->shown.whole || smoother || adapts(v);
}

// Between two orders: what costs more than showing the same light once more.
static bool has_moved(const struct view_order *a, const struct view_order *b)
{
    return a->opening == b->opening && a->looks == b->looks &&
           (a->time != b->time || !pose_same(&a->pose, &b->pose) || a->clip != b->clip ||
            a->width != b->width || a->height != b->height);
}

static bool is_unwanted(void *user)
{
    return atomic_load(&((struct viewer *)user)->abandon);
}

static void make_picture(void *user)
{
    struct viewer *v = user;
    const struct view_drawing drawing = {.order = &v->begun,
                                         .jumped = v->jumped,
                                         .moving = v->moving,
                                         .averaged = v->averaged,
                                         .seconds = v->seconds,
                                         .abandon = is_unwanted,
                                         .user = v};
    view_studio_draw(v->studio, &drawing, &v->made);
}

static void wake(void *user)
{
    ng_window_wake(((struct viewer *)user)->window);
}

// A picture that is being made is given up for the next, but not that one, too: while a camera moves,
// pictures are of where it was a moment ago, and all of them are seen.
static void give_up(struct viewer *v)
{
    if (!v->moves && !v->again && !v->shots && differs_in_more_than_time(&v->order, &v->begun))
        atomic_store(&v->abandon, true);
}

// How many pixels, and whether it joins the mean of those before.
static void choose_quality(struct viewer *v)
{
    uint32_t so_far = count_averaged(v);
    v->moving = v->begun_any && !v->shots && has_moved(&v->order, &v->begun);
    v->averaged = 0;
    if (v->moving || !view_order_antialiases(&v->order))
        return;
    v->averaged = !so_far || has_time_to_average(v) ? so_far + 1 : so_far;
    if (!so_far)
        v->rested = v->now;
}

static void hand_in(struct viewer *v)
{
    write_order(v);
    if (v->waiting) {
        give_up(v);
        return;
    }
    if (!wants_picture(v))
        return;
    bool last_step = v->now >= v->changed + ADAPTED_S;
    v->moves = v->begun_any && !pose_same(&v->order.pose, &v->begun.pose);
    choose_quality(v);
    v->seconds = last_step ? INFINITY : (float)(v->now - v->handed);
    v->jumped = v->jumps;
    v->jumps = false;
    v->handed = v->now;
    if (!v->begun_any || !same_order(&v->order, &v->begun))
        v->changed = v->now;
    v->begun = v->order;
    v->begun_any = v->waiting = true;
    atomic_store(&v->abandon, false);
    ng_worker_begin(v->worker);
}

static void take_frame(struct viewer *v)
{
    struct view_frame before = v->shown;
    v->shown = v->made;
    v->made = before; // its memory is used again
    ng_screen_take(v->screen, v->shown.pixels.items, v->shown.width, v->shown.height);
    if (v->shown.from_home) {
        v->controller = v->shown.home;
        pose_take(&v->shown.order.pose, &v->controller);
        v->begun.pose = v->shown.order.pose;
    }
    v->playback.duration = v->shown.duration;
    view_rate_add(&v->rate, v->now, v->shown.ms);
    v->redraws = SETTLING;
    v->frames++;
}

// Looks at what the worker has made, if it has, and nobody looks at the one before.
static ng_result collect(struct viewer *v)
{
    if (!v->waiting || ng_worker_is_busy(v->worker) || ng_worker_is_busy(v->presenter))
        return NG_OK;
    v->waiting = false;
    v->again = v->made.result == NG_ABANDONED;
    if (v->again)
        return NG_OK;
    NG_TRY(v->made.result);
    take_frame(v);
    return NG_OK;
}

// ---- What a person does
// ------------------------------------------------------------------------------------

static void tell(struct viewer *v, const char *fmt, ...) NG_PRINTF(2, 3);
static void tell(struct viewer *v, const char *fmt, ...)
{
    va_list args;
    va_start(args, fmt);
    vsnprintf(v->news, sizeof v->news, fmt, args);
    va_end(args);
    v->news_until = v->now + NEWS_S;
    v->redraws = SETTLING;
}

static void toggle(bool *shown, unsigned pressed)
{
    *shown ^= pressed % 2;
}

// From pixels of the window to those of the last picture's things, which are as many as light was computed
// for.
static void to_picture(const struct viewer *v, const float at[2], float out[2])
{
    out[0] = at[0] * (float)v->shown.pick.width / fmaxf((float)v->window->width, 1);
    out[1] = at[1] * (float)v->shown.pick.height / fmaxf((float)v->window->height, 1);
}

// What a drag or a step of the wheel at (x, y) of the window is about.
static void take_point(struct viewer *v, const float at[2])
{
    float world[3], in_picture[2], width = (float)v->window->width, height = (float)v->window->height;
    to_picture(v, at, in_picture);
    if (ng_pick_point(&v->shown.pick, in_picture[0], in_picture[1], world))
        ng_camera_controller_take(&v->controller, world);
    else if (width > 0 && height > 0)
        ng_camera_controller_take_nothing(&v->controller, 2 * at[0] / width - 1, 2 * at[1] / height - 1,
                                          width / height);
}

static void frame_thing(struct viewer *v, const struct ng_input *input)
{
    const struct ng_pick *pick = &v->shown.pick;
    float center[3], at[2], radius, aspect = (float)v->window->width / fmaxf((float)v->window->height, 1);
    to_picture(v, input->pointer, at);
    if (!input->shifted['F'] && ng_pick_thing(pick, at[0], at[1], center, &radius))
        ng_camera_controller_frame(&v->controller, center, radius, aspect);
    else if (pick->radius > 0)
        ng_camera_controller_frame(&v->controller, pick->center, pick->radius, aspect);
}

// Steps of the wheel in one place are about one point: what is under the pointer stays there, and pictures in
// motion know it less well.
static bool goes_on_about_point(const struct viewer *v, const struct ng_input *input)
{
    const struct pose pose = pose_of(&v->controller);
    return v->wheel.any && v->wheel.at[0] == input->pointer[0] && v->wheel.at[1] == input->pointer[1] &&
           pose_same(&v->wheel.pose, &pose);
}

static void steer(struct viewer *v, const struct ng_input *input)
{
    bool scrolls = input->scroll != 0 && !ng_camera_controller_flies(input);
    for (int b = 0; b < NG_BUTTON_COUNT; b++)
        if (input->clicked[b] && b != NG_BUTTON_RIGHT)
            take_point(v, input->grip[b]);
    if (scrolls && !goes_on_about_point(v, input))
        take_point(v, input->pointer);
    float speed = v->controller.speed;
    ng_camera_controller_update(&v->controller, input, (float)v->window->height);
    if (scrolls) {
        v->wheel.any = true;
        v->wheel.pose = pose_of(&v->controller);
        memcpy(v->wheel.at, input->pointer, sizeof v->wheel.at);
    }
    if (v->controller.speed != speed)
        tell(v, "flies %.3g m/s", (double)v->controller.speed);
}

static void next_camera(struct viewer *v, uint32_t steps)
{
    size_t count = v->shown.cameras.count;
    if (!count || !steps)
        return;
    v->order.camera = (uint32_t)((v->order.camera + steps) % count);
    v->order.looks++;
}

static void react_to_clock(struct viewer *v, const struct ng_input *input, double seconds)
{
    if (v->playback.duration > 0) // else time changes nothing
        ng_playback_advance(&v->playback, seconds);
    toggle(&v->playback.playing, input->pressed[' ']);
    int scrubs = input->pressed[NG_KEY_RIGHT] - input->pressed[NG_KEY_LEFT];
    if (scrubs)
        ng_playback_scrub(&v->playback, SCRUB_S * scrubs);
    if (input->pressed[NG_KEY_HOME])
        ng_playback_seek(&v->playback, 0);
    v->jumps |= v->playback.jumped;
}

// What the picture would be asked for by.
static bool write_command(const struct viewer *v, char *out, size_t size)
{
    const struct view_frame *f = &v->shown;
    const struct view_order *o = &f->order;
    const struct view_side *left = &o->sides[VIEW_LEFT];
    char pose[POSE_TEXT];
    pose_write(&o->pose, pose);
    struct view all = *v->args;
    all.scene = f->scene;
    all.weights = f->weights;
    all.pose = pose;
    all.method = left->method;
    all.layer = left->layer;
    all.comparison = o->comparison;
    all.other = o->sides[VIEW_RIGHT].method;
    all.samples = f->samples;
    all.time = o->time;
    all.size = (struct cli_size){f->width, f->height};
    all.opening.stops = (double)o->stops;
    all.opening.clip = view_clip_option(f, all.opening.clip);
    const struct render_picture plain = {.scene = all.scene,
                                         .weights = all.weights,
                                         .pose = pose,
                                         .method = lf_method_name(all.method),
                                         .size = all.size,
                                         .time = all.time,
                                         .samples = f->averaged ? f->averaged : all.samples,
                                         .antialias = f->averaged > 0,
                                         .opening = all.opening};
    if (!o->comparison && strcmp(ng_display_layer(left->layer), "beauty") == 0)
        return render_canonical(&plain, out, size);
    return cli_canonical(&cli_view_command, &all, out, size);
}

// What goes wrong is said in the log, and in the caption.
static void take_shot(struct viewer *v)
{
    char command[2048];
    if (!write_command(v, command, sizeof command))
        snprintf(command, sizeof command, "lightformer view %s", ng_path_name(v->shown.scene));
    char said[300];
    bool written = view_shot_write(&v->shown, command, said, sizeof said) == NG_OK;
    tell(v, "%s", written ? said : "the picture could not be written: see the terminal");
}

// Of a picture with all its pixels; the next one has them.
static void take_shots(struct viewer *v)
{
    for (; v->shots && is_shown(v) && v->shown.whole; v->shots--)
        take_shot(v);
}

static void react_to_keys(struct viewer *v, const struct ng_input *input)
{
    if (input->pressed[NG_KEY_ESCAPE])
        ng_window_close(v->window);
    toggle(&v->show_keys, input->pressed[NG_KEY_F1]);
    toggle(&v->show_choices, input->pressed[NG_KEY_F1 + 1]);
    toggle(&v->show_times, input->pressed[NG_KEY_F1 + 2]);
    toggle(&v->hide_captions, input->pressed[NG_KEY_F1 + 3]);
    toggle(&v->show_clips, input->pressed[NG_KEY_F1 + 4]);
    v->mark += input->pressed[NG_KEY_F1 + 8];
    v->shots += is_shown(v) ? (uint32_t)input->pressed[NG_KEY_F1 + 11] : 0;
    if (input->pressed[NG_KEY_F1 + 10] % 2)
        ng_window_set_full_screen(v->window, !ng_window_is_full_screen(v->window));
    float stops = v->order.stops + STOPS * (float)(input->pressed['='] - input->pressed['-']);
    v->order.stops = input->pressed['0'] ? 0 : fminf(fmaxf(stops, -MOST_STOPS), MOST_STOPS);
    if (input->pressed['0'] || input->pressed['='] || input->pressed['-'])
        tell(v, "exposure %+.1f EV", (double)v->order.stops);
    if (input->pressed['R'])
        v->controller = v->shown.home;
    if (input->pressed['F'])
        frame_thing(v, input);
    next_camera(v, input->pressed['V']);
}

static void react(struct viewer *v, double seconds)
{
    const struct ng_input *input = &v->window->input;
    bool on_ui = ng_ui_has_pointer(v->ui);
    ng_input_add(&v->input, input);
    react_to_clock(v, input, seconds);
    react_to_keys(v, input);
    view_picture_react(&v->picture, input, on_ui ? 0 : v->window->width);
    if (!on_ui && !v->picture.dragging)
        steer(v, input);
    if (v->news_until > 0 && v->now >= v->news_until) {
        v->news_until = 0;
        v->redraws = SETTLING;
    }
    if (v->window->stirred)
        v->redraws = SETTLING;
}

static void follow_files(struct viewer *v)
{
    const char *dropped = v->window->dropped;
    bool another = dropped && strcmp(dropped, v->order.scene) != 0;
    if (!dropped && !ng_watch_changed(v->watch))
        return;
    v->order.opening++;
    if (!another)
        return;
    memset(v->order.scene, 0, sizeof v->order.scene); // orders are compared as bytes
    snprintf(v->order.scene, sizeof v->order.scene, "%s", dropped);
    v->order.clip = NG_CLIPS_FIRST;
    v->order.camera = 0;
    ng_playback_seek(&v->playback, 0);
}

// Between two pictures the studio's device is ours.
static void follow_shaders(struct viewer *v)
{
    struct ng_gpu *gpu = v->waiting ? NULL : view_studio_gpu(v->studio);
    if (v->shaders && gpu)
        v->again |= ng_shader_reload_update(v->shaders, gpu);
}

// ---- What is over the picture
// ------------------------------------------------------------------------------

// With a mark if keys change it.
static void describe_side(const struct viewer *v, uint32_t side, char *out, size_t size)
{
    const struct view_picture *p = &v->picture;
    bool marked = p->comparison && p->active == side;
    snprintf(out, size, "%s%s", marked ? "> " : "", v->shown.sides[side]);
}

// Captions from the top down, or from the bottom up.
struct stack {
    struct ng_ui *ui;
    float y;
};

static void add_caption(struct stack *stack, bool right, const char *text)
{
    const float edge = 6, gap = 2;
    float height = ng_ui_caption(stack->ui, right ? -edge : edge, stack->y, "%s", text);
    stack->y += stack->y < 0 ? -(height + gap) : height + gap;
}

static void draw_news(struct viewer *v, struct stack *top)
{
    char text[300];
    snprintf(text, sizeof text, "loading %s", ng_path_name(v->order.scene));
    if (is_loading(v))
        add_caption(top, false, text);
    else if (v->shown.failed || (v->shaders && ng_shader_reload_failed(v->shaders)))
        add_caption(top, false, "what is in the file now cannot be shown: see the terminal");
    if (v->now < v->news_until)
        add_caption(top, false, v->news);
}

static void explain_difference(struct viewer *v, struct stack *top)
{
    char text[128];
    snprintf(text, sizeof text, "orange: left is brighter; blue: darker; full colour: by %.0f %%",
             100 * (double)NG_DIFFERENCE_FULL);
    add_caption(top, true, text);
    snprintf(text, sizeof text, "%u spp so far: means over %u x %u pixels", v->shown.samples, v->shown.cell,
             v->shown.cell);
    if (v->shown.cell > 1)
        add_caption(top, true, text);
}

static void draw_captions(struct viewer *v)
{
    struct stack top = {v->ui, 6}, bottom = {v->ui, -6};
    uint32_t comparison = v->shown.order.comparison;
    char text[300];
    draw_news(v, &top);
    if (!is_shown(v))
        return;
    if (comparison == NG_COMPARE_DIFFERENCE)
        explain_difference(v, &top);
    describe_side(v, VIEW_LEFT, text, sizeof text);
    add_caption(&bottom, false, text);
    describe_side(v, VIEW_RIGHT, text, sizeof text);
    if (comparison)
        add_caption(&bottom, true, text); // higher, since both may be long
}

static void draw_panels(struct viewer *v)
{
    if (v->show_keys) {
        if (ng_ui_window_begin(v->ui, "Keys"))
            ng_ui_text(v->ui, "%s", keys);
        ng_ui_window_end(v->ui);
    }
    if (v->show_choices)
        view_panel_picture(v->ui, &v->picture, &v->order.stops, MOST_STOPS);
    if (v->show_times)
        view_panel_times(v->ui, &v->shown);
    if (v->show_clips)
        view_panel_scene(v->ui, &v->shown, &v->order);
    if (!v->hide_captions)
        draw_captions(v);
}

static struct ng_graph_ref add_ui(void *user, struct ng_graph *graph, struct ng_graph_ref display)
{
    return ng_ui_add_pass(((struct viewer *)user)->ui, graph, display);
}

static void present(void *user)
{
    struct viewer *v = user;
    v->presented = ng_screen_show(v->screen, &v->showing);
}

static ng_result show(struct viewer *v, double seconds)
{
    v->since_shown += seconds;
    if (ng_worker_is_busy(v->presenter))
        return NG_OK;
    NG_TRY(v->presented);
    if (!v->redraws || !v->window->width || !v->window->height)
        return NG_OK;
    v->redraws--;
    struct ng_ui_frame ui = {v->window->width, v->window->height, (float)v->since_shown, &v->input};
    ng_ui_begin(v->ui, &ui);
    draw_panels(v);
    ng_ui_end(v->ui);
    v->since_shown = 0;
    ng_input_begin(&v->input);
    v->showing = (struct ng_screen_showing){v->window->width, v->window->height, add_ui, v};
    ng_worker_begin(v->presenter);
    return NG_OK;
}

// Whether all that was asked for is there.
static bool is_at_rest(const struct viewer *v)
{
    return !v->waiting && !wants_picture(v);
}

static void write_title(const struct viewer *v, char *out, size_t size)
{
    const struct view_figures f = view_rate_of(&v->rate, v->now);
    const char *name = ng_path_name(is_shown(v) ? v->shown.scene : v->order.scene);
    char sides[VIEW_SIDES][300], pace[32], clock[64] = "", mark[32] = "";
    if (!is_shown(v)) {
        snprintf(out, size, "%s - loading", name);
        return;
    }
    for (uint32_t i = 0; i < VIEW_SIDES; i++)
        describe_side(v, i, sides[i], sizeof sides[i]);
    snprintf(pace, sizeof pace, "%u fps", f.fps);
    if (v->playback.duration > 0)
        snprintf(clock, sizeof clock, " - %s at %.2f s", v->playback.playing ? "playing" : "paused",
                 v->playback.time);
    if (v->mark) // for tests: what was pressed before the key F9 has been taken in
        snprintf(mark, sizeof mark, " - mark %u", v->mark);
    bool both = v->shown.order.comparison;
    snprintf(out, size, "%s - %s, %.1f ms - %s - %s%s%s%s - F1: keys - frame %u%s", name,
             is_at_rest(v) ? "at rest" : pace, f.ms, v->shown.tier, sides[VIEW_LEFT], both ? " | " : "",
             both ? sides[VIEW_RIGHT] : "", clock, v->frames, mark);
}

// Figures that change in every frame can be read if they change a few times a second.
static void show_title(struct viewer *v)
{
    char title[sizeof v->title];
    bool rests = is_at_rest(v) && !v->redraws && !ng_worker_is_busy(v->presenter);
    if (!rests && v->now - v->title_set < TITLE_INTERVAL_S)
        return;
    write_title(v, title, sizeof title);
    if (strcmp(title, v->title) == 0)
        return;
    memcpy(v->title, title, sizeof title);
    v->title_set = v->now;
    ng_window_set_title(v->window, title);
}

// ---- The whole
// ---------------------------------------------------------------------------------------------

static ng_result open_screen(struct viewer *v)
{
    const struct view *args = v->args;
    struct ng_window_params window = {
        .title = ng_path_name(args->scene), .width = args->size.width, .height = args->size.height};
    NG_TRY(ng_window_create(&window, &v->window));
    NG_TRY(ng_screen_create(&(struct ng_screen_params){.window = v->window, .device = args->device},
                            &v->screen));
    NG_TRY(ng_worker_create(&(struct ng_worker_params){present, wake, v}, &v->presenter));
    return ng_ui_create(&(struct ng_ui_params){.gpu = v->screen->gpu, .format = VK_FORMAT_R8G8B8A8_UNORM},
                        &v->ui);
}

static ng_result open_studio(struct viewer *v)
{
    const struct view *args = v->args;
    NG_TRY(ng_watch_create(&v->watch));
    struct view_studio_params studio = {.device = args->device,
                                        .weights = args->weights,
                                        .pose = args->pose,
                                        .threads = args->threads,
                                        .samples = args->samples,
                                        .method = args->method,
                                        .other = args->other,
                                        .compares = args->comparison,
                                        .opening = &args->opening,
                                        .watch = v->watch};
    NG_TRY(view_studio_create(&studio, &v->studio));
    return ng_worker_create(&(struct ng_worker_params){make_picture, wake, v}, &v->worker);
}

static ng_result open_viewer(struct viewer *v)
{
    const struct view *args = v->args;
    NG_TRY(scene_file_check(args->scene));
    if (!ng_file_exists(args->scene)) { // better known before there is a window
        ng_log_error("%s: cannot open: there is no such file", args->scene);
        return NG_ERROR_NOT_FOUND;
    }
    if (args->shaders)
        NG_TRY(ng_shader_reload_create(args->shaders, &v->shaders));
    uint32_t other = args->other != args->method ? args->other : args->method == 0; // itself shows nothing
    v->picture = (struct view_picture){
        .sides = {{args->method, args->layer}, {other, args->layer}},
        .comparison = args->comparison,
        .divider = 0.5f,
    };
    v->playback.playing = args->time <= 0;
    v->playback.time = args->time;
    v->order.stops = (float)args->opening.stops;
    v->order.clip = NG_CLIPS_FIRST;
    v->order.opening = 1;
    snprintf(v->order.scene, sizeof v->order.scene, "%s", args->scene);
    v->redraws = SETTLING;
    NG_TRY(open_screen(v));
    return open_studio(v);
}

// How long nothing needs to be done unless something happens.
static double patience(const struct viewer *v)
{
    if (!v->window->width || !v->window->height) // minimised
        return LISTEN_S;
    if (v->redraws && !ng_worker_is_busy(v->presenter))
        return 0;
    return ng_camera_controller_flies(&v->window->input) ? FLIGHT_S : LISTEN_S;
}

static double clock_s(void)
{
    return (double)ng_clock_ns() * 1e-9;
}

static ng_result loop(struct viewer *v)
{
    v->now = clock_s();
    while (!v->window->closed && !(asks_for_frames(v) && v->frames >= v->args->frames)) {
        ng_window_wait(v->window, patience(v));
        double seconds = clock_s() - v->now;
        v->now += seconds;
        follow_files(v);
        NG_TRY(collect(v));
        react(v, seconds);
        take_shots(v);
        follow_shaders(v);
        hand_in(v);
        NG_TRY(show(v, seconds));
        show_title(v);
    }
    return NG_OK;
}

static void close_viewer(struct viewer *v)
{
    if (v->window)
        ng_window_hide(v->window); // a scene may still be loading
    atomic_store(&v->abandon, true);
    ng_worker_destroy(&v->worker);
    ng_worker_destroy(&v->presenter);
    ng_shader_reload_destroy(&v->shaders);
    view_studio_destroy(&v->studio);
    ng_watch_destroy(&v->watch);
    view_frame_finish(&v->shown);
    view_frame_finish(&v->made);
    ng_ui_destroy(&v->ui);
    ng_screen_destroy(&v->screen);
    ng_window_destroy(&v->window);
}

static int run(const void *args)
{
    struct view values = *(const struct view *)args;
    if (!opening_check(&values.opening, "view") || !pose_check(values.pose, "view"))
        return CLI_USAGE;
    values.method = method_choose(method_option(values.method), values.scene, values.weights);
    static struct viewer v; // large
    memset(&v, 0, sizeof v);
    v.args = &values;
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

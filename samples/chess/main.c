// Chess: the program to read first. It loads a scene, plays its animation, and draws it, in a window
//
//     chess
//
// or, where there is no display, to numbered pictures:
//
//     chess --headless --frames 60 --out out/chess
//
// With --neural a network gives all light, instead of the direct light that is rasterized without it.
//
// A stage (app/stage.h) holds one of each part of the engine, and draws frames with them. Errors are logged
// where they happen, by name and with the reason; here they are only passed on.
#include "app/playback.h"
#include "app/stage.h"
#include "app/window.h"
#include "asset/png.h"
#include "base/file.h"
#include "base/interrupt.h"
#include "base/printable.h"
#include "base/result.h"
#include "base/system.h"
#include "lightformer/methods/methods.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FRAMES_A_SECOND 30.0

struct options {
    const char *scene, *out, *weights;
    bool headless, neural;
    int frames;
};

// What is on show: the scene, and the method that lights it.
struct show {
    struct ng_stage *stage;
    struct lf_method *method;
    const char *method_name;
};

// A method joins the renderer under its name; frames ask for it by that.
static ng_result open_show(struct show *s, const struct options *o, struct ng_window *window)
{
    *s = (struct show){.method_name = o->neural ? "neural" : "raster"};
    NG_TRY(ng_stage_create(&(struct ng_stage_params){.scene = o->scene, .window = window}, &s->stage));
    const struct lf_method_params method = {.name = s->method_name,
                                            .composer = ng_renderer_composer(s->stage->renderer),
                                            .jobs = s->stage->jobs,
                                            .weights = o->weights};
    return lf_method_create(&method, &s->method);
}

static void close_show(struct show *s)
{
    lf_method_destroy(&s->method);
    ng_stage_destroy(&s->stage);
}

// In a window: time goes on as it does outside, until somebody presses Escape or closes it.
static ng_result play(const struct options *o)
{
    struct ng_window *window;
    struct show show;
    NG_TRY(
        ng_window_create(&(struct ng_window_params){.title = "Chess", .width = 960, .height = 720}, &window));
    ng_result result = open_show(&show, o, window);

    struct ng_playback playback = {.playing = true};
    uint64_t before_ns = ng_clock_ns();
    if (result == NG_OK)
        playback.duration = (double)show.stage->scene.duration;
    while (result == NG_OK && !window->closed) {
        uint64_t now_ns = ng_clock_ns();
        ng_playback_advance(&playback, (double)(now_ns - before_ns) * 1e-9);
        before_ns = now_ns;

        ng_window_poll(window);
        if (window->input.pressed[NG_KEY_ESCAPE])
            ng_window_close(window);
        result = ng_stage_draw(show.stage, &(struct ng_stage_frame){.time = playback.time,
                                                                    .still = playback.jumped,
                                                                    .method = show.method_name});
    }
    close_show(&show);
    ng_window_destroy(&window);
    return result;
}

// DIR/chess.0007.png
static void name_frame(const struct options *o, int number, char *out, size_t size)
{
    snprintf(out, size, "%s/chess.%04d.png", o->out, number);
}

// Draws one frame and writes what a display would show.
static ng_result write_frame(const struct show *show, const struct options *o, int number)
{
    static const char *const layers[] = {"display"};
    NG_TRY(ng_stage_draw(show->stage, &(struct ng_stage_frame){
                                          .time = number / FRAMES_A_SECOND,
                                          .width = 512,
                                          .height = 512,
                                          .method = show->method_name,
                                          .layers = layers,
                                          .layer_count = 1,
                                      }));
    struct ng_png_params png = {0};
    const uint8_t *pixels;
    NG_TRY(ng_renderer_display(show->stage->renderer, &pixels, &png.width, &png.height));
    png.pixels = pixels;

    char path[4096];
    name_frame(o, number, path, sizeof path);
    NG_TRY(ng_png_write(path, &png));
    puts(path);
    return NG_OK;
}

// Without a display: every frame is drawn, however long it takes.
static ng_result record(const struct options *o)
{
    struct show show;
    NG_TRY(ng_file_make_directory(o->out));
    ng_result result = open_show(&show, o, NULL);
    for (int i = 0; i < o->frames && result == NG_OK; i++)
        result = write_frame(&show, o, i);
    close_show(&show);
    return result;
}

static bool parse(int argc, char **argv, struct options *o)
{
    *o = (struct options){.scene = "content/chess/chess.glb",
                          .weights = "content/chess/chess.weights.safetensors",
                          .out = "out",
                          .frames = 1};
    for (int i = 1; i < argc; i++) {
        const char *value = i + 1 < argc ? argv[i + 1] : NULL;
        if (strcmp(argv[i], "--headless") == 0) {
            o->headless = true;
            continue;
        }
        if (strcmp(argv[i], "--neural") == 0) {
            o->neural = true;
            continue;
        }
        if (strcmp(argv[i], "--frames") == 0 && value && atoi(value) > 0)
            o->frames = atoi(value);
        else if (strcmp(argv[i], "--out") == 0 && value)
            o->out = value;
        else if (strcmp(argv[i], "--scene") == 0 && value)
            o->scene = value;
        else if (strcmp(argv[i], "--weights") == 0 && value)
            o->weights = value;
        else
            return false;
        i++;
    }
    return true;
}

// No frame may take the place of what it is drawn from.
static bool frames_are_others(const struct options *o)
{
    char path[4096];
    for (int i = 0; o->headless && i < o->frames; i++) {
        name_frame(o, i, path, sizeof path);
        if (!ng_file_same(path, o->scene) && !ng_file_same(path, o->weights))
            continue;
        ng_print_line(stderr, "chess: %s would be written over the scene or its weights; give another --out",
                      path);
        return false;
    }
    return true;
}

int main(int argc, char **argv)
{
    struct options o;
    ng_interrupt_watch();
    if (!parse(argc, argv, &o)) {
        bool help = argc == 2 && strcmp(argv[1], "--help") == 0;
        fputs(
            "usage: chess [--scene FILE] [--neural [--weights FILE]] [--headless [--frames N] [--out DIR]]\n",
            help ? stdout : stderr);
        return help ? 0 : 2;
    }
    if (!frames_are_others(&o))
        return 2;
    return (o.headless ? record(&o) : play(&o)) == NG_OK ? 0 : 1;
}

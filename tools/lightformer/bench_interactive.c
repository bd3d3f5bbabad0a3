// The studio of `view` gets the orders that a person's hands would make: a camera that turns, a clip that
// plays; then nothing more.
#include "bench_interactive.h"

#include "json.h"
#include "view_studio.h"

#include "app/clip_menu.h"
#include "app/watch.h"
#include "base/file.h"
#include "base/system.h"
#include "lightformer/methods/methods.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define WARM_UP       8 // pictures in which the tier settles
#define LEAST         5 // that are measured
#define MEASURE_S     2.0
#define TURN          0.004f // radians from picture to picture
#define FRAME_S       (1 / 30.0)
#define STILL_S       3.0 // as in command_view.c
#define MOST_AVERAGED 33

enum motion { CAMERA, CLIP, MOTIONS };
static const char *const motions[MOTIONS] = {[CAMERA] = "camera", [CLIP] = "clip"};

static const uint32_t sizes[][2] = {{640, 360}, {1280, 720}, {1920, 1080}};

struct session {
    struct view_studio *studio;
    struct view_order order;
    struct view_frame frame;
};

struct row {
    const uint32_t *size;
    const char *motion;
    uint32_t moving[2], light[2]; // pixels while it moves, and those that light is computed for
    double fps, worst_ms;
    double response_ms, whole_ms; // from an edit to the first picture, to that of all pixels
    uint32_t averaged;            // pictures, STILL_S after it
};

static double seconds(void)
{
    return (double)ng_clock_ns() * 1e-9;
}

static ng_result draw(struct session *s, bool moving, uint32_t averaged)
{
    const struct view_drawing drawing = {
        .order = &s->order, .moving = moving, .averaged = averaged, .seconds = INFINITY};
    view_studio_draw(s->studio, &drawing, &s->frame);
    s->order.pose = s->frame.order.pose;
    return s->frame.result;
}

static ng_result draw_moved(struct session *s, enum motion motion)
{
    if (motion == CAMERA)
        s->order.pose.yaw += TURN;
    else
        s->order.time = fmod(s->order.time + FRAME_S, s->frame.duration);
    return draw(s, true, 0);
}

static ng_result measure_motion(struct session *s, enum motion motion, struct row *row)
{
    uint32_t count = 0;
    for (int i = 0; i < WARM_UP; i++)
        NG_TRY(draw_moved(s, motion));
    double start = seconds(), now = start, before;
    for (; count < LEAST || now - start < MEASURE_S; count++) {
        before = now;
        NG_TRY(draw_moved(s, motion));
        now = seconds();
        row->worst_ms = fmax(row->worst_ms, (now - before) * 1e3);
    }
    row->fps = count / (now - start);
    row->moving[0] = s->frame.width;
    row->moving[1] = s->frame.height;
    memcpy(row->light, s->frame.light, sizeof row->light);
    return NG_OK;
}

// As `view` does it when it rests: one more in motion, one of all pixels, then as many as fit.
static ng_result measure_rest(struct session *s, enum motion motion, struct row *row)
{
    bool antialiases = view_order_antialiases(&s->order);
    double start = seconds();
    NG_TRY(draw_moved(s, motion));
    double rested = seconds();
    NG_TRY(draw(s, false, antialiases));
    row->response_ms = (rested - start) * 1e3;
    row->whole_ms = (seconds() - start) * 1e3;
    row->averaged = 1;
    while (antialiases && row->averaged < MOST_AVERAGED && seconds() + s->frame.ms * 1e-3 <= rested + STILL_S)
        NG_TRY(draw(s, false, ++row->averaged));
    return NG_OK;
}

// ---- What is said
// --------------------------------------------------------------------------------------------

static double share(const struct row *r)
{
    return (double)r->light[0] * r->light[1] / ((double)r->size[0] * r->size[1]);
}

static void print_head(const struct bench_interactive_params *p)
{
    printf("%s, %s\n", ng_path_name(p->scene), lf_method_name(p->method));
    printf(
        "window       moves    pictures/s  slowest ms  picture      light               first ms  whole ms  "
        "antialiased\n");
}

static void print_row(const struct row *r)
{
    printf("%4u x %-4u  %-7s %10.1f %11.0f   %4u x %-4u %4u x %-4u %5.1f %% %9.0f %9.0f %12u\n", r->size[0],
           r->size[1], r->motion, r->fps, r->worst_ms, r->moving[0], r->moving[1], r->light[0], r->light[1],
           100 * share(r), r->response_ms, r->whole_ms, r->averaged);
    fflush(stdout);
}

static void write_row(struct json *j, const struct row *r)
{
    json_object(j, NULL);
    json_number(j, "width", r->size[0]);
    json_number(j, "height", r->size[1]);
    json_text(j, "moves", r->motion);
    json_number(j, "pictures_s", r->fps);
    json_number(j, "slowest_ms", r->worst_ms);
    json_number(j, "moving_width", r->moving[0]);
    json_number(j, "moving_height", r->moving[1]);
    json_number(j, "light_width", r->light[0]);
    json_number(j, "light_height", r->light[1]);
    json_number(j, "first_ms", r->response_ms);
    json_number(j, "whole_ms", r->whole_ms);
    json_number(j, "averaged", r->averaged);
    json_end(j);
    fflush(j->out);
}

// ---- The whole
// -----------------------------------------------------------------------------------------------

static ng_result measure(struct session *s, const uint32_t *size, enum motion motion, struct row *row)
{
    *row = (struct row){.size = size, .motion = motions[motion]};
    s->order.width = size[0];
    s->order.height = size[1];
    NG_TRY(draw(s, false, 0));
    NG_TRY(measure_motion(s, motion, row));
    return measure_rest(s, motion, row);
}

static ng_result measure_all(const struct bench_interactive_params *p, struct session *s, struct json *j)
{
    const uint32_t one[] = {p->size.width, p->size.height};
    for (size_t i = 0; i < (one[0] ? 1 : NG_COUNT(sizes)); i++)
        for (enum motion m = CAMERA; m < MOTIONS; m++) {
            struct row row;
            if (m == CLIP && s->frame.duration <= 0)
                continue;
            NG_TRY(measure(s, one[0] ? one : sizes[i], m, &row));
            if (j)
                write_row(j, &row);
            else
                print_row(&row);
        }
    return NG_OK;
}

static ng_result open_session(const struct bench_interactive_params *p, struct ng_watch *watch,
                              struct session *s)
{
    const struct view_studio_params params = {.device = p->device,
                                              .weights = p->weights,
                                              .threads = p->threads,
                                              .method = p->method,
                                              .other = p->method,
                                              .opening = p->opening,
                                              .watch = watch};
    snprintf(s->order.scene, sizeof s->order.scene, "%s", p->scene);
    s->order.opening = 1;
    s->order.clip = NG_CLIPS_FIRST;
    s->order.stops = (float)p->opening->stops;
    s->order.sides[VIEW_LEFT].method = s->order.sides[VIEW_RIGHT].method = p->method;
    s->order.width = 64; // to open it
    s->order.height = 36;
    NG_TRY(view_studio_create(&params, &s->studio));
    return draw(s, false, 0);
}

ng_result bench_interactive(const struct bench_interactive_params *p)
{
    static struct session s; // large
    struct json j = {.out = stdout};
    struct ng_watch *watch;
    memset(&s, 0, sizeof s);
    NG_TRY(ng_watch_create(&watch));
    ng_result result = open_session(p, watch, &s);
    if (result == NG_OK && p->json) {
        json_object(&j, NULL);
        json_text(&j, "scene", ng_path_name(p->scene));
        json_text(&j, "method", lf_method_name(p->method));
        json_array(&j, "windows");
    } else if (result == NG_OK) {
        print_head(p);
    }
    bool begun = result == NG_OK;
    if (begun)
        result = measure_all(p, &s, p->json ? &j : NULL);
    if (begun && p->json) {
        json_end(&j);
        json_end(&j);
    }
    view_studio_destroy(&s.studio);
    view_frame_finish(&s.frame);
    ng_watch_destroy(&watch);
    return result;
}

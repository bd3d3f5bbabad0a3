// Each frame is compared with the one before it, moved along the motion of what is seen (as the temporal
// error of tools/eval does), in the bytes that a display shows. A steady error costs nothing.
#include "bench_flicker.h"

#include "json.h"
#include "opening.h"
#include "pose.h"
#include "progress.h"
#include "render_reference.h"

#include "app/camera_controller.h"
#include "app/stage.h"
#include "base/array.h"
#include "base/file.h"
#include "base/log.h"
#include "components/camera.h"
#include "components/components.h"
#include "components/transform.h"
#include "lightformer/methods/methods.h"
#include "scene/world.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FRAMES  60
#define SAMPLES 64u    // of the path tracer, a pixel
#define TURN    0.003f // radians from frame to frame
#define STEP    0.004f // of a lamp, in radii of the scene
#define WIDTH   160u
#define HEIGHT  90u

enum motion { CAMERA, LAMP, MOTIONS };
static const char *const motions[MOTIONS] = {[CAMERA] = "camera", [LAMP] = "lamp"};

enum maker { MOVING, WHOLE, REFERENCE, MAKERS };
static const char *const makers[MAKERS] = {[MOVING] = "moving", [WHOLE] = "whole", [REFERENCE] = "reference"};

struct sequence {
    NG_ARRAY(uint8_t) before, now; // [height][width][4], as a display shows them
    double change, shown;          // sums over what has a history
};

struct session {
    const struct bench_flicker_params *params;
    uint32_t size[2];
    struct ng_stage *stage;
    struct lf_method *method;
    struct render_reference *reference;
    struct ng_camera_controller eye;
    struct ng_camera lens;
    ng_entity lamp; // null: none can be moved
    NG_ARRAY(float) motion;
    NG_ARRAY(uint32_t) entities_before, entities;
    struct sequence sequences[MAKERS];
};

// ---- What changes between two pictures -------------------------------------------------------------------

static float fetch(const struct session *s, const uint8_t *rgba, float x, float y, int channel)
{
    uint32_t x0 = (uint32_t)x, y0 = (uint32_t)y, x1 = x0 + 1 < s->size[0] ? x0 + 1 : x0,
             y1 = y0 + 1 < s->size[1] ? y0 + 1 : y0;
    float u = x - (float)x0, v = y - (float)y0;
    const uint8_t *above = rgba + (size_t)y0 * s->size[0] * 4 + channel,
                  *below = rgba + (size_t)y1 * s->size[0] * 4 + channel;
    return (1 - v) * ((1 - u) * above[(size_t)x0 * 4] + u * above[(size_t)x1 * 4]) +
           v * ((1 - u) * below[(size_t)x0 * 4] + u * below[(size_t)x1 * 4]);
}

// Where a pixel was in the frame before; false: it was not seen there.
static bool find_history(const struct session *s, uint32_t x, uint32_t y, float out[2])
{
    size_t at = (size_t)y * s->size[0] + x;
    out[0] = (float)x - s->motion.items[2 * at];
    out[1] = (float)y - s->motion.items[2 * at + 1];
    if (!(out[0] >= 0 && out[1] >= 0 && out[0] <= (float)(s->size[0] - 1) &&
          out[1] <= (float)(s->size[1] - 1)))
        return false;
    size_t was = (size_t)lroundf(out[1]) * s->size[0] + (size_t)lroundf(out[0]);
    return s->entities.items[at] && s->entities_before.items[was] == s->entities.items[at];
}

static void add_change(const struct session *s, struct sequence *q)
{
    for (uint32_t y = 0; y < s->size[1]; y++)
        for (uint32_t x = 0; x < s->size[0]; x++) {
            float from[2];
            if (!find_history(s, x, y, from))
                continue;
            for (int c = 0; c < 3; c++) {
                float now = q->now.items[((size_t)y * s->size[0] + x) * 4 + (size_t)c];
                q->change += fabs((double)(now - fetch(s, q->before.items, from[0], from[1], c)));
                q->shown += (double)now;
            }
        }
}

// ---- Frames ----------------------------------------------------------------------------------------------

static ng_result take_display(struct session *s, struct sequence *q, const uint8_t *rgba)
{
    const struct sequence last = *q;
    q->before.items = last.now.items, q->before.count = last.now.count,
    q->before.capacity = last.now.capacity;
    q->now.items = last.before.items, q->now.count = last.before.count,
    q->now.capacity = last.before.capacity;
    if (!ng_array_resize(&q->now, (size_t)s->size[0] * s->size[1] * 4))
        return ng_out_of_memory("a picture");
    memcpy(q->now.items, rgba, q->now.count);
    return NG_OK;
}

static ng_result take_layers(struct session *s)
{
    struct ng_layer motion, entity;
    size_t pixels = (size_t)s->size[0] * s->size[1];
    NG_TRY(ng_renderer_layer(s->stage->renderer, "motion", &motion));
    NG_TRY(ng_renderer_layer(s->stage->renderer, "entity", &entity));
    if (!ng_array_resize(&s->motion, 2 * pixels) || !ng_array_resize(&s->entities, pixels) ||
        !ng_array_resize(&s->entities_before, pixels))
        return ng_out_of_memory("a picture");
    memcpy(s->entities_before.items, s->entities.items, pixels * sizeof(uint32_t));
    memcpy(s->motion.items, motion.pixels, 2 * pixels * sizeof(float));
    memcpy(s->entities.items, entity.ids, pixels * sizeof(uint32_t));
    return NG_OK;
}

static ng_result draw_display(struct session *s, enum maker maker)
{
    static const char *const layers[] = {"display", "motion", "entity"};
    bool whole = maker == WHOLE;
    const struct ng_stage_frame frame = {.width = s->size[0],
                                         .height = s->size[1],
                                         .light_width = whole ? 0 : (s->size[0] + 1) / 2,
                                         .light_height = whole ? 0 : (s->size[1] + 1) / 2,
                                         .method = lf_method_name(s->params->method),
                                         .layers = layers,
                                         .layer_count = whole ? 3 : 1};
    const uint8_t *rgba;
    uint32_t width, height;
    NG_TRY(ng_stage_draw(s->stage, &frame));
    NG_TRY(ng_renderer_display(s->stage->renderer, &rgba, &width, &height));
    NG_TRY(take_display(s, &s->sequences[maker], rgba));
    return whole ? take_layers(s) : NG_OK;
}

static ng_result draw_reference(struct session *s)
{
    struct output_picture picture;
    uint32_t samples;
    NG_TRY(render_reference_draw(s->reference, s->stage->snapshot, &samples));
    NG_TRY(render_reference_fetch(s->reference, NULL, 0, true, &picture));
    return take_display(s, &s->sequences[REFERENCE], picture.display);
}

// The whole picture first: it is the one whose motion is from the frame before.
static ng_result draw_all(struct session *s)
{
    NG_TRY(draw_display(s, WHOLE));
    NG_TRY(draw_display(s, MOVING));
    return draw_reference(s);
}

static void move(struct session *s, enum motion motion)
{
    struct ng_transform *t = motion == LAMP ? ng_world_edit(s->stage->world, s->lamp, NG_TRANSFORM) : NULL;
    if (motion == CAMERA) {
        struct pose pose = pose_of(&s->eye);
        pose.yaw += TURN;
        pose_take(&pose, &s->eye);
        const struct ng_free_camera camera = pose_camera(&s->eye, &s->lens);
        ng_stage_look(s->stage, &camera);
    } else if (t) {
        t->translation[0] += STEP * s->stage->snapshot->scene_radius;
    }
}

static ng_result measure(struct session *s, enum motion motion)
{
    struct progress progress;
    ng_result result = draw_all(s);
    for (int i = 0; i < MAKERS; i++)
        s->sequences[i].change = s->sequences[i].shown = 0;
    progress_begin(&progress, "frame", FRAMES);
    for (uint32_t n = 1; n < FRAMES && result == NG_OK; n++) {
        progress_update(&progress, n);
        move(s, motion);
        result = draw_all(s);
        for (int i = 0; i < MAKERS && result == NG_OK; i++)
            add_change(s, &s->sequences[i]);
    }
    progress_end(&progress);
    return result;
}

// ---- What is said ----------------------------------------------------------------------------------------

static double flicker(const struct sequence *q)
{
    return q->shown > 0 ? q->change / q->shown : 0;
}

static double ratio_of(const struct session *s, enum maker maker)
{
    double reference = flicker(&s->sequences[REFERENCE]);
    return reference > 0 ? flicker(&s->sequences[maker]) / reference : NAN;
}

static void print(const struct session *s, enum motion motion)
{
    for (enum maker m = MOVING; m < MAKERS; m++)
        printf("%-7s %-10s %10.5f %8.3f\n", motions[motion], makers[m], flicker(&s->sequences[m]),
               ratio_of(s, m));
    fflush(stdout);
}

static void write(const struct session *s, enum motion motion, struct json *j)
{
    json_object(j, motions[motion]);
    for (enum maker m = MOVING; m < MAKERS; m++)
        json_number(j, makers[m], flicker(&s->sequences[m]));
    json_number(j, "ratio", ratio_of(s, MOVING));
    json_end(j);
}

// ---- The whole -------------------------------------------------------------------------------------------

static void find_lamp(struct session *s)
{
    const struct ng_snapshot *n = s->stage->snapshot;
    for (uint32_t i = n->light_count; i-- > 0;)
        if (ng_world_has(s->stage->world, n->lights[i].entity, NG_TRANSFORM) &&
            !n->lights[i].source.type->infinite)
            s->lamp = n->lights[i].entity;
}

static ng_result open_parts(struct session *s)
{
    const struct bench_flicker_params *p = s->params;
    const struct render_reference_params reference = {
        .scene = p->scene,
        .world = s->stage->world,
        .reference = {.width = s->size[0], .height = s->size[1], .jobs = s->stage->jobs},
        .samples = SAMPLES};
    const ng_entity camera = s->stage->scene.camera;
    NG_TRY(lf_method_create(&(struct lf_method_params){.name = lf_method_name(p->method),
                                                       .composer = ng_renderer_composer(s->stage->renderer),
                                                       .jobs = s->stage->jobs,
                                                       .scene = p->scene,
                                                       .weights = p->weights},
                            &s->method));
    NG_TRY(render_reference_create(&reference, &s->reference));
    NG_TRY(ng_stage_seek(s->stage, 0, NULL));
    find_lamp(s);
    if (!pose_look(s->stage->world, s->stage->scene.root, camera, &s->eye)) {
        ng_log_error("%s: has no camera to move; add one", p->scene);
        return NG_ERROR_NOT_FOUND;
    }
    s->lens = *(const struct ng_camera *)ng_world_get(s->stage->world, camera, NG_CAMERA);
    return NG_OK;
}

static ng_result measure_all(struct session *s)
{
    struct json j = {.out = stdout};
    ng_result result = NG_OK;
    if (s->params->json)
        json_object(&j, NULL);
    else
        printf("%s, %s, %u x %u\nmoves   pictures      flicker    ratio\n", ng_path_name(s->params->scene),
               lf_method_name(s->params->method), s->size[0], s->size[1]);
    for (enum motion m = CAMERA; m < MOTIONS && result == NG_OK; m++) {
        if (m == LAMP && ng_entity_is_null(s->lamp))
            continue;
        result = measure(s, m);
        if (result == NG_OK && s->params->json)
            write(s, m, &j);
        else if (result == NG_OK)
            print(s, m);
    }
    if (s->params->json)
        json_end(&j);
    return result;
}

static void close_session(struct session *s)
{
    for (int i = 0; i < MAKERS; i++) {
        ng_array_finish(&s->sequences[i].before);
        ng_array_finish(&s->sequences[i].now);
    }
    ng_array_finish(&s->motion);
    ng_array_finish(&s->entities);
    ng_array_finish(&s->entities_before);
    render_reference_destroy(&s->reference);
    lf_method_destroy(&s->method);
    ng_stage_destroy(&s->stage);
}

ng_result bench_flicker(const struct bench_flicker_params *p)
{
    struct session s = {
        .params = p,
        .size = {p->size.width ? p->size.width : WIDTH, p->size.width ? p->size.height : HEIGHT}};
    struct ng_stage_params stage = {.scene = p->scene, .device = p->device, .threads = p->threads};
    opening_apply(p->opening, &stage);
    stage.clip = "none"; // which would put back what is moved
    NG_TRY(ng_stage_create(&stage, &s.stage));
    ng_result result = open_parts(&s);
    if (result == NG_OK)
        result = measure_all(&s);
    close_session(&s);
    return result;
}

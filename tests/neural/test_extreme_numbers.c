// Numbers that are none, or far too large or small, in every field of cameras, lights, transforms and
// materials, past the checks of files and edits: every method draws a picture, and what they stood in stays
// usable.
#include "neural_test.h"

#include "base/rng.h"
#include "components/camera.h"
#include "components/light_directional.h"
#include "components/light_disk.h"
#include "components/light_environment.h"
#include "components/light_mesh.h"
#include "components/light_sphere.h"
#include "scene/world.h"

#include <float.h>
#include <math.h>

enum { SIDE = 12, MAX_FIELDS = 256, ROUNDS = 48 };

struct target {
    ng_entity entity;
    ng_component component;
    const struct ng_field *field;
};

struct targets {
    struct target items[MAX_FIELDS];
    uint32_t count;
};

static void add_targets(struct targets *t, const struct ng_world *world, ng_entity e)
{
    for (ng_component c = 0; c < NG_COMPONENT_COUNT; c++) {
        const struct ng_component_desc *desc = ng_world_component(world, c);
        bool wanted = c == NG_TRANSFORM || c == NG_CAMERA || c == NG_MATERIAL || c == NG_SCENE_SCALE ||
                      ng_component_is_light(c);
        for (uint32_t i = 0; wanted && ng_world_has(world, e, c) && i < desc->field_count; i++)
            if (ng_field_floats(desc->fields[i].type)) {
                assert_true(t->count < MAX_FIELDS);
                t->items[t->count++] = (struct target){e, c, &desc->fields[i]};
            }
    }
}

// The room with a light of every kind.
static void open_full_room(struct room *r, struct targets *t)
{
    const float here[3] = {0.5f, 0.5f, 0.5f};
    const struct ng_light_sphere ball = {.on = true, .color = {1, 1, 1}, .radiance = 2, .radius = 0.1f};
    const struct ng_light_disk disk = {.on = true, .color = {1, 1, 1}, .radiance = 2, .radius = 0.1f};
    const struct ng_light_directional sun = {.on = true, .color = {1, 1, 1}, .irradiance = 1};
    const struct ng_light_environment sky = {.on = true, .color = {1, 1, 1}, .intensity = 0.1f};
    room_open(r, POINT | PANEL | SPOT);
    r->width = r->height = SIDE;
    struct scene *s = &r->scene;
    ng_entity glow = scene_glow(s, (const float[3]){1, 1, 1});
    ng_entity tile = scene_quad(s, (const float[3]){-1, 1, 0}, (const float[3]){0.2f, 0, 0},
                                (const float[3]){0, 0.2f, 0}, glow);
    OK(ng_world_add(s->world, tile, NG_LIGHT_MESH, NULL));
    const ng_entity all[] = {s->camera,
                             s->scale,
                             r->box,
                             r->ball,
                             r->white,
                             glow,
                             tile,
                             r->point,
                             r->panel,
                             r->spot,
                             scene_light(s, NG_LIGHT_SPHERE, &ball, here, NULL),
                             scene_light(s, NG_LIGHT_DISK, &disk, here, scene_down),
                             scene_light(s, NG_LIGHT_DIRECTIONAL, &sun, here, scene_down),
                             scene_light(s, NG_LIGHT_ENVIRONMENT, &sky, here, NULL)};
    for (size_t i = 0; i < NG_COUNT(all); i++)
        add_targets(t, s->world, all[i]);
}

static const float extremes[] = {NAN,   INFINITY, -INFINITY, FLT_MAX, -FLT_MAX, 1e30f, 1e19f,   -1e19f,
                                 1e18f, -1e18f,   1e12f,     -1e9f,   0,        -1,    FLT_MIN, 1e-30f};

static float *edit(struct room *r, const struct target *t)
{
    return (float *)((char *)ng_world_edit(r->scene.world, t->entity, t->component) + t->field->offset);
}

// The path tracer says so where the sum of paths is no number.
static void draw_reference(struct room *r)
{
    const struct lf_reference_params params = {
        .width = SIDE, .height = SIDE, .depth = 4, .jobs = r->scene.jobs};
    struct lf_reference *reference;
    struct test_log log;
    OK(lf_reference_create(&params, &reference));
    OK(lf_reference_begin(reference, r->scene.tracer));
    test_log_begin(&log);
    ng_result result = lf_reference_run(reference, &(struct lf_reference_run_params){.samples = 1});
    test_log_end(&log);
    assert_true(result == NG_OK ? log.errors == 0 : result == NG_ERROR_FORMAT && log.errors == 1);
    lf_reference_destroy(&reference);
}

static void draw_raster(struct room *r, struct method *m)
{
    const struct ng_render_params params = {
        .snapshot = r->scene.snapshot, .width = SIDE, .height = SIDE, .method = "raster"};
    struct ng_cmd *cmd;
    OK(ng_frame_begin(r->gpu, &cmd));
    OK(ng_renderer_frame(m->renderer, &cmd, &params));
    OK(ng_frame_end(r->gpu, &cmd));
}

static void draw_by_all(struct room *r, struct method *m)
{
    scene_frame(&r->scene, 0);
    draw_reference(r);
    draw_raster(r, m);
    OK(room_draw_again(r, m));
}

// Each field alone, with every number, by the path tracer.
static void every_field_takes_every_number(void **state)
{
    NG_UNUSED(state);
    struct room r;
    struct targets t = {0};
    open_full_room(&r, &t);
    scene_frame(&r.scene, 0);
    assert_true(t.count > 40);
    for (uint32_t i = 0; i < t.count; i++)
        for (size_t k = 0; k < NG_COUNT(extremes); k++) {
            float kept[4];
            uint32_t n = ng_field_floats(t.items[i].field->type);
            if (!n)
                continue;
            memcpy(kept, edit(&r, &t.items[i]), n * sizeof(float));
            edit(&r, &t.items[i])[k % n] = extremes[k];
            scene_frame(&r.scene, 0);
            draw_reference(&r);
            memcpy(edit(&r, &t.items[i]), kept, n * sizeof(float));
        }
    room_close(&r);
}

// Several at once, by all methods; when they are gone the picture is the one from before.
static void all_methods_take_several(void **state)
{
    NG_UNUSED(state);
    struct room r;
    struct method m, fresh;
    struct targets t = {0};
    struct ng_rng rng = ng_rng_make(12, 1);
    open_full_room(&r, &t);
    method_open(&r, NULL, &m);
    method_open(&r, NULL, &fresh);
    draw_by_all(&r, &m);
    for (int round = 0; round < ROUNDS; round++) {
        struct target changed[3];
        float kept[3][4];
        for (int k = 0; k < 3; k++) {
            changed[k] = t.items[ng_rng_below(&rng, t.count)];
            uint32_t n = ng_field_floats(changed[k].field->type);
            memcpy(kept[k], edit(&r, &changed[k]), n * sizeof(float));
            edit(&r, &changed[k])[ng_rng_below(&rng, n)] = extremes[ng_rng_below(&rng, NG_COUNT(extremes))];
        }
        draw_by_all(&r, &m);
        for (int k = 3; k-- > 0;)
            memcpy(edit(&r, &changed[k]), kept[k], ng_field_floats(changed[k].field->type) * sizeof(float));
    }
    draw_by_all(&r, &m);
    OK(room_draw_again(&r, &fresh));
    assert_same_picture(&r, &m, &fresh, "extreme numbers");
    method_close(&m);
    method_close(&fresh);
    room_close(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_field_takes_every_number),
        cmocka_unit_test(all_methods_take_several),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#include "neural_test.h"

#include "components/light_point.h"
#include "components/light_rectangle.h"
#include "components/light_spot.h"
#include "components/transform.h"
#include "networks.h"
#include "scene/world.h"

static const char *const parts[PARTS] = {"unshadowed", "direct", "indirect"};

static void add_walls(struct room *r)
{
    struct scene *s = &r->scene;
    r->white = scene_material(s, (const float[3]){0.7f, 0.7f, 0.7f}, 0, 0.6f);
    r->red = scene_material(s, (const float[3]){0.7f, 0.1f, 0.1f}, 0, 0.3f);
    scene_quad(s, (const float[3]){-2, -2, 2}, (const float[3]){4, 0, 0}, (const float[3]){0, 0, -4},
               r->white);
    scene_quad(s, (const float[3]){-2, 2, -2}, (const float[3]){4, 0, 0}, (const float[3]){0, 0, 4},
               r->white);
    scene_quad(s, (const float[3]){-2, -2, -2}, (const float[3]){4, 0, 0}, (const float[3]){0, 4, 0},
               r->white);
    scene_quad(s, (const float[3]){-2, -2, 2}, (const float[3]){0, 0, -4}, (const float[3]){0, 4, 0}, r->red);
    scene_quad(s, (const float[3]){2, -2, -2}, (const float[3]){0, 0, 4}, (const float[3]){0, 4, 0},
               r->white);
}

static void add_things(struct room *r)
{
    struct scene *s = &r->scene;
    ng_entity metal = scene_material(s, (const float[3]){0.9f, 0.8f, 0.5f}, 1, 0.1f);
    r->box = scene_quad(s, (const float[3]){-1, -1, -0.5f}, (const float[3]){0.8f, 0, 0.2f},
                        (const float[3]){0, 0.9f, 0.1f}, r->red);
    r->ball = scene_sphere(s, (const float[3]){0.7f, -1.2f, 0}, 0.6f, false, metal);
}

ng_entity room_add_point(struct room *r, const float position[3], float intensity)
{
    const struct ng_light_point light = {.on = true, .color = {1, 0.8f, 0.6f}, .intensity = intensity};
    return scene_light(&r->scene, NG_LIGHT_POINT, &light, position, NULL);
}

static void add_lights(struct room *r, unsigned lights)
{
    const struct ng_light_rectangle panel = {
        .on = true, .color = {0.7f, 0.8f, 1}, .radiance = 9, .size = {0.8f, 0.5f}};
    const struct ng_light_spot spot = {
        .on = true, .color = {1, 1, 1}, .intensity = 20, .inner_angle = 0.1f, .outer_angle = 0.2f};
    if (lights & POINT)
        r->point = room_add_point(r, (const float[3]){0.4f, 0.3f, 0.9f}, 6);
    if (lights & PANEL)
        r->panel =
            scene_light(&r->scene, NG_LIGHT_RECTANGLE, &panel, (const float[3]){-0.3f, 1.9f, 0}, scene_down);
    // Sees a patch of the floor at the right, and nothing else.
    if (lights & SPOT)
        r->spot =
            scene_light(&r->scene, NG_LIGHT_SPOT, &spot, (const float[3]){1.5f, 1.5f, -1.5f}, scene_down);
}

void room_open(struct room *r, unsigned lights)
{
    *r = (struct room){.width = 40, .height = 32};
    test_path(r->weights, sizeof r->weights, "test.weights.safetensors");
    network_write_random(r->weights, 7);
    r->gpu = gpu_test_begin();
    scene_open(&r->scene, 2);
    add_walls(r);
    add_things(r);
    add_lights(r, lights);
}

void room_close(struct room *r)
{
    scene_close(&r->scene);
    gpu_test_end(r->gpu);
}

void method_open(const struct room *r, const struct lf_neural_params *params, struct method *out)
{
    struct lf_neural_params p = params ? *params : (struct lf_neural_params){0};
    p.weights = p.weights ? p.weights : r->weights;
    p.jobs = r->scene.jobs;
    OK(ng_renderer_create(&(struct ng_renderer_params){.gpu = r->gpu, .jobs = p.jobs}, &out->renderer));
    OK(lf_neural_create(&p, &out->neural));
    OK(lf_neural_join(out->neural, ng_renderer_composer(out->renderer)));
}

void method_close(struct method *m)
{
    lf_neural_destroy(&m->neural);
    ng_renderer_destroy(&m->renderer);
}

ng_result room_draw_again(const struct room *r, struct method *m)
{
    const struct ng_render_params params = {.snapshot = r->scene.snapshot,
                                            .width = r->width,
                                            .height = r->height,
                                            .method = LF_NEURAL_METHOD,
                                            .layers = parts,
                                            .layer_count = PARTS};
    struct ng_cmd *cmd;
    OK(ng_frame_begin(r->gpu, &cmd));
    ng_result drawn = ng_renderer_frame(m->renderer, &cmd, &params);
    OK(ng_frame_end(r->gpu, &cmd));
    return drawn;
}

void room_draw(struct room *r, struct method *m)
{
    scene_frame(&r->scene, 0);
    OK(room_draw_again(r, m));
}

float *room_layer(const struct room *r, struct method *m, const char *name)
{
    struct ng_layer layer;
    OK(ng_renderer_layer(m->renderer, name, &layer));
    assert_int_equal(layer.width, r->width);
    assert_int_equal(layer.height, r->height);
    size_t size = (size_t)r->width * r->height * 3 * sizeof(float);
    float *copy = malloc(size);
    assert_non_null(copy);
    memcpy(copy, layer.pixels, size);
    return copy;
}

static uint32_t bits_of(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

void assert_same_picture(const struct room *r, struct method *a, struct method *b, const char *after)
{
    size_t count = (size_t)r->width * r->height * 3;
    for (int p = 0; p < PARTS; p++) {
        float *x = room_layer(r, a, parts[p]), *y = room_layer(r, b, parts[p]);
        for (size_t i = 0; i < count; i++)
            if (bits_of(x[i]) != bits_of(y[i]))
                fail_msg("after %s, %s differs at (%zu, %zu): %.9g and %.9g", after, parts[p],
                         i / 3 % r->width, i / 3 / r->width, (double)x[i], (double)y[i]);
        free(x);
        free(y);
    }
}

void room_move(struct room *r, ng_entity e, float x, float y, float z)
{
    struct ng_transform *t = ng_world_edit(r->scene.world, e, NG_TRANSFORM);
    assert_non_null(t);
    t->translation[0] += x;
    t->translation[1] += y;
    t->translation[2] += z;
}

void room_set(struct room *r, ng_entity e, const char *field, float value)
{
    OK(ng_world_set_field(r->scene.world, e, field, NG_FIELD_F32, &value));
}

void room_switch(struct room *r, ng_entity light, const char *field, bool on)
{
    OK(ng_world_set_field(r->scene.world, light, field, NG_FIELD_BOOL, &on));
}

// What physics asks of a picture, whatever drew it: light of lamps adds up, colours do not mix, lamps in one
// place are one. By the path tracer, and by the method "neural" with a network of which nothing is learned.
#include "neural_test.h"

#include "components/light_disk.h"
#include "components/light_point.h"
#include "components/light_rectangle.h"
#include "components/light_sphere.h"
#include "components/material.h"
#include "networks.h"
#include "scene/world.h"

#include <math.h>

enum { SPP = 256 };

static const char *const layers[] = {"direct", "indirect"};

// Of a picture by one of the methods, for each layer: [height][width][3]
struct drawn {
    float *layer[NG_COUNT(layers)];
};

static struct drawn draw_neural(struct room *r)
{
    struct method m;
    struct drawn out;
    method_open(r, NULL, &m);
    room_draw(r, &m);
    for (size_t i = 0; i < NG_COUNT(layers); i++)
        out.layer[i] = room_layer(r, &m, layers[i]);
    method_close(&m);
    return out;
}

static struct drawn trace(struct room *r)
{
    struct drawn out;
    scene_frame(&r->scene, 0);
    for (size_t i = 0; i < NG_COUNT(layers); i++)
        out.layer[i] = scene_render_layer(
            &r->scene,
            &(struct lf_reference_params){.width = r->width, .height = r->height, .jobs = r->scene.jobs}, SPP,
            layers[i]);
    return out;
}

static const struct {
    const char *name;
    struct drawn (*draw)(struct room *room);
    double bound; // of sums: float rounding, or noise
} methods[] = {{"neural", draw_neural, 1e-4}, {"reference", trace, 0.01}};

static void free_drawn(struct drawn *d)
{
    for (size_t i = 0; i < NG_COUNT(layers); i++)
        free(d->layer[i]);
}

static double sum_of(const struct room *r, const float *layer, int channel)
{
    double sum = 0;
    for (size_t i = (size_t)channel; i < (size_t)r->width * r->height * 3; i += 3)
        sum += (double)layer[i];
    return sum;
}

static void open_room(struct room *r, unsigned lights)
{
    room_open(r, lights);
    network_write_physics(r->weights);
}

static void light_of_lamps_adds_up(void **state)
{
    NG_UNUSED(state);
    for (size_t m = 0; m < NG_COUNT(methods); m++) {
        struct room r;
        struct drawn part[3];
        open_room(&r, POINT | PANEL);
        for (int k = 0; k < 3; k++) { // one, the other, both
            room_switch(&r, r.point, "light_point.on", k != 1);
            room_switch(&r, r.panel, "light_rectangle.on", k != 0);
            part[k] = methods[m].draw(&r);
        }
        for (size_t l = 0; l < NG_COUNT(layers); l++) {
            double apart = sum_of(&r, part[0].layer[l], 0) + sum_of(&r, part[1].layer[l], 0),
                   together = sum_of(&r, part[2].layer[l], 0);
            print_message("%s, %s: %g and %g\n", methods[m].name, layers[l], apart, together);
            assert_true(apart > 0 && fabs(together / apart - 1) < methods[m].bound);
        }
        for (int k = 0; k < 3; k++)
            free_drawn(&part[k]);
        room_close(&r);
    }
}

static void red_light_stays_red(void **state)
{
    NG_UNUSED(state);
    for (size_t m = 0; m < NG_COUNT(methods); m++) {
        struct room r;
        const struct ng_light_point red = {.on = true, .color = {1, 0, 0}, .intensity = 6};
        open_room(&r, 0);
        scene_light(&r.scene, NG_LIGHT_POINT, &red, (const float[3]){0.4f, 0.3f, 0.9f}, NULL);
        struct drawn d = methods[m].draw(&r);
        for (size_t l = 0; l < NG_COUNT(layers); l++) {
            assert_true(sum_of(&r, d.layer[l], 0) > 0);
            assert_true(sum_of(&r, d.layer[l], 1) == 0 && sum_of(&r, d.layer[l], 2) == 0);
        }
        free_drawn(&d);
        room_close(&r);
    }
}

// A channel that a material does not reflect diffusely has its glossy light alone, whatever the others do.
static void channels_do_not_mix(void **state)
{
    NG_UNUSED(state);
    for (size_t m = 0; m < NG_COUNT(methods); m++) {
        struct room r;
        struct drawn black, colored;
        open_room(&r, POINT);
        struct ng_material *white = ng_world_edit(r.scene.world, r.white, NG_MATERIAL),
                           *red = ng_world_edit(r.scene.world, r.red, NG_MATERIAL);
        assert_non_null(white);
        assert_non_null(red);
        memset(white->base_color, 0, sizeof white->base_color);
        memset(red->base_color, 0, sizeof red->base_color);
        black = methods[m].draw(&r);
        red = ng_world_edit(r.scene.world, r.red, NG_MATERIAL);
        red->base_color[0] = 0.9f;
        colored = methods[m].draw(&r);
        for (size_t l = 0; l < NG_COUNT(layers); l++) {
            double a = sum_of(&r, black.layer[l], 1), b = sum_of(&r, colored.layer[l], 1);
            print_message("%s, %s: green %g and %g\n", methods[m].name, layers[l], a, b);
            assert_true(a > 0 && fabs(b / a - 1) < 3 * methods[m].bound);
        }
        assert_true(sum_of(&r, colored.layer[0], 0) > 1.2 * sum_of(&r, black.layer[0], 0));
        free_drawn(&black);
        free_drawn(&colored);
        room_close(&r);
    }
}

// ---- the rasterizer: depth maps of lamps in one place, and close to other surfaces -----------------------

static double rasterized(struct room *r, const char *layer)
{
    struct method m;
    method_open(r, NULL, &m);
    scene_frame(&r->scene, 0);
    const struct ng_render_params params = {.snapshot = r->scene.snapshot,
                                            .width = r->width,
                                            .height = r->height,
                                            .method = "raster",
                                            .layers = &layer,
                                            .layer_count = 1};
    struct ng_cmd *cmd;
    OK(ng_frame_begin(r->gpu, &cmd));
    OK(ng_renderer_frame(m.renderer, &cmd, &params));
    OK(ng_frame_end(r->gpu, &cmd));
    float *pixels = room_layer(r, &m, layer);
    double sum = sum_of(r, pixels, 0);
    free(pixels);
    method_close(&m);
    return sum;
}

static const struct ng_light_rectangle panel = {
    .on = true, .color = {1, 1, 1}, .radiance = 4, .size = {0.8f, 0.5f}};
static const struct ng_light_disk disk = {.on = true, .color = {1, 1, 1}, .radiance = 4, .radius = 0.4f};
static const struct ng_light_sphere ball = {.on = true, .color = {1, 1, 1}, .radiance = 4, .radius = 0.3f};
static const struct ng_light_point point = {.on = true, .color = {1, 1, 1}, .intensity = 4};
static const struct {
    ng_component type;
    const void *light;
} lamps[] = {
    {NG_LIGHT_RECTANGLE, &panel}, {NG_LIGHT_DISK, &disk}, {NG_LIGHT_SPHERE, &ball}, {NG_LIGHT_POINT, &point}};

// Two lamps twice as far as one: what each of them lights and shows does not depend on the other.
static void lamps_in_one_place_shine_as_two(void **state)
{
    NG_UNUSED(state);
    for (size_t l = 0; l < NG_COUNT(lamps); l++) {
        struct room r;
        open_room(&r, 0);
        scene_light(&r.scene, lamps[l].type, lamps[l].light, (const float[3]){0.2f, 0.8f, 0}, scene_down);
        double direct = rasterized(&r, "direct"), emission = rasterized(&r, "emission");
        scene_light(&r.scene, lamps[l].type, lamps[l].light, (const float[3]){0.2f, 0.8001f, 0}, scene_down);
        assert_true(direct > 0);
        NEAR(rasterized(&r, "direct") / direct, 2, 0.002);
        NEAR(rasterized(&r, "emission"), 2 * emission, 0.02 * emission);
        room_close(&r);
    }
}

static void a_lamp_behind_a_ceiling_is_dark(void **state)
{
    NG_UNUSED(state);
    for (size_t l = 0; l < NG_COUNT(lamps); l++)
        for (int behind = 0; behind < 2; behind++) {
            struct room r;
            open_room(&r, 0);
            float off = lamps[l].type == NG_LIGHT_SPHERE ? ball.radius : 0;
            const float at[3] = {0, behind ? 2.0003f + off : 1.999f - off, 0};
            scene_light(&r.scene, lamps[l].type, lamps[l].light, at, scene_down);
            double direct = rasterized(&r, "direct"), whole = rasterized(&r, "unshadowed");
            print_message("%zu: %g of %g\n", l, direct, whole);
            // A ball stands far enough behind for filters to look past the wall's upper edge.
            double least = lamps[l].type == NG_LIGHT_SPHERE ? 0.05 : 0.01;
            assert_true(whole > 0 && (behind ? direct < least * whole : direct > 0.9 * whole));
            room_close(&r);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(light_of_lamps_adds_up),
        cmocka_unit_test(red_light_stays_red),
        cmocka_unit_test(channels_do_not_mix),
        cmocka_unit_test(lamps_in_one_place_shine_as_two),
        cmocka_unit_test(a_lamp_behind_a_ceiling_is_dark),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// What a change redoes, pass by pass. That what is not redone is right is test_random_edits' matter.
#include "neural_test.h"

#include "components/light_environment.h"
#include "components/light_rectangle.h"
#include "components/light_spot.h"
#include "components/material.h"
#include "components/name.h"
#include "networks.h"
#include "scene/world.h"

#include <math.h>
#include <stdio.h>

// ---- what is redone --------------------------------------------------------------------------------------

struct watch {
    struct room room;
    struct method method;
    struct lf_neural_counters before;
};

static void watch_open(struct watch *w)
{
    room_open(&w->room, POINT | PANEL | SPOT);
    method_open(&w->room, NULL, &w->method);
    room_draw(&w->room, &w->method);
    w->before = lf_neural_counters_of(w->method.neural);
}

static void watch_close(struct watch *w)
{
    method_close(&w->method);
    room_close(&w->room);
}

// Draws, and compares how often each part was made: of all lights together, but for the first and last three.
static void expect(struct watch *w, uint64_t pixels, uint64_t rsm, uint64_t light, uint64_t view,
                   uint64_t gather)
{
    room_draw(&w->room, &w->method);
    struct lf_neural_counters now = lf_neural_counters_of(w->method.neural);
    assert_int_equal(now.encoder.pixels - w->before.encoder.pixels, pixels);
    assert_int_equal(now.encoder.rsm - w->before.encoder.rsm, rsm);
    assert_int_equal(now.encoder.light - w->before.encoder.light, light);
    assert_int_equal(now.encoder.clues - w->before.encoder.clues, view);
    assert_int_equal(now.encoder.view - w->before.encoder.view, view);
    assert_int_equal(now.gather - w->before.gather, gather);
    w->before = now;
}

static void only_what_depends_on_a_change_is_redone(void **state)
{
    NG_UNUSED(state);
    struct watch w = {0};
    watch_open(&w);
    struct room *r = &w.room;
    assert_int_equal(w.before.encoder.view, 3);
    expect(&w, 0, 0, 0, 0, 0); // nothing: the last picture stays

    room_move(r, r->scene.camera, 0.1f, 0, 0); // the part on screen, of each light
    expect(&w, 1, 0, 0, 3, 1);

    room_set(r, r->point, "light_point.intensity", 9); // powers: the gather alone
    expect(&w, 0, 0, 0, 0, 1);
    room_switch(r, r->panel, "light_rectangle.on", false);
    expect(&w, 0, 0, 0, 0, 1);
    room_switch(r, r->panel, "light_rectangle.on", true); // its encoding was kept
    expect(&w, 0, 0, 0, 0, 1);

    room_move(r, r->point, 0.1f, 0, 0); // one light: itself alone
    expect(&w, 0, 1, 1, 1, 1);

    room_move(r, r->ball, -0.05f, 0, 0); // two lights see it; on screen it matters for all
    expect(&w, 1, 2, 2, 3, 1);

    w.room.width = 33; // the screen again
    expect(&w, 1, 0, 0, 3, 1);

    ng_entity more = room_add_point(r, (const float[3]){-1, 0, 1}, 2); // the others stay as they are
    expect(&w, 0, 1, 1, 1, 1);
    OK(ng_entity_destroy(r->scene.world, more));
    expect(&w, 0, 0, 0, 0, 1);
    OK(ng_entity_destroy(r->scene.world, r->point)); // those after it move up in the list
    expect(&w, 0, 0, 0, 2, 1);                       // and are few enough to ask more
    watch_close(&w);
}

// A panel is a thing, too: it stands in the light of others, and is seen in mirrors. What it sends is not.
static void lights_with_a_surface_are_things(void **state)
{
    NG_UNUSED(state);
    struct watch w = {0};
    watch_open(&w);
    struct room *r = &w.room;

    room_set(r, r->panel, "light_rectangle.radiance", 0); // powers: the gather alone
    expect(&w, 0, 0, 0, 0, 1);
    room_set(r, r->panel, "light_rectangle.radiance", 4);
    expect(&w, 0, 0, 0, 0, 1);
    struct ng_light_rectangle *panel = ng_world_edit(r->scene.world, r->panel, NG_LIGHT_RECTANGLE);
    panel->color[0] = 0.2f; // one light: itself alone
    expect(&w, 0, 1, 1, 1, 1);

    // The point light sees it, the spot does not; on screen it matters for all.
    room_move(r, r->panel, 0.1f, 0, 0);
    expect(&w, 1, 2, 2, 3, 1);
    panel = ng_world_edit(r->scene.world, r->panel, NG_LIGHT_RECTANGLE);
    panel->size[0] = 0.6f;
    expect(&w, 1, 2, 2, 3, 1);
    OK(ng_entity_destroy(r->scene.world, r->panel));
    expect(&w, 1, 1, 1, 2, 1);
    watch_close(&w);
}

static bool shows_lamp(struct watch *w)
{
    static const char *const layers[] = {"emission", "indirect"};
    const struct ng_render_params params = {.snapshot = w->room.scene.snapshot,
                                            .width = w->room.width,
                                            .height = w->room.height,
                                            .method = LF_NEURAL_METHOD,
                                            .layers = layers,
                                            .layer_count = NG_COUNT(layers)};
    struct ng_cmd *cmd;
    OK(ng_frame_begin(w->room.gpu, &cmd));
    OK(ng_renderer_frame(w->method.renderer, &cmd, &params));
    OK(ng_frame_end(w->room.gpu, &cmd));
    float *emission = room_layer(&w->room, &w->method, layers[0]);
    float *indirect = room_layer(&w->room, &w->method, layers[1]);
    size_t count = (size_t)w->room.width * w->room.height, shown = 0;
    for (size_t i = 0; i < count; i++)
        if (emission[i * 3] > 0) {
            shown++;
            assert_true(!(indirect[i * 3] > 0)); // it hides what is behind it
        }
    free(emission);
    free(indirect);
    return shown > 0;
}

static void expect_as_fresh(struct watch *w, const char *what)
{
    struct method fresh;
    method_open(&w->room, NULL, &fresh);
    OK(room_draw_again(&w->room, &fresh));
    assert_same_picture(&w->room, &w->method, &fresh, what);
    method_close(&fresh);
}

// Small lamps that reflect nothing cost what they touch: themselves, and lights that they stand in the way
// of.
static void a_lamp_costs_what_it_touches(void **state)
{
    NG_UNUSED(state);
    struct watch w = {0};
    watch_open(&w);
    struct room *r = &w.room;
    struct ng_light_rectangle *panel = ng_world_edit(r->scene.world, r->panel, NG_LIGHT_RECTANGLE);
    panel->size[0] = panel->size[1] = 0.25f;
    memset(panel->albedo, 0, sizeof panel->albedo);
    struct ng_light_rectangle other = *panel;
    ng_entity beside =
        scene_light(&r->scene, NG_LIGHT_RECTANGLE, &other, (const float[3]){0.5f, 1.9f, 0}, scene_down);
    room_draw(r, &w.method);
    w.before = lf_neural_counters_of(w.method.neural);

    room_move(r, r->panel, 0.1f, 0, 0); // in the plane of the other lamp; the point light alone sees it
    expect(&w, 0, 2, 2, 2, 1);
    expect_as_fresh(&w, "a lamp moved");
    room_move(r, beside, 0, -0.5f, 0); // below the panel, and in the view of the point light
    expect(&w, 0, 3, 3, 3, 1);
    expect_as_fresh(&w, "a lamp came down");

    OK(ng_entity_destroy(r->scene.world, beside));
    const float toward_camera[4] = {0, 1, 0, 0}; // in the picture
    scene_light(&r->scene, NG_LIGHT_RECTANGLE, &other, (const float[3]){0.2f, -0.3f, 0.4f}, toward_camera);
    room_draw(r, &w.method);
    expect_as_fresh(&w, "a lamp is in the picture");
    OK(ng_entity_destroy(r->scene.world, r->panel));
    room_draw(r, &w.method);
    expect_as_fresh(&w, "a lamp went away");
    assert_true(shows_lamp(&w));
    watch_close(&w);
}

// A millimetre above the point light, nearer than the near plane of its maps. The panel sees it, too.
static void what_is_very_near_a_light_is_in_its_light(void **state)
{
    NG_UNUSED(state);
    struct watch w = {0};
    watch_open(&w);
    scene_quad(&w.room.scene, (const float[3]){0.399f, 0.301f, 0.899f}, (const float[3]){0.002f, 0, 0},
               (const float[3]){0, 0, 0.002f}, w.room.red);
    expect(&w, 1, 2, 2, 3, 1);
    watch_close(&w);
}

static void another_method_encodes_nothing(void **state)
{
    NG_UNUSED(state);
    struct watch w = {0};
    watch_open(&w);
    const struct ng_render_params raster = {.snapshot = w.room.scene.snapshot, .width = 16, .height = 16};
    struct ng_cmd *cmd;
    OK(ng_frame_begin(w.room.gpu, &cmd));
    OK(ng_renderer_frame(w.method.renderer, &cmd, &raster));
    OK(ng_frame_end(w.room.gpu, &cmd));
    expect(&w, 0, 0, 0, 0, 1); // the images were given up, the encodings were not
    watch_close(&w);
}

// As undo and redo do while another method is shown: the same light, but its tables lie elsewhere.
static void a_light_that_comes_back_is_followed(void **state)
{
    NG_UNUSED(state);
    const struct ng_light_environment sky = {.on = true, .color = {1, 1, 1}, .intensity = 1};
    struct room r;
    struct method kept, full;
    room_open(&r, 0);
    ng_entity light = scene_light(&r.scene, NG_LIGHT_ENVIRONMENT, &sky, (const float[3]){0}, NULL);
    method_open(&r, NULL, &kept);
    room_draw(&r, &kept);
    OK(ng_world_remove(r.scene.world, light, NG_LIGHT_ENVIRONMENT));
    scene_frame(&r.scene, 0); // and is not drawn
    OK(ng_world_add(r.scene.world, light, NG_LIGHT_ENVIRONMENT, &sky));
    room_move(&r, r.scene.camera, 0.1f, 0, 0);
    room_draw(&r, &kept);
    method_open(&r, NULL, &full);
    OK(room_draw_again(&r, &full));
    assert_same_picture(&r, &kept, &full, "a light came back");
    method_close(&full);
    method_close(&kept);
    room_close(&r);
}

static ng_asset add_color(struct room *r, unsigned char red, unsigned char blue)
{
    struct ng_image image = {.width = 1, .height = 1, .levels = 1, .size = 4, .pixels = malloc(4)};
    ng_asset id;
    assert_non_null(image.pixels);
    memcpy(image.pixels, (const unsigned char[4]){red, 0, blue, 255}, 4);
    OK(ng_assets_take_image(r->scene.assets, "color", &image, &id));
    return id;
}

// What emits and is no light is seen in metal, whatever it emits by.
static void emission_in_a_mirror_is_followed(void **state)
{
    NG_UNUSED(state);
    struct room r;
    struct method kept, fresh;
    room_open(&r, POINT);
    const ng_asset colors[] = {add_color(&r, 255, 0), add_color(&r, 0, 255), {0}};
    method_open(&r, NULL, &kept);
    room_draw(&r, &kept);
    float *before = room_layer(&r, &kept, "indirect");
    for (size_t i = 0; i < NG_COUNT(colors); i++) {
        struct ng_material *red = ng_world_edit(r.scene.world, r.red, NG_MATERIAL);
        memcpy(red->emissive, (const float[3]){3, 3, 3}, sizeof red->emissive);
        red->emissive_texture = colors[i];
        room_draw(&r, &kept);
        method_open(&r, NULL, &fresh);
        OK(room_draw_again(&r, &fresh));
        assert_same_picture(&r, &kept, &fresh, "other emission");
        method_close(&fresh);
        float *after = room_layer(&r, &kept, "indirect");
        assert_memory_not_equal(before, after, (size_t)r.width * r.height * 3 * sizeof(float));
        free(before);
        before = after;
    }
    free(before);
    method_close(&kept);
    room_close(&r);
}

// Both have entities, assets and edits of the same numbers.
static void another_world_is_another(void **state)
{
    NG_UNUSED(state);
    struct room a, b;
    struct method kept, full;
    room_open(&a, POINT | PANEL);
    room_open(&b, POINT | PANEL);
    for (int i = 0; i < 2; i++) {
        struct room *r = i ? &b : &a;
        struct ng_material *red = ng_world_edit(r->scene.world, r->red, NG_MATERIAL);
        red->base_color_texture = add_color(r, i ? 0 : 255, i ? 255 : 0);
        room_move(r, r->ball, 0, i ? 0.5f : 0, 0);
        scene_frame(&r->scene, 0);
    }
    const struct ng_snapshot *first = a.scene.snapshot;
    method_open(&a, NULL, &kept);
    method_open(&a, NULL, &full);
    OK(room_draw_again(&a, &kept));
    a.scene.snapshot = b.scene.snapshot;
    OK(room_draw_again(&a, &kept));
    OK(room_draw_again(&a, &full));
    assert_same_picture(&a, &kept, &full, "another world");
    a.scene.snapshot = first;
    method_close(&full);
    method_close(&kept);
    room_close(&b);
    room_close(&a);
}

// Buffers have the names and sizes that they had with the network before.
static void another_network_starts_anew(void **state)
{
    NG_UNUSED(state);
    struct room r;
    struct method kept, full;
    room_open(&r, POINT | PANEL);
    method_open(&r, NULL, &kept);
    room_draw(&r, &kept);
    lf_neural_destroy(&kept.neural);
    network_write_random(r.weights, 8);
    OK(lf_neural_create(&(struct lf_neural_params){.weights = r.weights, .jobs = r.scene.jobs},
                        &kept.neural));
    OK(lf_neural_join(kept.neural, ng_renderer_composer(kept.renderer)));
    OK(room_draw_again(&r, &kept));
    method_open(&r, NULL, &full);
    OK(room_draw_again(&r, &full));
    assert_same_picture(&r, &kept, &full, "another network");
    method_close(&full);
    method_close(&kept);
    room_close(&r);
}

// Its buffers have the first name, and so have its clues, though another light is called that now.
static void a_renamed_light_has_the_clues_of_its_first_name(void **state)
{
    NG_UNUSED(state);
    static const char clue[] = "light/vpl.offset";
    struct watch w = {0};
    char buffer[64];
    struct lf_clue out;
    watch_open(&w);
    assert_true(lf_encoder_clue_buffer(clue, buffer, sizeof buffer));
    assert_string_equal(buffer, "encode:light/rsm");
    struct ng_name *name = ng_world_edit(w.room.scene.world, w.room.point, NG_NAME);
    snprintf(name->text, sizeof name->text, "lamp");
    expect(&w, 0, 0, 0, 0, 0);
    OK(lf_neural_clue(w.method.neural, clue, &out));
    assert_int_equal(out.width, 1); // VPL of a point
    lf_clue_finish(&out);
    watch_close(&w);
}

// Two lights of an entity, of types that begin alike, one after the other: the names of both are taken.
static void lights_of_one_entity_have_buffers_of_their_own(void **state)
{
    NG_UNUSED(state);
    struct watch w = {0};
    watch_open(&w);
    struct ng_world *world = w.room.scene.world;
    snprintf(((struct ng_name *)ng_world_edit(world, w.room.point, NG_NAME))->text, NG_TEXT_SIZE, "lamp");
    ng_entity other = ng_entity_create(world);
    OK(ng_world_add(world, other, NG_TRANSFORM, NULL));
    OK(ng_world_add(world, other, NG_NAME, &(struct ng_name){.text = "light"}));
    OK(ng_world_add(world, other, NG_LIGHT_SPOT, NULL));
    room_draw(&w.room, &w.method);
    ((struct ng_light_spot *)ng_world_edit(world, other, NG_LIGHT_SPOT))->on = false;
    OK(ng_world_add(world, other, NG_LIGHT_SPHERE, NULL));
    room_draw(&w.room, &w.method);
    watch_close(&w);
}

// ---- the graph -------------------------------------------------------------------------------------------

static bool ran(struct ng_renderer *renderer, const char *pass)
{
    size_t count;
    const struct ng_pass_stats *stats = ng_graph_stats(ng_renderer_graph(renderer), &count);
    for (size_t i = 0; i < count; i++)
        if (strcmp(stats[i].name, pass) == 0)
            return stats[i].runs > 0;
    return false;
}

static void each_light_has_a_node_of_its_own(void **state)
{
    NG_UNUSED(state);
    static const char *const passes[] = {"trace:update",        "clues:pixels",        "encode:light/rsm",
                                         "encode:light/light",  "encode:light/clues",  "encode:light/view",
                                         "encode:light#2/view", "encode:light#3/view", "gather"};
    struct watch w = {0};
    watch_open(&w);
    char *dump = ng_graph_dump(ng_renderer_graph(w.method.renderer), NG_DUMP_TEXT);
    assert_non_null(dump);
    for (size_t i = 0; i < NG_COUNT(passes); i++) {
        assert_true(ran(w.method.renderer, passes[i]));
        assert_non_null(strstr(dump, passes[i]));
    }
    free(dump);
    watch_close(&w);
}

// Which way a light's surroundings are found is the encoder's business: with rays nobody reads the maps.
static void maps_are_drawn_only_if_they_are_read(void **state)
{
    NG_UNUSED(state);
    struct watch w = {0};
    watch_open(&w);
    assert_false(ran(w.method.renderer, "rsm:light/depth"));
    assert_false(ran(w.method.renderer, "rsm:light/surface"));
    method_close(&w.method);
    method_open(&w.room, &(struct lf_neural_params){.rsm = LF_RSM_MAPS}, &w.method);
    room_draw(&w.room, &w.method);
    assert_true(ran(w.method.renderer, "rsm:light/depth"));
    assert_true(ran(w.method.renderer, "rsm:light/surface"));
    watch_close(&w);
}

static double mean_difference(const float *a, const float *b, size_t count)
{
    double difference = 0, sum = 0;
    for (size_t i = 0; i < count; i++) {
        difference += fabs((double)a[i] - (double)b[i]);
        sum += fabs((double)b[i]);
    }
    return difference / sum;
}

static void maps_and_rays_see_the_same(void **state)
{
    NG_UNUSED(state);
    struct room r;
    struct method rays, maps;
    room_open(&r, POINT | PANEL);
    network_write_physics(r.weights);
    method_open(&r, NULL, &rays);
    method_open(&r, &(struct lf_neural_params){.rsm = LF_RSM_MAPS}, &maps);
    room_draw(&r, &rays);
    OK(room_draw_again(&r, &maps));
    static const struct {
        const char *layer;
        double most;
    } tolerances[] = {{"unshadowed", 1e-5}, {"direct", 0.05}, {"indirect", 0.05}};
    for (size_t i = 0; i < NG_COUNT(tolerances); i++) {
        float *a = room_layer(&r, &rays, tolerances[i].layer),
              *b = room_layer(&r, &maps, tolerances[i].layer);
        assert_true(mean_difference(a, b, (size_t)r.width * r.height * 3) < tolerances[i].most);
        free(a);
        free(b);
    }
    method_close(&maps);
    method_close(&rays);
    room_close(&r);
}

static void a_steady_load_creates_nothing(void **state)
{
    NG_UNUSED(state);
    struct watch w = {0};
    watch_open(&w);
    ng_graph_ignore_keys(ng_renderer_graph(w.method.renderer), true);
    for (int i = 0; i < 4; i++)
        room_draw(&w.room, &w.method);
    struct ng_graph *g = ng_renderer_graph(w.method.renderer);
    uint64_t objects = ng_graph_counters(g).objects_created;
    for (int i = 0; i < 4; i++) {
        room_move(&w.room, w.room.ball, 0.01f, 0, 0);
        room_draw(&w.room, &w.method);
    }
    assert_int_equal(ng_graph_counters(g).objects_created, objects);
    watch_close(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(only_what_depends_on_a_change_is_redone),
        cmocka_unit_test(lights_with_a_surface_are_things),
        cmocka_unit_test(a_lamp_costs_what_it_touches),
        cmocka_unit_test(what_is_very_near_a_light_is_in_its_light),
        cmocka_unit_test(another_method_encodes_nothing),
        cmocka_unit_test(a_light_that_comes_back_is_followed),
        cmocka_unit_test(emission_in_a_mirror_is_followed),
        cmocka_unit_test(a_renamed_light_has_the_clues_of_its_first_name),
        cmocka_unit_test(lights_of_one_entity_have_buffers_of_their_own),
        cmocka_unit_test(another_world_is_another),
        cmocka_unit_test(another_network_starts_anew),
        cmocka_unit_test(each_light_has_a_node_of_its_own),
        cmocka_unit_test(maps_are_drawn_only_if_they_are_read),
        cmocka_unit_test(maps_and_rays_see_the_same),
        cmocka_unit_test(a_steady_load_creates_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#include "test.h"

#include "app/camera_controller.h"
#include "app/clip_menu.h"
#include "app/playback.h"
#include "app/watch.h"
#include "asset/assets.h"
#include "asset/gltf.h"
#include "base/file.h"
#include "components/components.h"
#include "render/scene_systems.h"
#include "scene/system.h"
#include "scene/world.h"

#include <cglm/cglm.h>
#include <threads.h>

static const float identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

static void assert_near(float a, float b)
{
    assert_float_equal(a, b, 1e-5f);
}

static void assert_near3(const float a[3], float x, float y, float z)
{
    assert_near(a[0], x);
    assert_near(a[1], y);
    assert_near(a[2], z);
}

// Where a camera that carries this transform looks.
// Exchanges left and right: what a person pulls to the right goes to the right on screen.
static void a_mirrored_camera_stays_mirrored(void **state)
{
    NG_UNUSED(state);
    const float looking_back[16] = {[0] = 1, [5] = 1, [10] = -1, [15] = 1};
    struct ng_camera_controller c;
    ng_camera_controller_look(&c, looking_back, 2);
    struct ng_transform t = ng_camera_controller_transform(&c);
    assert_true(t.scale[0] < 0 && t.scale[1] > 0 && t.scale[2] > 0);
    vec3 forward, right;
    glm_quat_rotatev(t.rotation, (vec3){0, 0, -1}, forward);
    glm_quat_rotatev(t.rotation, (vec3){t.scale[0], 0, 0}, right);
    assert_true(forward[2] > 0.999f && right[0] > 0.999f);
    struct ng_input input = {.down = {['D'] = true}};
    ng_camera_controller_update(&c, &input, 100, 1);
    assert_true(c.eye[0] > 0);
}

static void ahead(const struct ng_camera_controller *c, vec3 out)
{
    struct ng_transform t = ng_camera_controller_transform(c);
    glm_quat_rotatev(t.rotation, (vec3){0, 0, -1}, out);
}

static void orbit_keeps_the_point_in_the_middle(void **state)
{
    NG_UNUSED(state);
    struct ng_camera_controller c;
    ng_camera_controller_look(&c, identity, 2);
    ng_camera_controller_orbit(&c, GLM_PI_2f, 0);
    assert_near3(c.eye, 2, 0, -2); // to the right of the point (0, 0, -2)
    vec3 look;
    ahead(&c, look);
    assert_near3(look, -1, 0, 0);

    for (int i = 0; i < 100; i++)
        ng_camera_controller_orbit(&c, 0.37f, i % 2 ? 0.4f : -0.3f);
    ahead(&c, look);
    vec3 point = {c.eye[0] + 2 * look[0], c.eye[1] + 2 * look[1], c.eye[2] + 2 * look[2]};
    for (int i = 0; i < 3; i++)
        assert_float_equal(point[i], i == 2 ? -2 : 0, 1e-4f);
}

static void orbit_stops_short_of_the_poles(void **state)
{
    NG_UNUSED(state);
    struct ng_camera_controller c;
    ng_camera_controller_look(&c, identity, 2);
    ng_camera_controller_orbit(&c, 0, -100);
    vec3 look;
    ahead(&c, look);
    assert_true(look[1] < -0.99f);
    assert_true(look[2] < 0); // still the side it came from
}

static void look_takes_over_a_camera(void **state)
{
    NG_UNUSED(state);
    static const float directions[][3] = {{0, 0, -1}, {1, 0, 0}, {-0.48f, 0.6f, 0.64f}, {0.6f, -0.8f, 0}};
    for (size_t i = 0; i < NG_COUNT(directions); i++) {
        mat4 view, camera;
        vec3 eye = {1, 2, 3}, look;
        glm_look(eye, (float *)directions[i], (vec3){0, 1, 0}, view);
        glm_mat4_inv(view, camera);
        struct ng_camera_controller c;
        ng_camera_controller_look(&c, (const float *)camera, 5);
        assert_near3(c.eye, 1, 2, 3);
        ahead(&c, look);
        assert_near3(look, directions[i][0], directions[i][1], directions[i][2]);
    }
    // Straight down with the top of the image towards +X.
    const float down[16] = {0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1};
    struct ng_camera_controller c;
    ng_camera_controller_look(&c, down, 1);
    struct ng_transform t = ng_camera_controller_transform(&c);
    vec3 up;
    glm_quat_rotatev(t.rotation, (vec3){0, 1, 0}, up);
    assert_true(up[0] > 0.99f);
}

static void flying_turns_about_the_eye(void **state)
{
    NG_UNUSED(state);
    struct ng_camera_controller c;
    ng_camera_controller_look(&c, identity, 2);
    ng_camera_controller_turn(&c, -GLM_PI_2f, 0);
    assert_near3(c.eye, 0, 0, 0);
    ng_camera_controller_move(&c, 0, 0, 3); // ahead is now +X
    assert_near3(c.eye, 3, 0, 0);
    ng_camera_controller_move(&c, 1, 2, 0); // right is +Z
    assert_near3(c.eye, 3, 2, 1);
}

static void zoom_never_reaches_the_point(void **state)
{
    NG_UNUSED(state);
    struct ng_camera_controller c;
    ng_camera_controller_look(&c, identity, 2);
    ng_camera_controller_zoom(&c, 1);
    assert_near3(c.eye, 0, 0, -0.2f);
    ng_camera_controller_zoom(&c, -1);
    assert_near3(c.eye, 0, 0, 0);
    ng_camera_controller_zoom(&c, 1000);
    assert_true(c.distance > 0 && c.eye[2] > -2);
}

static void input_moves_the_camera(void **state)
{
    NG_UNUSED(state);
    struct ng_camera_controller c, still;
    ng_camera_controller_look(&c, identity, 2);
    ng_camera_controller_orbit(&c, 0.1f, 0);
    still = c;
    struct ng_input input = {.pointer = {50, -20}};
    ng_camera_controller_update(&c, &input, 500, 0.1f);
    assert_memory_equal(&c, &still, sizeof c); // no button: the mouse just passes by

    input.drag[NG_BUTTON_LEFT][0] = 50;
    input.drag[NG_BUTTON_LEFT][1] = -20;
    ng_camera_controller_update(&c, &input, 500, 0.1f);
    assert_near(c.yaw, -0.2f);
    assert_near(c.pitch, 0.12f);

    ng_camera_controller_look(&c, identity, 2);
    input = (struct ng_input){0};
    input.down['W'] = input.down[NG_KEY_SHIFT] = true;
    ng_camera_controller_update(&c, &input, 500, 0.1f);
    assert_near3(c.eye, 0, 0, -0.8f); // 2 m/s, four times, a tenth of a second
}

static void clock_wraps_and_pauses(void **state)
{
    NG_UNUSED(state);
    struct ng_playback p = {.duration = 4, .playing = true};
    ng_playback_advance(&p, 3.5);
    assert_true(p.time == 3.5 && !p.jumped);
    ng_playback_advance(&p, 1);
    assert_true(p.time == 0.5 && p.jumped);
    p.playing = false;
    ng_playback_advance(&p, 1);
    assert_true(p.time == 0.5 && !p.jumped);
    ng_playback_scrub(&p, -1);
    assert_true(p.time == 3.5 && p.jumped);
    ng_playback_seek(&p, 4);
    assert_true(p.time == 0);

    struct ng_playback endless = {.playing = true};
    ng_playback_advance(&endless, 100);
    assert_true(endless.time == 100);
    ng_playback_scrub(&endless, -200);
    assert_true(endless.time == 0);
}

// Writes a file; false until whoever watches it has seen that.
static void write_text(const char *path, const char *text)
{
    assert_int_equal(ng_file_write(path, text, strlen(text)), NG_OK);
}

static void wait_for_change(struct ng_watch *watch)
{
    const struct timespec moment = {.tv_nsec = 20000000};
    for (int i = 0; i < 3000; i++) { // a minute, on a machine that does something else
        if (ng_watch_changed(watch))
            return;
        thrd_sleep(&moment, NULL);
    }
    fail_msg("the change is not seen");
}

static void files_that_change_are_told(void **state)
{
    NG_UNUSED(state);
    char first[512], second[512];
    struct ng_watch *watch;
    test_path(first, sizeof first, "first.txt");
    test_path(second, sizeof second, "second.txt");
    remove(second);
    write_text(first, "one");
    assert_int_equal(ng_watch_create(&watch), NG_OK);
    assert_true(ng_watch_add(watch, first));
    assert_true(ng_watch_add(watch, second)); // which is not there yet
    assert_false(ng_watch_changed(watch));
    write_text(first, "two more");
    wait_for_change(watch);
    assert_false(ng_watch_changed(watch)); // once
    write_text(second, "here");
    wait_for_change(watch);
    assert_int_equal(remove(second), 0); // for good: no reason to wait for the other one in vain
    wait_for_change(watch);
    write_text(first, "three, then");
    wait_for_change(watch);
    ng_watch_clear(watch);
    write_text(first, "nobody looks");
    assert_false(ng_watch_changed(watch));
    ng_watch_destroy(&watch);
}

// One clip instead of another: what only the first one moves goes back to where it was.
static void a_clip_chosen_plays_alone(void **state)
{
    NG_UNUSED(state);
    struct ng_world *world;
    struct ng_assets *assets;
    struct ng_gltf_scene scene;
    struct ng_clip_menu *menu;
    assert_int_equal(ng_world_create(NULL, &world), NG_OK);
    assert_int_equal(ng_components_register(world), NG_OK);
    assert_int_equal(ng_assets_create(&assets), NG_OK);
    assert_int_equal(ng_scene_systems_add(world, assets, NULL), NG_OK);
    assert_int_equal(ng_gltf_load("tests/files/good/clips_three.gltf", world, assets, NULL, &scene), NG_OK);
    assert_int_equal(ng_clip_menu_create(world, assets, scene.root, &menu), NG_OK);
    assert_string_equal(ng_clip_menu_name(menu, 1), "right");
    assert_null(ng_clip_menu_name(menu, 3));
    assert_near(ng_clip_menu_duration(menu, 2), 1);
    ng_entity tip = {0};
    for (ng_entity e = scene.root; !ng_entity_is_null(e); e = ng_world_next_below(world, scene.root, e))
        if (strcmp(ng_world_get(world, e, NG_NAME), "tip") == 0)
            tip = e;
    struct ng_transform rest = *(const struct ng_transform *)ng_world_get(world, tip, NG_TRANSFORM);
    const struct {
        uint32_t choice;
        bool plays[3];
    } steps[] = {{NG_CLIPS_FIRST, {true}}, {1, {false, true}}, {NG_CLIPS_ALL, {true, true, true}},
                 {NG_CLIPS_NONE, {false}}, {0, {true, false}}, {NG_CLIPS_NONE, {false}}};
    for (size_t i = 0; i < NG_COUNT(steps); i++) {
        ng_clip_menu_play(menu, steps[i].choice);
        assert_int_equal(ng_clip_menu_choice(menu), steps[i].choice);
        for (uint32_t k = 0; k < 3; k++)
            assert_int_equal(ng_clip_menu_plays(menu, k), steps[i].plays[k]);
        assert_int_equal(ng_world_run(world, 0.5), NG_OK);
        const struct ng_transform *now = ng_world_get(world, tip, NG_TRANSFORM);
        if (steps[i].choice != NG_CLIPS_ALL) // whose mean stands as at rest
            assert_int_equal(memcmp((const void *)now, (const void *)&rest, sizeof rest) == 0,
                             steps[i].choice == NG_CLIPS_NONE);
    }
    ng_clip_menu_destroy(&menu);
    ng_world_destroy(&world);
    ng_assets_destroy(&assets);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_mirrored_camera_stays_mirrored),
        cmocka_unit_test(orbit_keeps_the_point_in_the_middle),
        cmocka_unit_test(orbit_stops_short_of_the_poles),
        cmocka_unit_test(look_takes_over_a_camera),
        cmocka_unit_test(flying_turns_about_the_eye),
        cmocka_unit_test(zoom_never_reaches_the_point),
        cmocka_unit_test(input_moves_the_camera),
        cmocka_unit_test(clock_wraps_and_pauses),
        cmocka_unit_test(files_that_change_are_told),
        cmocka_unit_test(a_clip_chosen_plays_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#include "test.h"

#include "app/camera_controller.h"
#include "app/clip_menu.h"
#include "app/pick.h"
#include "app/playback.h"
#include "app/watch.h"
#include "app/worker.h"
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
    struct ng_input input = {.held = {['D'] = 1}};
    ng_camera_controller_update(&c, &input, 100);
    assert_true(c.eye[0] > 0);
}

// Where a camera that carries the controller's transform looks.
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
    for (int i = 0; i < 100; i++)
        ng_camera_controller_zoom(&c, 1000);
    assert_true(c.point[2] > 0 && c.eye[2] > -2);
}

// Where a point of the world is on screen: from -1 to 1 to the right and up, in a picture as wide as high.
static void project(const struct ng_camera_controller *c, const float world[3], float out[2])
{
    struct ng_transform t = ng_camera_controller_transform(c);
    versor back;
    vec3 own;
    glm_quat_inv(t.rotation, back);
    glm_vec3_sub((float *)world, t.translation, own);
    glm_quat_rotatev(back, own, own);
    float half = c->lens / 2 * (c->parallel ? 1 : -own[2]);
    out[0] = own[0] * t.scale[0] / half;
    out[1] = own[1] / half;
}

// Whatever one does about a point, it stays where it is on screen, or under the pointer that drags it.
static void the_point_stays_under_the_pointer(void **state)
{
    NG_UNUSED(state);
    const float mirrored[16] = {[0] = -1, [5] = 1, [10] = 1, [15] = 1};
    const float point[3] = {0.7f, -0.4f, -3};
    for (int i = 0; i < 4; i++) {
        struct ng_camera_controller c;
        float before[2], after[2];
        bool parallel = i % 2;
        ng_camera_controller_look(&c, i < 2 ? identity : mirrored, 2);
        ng_camera_controller_see(&c, parallel ? 4 : 1.2f, parallel);
        ng_camera_controller_turn(&c, 0.2f, -0.1f);
        ng_camera_controller_take(&c, point);
        project(&c, point, before);
        ng_camera_controller_orbit(&c, 0.5f, 0.3f);
        ng_camera_controller_orbit(&c, -2, 5); // to the pole
        ng_camera_controller_zoom(&c, 3);
        ng_camera_controller_zoom(&c, -1);
        project(&c, point, after);
        assert_near3((float[]){after[0], after[1], 0}, before[0], before[1], 0);

        struct ng_input input = {.drag[NG_BUTTON_MIDDLE] = {20, 10}};
        ng_camera_controller_update(&c, &input, 100); // a fifth to the right, a tenth down
        project(&c, point, after);
        assert_near3((float[]){after[0], after[1], 0}, before[0] + 0.4f, before[1] - 0.2f, 0);
        float world[3];
        ng_camera_controller_point(&c, world);
        assert_near3(world, point[0], point[1], point[2]);
    }
}

static void orbit_keeps_its_distance_from_the_point(void **state)
{
    NG_UNUSED(state);
    struct ng_camera_controller c;
    vec3 point = {1, 2, -5};
    ng_camera_controller_look(&c, identity, 2);
    ng_camera_controller_take(&c, point);
    float before = glm_vec3_distance(c.eye, point);
    for (int i = 0; i < 50; i++)
        ng_camera_controller_orbit(&c, 0.3f, i % 3 ? 0.1f : -0.25f);
    assert_float_equal(glm_vec3_distance(c.eye, point), before, 1e-4f);
}

// A pointer on the sky: zooming goes that way and never gets stuck.
static void nothing_is_a_reach_away(void **state)
{
    NG_UNUSED(state);
    struct ng_camera_controller c;
    float on_screen[2], world[3];
    ng_camera_controller_look(&c, identity, 10);
    for (int i = 0; i < 20; i++) {
        ng_camera_controller_take_nothing(&c, 0.5f, -0.25f, 1);
        ng_camera_controller_point(&c, world);
        project(&c, world, on_screen);
        assert_near3((float[]){on_screen[0], on_screen[1], 0}, 0.5f, 0.25f, 0);
        ng_camera_controller_zoom(&c, 1);
    }
    assert_float_equal(c.eye[2], -20, 1e-3f);
}

static void framing_shows_all_of_a_sphere(void **state)
{
    NG_UNUSED(state);
    const float center[3] = {5, -1, 3};
    for (int i = 0; i < 4; i++) {
        float aspect = i < 2 ? 1.6f : 0.5f, radius = 0.3f, on_screen[2];
        struct ng_camera_controller c;
        ng_camera_controller_look(&c, identity, 2);
        ng_camera_controller_see(&c, i % 2 ? 4 : 1.2f, i % 2);
        ng_camera_controller_turn(&c, 0.7f, 0.2f);
        ng_camera_controller_frame(&c, center, radius, aspect);
        project(&c, center, on_screen);
        assert_near3((float[]){on_screen[0], on_screen[1], 0}, 0, 0, 0);
        vec3 look, far;
        ahead(&c, look);
        glm_vec3_ortho(look, far);
        glm_vec3_normalize(far);
        glm_vec3_scale(far, radius, far);
        glm_vec3_add((float *)center, far, far);
        project(&c, far, on_screen);
        float size = hypotf(on_screen[0], on_screen[1]) / fminf(aspect, 1); // of the side that is shorter
        assert_true(size > 0.7f && size < 1);
    }
}

static void input_moves_the_camera(void **state)
{
    NG_UNUSED(state);
    struct ng_camera_controller c, still;
    ng_camera_controller_look(&c, identity, 2);
    ng_camera_controller_orbit(&c, 0.1f, 0);
    still = c;
    struct ng_input input = {.pointer = {50, -20}, .buttons = {true, true, true}, .down = {['W'] = true}};
    ng_camera_controller_update(&c, &input, 500);
    assert_memory_equal(&c, &still,
                        sizeof c); // the mouse rests, and a key that is down has not been for long

    input = (struct ng_input){.drag[NG_BUTTON_LEFT] = {50, -20}};
    ng_camera_controller_update(&c, &input, 500);
    assert_near(c.yaw, -0.2f);
    assert_near(c.pitch, 0.12f);
}

// ---- Keys and time ---------------------------------------------------------------------------------------

// What a person does, by time.
struct act {
    double time;
    int key;
    bool down;
};

// How far the eye gets in frames of some length.
static void fly(const struct act *acts, size_t count, double frame, double end, float eye[3])
{
    struct ng_camera_controller c;
    struct ng_input input = {.time = 10};
    size_t next = 0;
    ng_camera_controller_look(&c, identity, 2); // 2 m/s
    for (double now = 0; now < end;) {
        now = fmin(now + frame, end);
        for (; next < count && acts[next].time <= now; next++)
            ng_input_key(&input, acts[next].key, acts[next].down, 10 + acts[next].time);
        ng_input_pass(&input, 10 + now);
        ng_camera_controller_update(&c, &input, 100);
        ng_input_begin(&input);
    }
    memcpy(eye, c.eye, sizeof c.eye);
}

static void flight_follows_the_time_of_a_key(void **state)
{
    NG_UNUSED(state);
    const struct {
        struct act acts[8];
        size_t count;
        float eye[3];
    } cases[] = {
        {{{0.103, 'W', true}, {0.353, 'W', false}}, 2, {0, 0, -0.5f}}, // a quarter of a second at 2 m/s
        {{{0.101, 'D', true}, {0.121, 'D', false}}, 2, {0.04f, 0, 0}}, // a tap
        {{{0, 'E', true}, {0.03, 'E', false}, {0.05, 'E', true}, {0.08, 'E', false}}, 4, {0, 0.12f, 0}},
        // Shift for a part of the way: 0.1 s at 2 m/s, 0.1 s at 8, 0.05 s at 2.
        {{{0.1, 'S', true}, {0.2, NG_KEY_SHIFT, true}, {0.3, NG_KEY_SHIFT, false}, {0.35, 'S', false}},
         4,
         {0, 0, 1.1f}},
        {{{0.1, 'W', true}, {0.15, 'S', true}, {0.25, 'W', false}, {0.26, 'S', false}}, 4, {0, 0, -0.08f}},
        {{{0.8, 'A', true}}, 1, {-0.4f, 0, 0}}, // still down at the end
    };
    static const double frames[] = {0.001, 1.0 / 60, 0.1, 0.23};
    for (size_t i = 0; i < NG_COUNT(cases); i++)
        for (size_t k = 0; k < NG_COUNT(frames); k++) {
            float eye[3];
            fly(cases[i].acts, cases[i].count, frames[k], 1, eye);
            for (int a = 0; a < 3; a++)
                assert_float_equal(eye[a], cases[i].eye[a], 1e-4f);
        }
}

// A program that slept for a minute does not fly for a minute.
static void steps_of_flight_are_bounded(void **state)
{
    NG_UNUSED(state);
    const struct act down = {0.1, 'W', true};
    float eye[3];
    fly(&down, 1, 60, 60, eye);
    assert_true(-eye[2] <= 2 * NG_INPUT_LONGEST + 1e-4f && eye[2] < 0);
}

static void the_wheel_sets_the_speed_in_flight(void **state)
{
    NG_UNUSED(state);
    struct ng_camera_controller c;
    ng_camera_controller_look(&c, identity, 2);
    struct ng_input input = {.scroll = 2, .down = {['W'] = true}};
    ng_camera_controller_update(&c, &input, 100);
    assert_near3(c.eye, 0, 0, 0);
    assert_true(c.speed > 2.5f);
    input.scroll = -2;
    ng_camera_controller_update(&c, &input, 100);
    assert_near(c.speed, 2);
    input = (struct ng_input){.scroll = -1e9f, .buttons[NG_BUTTON_RIGHT] = true};
    for (int i = 0; i < 100; i++)
        ng_camera_controller_update(&c, &input, 100);
    assert_true(c.speed > 0);
    input = (struct ng_input){.scroll = 1};
    ng_camera_controller_update(&c, &input, 100);
    assert_true(c.eye[2] < 0); // nobody flies: it zooms
}

static void presses_in_one_frame_are_counted(void **state)
{
    NG_UNUSED(state);
    struct ng_input input = {0};
    for (int i = 0; i < 3; i++) {
        ng_input_key(&input, NG_KEY_SHIFT, i == 1, 0.1 * i);
        ng_input_key(&input, 'L', true, 0.1 * i + 0.01);
        ng_input_key(&input, 'L', false, 0.1 * i + 0.03);
        ng_input_button(&input, NG_BUTTON_LEFT, true, 0.1 * i + 0.04);
        ng_input_pointer(&input, 10 + (float)i, 5, 0.1 * i + 0.05);
        ng_input_button(&input, NG_BUTTON_LEFT, false, 0.1 * i + 0.06);
        ng_input_pointer(&input, 100, 100, 0.1 * i + 0.07);
        ng_input_scroll(&input, 1, 0.1 * i + 0.08);
    }
    assert_int_equal(input.pressed['L'], 3);
    assert_int_equal(input.shifted['L'], 1); // and Shift is up again by now
    assert_int_equal(input.clicked[NG_BUTTON_LEFT], 3);
    assert_near(input.held['L'], 0.06f);
    assert_near(input.scroll, 3);
    // From 0 to 10, then back from 100 to 11 and 12: what moved while the button was up is no drag.
    assert_near(input.drag[NG_BUTTON_LEFT][0], 10 - 89 - 88);
    assert_near3((float[]){input.grip[NG_BUTTON_LEFT][0], input.grip[NG_BUTTON_LEFT][1], 0}, 100, 100, 0);
    for (int i = 0; i < 1000; i++)
        ng_input_key(&input, 'L', true, 1); // repeats
    assert_int_equal(input.pressed['L'], UINT8_MAX);
    ng_input_begin(&input);
    assert_true(input.pressed['L'] == 0 && input.down['L'] && input.held['L'] == 0 && input.scroll == 0);
}

// Two polls as one are what one poll would have been.
static void polls_add_up(void **state)
{
    NG_UNUSED(state);
    struct ng_input whole = {0}, part = {0}, sum = {0};
    for (int i = 0; i < 40; i++) {
        struct ng_input *each[] = {&whole, &part};
        double t = 0.01 * (i + 1);
        for (int k = 0; k < 2; k++) {
            ng_input_key(each[k], i % 3 ? 'W' : NG_KEY_SHIFT, i % 4 < 2, t);
            ng_input_button(each[k], NG_BUTTON_RIGHT, i % 5 < 3, t);
            ng_input_pointer(each[k], (float)(i * i % 7), (float)i, t);
            ng_input_scroll(each[k], i % 2 ? 1 : -2, t);
        }
        if (i % 6 == 5) {
            ng_input_add(&sum, &part);
            ng_input_begin(&part);
        }
    }
    ng_input_add(&sum, &part);
    assert_memory_equal(sum.pressed, whole.pressed, sizeof sum.pressed);
    assert_memory_equal(sum.shifted, whole.shifted, sizeof sum.shifted);
    assert_memory_equal(sum.clicked, whole.clicked, sizeof sum.clicked);
    assert_memory_equal(sum.grip, whole.grip, sizeof sum.grip);
    assert_near(sum.held['W'], whole.held['W']);
    assert_near(sum.hurried['W'], whole.hurried['W']);
    assert_near(sum.drag[NG_BUTTON_RIGHT][0], whole.drag[NG_BUTTON_RIGHT][0]);
    assert_near(sum.scroll, whole.scroll);
    assert_true(sum.time == whole.time && sum.down['W'] == whole.down['W']);
}

// ---- What is under the pointer ---------------------------------------------------------------------------

static void a_pick_tells_what_is_under_the_pointer(void **state)
{
    NG_UNUSED(state);
    float positions[6][4] = {[1] = {1, 2, 3, 1}, [3] = {4, 5, 6, -1}}, world[3], radius;
    uint32_t entities[6] = {[1] = 7, [3] = 9};
    struct ng_pick_bounds things[] = {
        {7, {0, 0, 0}, {1, 1, 1}}, {8, {-50, -50, -50}, {50, 50, 50}}, {7, {1, 1, 1}, {4, 2, 3}}};
    struct ng_pick pick = {.width = 3,
                           .height = 2,
                           .positions = {&positions[0][0], 24, 24},
                           .entities = {entities, 6, 6},
                           .things = {things, 3, 3}};
    assert_true(ng_pick_point(&pick, 1.9f, 0.9f, world));
    assert_near3(world, 1, 2, 3);
    assert_true(ng_pick_point(&pick, 0, 1, world)); // a lamp
    assert_near3(world, 4, 5, 6);
    assert_false(ng_pick_point(&pick, 2, 0, world));
    const float outside[][2] = {{-0.1f, 0}, {3, 0}, {0, 2}, {1, -1}, {NAN, 0}, {1e20f, 1}};
    for (size_t i = 0; i < NG_COUNT(outside); i++)
        assert_false(ng_pick_point(&pick, outside[i][0], outside[i][1], world));
    assert_true(ng_pick_thing(&pick, 1, 0, world, &radius)); // all of its parts
    assert_near3(world, 2, 1, 1.5f);
    assert_near(radius, sqrtf(16 + 4 + 9) / 2);
    assert_false(ng_pick_thing(&pick, 0, 1, world, &radius)); // whose bounds nobody knows
    assert_false(ng_pick_thing(&pick, 0, 0, world, &radius));
}

// ---- Work on another thread
// --------------------------------------------------------------------------------

struct labour {
    int made, told;
};

static void make(void *user)
{
    ((struct labour *)user)->made++;
}

static void tell(void *user)
{
    ((struct labour *)user)->told++;
}

static void a_worker_does_one_thing_after_another(void **state)
{
    NG_UNUSED(state);
    struct labour labour = {0};
    struct ng_worker *worker;
    assert_int_equal(ng_worker_create(&(struct ng_worker_params){make, tell, &labour}, &worker), NG_OK);
    for (int i = 1; i <= 100; i++) {
        ng_worker_begin(worker);
        while (ng_worker_is_busy(worker))
            thrd_yield();
        assert_int_equal(labour.made, i);
    }
    ng_worker_begin(worker);
    ng_worker_destroy(&worker); // what was begun is done
    assert_int_equal(labour.made, 101);
    assert_int_equal(labour.told, 101);
    assert_null(worker);
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
        cmocka_unit_test(the_point_stays_under_the_pointer),
        cmocka_unit_test(orbit_keeps_its_distance_from_the_point),
        cmocka_unit_test(nothing_is_a_reach_away),
        cmocka_unit_test(framing_shows_all_of_a_sphere),
        cmocka_unit_test(input_moves_the_camera),
        cmocka_unit_test(flight_follows_the_time_of_a_key),
        cmocka_unit_test(steps_of_flight_are_bounded),
        cmocka_unit_test(the_wheel_sets_the_speed_in_flight),
        cmocka_unit_test(presses_in_one_frame_are_counted),
        cmocka_unit_test(polls_add_up),
        cmocka_unit_test(a_pick_tells_what_is_under_the_pointer),
        cmocka_unit_test(a_worker_does_one_thing_after_another),
        cmocka_unit_test(clock_wraps_and_pauses),
        cmocka_unit_test(files_that_change_are_told),
        cmocka_unit_test(a_clip_chosen_plays_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// The animation system on a world: blending, quiet ticks, and targets that are not what clips expect.
#include "test.h"

#include "anim/animate.h"
#include "base/jobs.h"
#include "components/animation.h"
#include "components/camera.h"
#include "components/components.h"
#include "components/transform.h"
#include "scene/system.h"
#include "scene/world.h"

#include <math.h>

#define NEAR(a, b, e) assert_true(fabs((double)(a) - (double)(b)) <= (e))
#define OK(call)      assert_int_equal((call), NG_OK)

enum { CLIPS = 3 };

struct scene {
    struct ng_world *world;
    ng_entity target, players[CLIPS];
    struct ng_channel channels[CLIPS];
    struct ng_clip clips[CLIPS];
    float times[2], values[CLIPS][6];
    struct ng_animator *animator;
};

static const struct ng_clip *find_clip(const void *user, ng_asset clip)
{
    const struct scene *s = user;
    return clip.id && clip.id <= CLIPS ? &s->clips[clip.id - 1] : NULL;
}

// Clip k moves the target along x from 0 to 10 (k + 1) in a second.
static void open_scene(struct scene *s)
{
    memset(s, 0, sizeof *s);
    OK(ng_world_create(NULL, &s->world));
    OK(ng_components_register(s->world));
    OK(ng_animator_create(&s->animator));
    s->target = ng_entity_create(s->world);
    OK(ng_world_add(s->world, s->target, NG_TRANSFORM, NULL));
    s->times[1] = 1;
    for (uint32_t k = 0; k < CLIPS; k++) {
        s->values[k][3] = 10 * (float)(k + 1);
        s->channels[k] = (struct ng_channel){.target = s->target,
                                             .component = NG_TRANSFORM,
                                             .field_offset = offsetof(struct ng_transform, translation),
                                             .width = 3,
                                             .interpolation = NG_INTERPOLATION_LINEAR,
                                             .key_count = 2,
                                             .times = s->times,
                                             .values = s->values[k]};
        s->clips[k] = (struct ng_clip){.channel_count = 1, .channels = &s->channels[k], .duration = 1};
        s->players[k] = ng_entity_create(s->world);
        OK(ng_world_add(s->world, s->players[k], NG_ANIMATION,
                        &(struct ng_animation){.clip = {k + 1}, .weight = 1, .speed = 1, .playing = k == 0}));
    }
}

static void close_scene(struct scene *s)
{
    ng_animator_destroy(&s->animator);
    ng_world_destroy(&s->world);
}

static float animate(struct scene *s, double time)
{
    OK(ng_animate(s->animator, &(struct ng_animate_params){
                                   .world = s->world, .time = time, .lookup = find_clip, .user = s}));
    const struct ng_transform *t = ng_world_get(s->world, s->target, NG_TRANSFORM);
    return t ? t->translation[0] : NAN;
}

static struct ng_animation *player(struct scene *s, int k)
{
    return ng_world_edit(s->world, s->players[k], NG_ANIMATION);
}

static void test_plays_blends_and_stops(void **state)
{
    (void)state;
    struct scene s;
    open_scene(&s);
    NEAR(animate(&s, 0.5), 5, 1e-5);
    player(&s, 1)->playing = true; // a second clip on the same field: the mean
    NEAR(animate(&s, 0.5), 7.5, 1e-5);
    player(&s, 1)->weight = 3; // by weight
    NEAR(animate(&s, 0.5), 5 * 0.25 + 10 * 0.75, 1e-5);
    player(&s, 0)->weight = 0; // off
    NEAR(animate(&s, 0.5), 10, 1e-5);
    player(&s, 1)->clip.id = 3; // another clip in the same player
    NEAR(animate(&s, 0.5), 15, 1e-5);
    player(&s, 1)->playing = false; // nobody drives the field: it stays
    NEAR(animate(&s, 0.9), 15, 1e-5);
    player(&s, 2)->playing = true;
    player(&s, 2)->clip.id = 99; // no such clip
    NEAR(animate(&s, 0.2), 15, 1e-5);
    close_scene(&s);
}

static void test_only_what_differs_is_written(void **state)
{
    (void)state;
    struct scene s;
    open_scene(&s);
    animate(&s, 0.5);
    uint32_t since = ng_world_stamp(s.world);
    animate(&s, 0.5); // paused
    assert_true(ng_world_changed_at(s.world, s.target, NG_TRANSFORM) <= since);
    animate(&s, 2);
    assert_true(ng_world_changed_at(s.world, s.target, NG_TRANSFORM) > since);
    since = ng_world_stamp(s.world);
    animate(&s, 3); // past the end
    assert_true(ng_world_component_changed_at(s.world, NG_TRANSFORM) <= since);
    close_scene(&s);
}

// Splines overshoot: what a field cannot hold stays outside of it.
static void test_values_keep_to_the_field(void **state)
{
    (void)state;
    struct scene s;
    float fov[6] = {0, 1, 40, 40, 1, 0}, wild[6] = {0, 1, NAN, INFINITY, 1, 0}; // in, value, out
    open_scene(&s);
    OK(ng_world_add(s.world, s.target, NG_CAMERA, NULL));
    const struct ng_camera *camera = ng_world_get(s.world, s.target, NG_CAMERA);
    s.channels[0] = (struct ng_channel){.target = s.target,
                                        .component = NG_CAMERA,
                                        .field_offset = offsetof(struct ng_camera, fov_y),
                                        .width = 1,
                                        .interpolation = NG_INTERPOLATION_CUBIC,
                                        .key_count = 2,
                                        .times = s.times,
                                        .values = fov};
    animate(&s, 0.2);
    assert_true(camera->fov_y == 3.1f);
    animate(&s, 1);
    assert_true(camera->fov_y == 1);
    s.channels[0].values = wild;
    animate(&s, 0.5);
    assert_true(camera->fov_y == 1); // as it was
    close_scene(&s);
}

static void test_targets_that_are_not_there(void **state)
{
    (void)state;
    struct scene s;
    open_scene(&s);
    s.channels[1].component = NG_CAMERA; // the target has none
    s.channels[2].field_offset = sizeof(struct ng_transform) - 4;
    player(&s, 1)->playing = player(&s, 2)->playing = true;
    NEAR(animate(&s, 0.5), 5, 1e-5);
    s.channels[0].target = (ng_entity){12345};
    OK(ng_world_remove(s.world, s.target, NG_TRANSFORM));
    animate(&s, 0.6);
    OK(ng_entity_destroy(s.world, s.target));
    animate(&s, 0.7);
    close_scene(&s);
}

static void test_as_a_system(void **state)
{
    (void)state;
    struct scene s;
    open_scene(&s);
    OK(ng_animation_system_add(
        &(struct ng_animate_params){.world = s.world, .lookup = find_clip, .user = &s}));
    OK(ng_world_run(s.world, 0.25));
    NEAR(((const struct ng_transform *)ng_world_get(s.world, s.target, NG_TRANSFORM))->translation[0], 2.5,
         1e-5);
    close_scene(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_plays_blends_and_stops),
        cmocka_unit_test(test_only_what_differs_is_written),
        cmocka_unit_test(test_values_keep_to_the_field),
        cmocka_unit_test(test_targets_that_are_not_there),
        cmocka_unit_test(test_as_a_system),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

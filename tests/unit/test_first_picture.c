// What a file gets that has no light, no camera, several clips of one thing, or lamps that are only emissive.
#include "test.h"

#include "anim/clips.h"
#include "asset/assets.h"
#include "asset/gltf.h"
#include "base/file.h"
#include "components/animation.h"
#include "components/camera.h"
#include "components/components.h"
#include "components/light_environment.h"
#include "components/name.h"
#include "components/scene_scale.h"
#include "components/transform.h"
#include "scene/world.h"

#include <math.h>

struct loaded {
    struct ng_world *world;
    struct ng_assets *assets;
    struct ng_gltf_scene scene;
};

static ng_result load_path(struct loaded *l, const char *path, const struct ng_gltf_params *params)
{
    struct test_log log; // warnings of other parts are theirs
    assert_int_equal(ng_world_create(NULL, &l->world), NG_OK);
    assert_int_equal(ng_components_register(l->world), NG_OK);
    assert_int_equal(ng_assets_create(&l->assets), NG_OK);
    test_log_begin(&log);
    ng_result r = ng_gltf_load(path, l->world, l->assets, params, &l->scene);
    test_log_end(&log);
    return r;
}

static ng_result load(struct loaded *l, const char *name, const struct ng_gltf_params *params)
{
    char path[256];
    snprintf(path, sizeof path, "tests/files/good/%s.gltf", name);
    return load_path(l, path, params);
}

static void finish(struct loaded *l)
{
    ng_assets_destroy(&l->assets);
    ng_world_destroy(&l->world);
}

// ---- light -----------------------------------------------------------------------------------------------

static void test_sky(void **state)
{
    NG_UNUSED(state);
    struct loaded l, again;
    const struct ng_gltf_params params = {.default_light = true};
    assert_int_equal(load(&l, "no_light", &params), NG_OK);
    assert_int_equal(load(&again, "no_light", &params), NG_OK);
    assert_false(ng_entity_is_null(l.scene.sky));
    assert_int_equal(l.scene.light_count, 1);
    const struct ng_light_environment *sky = ng_world_get(l.world, l.scene.sky, NG_LIGHT_ENVIRONMENT);
    const struct ng_image *map = ng_assets_image(l.assets, sky->map), *other = NULL;
    sky = ng_world_get(again.world, again.scene.sky, NG_LIGHT_ENVIRONMENT);
    other = ng_assets_image(again.assets, sky->map);
    assert_non_null(map);
    assert_int_equal(map->size, other->size);
    assert_memory_equal(map->pixels, other->pixels, map->size);
    const float *texels = map->pixels;
    float least = INFINITY, most = 0;
    for (size_t i = 0; i < (size_t)map->width * map->height; i++) {
        least = fminf(least, texels[i * 4]);
        most = fmaxf(most, texels[i * 4]);
    }
    assert_true(least > 0.01f && most > 5 * least); // nothing is black, and lamps stand out
    finish(&again);
    finish(&l);
}

// Whoever puts several files into one world asks for no sky, and a file with a light gets none.
static void test_no_sky(void **state)
{
    NG_UNUSED(state);
    struct loaded l;
    assert_int_equal(load(&l, "no_light", NULL), NG_OK);
    assert_true(ng_entity_is_null(l.scene.sky));
    assert_int_equal(l.scene.light_count, 0);
    finish(&l);
    assert_int_equal(load(&l, "no_camera", &(struct ng_gltf_params){.default_light = true}), NG_OK);
    assert_true(ng_entity_is_null(l.scene.sky));
    assert_int_equal(l.scene.light_count, 1);
    finish(&l);
}

// A light of no strength is none; one that NG_scene switches off is dark because its author wants that.
static void test_dark_lights(void **state)
{
    NG_UNUSED(state);
    struct loaded l;
    char path[512];
    void *data;
    size_t size;
    assert_int_equal(ng_file_read("tests/files/good/no_camera.gltf", 0, &data, &size), NG_OK);
    char *strength = strstr(data, "\"intensity\": 2.5");
    assert_non_null(strength);
    strength[strlen("\"intensity\": ")] = '0'; // 0.0
    strength[strlen("\"intensity\": 2.")] = '0';
    test_path(path, sizeof path, "dark.gltf");
    assert_int_equal(ng_file_write(path, data, size), NG_OK);
    free(data);
    assert_int_equal(load_path(&l, path, &(struct ng_gltf_params){.default_light = true}), NG_OK);
    assert_false(ng_entity_is_null(l.scene.sky));
    assert_int_equal(l.scene.light_count, 2);
    finish(&l);
}

static uint32_t emitters(const char *name, enum ng_gltf_emitters wanted)
{
    struct loaded l;
    const struct ng_gltf_params params = {.default_light = true, .emissive_lights = wanted};
    assert_int_equal(load(&l, name, &params), NG_OK);
    uint32_t count = 0;
    for (ng_entity e = l.scene.root; !ng_entity_is_null(e); e = ng_world_next_below(l.world, l.scene.root, e))
        count += ng_world_has(l.world, e, NG_LIGHT_MESH);
    if (wanted != NG_GLTF_EMITTERS_OFF && l.scene.foreign) {
        assert_int_equal(l.scene.emitter_count, count);
        assert_int_equal(l.scene.light_count, 1 + count); // and a sky
    }
    finish(&l);
    return count;
}

static void test_emissive_meshes(void **state)
{
    NG_UNUSED(state);
    assert_int_equal(emitters("emissive_only", NG_GLTF_EMITTERS_AUTO), 1);
    assert_int_equal(emitters("emissive_only", NG_GLTF_EMITTERS_ON), 1);
    assert_int_equal(emitters("emissive_only", NG_GLTF_EMITTERS_OFF), 0);
    assert_int_equal(emitters("no_light", NG_GLTF_EMITTERS_ON), 0);
    // One mesh of this file is a light by NG_scene, and no other becomes one unasked.
    assert_int_equal(emitters("everything", NG_GLTF_EMITTERS_AUTO), 1);
}

// Writes a file of as many emissive triangles as are asked for, of two materials in turn.
static void write_lamps(const char *path, int count)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs("{\"asset\": {\"version\": \"2.0\"}, \"nodes\": [{\"mesh\": 0}], \"meshes\": [{\"primitives\": [",
          file);
    for (int i = 0; i < count; i++)
        fprintf(file, "%s{\"attributes\": {\"POSITION\": 0}, \"material\": %d}", i ? ", " : "", i % 2);
    fputs(
        "]}], \"materials\": [{\"emissiveFactor\": [1, 1, 1]}, {\"emissiveFactor\": [0, 0, 1]}], "
        "\"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"type\": \"VEC3\", \"count\": 3, "
        "\"min\": [0, 0, 0], \"max\": [1, 1, 0]}], "
        "\"bufferViews\": [{\"buffer\": 0, \"byteLength\": 36}], \"buffers\": [{\"byteLength\": 36, \"uri\": "
        "\"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]}",
        file);
    assert_int_equal(fclose(file), 0);
}

// Few lamps are lights each, of many those of one material are one light together.
static void test_many_emissive_meshes(void **state)
{
    NG_UNUSED(state);
    static const struct {
        int lamps;
        uint32_t lights;
    } cases[] = {{3, 3}, {300, 2}};
    char path[512];
    test_path(path, sizeof path, "lamps.gltf");
    for (size_t i = 0; i < NG_COUNT(cases); i++) {
        struct loaded l;
        write_lamps(path, cases[i].lamps);
        assert_int_equal(load_path(&l, path, NULL), NG_OK);
        assert_int_equal(l.scene.primitive_count, cases[i].lamps);
        assert_int_equal(l.scene.emitter_count, cases[i].lights);
        finish(&l);
    }
}

// ---- camera ----------------------------------------------------------------------------------------------

struct view {
    float axes[3][3], eye[3]; // right, up, back
    float slope;              // of the frame's edge
};

static struct view view_of(const struct loaded *l)
{
    const struct ng_camera *camera = ng_world_get(l->world, l->scene.camera, NG_CAMERA);
    const struct ng_transform *t = ng_world_get(l->world, l->scene.camera, NG_TRANSFORM);
    float x = t->rotation[0], y = t->rotation[1], z = t->rotation[2], w = t->rotation[3];
    struct view v = {.axes = {{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
                              {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
                              {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}},
                     .slope = tanf(camera->fov_y / 2)};
    memcpy(v.eye, t->translation, sizeof v.eye);
    return v;
}

static float along(const float axis[3], const float p[3], const float eye[3])
{
    return axis[0] * (p[0] - eye[0]) + axis[1] * (p[1] - eye[1]) + axis[2] * (p[2] - eye[2]);
}

// The largest part of half the frame that a corner of a box takes, across or upright; above 1: it is not
// seen.
static float reach(const struct view *v, const float low[3], const float high[3])
{
    float most = 0;
    for (int corner = 0; corner < 8; corner++) {
        float p[3];
        for (int k = 0; k < 3; k++)
            p[k] = corner >> k & 1 ? high[k] : low[k];
        float depth = -along(v->axes[2], p, v->eye);
        assert_true(depth > 0);
        for (int k = 0; k < 2; k++)
            most = fmaxf(most, fabsf(along(v->axes[k], p, v->eye)) / (depth * v->slope));
    }
    return most;
}

static void test_made_camera(void **state)
{
    NG_UNUSED(state);
    struct loaded l;
    assert_int_equal(load(&l, "no_camera", NULL), NG_OK);
    assert_true(l.scene.camera_made);
    struct view v = view_of(&l);
    float part = reach(&v, (const float[]){-3, 0, -3}, (const float[]){3, 1, 3});
    assert_true(part > 0.8f && part < 1);
    // From the front right, a little above.
    assert_true(v.axes[2][0] > 0.2f && v.axes[2][1] > 0.1f && v.axes[2][1] < 0.6f && v.axes[2][2] > 0.5f);
    finish(&l);
}

// What is seen is 2 m high, whatever the file's points and its idle joints say.
static void test_skinned_bounds(void **state)
{
    NG_UNUSED(state);
    struct loaded l;
    assert_int_equal(load(&l, "skin_framing_unused_joint", NULL), NG_OK);
    const struct ng_scene_scale *scale = ng_world_get(l.world, l.scene.root, NG_SCENE_SCALE);
    assert_true(scale->radius > 0.9f && scale->radius < 1.5f);
    finish(&l);
    // The column leans to the left when the first clip begins, to the right in the second, and stands in the
    // third: the floor is the larger, so that the box of all is wide; its height is the column's.
    static const char *const clips[] = {"left", "right", "straight", "none"};
    float centers[4];
    for (int i = 0; i < 4; i++) {
        assert_int_equal(load(&l, "clips_three", &(struct ng_gltf_params){.clip = clips[i]}), NG_OK);
        scale = ng_world_get(l.world, l.scene.root, NG_SCENE_SCALE);
        centers[i] = scale->center[1];
        finish(&l);
    }
    assert_float_equal(centers[0], centers[1], 1e-3);
    assert_float_equal(centers[2], 1, 1e-3);
    assert_float_equal(centers[3], 1, 1e-3);
    assert_true(centers[0] < 0.9f);
}

// ---- clips -----------------------------------------------------------------------------------------------

// A letter for each clip that plays.
static void playing(const struct loaded *l, char *out)
{
    for (ng_entity e = l->scene.root; !ng_entity_is_null(e);
         e = ng_world_next_below(l->world, l->scene.root, e)) {
        const struct ng_animation *a = ng_world_get(l->world, e, NG_ANIMATION);
        if (a && a->playing)
            *out++ = ((const struct ng_name *)ng_world_get(l->world, e, NG_NAME))->text[0];
    }
    *out = 0;
}

static void test_clips_of_a_file(void **state)
{
    NG_UNUSED(state);
    static const struct {
        const char *choice, *plays;
    } cases[] = {{NULL, "l"}, {"right", "r"}, {"straight", "s"}, {"all", "lrs"}, {"none", ""}};
    struct loaded l;
    char plays[8];
    for (size_t i = 0; i < NG_COUNT(cases); i++) {
        assert_int_equal(load(&l, "clips_three", &(struct ng_gltf_params){.clip = cases[i].choice}), NG_OK);
        playing(&l, plays);
        assert_string_equal(plays, cases[i].plays);
        finish(&l);
    }
    assert_int_equal(load(&l, "clips_three", &(struct ng_gltf_params){.clip = "middle"}), NG_ERROR_NOT_FOUND);
    assert_int_equal(ng_world_entity_count(l.world), 0);
    finish(&l);
    assert_int_equal(load(&l, "no_light", &(struct ng_gltf_params){.clip = "none"}), NG_OK);
    finish(&l);
    assert_int_equal(load(&l, "no_light", &(struct ng_gltf_params){.clip = "left"}), NG_ERROR_NOT_FOUND);
    finish(&l);
}

#define CLIPS 5

// Clips of two fields: a and b drive the first, c the second, d both, and e, which blends, the first.
static void test_clips_of_other_fields(void **state)
{
    NG_UNUSED(state);
    struct ng_world *world;
    assert_int_equal(ng_world_create(NULL, &world), NG_OK);
    assert_int_equal(ng_components_register(world), NG_OK);
    ng_entity thing = ng_entity_create(world);
    assert_int_equal(ng_world_add(world, thing, NG_TRANSFORM, NULL), NG_OK);
    const struct ng_channel first = {.target = thing,
                                     .component = NG_TRANSFORM,
                                     .field_offset = 0,
                                     .width = 3},
                            second = {
                                .target = thing, .component = NG_TRANSFORM, .field_offset = 12, .width = 4};
    struct ng_channel channels[CLIPS][2] = {{first}, {first}, {second}, {first, second}, {first}};
    static const uint32_t counts[CLIPS] = {1, 1, 1, 2, 1};
    struct ng_clip clips[CLIPS];
    struct ng_clip_player players[CLIPS];
    for (int i = 0; i < CLIPS; i++) {
        clips[i] = (struct ng_clip){.channel_count = counts[i], .channels = channels[i]};
        players[i] = (struct ng_clip_player){ng_entity_create(world), &clips[i], i == 4};
        assert_int_equal(ng_world_add(world, players[i].entity, NG_ANIMATION, NULL), NG_OK);
    }
    static const bool expected[CLIPS] = {true, false, true, false, true};
    assert_int_equal(ng_clips_play(world, players, CLIPS, NULL), NG_OK);
    for (int i = 0; i < CLIPS; i++)
        assert_int_equal(
            ((const struct ng_animation *)ng_world_get(world, players[i].entity, NG_ANIMATION))->playing,
            expected[i]);

    // What the clips left behind is taken back.
    struct ng_clips_rest rest;
    struct ng_transform moved = {.translation = {1, 2, 3}, .rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}};
    assert_int_equal(ng_clips_rest_take(world, players, CLIPS, &rest), NG_OK);
    assert_int_equal(ng_world_set(world, thing, NG_TRANSFORM, &moved), NG_OK);
    ng_clips_rest_put(&rest, world);
    assert_memory_equal(ng_world_get(world, thing, NG_TRANSFORM), ng_transform_component.defaults,
                        sizeof moved);
    ng_clips_rest_finish(&rest);
    ng_world_destroy(&world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sky),
        cmocka_unit_test(test_no_sky),
        cmocka_unit_test(test_dark_lights),
        cmocka_unit_test(test_emissive_meshes),
        cmocka_unit_test(test_many_emissive_meshes),
        cmocka_unit_test(test_made_camera),
        cmocka_unit_test(test_skinned_bounds),
        cmocka_unit_test(test_clips_of_a_file),
        cmocka_unit_test(test_clips_of_other_fields),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

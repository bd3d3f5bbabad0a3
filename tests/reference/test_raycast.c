// The G-buffer by rays and the rasterizer's show the same: every layer, in every pixel inside of things; and
// on edges the same things but for a few pixels.
#include "views.h"

#include "app/stage.h"
#include "base/rng.h"
#include "components/transform.h"
#include "lightformer/raycast/finish.h"
#include "lightformer/raycast/raycast.h"
#include "scene/world.h"

#include <math.h>

enum { ENTITY, POSITION, NORMAL, ALBEDO, SPECULAR, ROUGHNESS, EMISSION, DEPTH, MOTION, LAYERS };
static const char *const names[LAYERS] = {"entity",    "position", "normal", "albedo", "specular",
                                          "roughness", "emission", "depth",  "motion"};

// Mean difference inside of things, relative to the layer's mean. Normals, albedo and the like are halfs;
// depth and position of the rasterizer come from its depth, and motion is a difference of such.
struct tolerances {
    double of[LAYERS];
    double others; // part of the pixels that show another thing
};
static const struct tolerances usual = {.of = {[POSITION] = 1e-5,
                                               [NORMAL] = 2e-3,
                                               [ALBEDO] = 6e-3,
                                               [SPECULAR] = 2e-3,
                                               [ROUGHNESS] = 2e-3,
                                               [EMISSION] = 0.01,
                                               [DEPTH] = 1e-5,
                                               [MOTION] = 1e-3},
                                        .others = 0.003};

// A stage, perhaps with the provider.
struct artist {
    struct ng_stage *stage;
    struct lf_raycast *raycast;
};

static void open_artist(const char *path, bool rays, uint32_t threads, struct artist *a)
{
    *a = (struct artist){0};
    OK(ng_stage_create(&(struct ng_stage_params){.scene = path, .threads = threads}, &a->stage));
    if (!rays)
        return;
    OK(lf_raycast_create(&(struct lf_raycast_params){.jobs = a->stage->jobs, .use = LF_RAYCAST_RAYS},
                         &a->raycast));
    OK(lf_raycast_join(a->raycast, ng_renderer_composer(a->stage->renderer)));
}

static void close_artist(struct artist *a)
{
    lf_raycast_destroy(&a->raycast);
    ng_stage_destroy(&a->stage);
}

// Whether the rays of the second frame pass beside the middles of pixels.
static bool shifted;

// The second of two frames, so that there is motion.
static void draw(struct artist *a, uint32_t width, uint32_t height, void (*change)(struct ng_stage *),
                 struct ng_layer layers[LAYERS])
{
    struct ng_stage_frame frame = {.width = width,
                                   .height = height,
                                   .layers = names,
                                   .layer_count = LAYERS,
                                   .time = 0.4,
                                   .averaged = shifted};
    if (change)
        change(a->stage);
    OK(ng_stage_draw(a->stage, &frame));
    frame.time += 1 / 30.0;
    frame.averaged *= 2;
    OK(ng_stage_draw(a->stage, &frame));
    for (int i = 0; i < LAYERS; i++)
        OK(ng_renderer_layer(a->stage->renderer, names[i], &layers[i]));
}

// What both show, and how many pixels show another thing: each a thing of its own. To free.
static uint32_t *agree(const struct ng_layer *a, const struct ng_layer *b, uint32_t *others)
{
    uint32_t pixels = a->width * a->height, *ids = calloc(pixels, sizeof *ids);
    assert_non_null(ids);
    *others = 0;
    for (uint32_t i = 0; i < pixels; i++) {
        bool same = a->ids[i] == b->ids[i];
        ids[i] = same ? a->ids[i] : UINT32_MAX - i;
        *others += !same;
    }
    return ids;
}

// Motion in pixels, and not as a part of it: most things stand still.
static double pixels_apart(const struct ng_layer *a, const struct ng_layer *b, const uint32_t *ids)
{
    double sum = 0;
    uint32_t inside = 0;
    for (uint32_t i = 0; i < a->width * a->height; i++) {
        uint32_t x = i % a->width, y = i / a->width;
        if (!view_is_inside(ids, (int)a->width, (int)a->height, (int)x, (int)y))
            continue;
        sum += hypot((double)a->pixels[2 * i] - (double)b->pixels[2 * i],
                     (double)a->pixels[2 * i + 1] - (double)b->pixels[2 * i + 1]);
        inside++;
    }
    return inside ? sum / inside : 0;
}

static void compare_with(const char *path, uint32_t width, uint32_t height, void (*change)(struct ng_stage *),
                         const struct tolerances *tolerances)
{
    struct artist rays, raster;
    struct ng_layer a[LAYERS], b[LAYERS];
    open_artist(path, true, 2, &rays);
    open_artist(path, false, 2, &raster);
    draw(&rays, width, height, change, a);
    draw(&raster, width, height, change, b);
    uint32_t others, *ids = agree(&a[ENTITY], &b[ENTITY], &others);
    for (int i = 1; i < LAYERS; i++) {
        double d = i == MOTION ? pixels_apart(&a[i], &b[i], ids)
                               : view_difference(a[i].pixels, b[i].pixels, ids, a[i].channels, (int)width,
                                                 (int)height);
        if (!(d <= tolerances->of[i]))
            fail_msg("%s, %ux%u: layer %s differs by %g", path, width, height, names[i], d);
    }
    if (others > 2 + (uint32_t)(tolerances->others * width * height))
        fail_msg("%s, %ux%u: %u pixels show another thing", path, width, height, others);
    free(ids);
    close_artist(&rays);
    close_artist(&raster);
}

static void compare(const char *path, uint32_t width, uint32_t height, void (*change)(struct ng_stage *))
{
    compare_with(path, width, height, change, &usual);
}

static const char *const unit[] = {"accessors",       "alpha_mask",
                                   "animated_fields", "character",
                                   "double_sided",    "hierarchy",
                                   "interpolation",   "light_directional",
                                   "light_disk",      "light_environment",
                                   "light_mesh",      "light_point",
                                   "light_rectangle", "light_rectangle_textured",
                                   "light_sphere",    "light_spot",
                                   "materials",       "mirrored",
                                   "normal_map",      "subdivision",
                                   "textures"};

static void test_every_unit_scene(void **state)
{
    (void)state;
    for (size_t i = 0; i < NG_COUNT(unit); i++) {
        char path[128];
        snprintf(path, sizeof path, "content/unit/%s.glb", unit[i]);
        compare(path, 160, 120, NULL);
    }
}

static void test_textures_and_what_covers_a_part(void **state)
{
    (void)state;
    static const char *const files[] = {"materials/blend_30",
                                        "materials/filter_nearest",
                                        "materials/leaves_far",
                                        "materials/magnified",
                                        "materials/specular_glossiness",
                                        "materials/texture_transform",
                                        "materials/unlit",
                                        "geometry/figure",
                                        "geometry/uv_set_1",
                                        "geometry/vertex_color"};
    for (size_t i = 0; i < NG_COUNT(files); i++) {
        char path[128];
        snprintf(path, sizeof path, "tests/files/%s.gltf", files[i]);
        compare(path, 192, 192, NULL);
    }
}

static void test_cameras(void **state)
{
    (void)state;
    static const char *const paths[] = {"content/unit/double_sided.glb", "content/unit/mirrored.glb",
                                        "tests/files/geometry/orthographic.gltf"};
    for (size_t k = 0; k < NG_COUNT(paths); k++)
        for (size_t i = 0; i < VIEW_CAMERAS; i++)
            compare(paths[k], 96, 96, view_cameras[i]);
    compare("tests/files/geometry/orthographic.gltf", 96, 64, NULL);
    compare("content/unit/materials.glb", 96, 64, view_look_in_parallel);
    compare("content/unit/textures.glb", 96, 64, view_look_in_parallel);
    compare("content/unit/character.glb", 96, 64, view_look_in_parallel);
    compare("content/unit/light_environment.glb", 96, 64, view_look_in_parallel);
    compare("content/unit/normal_map.glb", 192, 192, view_mirror_normal_maps);
    compare("content/unit/light_point.glb", 96, 96, view_turn_normals);
}

static void test_sizes(void **state)
{
    (void)state;
    static const uint32_t sizes[][2] = {{1, 1}, {1, 7}, {5, 1}, {3, 2}, {33, 29}, {64, 3}};
    for (size_t i = 0; i < NG_COUNT(sizes); i++) {
        compare("content/unit/materials.glb", sizes[i][0], sizes[i][1], NULL);
        compare("content/unit/light_sphere.glb", sizes[i][0], sizes[i][1], NULL);
    }
}

static void test_chess(void **state)
{
    (void)state;
    compare("content/chess/chess.glb", 256, 256, NULL);
}

// Whichever of the pictures it is that are averaged (render/subpixel.h).
static void test_shifted_rays(void **state)
{
    (void)state;
    shifted = true;
    compare("content/chess/chess.glb", 192, 128, NULL);
    compare("tests/files/materials/blend_30.gltf", 192, 192, NULL);
    compare("content/unit/light_environment.glb", 96, 64, NULL);
    compare("content/unit/materials.glb", 96, 64, view_look_in_parallel);
    shifted = false;
}

// Every light that has a place, in front of the camera and shining at it.
static void hang_lights_in_view(struct ng_stage *stage)
{
    OK(ng_stage_seek(stage, 0, NULL));
    const struct ng_snapshot *s = stage->snapshot;
    for (uint32_t i = 0; i < s->light_count; i++) {
        struct ng_transform *t = ng_world_edit(stage->world, s->lights[i].entity, NG_TRANSFORM);
        if (!t)
            continue;
        *t = (struct ng_transform){.translation = {((float)i - 0.5f) * 0.4f, 0.1f, -2},
                                   .rotation = {0, 1, 0, 0},
                                   .scale = {0.15f, 0.15f, 0.15f}};
        OK(ng_world_set_parent(stage->world, s->lights[i].entity, stage->scene.camera, (ng_entity){0}));
    }
}

// And what emits in front of the camera is a lamp.
static void expect_lamps(const char *path)
{
    struct artist a;
    struct ng_layer layers[LAYERS];
    uint32_t shining = 0;
    open_artist(path, true, 2, &a);
    draw(&a, 192, 160, hang_lights_in_view, layers);
    bool lamps = ng_snapshot_has_lamps(a.stage->snapshot);
    for (uint32_t i = 0; i < 192 * 160; i++)
        shining += layers[EMISSION].pixels[3 * i] > 0;
    close_artist(&a);
    if (!lamps || shining < 20)
        fail_msg("%s: %u pixels of a lamp", path, shining);
}

static void test_lamps(void **state)
{
    (void)state;
    static const char *const paths[] = {"content/unit/light_rectangle.glb", "content/unit/light_disk.glb",
                                        "content/unit/light_sphere.glb",
                                        "content/unit/light_rectangle_textured.glb"};
    for (size_t i = 0; i < NG_COUNT(paths); i++) {
        expect_lamps(paths[i]);
        compare(paths[i], 192, 160, hang_lights_in_view);
    }
}

// The same bytes for any number of threads.
static void test_threads(void **state)
{
    (void)state;
    struct artist one, many;
    struct ng_layer a[LAYERS], b[LAYERS];
    open_artist("content/unit/light_sphere.glb", true, 1, &one);
    open_artist("content/unit/light_sphere.glb", true, 5, &many);
    draw(&one, 61, 47, NULL, a);
    draw(&many, 61, 47, NULL, b);
    for (int i = 0; i < LAYERS; i++) {
        size_t size = (size_t)a[i].width * a[i].height * a[i].channels * 4;
        assert_memory_equal(a[i].info->uint ? (const void *)a[i].ids : a[i].pixels,
                            b[i].info->uint ? (const void *)b[i].ids : b[i].pixels, size);
    }
    close_artist(&one);
    close_artist(&many);
}

static void make_direction(struct ng_rng *rng, int lane, float out[3][LF_PACKET])
{
    float v[3], square = 0;
    for (int k = 0; k < 3; k++) {
        v[k] = ng_rng_range(rng, -1, 1) + 1e-3f;
        square += v[k] * v[k];
    }
    for (int k = 0; k < 3; k++)
        out[k][lane] = v[k] / sqrtf(square);
}

// Numbers of a tile, of which some are what surfaces seldom have: no normal, no area, the back.
static void make_tile(struct ng_rng *rng, struct lf_finish *tile, float direction[3][LF_PACKET])
{
    for (int i = 0; i < LF_PACKET; i++) {
        make_direction(rng, i, tile->flat);
        make_direction(rng, i, direction);
        tile->shown[i] = ng_rng_below(rng, 4) > 0;
        tile->side[i] = ng_rng_below(rng, 3) ? 1 : -1;
        tile->roughness[i] = ng_rng_float(rng);
        bool flat = ng_rng_below(rng, 8) > 0, smooth = !flat || ng_rng_below(rng, 8) > 0;
        for (int k = 0; k < 3; k++) {
            tile->normal[k][i] = smooth ? ng_rng_range(rng, -2, 2) : 0;
            tile->flat[k][i] = flat ? tile->flat[k][i] : 0;
            tile->albedo[k][i] = ng_rng_float(rng);
            tile->f0[k][i] = ng_rng_float(rng);
            tile->before[k][i] = ng_rng_range(rng, -9, 9);
        }
    }
}

static void test_instruction_sets(void **state)
{
    (void)state;
    struct ng_rng rng = ng_rng_make(5, 0);
    for (int round = 0; round < 200; round++) {
        struct lf_finish tile;
        struct lf_finish_view view = {.pixels = {300, 200},
                                      .middle = {7, -3},
                                      .parallel = round % 2,
                                      .previous = {1, 0, 0, 0, 0, 0.8f, 0.6f}};
        struct lf_finished first, other;
        float direction[3][LF_PACKET];
        view.previous[14] = 0.1f;
        make_tile(&rng, &tile, direction);
        lf_finish_kernels_of(0)->finish(&tile, direction, &view, &first);
        for (uint32_t k = 1; lf_finish_kernels_of(k); k++) {
            lf_finish_kernels_of(k)->finish(&tile, direction, &view, &other);
            assert_memory_equal(&first, &other, sizeof first);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_every_unit_scene),
                                       cmocka_unit_test(test_textures_and_what_covers_a_part),
                                       cmocka_unit_test(test_cameras),
                                       cmocka_unit_test(test_sizes),
                                       cmocka_unit_test(test_chess),
                                       cmocka_unit_test(test_shifted_rays),
                                       cmocka_unit_test(test_lamps),
                                       cmocka_unit_test(test_threads),
                                       cmocka_unit_test(test_instruction_sets)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

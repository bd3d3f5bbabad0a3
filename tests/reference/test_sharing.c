// Meshes that instances share where memory is short: rays meet what they meet in the flattened scene, in
// every way of tracing, when things move, and what does not fit is refused with its size.
#include "scene.h"

#include "base/rng.h"
#include "components/light_sphere.h"
#include "components/material.h"
#include "components/mesh.h"
#include "components/transform.h"
#include "lightformer/trace/view.h"
#include "scene/world.h"

#include <math.h>
#include <string.h>

enum { COPIES = 48, RAYS = 4096 };

// The scene's own tracer is flattened.
struct twins {
    struct scene scene;
    struct lf_tracer *shared;
    ng_entity copies[COPIES];
    struct ng_rng rng;
};

static ng_entity masked_material(struct scene *s)
{
    static const unsigned char texels[8] = {255, 255, 255, 0, 255, 255, 255, 255}; // the left half is a hole
    struct ng_image image = {.width = 2, .height = 1, .levels = 1, .format = NG_PIXEL_RGBA8_SRGB, .size = 8};
    ng_asset texture;
    image.pixels = malloc(sizeof texels);
    assert_non_null(image.pixels);
    memcpy(image.pixels, texels, sizeof texels);
    OK(ng_assets_take_image(s->assets, "mask", &image, &texture));
    ng_entity e = scene_material(s, (const float[3]){1, 1, 1}, 0, 1);
    struct ng_material *m = ng_world_edit(s->world, e, NG_MATERIAL);
    m->base_color_texture = texture;
    m->alpha_mode = NG_ALPHA_MASK;
    return e;
}

// Anywhere, turned, stretched, every third mirrored.
static struct ng_transform any_place(struct ng_rng *rng, int i)
{
    struct ng_transform t;
    for (int k = 0; k < 3; k++) {
        t.translation[k] = ng_rng_range(rng, -2, 2);
        t.scale[k] = ng_rng_range(rng, 0.5f, 1.5f);
    }
    float length = 0;
    for (int k = 0; k < 4; k++) {
        t.rotation[k] = ng_rng_range(rng, -1, 1);
        length += t.rotation[k] * t.rotation[k];
    }
    for (int k = 0; k < 4; k++)
        t.rotation[k] /= sqrtf(length);
    t.scale[0] *= i % 3 ? 1.0f : -1.0f;
    return t;
}

static void move(struct twins *w, int i)
{
    struct ng_transform t = any_place(&w->rng, i);
    OK(ng_world_set(w->scene.world, w->copies[i], NG_TRANSFORM, &t));
}

static void follow(struct twins *w)
{
    scene_frame(&w->scene, 0);
    OK(lf_tracer_update(w->shared, w->scene.snapshot));
}

static void open_twins(struct twins *w)
{
    const struct ng_light_sphere ball = {.on = true, .color = {1, 1, 1}, .radiance = 1, .radius = 0.5f};
    struct scene *s = &w->scene;
    w->rng = ng_rng_make(5, 1);
    scene_open(s, 2);
    const ng_entity materials[4] = {scene_material(s, (const float[3]){1, 1, 1}, 0, 1), masked_material(s),
                                    scene_material(s, (const float[3]){1, 0, 0}, 0, 1),
                                    scene_material(s, (const float[3]){1, 0, 0}, 0, 1)};
    ((struct ng_material *)ng_world_edit(s->world, materials[3], NG_MATERIAL))->double_sided = true;
    const ng_entity first[2] = {scene_sphere(s, (const float[3]){0, 0, 0}, 0.3f, false, materials[0]),
                                scene_quad(s, (const float[3]){0, 0, 0}, (const float[3]){1, 0, 0},
                                           (const float[3]){0, 1, 0.2f}, materials[0])};
    for (int i = 0; i < COPIES; i++) {
        struct ng_mesh mesh = *(const struct ng_mesh *)ng_world_get(s->world, first[i % 2], NG_MESH);
        mesh.material = materials[i / 2 % 4];
        w->copies[i] = scene_entity(s, "copy", (const float[3]){0, 0, 0}, NULL);
        OK(ng_world_add(s->world, w->copies[i], NG_MESH, &mesh));
        move(w, i);
    }
    scene_light(s, NG_LIGHT_SPHERE, &ball, (const float[3]){0, 0.5f, 0}, NULL);
    scene_frame(s, 0);
    OK(lf_tracer_create(&w->shared));
    lf_tracer_limit_memory(w->shared, lf_tracer_stats_of(s->tracer).bytes);
    OK(lf_tracer_update(w->shared, s->snapshot));
}

static void close_twins(struct twins *w)
{
    lf_tracer_destroy(&w->shared);
    scene_close(&w->scene);
}

static struct lf_ray any_ray(struct ng_rng *rng)
{
    struct lf_ray ray = {.far = ng_rng_below(rng, 2) ? INFINITY : 3};
    float length = 0;
    for (int k = 0; k < 3; k++) {
        ray.origin[k] = ng_rng_range(rng, -2, 2);
        ray.direction[k] = ng_rng_range(rng, -1, 1);
        length += ray.direction[k] * ray.direction[k];
    }
    for (int k = 0; k < 3; k++)
        ray.direction[k] /= sqrtf(length);
    return ray;
}

static bool same_hit(const struct lf_hit *a, const struct lf_hit *b)
{
    bool same = a->instance == b->instance && a->triangle == b->triangle && a->front == b->front &&
                fabsf(a->distance - b->distance) <= 1e-5f * (1 + a->distance);
    for (int k = 0; same && k < 3; k++)
        same = fabsf(a->normal[k] - b->normal[k]) < 1e-4f && fabsf(a->position[k] - b->position[k]) < 1e-4f;
    for (int k = 0; same && k < 2; k++)
        same = fabsf(a->barycentric[k] - b->barycentric[k]) < 1e-3f;
    return same;
}

static bool same_packet(const struct twins *w, const struct lf_ray *rays)
{
    struct lf_packet p = {.passes = 0}, a, b;
    struct lf_hit x[LF_PACKET], y[LF_PACKET];
    for (int i = 0; i < LF_PACKET; i++) {
        for (int k = 0; k < 3; k++) {
            p.origin[k][i] = rays[i].origin[k];
            p.direction[k][i] = rays[i].direction[k];
        }
        p.far[i] = rays[i].far;
    }
    a = b = p;
    lf_trace_packet(w->scene.tracer, &a, x);
    lf_trace_packet(w->shared, &b, y);
    bool same = true;
    for (int i = 0; i < LF_PACKET; i++)
        same = same && a.met[i] == b.met[i] && (!a.met[i] || same_hit(&x[i], &y[i]));
    a = b = p;
    lf_trace_packet_occluded(w->scene.tracer, &a);
    lf_trace_packet_occluded(w->shared, &b);
    return same && memcmp(a.met, b.met, sizeof a.met) == 0;
}

// What the twins say of 16 rays, in all ways; the hits that were compared.
static bool same_in_all_ways(const struct twins *w, const struct lf_ray *rays, int *hits)
{
    struct lf_hit x[LF_PACKET], y[LF_PACKET];
    bool met_x[LF_PACKET], met_y[LF_PACKET], dark_x[LF_PACKET], dark_y[LF_PACKET],
        same = same_packet(w, rays);
    const struct lf_tracer *flat = w->scene.tracer;
    lf_trace_closest_many(flat, rays, LF_PACKET, met_x, x);
    lf_trace_closest_many(w->shared, rays, LF_PACKET, met_y, y);
    lf_trace_occluded_many(flat, rays, LF_PACKET, dark_x);
    lf_trace_occluded_many(w->shared, rays, LF_PACKET, dark_y);
    for (int i = 0; i < LF_PACKET; i++) {
        *hits += met_x[i];
        same =
            same && met_x[i] == met_y[i] && dark_x[i] == dark_y[i] && (!met_x[i] || same_hit(&x[i], &y[i]));
        same = same && lf_trace_shadowed(flat, &rays[i], 0) == lf_trace_shadowed(w->shared, &rays[i], 0);
        for (int kind = 0; kind < 2; kind++) {
            bool a = lf_trace_closest(flat, &rays[i], (enum lf_ray_kind)kind, &x[i]);
            bool b = lf_trace_closest(w->shared, &rays[i], (enum lf_ray_kind)kind, &y[i]);
            same = same && a == b && (!a || same_hit(&x[i], &y[i]));
        }
    }
    return same;
}

// What the camera sees in a picture: of the twins, and ray by ray.
static void expect_the_same_view(const struct twins *w, bool parallel)
{
    enum { WIDTH = 50, HEIGHT = 37 };
    struct ng_snapshot_camera camera = w->scene.snapshot->camera;
    camera.orthographic = parallel;
    camera.height = 4;
    const struct lf_view view = lf_view_of(&camera, WIDTH, HEIGHT);
    int others = 0, alone = 0, hits = 0;
    for (uint32_t y = 0; y < HEIGHT; y += LF_TILE)
        for (uint32_t x = 0; x < WIDTH; x += LF_TILE) {
            struct lf_tile a, b;
            lf_trace_tile(w->scene.tracer, &view, x, y, false, &a);
            lf_trace_tile(w->shared, &view, x, y, false, &b);
            for (uint32_t i = 0; i < LF_PACKET; i++) {
                const uint32_t pixel[2] = {x + i % LF_TILE, y + i / LF_TILE};
                const struct lf_ray ray = lf_view_ray(&view, pixel[0], pixel[1]);
                struct lf_hit hit;
                bool inside = pixel[0] < WIDTH && pixel[1] < HEIGHT;
                bool met = inside && lf_trace_pixel(w->scene.tracer, &ray, LF_RAY_CAMERA, pixel, &hit);
                hits += a.met[i];
                others += a.met[i] != b.met[i] || (a.met[i] && !same_hit(&a.hits[i], &b.hits[i]));
                alone += a.met[i] != met || (met && !same_hit(&a.hits[i], &hit));
            }
        }
    assert_true(hits > WIDTH * HEIGHT / 8);
    if (others > 4 || alone > 4)
        fail_msg("%d of %d pixels show other things, and %d ray by ray", others, hits, alone);
}

// But for rays along edges, where rounding decides.
static void expect_the_same(struct twins *w)
{
    int hits = 0, others = 0;
    for (int i = 0; i < RAYS / LF_PACKET; i++) {
        struct lf_ray rays[LF_PACKET];
        for (int k = 0; k < LF_PACKET; k++)
            rays[k] = any_ray(&w->rng);
        others += !same_in_all_ways(w, rays, &hits);
    }
    assert_true(hits > RAYS / 4);
    if (others > 1)
        fail_msg("%d of %d packets meet other things", others, RAYS / LF_PACKET);
    expect_the_same_view(w, false);
    expect_the_same_view(w, true);
}

static void test_shared_meshes_are_met_as_flattened_ones(void **state)
{
    (void)state;
    struct twins w;
    open_twins(&w);
    struct lf_tracer_stats flat = lf_tracer_stats_of(w.scene.tracer), shared = lf_tracer_stats_of(w.shared);
    assert_true(flat.shared == 0 && shared.shared >= COPIES && shared.triangles == flat.triangles);
    assert_true(shared.bytes < flat.bytes / 2);
    expect_the_same(&w);
    close_twins(&w);
}

static void test_shared_meshes_follow_what_moves(void **state)
{
    (void)state;
    struct twins w;
    open_twins(&w);
    for (int i = 0; i < COPIES; i += 5)
        move(&w, i);
    follow(&w);
    struct lf_tracer_stats stats = lf_tracer_stats_of(w.shared);
    assert_true(stats.built == 0 && stats.updated == (COPIES + 4) / 5);
    expect_the_same(&w);
    // Masks come and go with materials; a mesh is shared by masked and opaque ones.
    const struct ng_mesh *mesh = ng_world_get(w.scene.world, w.copies[4], NG_MESH);
    struct ng_material *m = ng_world_edit(w.scene.world, mesh->material, NG_MATERIAL);
    m->alpha_mode = NG_ALPHA_MASK;
    m->alpha = 0.1f; // nothing of it is left
    follow(&w);
    expect_the_same(&w);
    // What Embree could not turn rays to and fro is flattened: a sphere that is a point, quads that are far
    // too narrow (one is not), or too long.
    const float scales[] = {0, 1e-4f, 1e-9f, 1e9f};
    for (int i = 0; i < 4; i++) {
        struct ng_transform *t = ng_world_edit(w.scene.world, w.copies[i ? 2 * i - 1 : 0], NG_TRANSFORM);
        for (int k = i ? 1 : 0; k < (i ? 2 : 3); k++)
            t->scale[k] = scales[i];
    }
    follow(&w);
    stats = lf_tracer_stats_of(w.shared);
    assert_true(stats.built > 0 && stats.shared == COPIES + 2 - 3);
    expect_the_same(&w);
    close_twins(&w);
}

static void test_what_does_not_fit_is_refused_with_its_size(void **state)
{
    (void)state;
    struct twins w;
    struct test_log log;
    open_twins(&w);
    lf_tracer_limit_memory(w.shared, 10000);
    OK(ng_entity_destroy(w.scene.world, w.copies[0])); // so that all is built again
    scene_frame(&w.scene, 0);
    test_log_begin(&log);
    assert_int_equal(lf_tracer_update(w.shared, w.scene.snapshot), NG_ERROR_MEMORY);
    test_log_end(&log);
    assert_int_equal(log.errors, 1);
    assert_non_null(strstr(log.text, "triangles need"));
    // More than was thought: Embree may not take it either.
    lf_tracer_limit_memory(w.shared, 150000);
    test_log_begin(&log);
    assert_int_equal(lf_tracer_update(w.shared, w.scene.snapshot), NG_ERROR_MEMORY);
    test_log_end(&log);
    assert_int_equal(log.errors, 1);
    lf_tracer_limit_memory(w.shared, 0);
    follow(&w);
    assert_int_equal(lf_tracer_stats_of(w.shared).shared, 0);
    expect_the_same(&w);
    close_twins(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_shared_meshes_are_met_as_flattened_ones),
        cmocka_unit_test(test_shared_meshes_follow_what_moves),
        cmocka_unit_test(test_what_does_not_fit_is_refused_with_its_size),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// Rays: hits, sides, masks, exact shapes, textures, and updates that touch what moved.
#include "scene.h"

#include "base/rng.h"
#include "components/light_disk.h"
#include "components/light_sphere.h"
#include "components/material.h"
#include "components/mesh.h"
#include "components/name.h"
#include "components/transform.h"
#include "lightformer/trace/texture.h"
#include "lightformer/trace/vec.h"
#include "render/copies.h"
#include "scene/world.h"

#include <math.h>
#include <string.h>

static const float origin[3] = {0, 0, 0};

static struct lf_ray make_ray(float x, float y, float z, float dx, float dy, float dz)
{
    float length = sqrtf(dx * dx + dy * dy + dz * dz);
    return (struct lf_ray){
        .origin = {x, y, z}, .direction = {dx / length, dy / length, dz / length}, .far = INFINITY};
}

// Embree divides by a reciprocal that its kernels for SSE, AVX2 and AVX-512 refine each in a way of their
// own: distances are off by a few units of the last place, and so is all that follows from a hit.
#define ROUNDING 1e-6

static ng_entity add_floor(struct scene *s, ng_entity material)
{
    return scene_quad(s, (const float[3]){-1, -1, 0}, (const float[3]){2, 0, 0}, (const float[3]){0, 2, 0},
                      material);
}

static void test_a_hit_says_where_and_what(void **state)
{
    (void)state;
    struct scene s;
    scene_open(&s, 1);
    add_floor(&s, scene_material(&s, (const float[3]){0.5f, 0.25f, 1}, 0.5f, 0.01f));
    scene_frame(&s, 0);
    struct lf_ray ray = make_ray(0.25f, -0.5f, 2, 0, 0, -1);
    struct lf_hit hit;
    struct lf_surface surface;
    assert_true(lf_trace_closest(s.tracer, &ray, LF_RAY_ALL, &hit));
    assert_true(hit.front && hit.instance == 0);
    NEAR(hit.distance, 2, ROUNDING);
    NEAR(hit.position[0], 0.25, ROUNDING);
    NEAR(hit.position[1], -0.5, ROUNDING);
    NEAR(hit.position[2], 0, ROUNDING);
    NEAR(hit.normal[2], 1, ROUNDING);
    lf_surface_at(s.tracer, &hit, &surface);
    NEAR(surface.albedo[1], 0.125, 1e-6);
    NEAR(surface.f0[0], 0.27, 1e-6);
    NEAR(surface.roughness, 0.045, 1e-6);
    assert_true(surface.light == NG_NONE && !lf_surface_is_black(&surface));
    // Limits of the ray.
    ray.far = 1.9f;
    assert_false(lf_trace_closest(s.tracer, &ray, LF_RAY_ALL, &hit));
    assert_false(lf_trace_occluded(s.tracer, &ray));
    ray.far = 2.1f;
    assert_true(lf_trace_occluded(s.tracer, &ray));
    ray.near = 2.05f;
    assert_false(lf_trace_closest(s.tracer, &ray, LF_RAY_ALL, &hit));
    scene_close(&s);
}

static void test_camera_rays_pass_through_backs(void **state)
{
    (void)state;
    struct scene s;
    scene_open(&s, 1);
    ng_entity material = scene_material(&s, (const float[3]){1, 1, 1}, 0, 1);
    add_floor(&s, material);
    scene_frame(&s, 0);
    struct lf_ray below =
        make_ray(0.25f, -0.5f, -2, 0, 0, 1); // off the diagonal, which is two triangles' edge
    struct lf_hit hit;
    struct lf_surface surface;
    assert_false(lf_trace_closest(s.tracer, &below, LF_RAY_CAMERA, &hit));
    assert_true(lf_trace_occluded(s.tracer, &below));
    assert_true(lf_trace_closest(s.tracer, &below, LF_RAY_ALL, &hit));
    assert_false(hit.front);
    lf_surface_at(s.tracer, &hit, &surface);
    assert_true(lf_surface_is_black(&surface));

    ((struct ng_material *)ng_world_edit(s.world, material, NG_MATERIAL))->double_sided = true;
    scene_frame(&s, 1);
    assert_true(lf_trace_closest(s.tracer, &below, LF_RAY_CAMERA, &hit));
    lf_surface_at(s.tracer, &hit, &surface);
    assert_false(hit.front);
    NEAR(surface.normal[2], -1, ROUNDING);
    NEAR(surface.flat_normal[2], -1, ROUNDING);
    assert_false(lf_surface_is_black(&surface));
    scene_close(&s);
}

static void test_mirrored_placements_keep_their_front(void **state)
{
    (void)state;
    struct scene s;
    scene_open(&s, 1);
    ng_entity floor = add_floor(&s, scene_material(&s, (const float[3]){1, 1, 1}, 0, 1));
    ((struct ng_transform *)ng_world_edit(s.world, floor, NG_TRANSFORM))->scale[0] = -1;
    scene_frame(&s, 0);
    struct lf_ray above = make_ray(-2, 0.1f, 1, 0, 0, -1);
    struct lf_hit hit;
    assert_true(lf_trace_closest(s.tracer, &above, LF_RAY_CAMERA, &hit));
    assert_true(hit.front);
    NEAR(hit.normal[2], 1, ROUNDING);
    scene_close(&s);
}

// Light that a shading normal asks for must not be behind its own triangle.
static void test_triangles_overrule_normals_that_contradict_them(void **state)
{
    (void)state;
    struct scene s;
    scene_open(&s, 1);
    add_floor(&s, scene_material(&s, (const float[3]){1, 1, 1}, 0, 1));
    scene_frame(&s, 0);
    const struct lf_ray ray = make_ray(0.25f, -0.5f, 2, 0, 0, -1);
    const float tilts[] = {1.4f, 1.5f, 1.6f, 3}; // cosines 0.17, 0.07, -0.03, -0.99
    for (size_t i = 0; i < NG_COUNT(tilts); i++) {
        const float tilted[3] = {sinf(tilts[i]), 0, cosf(tilts[i])}, up[3] = {0, 0, 1};
        const struct ng_snapshot_mesh *mesh = &s.snapshot->meshes[s.snapshot->instances[0].mesh];
        struct lf_hit hit;
        struct lf_surface surface;
        for (uint32_t k = 0; k < mesh->vertex_count; k++)
            memcpy((float *)mesh->normals + k * 3, tilted, sizeof tilted);
        assert_true(lf_trace_closest(s.tracer, &ray, LF_RAY_ALL, &hit));
        lf_surface_at(s.tracer, &hit, &surface);
        for (int c = 0; c < 3; c++) {
            NEAR(surface.normal[c], i ? up[c] : tilted[c], 1e-6);
            NEAR(surface.flat_normal[c], up[c], 1e-6);
        }
    }
    scene_close(&s);
}

// The normal-mapped panel of the scene, and the shading normal at a place of its plane.
static ng_entity find_panel(const struct scene *s)
{
    for (uint32_t i = 0; i < s->snapshot->instance_count; i++) {
        const struct ng_name *name = ng_world_get(s->world, s->snapshot->instances[i].entity, NG_NAME);
        if (name && strcmp(name->text, "panel") == 0)
            return s->snapshot->instances[i].entity;
    }
    fail_msg("there is no panel");
    return (ng_entity){0};
}

static void find_normal(const struct scene *s, const float center[3], float x, float y, float out[3])
{
    struct lf_ray ray = make_ray(center[0] + x, center[1] + y, center[2] + 1, 0, 0, -1);
    struct lf_hit hit;
    struct lf_surface surface;
    assert_true(lf_trace_closest(s->tracer, &ray, LF_RAY_CAMERA, &hit));
    lf_surface_at(s->tracer, &hit, &surface);
    memcpy(out, surface.normal, sizeof surface.normal);
}

// Domes stay domes in a mirror, lit from above at their upper half.
static void test_mirrored_placements_mirror_normal_maps(void **state)
{
    (void)state;
    struct scene s;
    float before[3], after[3];
    scene_load(&s, 1, "content/unit/normal_map.glb");
    scene_frame(&s, 0);
    ng_entity panel = find_panel(&s);
    struct ng_transform t = *(const struct ng_transform *)ng_world_get(s.world, panel, NG_TRANSFORM);
    find_normal(&s, t.translation, 0.1f, 0.2f, before);
    assert_true(before[0] < -0.2f && before[1] > 0.2f); // the upper left part of a dome
    ((struct ng_transform *)ng_world_edit(s.world, panel, NG_TRANSFORM))->scale[0] = -1;
    scene_frame(&s, 0);
    find_normal(&s, t.translation, -0.1f, 0.2f, after);
    NEAR(after[0], -before[0], 1e-4);
    NEAR(after[1], before[1], 1e-4);
    NEAR(after[2], before[2], 1e-4);
    scene_close(&s);
}

// Which of the rays that look at metal from all around see it reflect into itself: `plain` with the normals
// that it has, `seen` with those that it shows.
struct mirrors {
    int met, plain, seen, turned;
};

static bool leads_out(const struct lf_surface *s, const float direction[3])
{
    float mirrored[3];
    lf_mad(direction, s->normal, -2 * lf_dot(direction, s->normal), mirrored);
    return lf_dot(mirrored, s->flat_normal) > 0 && lf_dot(direction, s->normal) < 0;
}

static void look_at_metal(const struct scene *s, const struct lf_ray *ray, struct mirrors *count)
{
    struct lf_hit hit;
    struct lf_surface plain, seen;
    if (!lf_trace_closest(s->tracer, ray, LF_RAY_ALL, &hit))
        return;
    lf_surface_at(s->tracer, &hit, &plain);
    lf_surface_seen_at(s->tracer, &hit, ray->direction, &seen);
    bool fine = leads_out(&plain, ray->direction);
    count->met++;
    count->plain += !fine;
    count->seen += !leads_out(&seen, ray->direction);
    NEAR(lf_dot(seen.normal, seen.normal), 1, 1e-5);
    // Nothing happens where nothing is wrong, but for reflections that just lead out.
    float turn = lf_dot(plain.normal, seen.normal);
    count->turned += fine && turn < 0.999f;
}

static struct mirrors look_at_all_metal(const struct scene *s)
{
    struct mirrors count = {0};
    struct ng_rng rng = ng_rng_make(9, 1);
    for (int i = 0; i < 20000; i++) {
        float from[3], to[3];
        for (int c = 0; c < 3; c++) {
            from[c] = ng_rng_range(&rng, -4, 4);
            to[c] = ng_rng_range(&rng, -2, 2);
        }
        struct lf_ray ray =
            make_ray(from[0], from[1], from[2], to[0] - from[0], to[1] - from[1], to[2] - from[2]);
        lf_normalize(ray.direction);
        look_at_metal(s, &ray, &count);
    }
    return count;
}

static void check_metal(struct scene *s)
{
    scene_frame(s, 0);
    struct mirrors count = look_at_all_metal(s);
    assert_true(count.met > 5000);
    assert_true(count.plain > count.met / 50);
    assert_int_equal(count.seen, 0);
    assert_int_equal(count.turned, 0);
}

// Bumps, and vertex normals of few triangles; from the front and from behind, and in a mirror.
static void test_metal_never_reflects_into_itself(void **state)
{
    (void)state;
    struct scene s;
    scene_load(&s, 1, "tests/files/materials/metal.gltf");
    check_metal(&s);
    const struct ng_snapshot *snapshot = s.snapshot;
    for (uint32_t i = 0; i < snapshot->material_count; i++) {
        struct ng_material *m = ng_world_edit(s.world, snapshot->materials[i].entity, NG_MATERIAL);
        if (m)
            m->double_sided = true;
    }
    check_metal(&s);
    for (uint32_t i = 0; i < snapshot->instance_count; i++)
        ((struct ng_transform *)ng_world_edit(s.world, snapshot->instances[i].entity, NG_TRANSFORM))
            ->scale[0] = -1;
    check_metal(&s);
    for (uint32_t i = 0; i < snapshot->material_count; i++) {
        struct ng_material *m = ng_world_edit(s.world, snapshot->materials[i].entity, NG_MATERIAL);
        if (m) // smooth normals alone
            m->normal_scale = 0;
    }
    scene_frame(&s, 0);
    struct mirrors count = look_at_all_metal(&s);
    assert_true(count.plain > 20);
    assert_int_equal(count.seen, 0);
    scene_close(&s);
}

// Bumps of matt surfaces stay: their light needs no reflections.
static void test_matt_surfaces_keep_their_normals(void **state)
{
    (void)state;
    struct scene s;
    struct lf_hit hit;
    struct lf_surface plain, seen;
    scene_open(&s, 1);
    add_floor(&s, scene_material(&s, (const float[3]){0.8f, 0.8f, 0.8f}, 0, 1));
    scene_frame(&s, 0);
    const struct ng_snapshot_mesh *mesh = &s.snapshot->meshes[s.snapshot->instances[0].mesh];
    const float tilted[3] = {sinf(1), 0, cosf(1)};
    for (uint32_t k = 0; k < mesh->vertex_count; k++)
        memcpy((float *)mesh->normals + k * 3, tilted, sizeof tilted);
    const struct lf_ray ray = make_ray(-0.3f, -0.5f, 1, 0.5f, 0, -0.9f);
    assert_true(lf_trace_closest(s.tracer, &ray, LF_RAY_ALL, &hit));
    lf_surface_at(s.tracer, &hit, &plain);
    lf_surface_seen_at(s.tracer, &hit, ray.direction, &seen);
    assert_false(leads_out(&plain, ray.direction));
    assert_true(lf_dot(plain.normal, seen.normal) > 0.998f);
    scene_close(&s);
}

// Two panes that cover a third each: rays that differ in their samples alone are stopped by each as often as
// that, and by one as if the other were not there. A ray meets the same whenever it is traced.
static void test_blended_surfaces_stop_their_part(void **state)
{
    (void)state;
    enum { RAYS = 8192 };
    struct scene s;
    uint32_t met[3] = {0};
    scene_open(&s, 1);
    ng_entity pane = scene_material(&s, (const float[3]){1, 1, 1}, 0, 1);
    struct ng_material *m = ng_world_edit(s.world, pane, NG_MATERIAL);
    m->alpha_mode = NG_ALPHA_BLEND;
    m->alpha = 1 / 3.0f;
    for (int i = 0; i < 2; i++)
        scene_quad(&s, (const float[3]){-1, -1, (float)-i}, (const float[3]){2, 0, 0},
                   (const float[3]){0, 2, 0}, pane);
    scene_frame(&s, 0);
    for (uint32_t i = 0; i < RAYS; i++) {
        struct lf_ray ray = {
            .origin = {0.3f, 0.1f, 1}, .direction = {0, 0, -1}, .far = INFINITY, .sample = i};
        struct lf_hit hit, again;
        bool stopped = lf_trace_closest(s.tracer, &ray, LF_RAY_ALL, &hit);
        assert_int_equal(lf_trace_closest(s.tracer, &ray, LF_RAY_ALL, &again), stopped);
        assert_int_equal(lf_trace_occluded(s.tracer, &ray), stopped);
        met[stopped ? hit.distance > 1.5f : 2]++;
    }
    NEAR(met[0] / (double)RAYS, 1 / 3.0, 0.02);
    NEAR(met[1] / (double)RAYS, 2 / 9.0, 0.02);
    NEAR(met[2] / (double)RAYS, 4 / 9.0, 0.02);
    // Of pixels the same, a few at a time.
    memset(met, 0, sizeof met);
    for (uint32_t y = 0; y < 64; y++)
        for (uint32_t x = 0; x < 64; x++) {
            struct lf_ray ray = {.origin = {0.3f, 0.1f, 1}, .direction = {0, 0, -1}, .far = INFINITY};
            struct lf_hit hit;
            bool stopped = lf_trace_pixel(s.tracer, &ray, LF_RAY_CAMERA, (const uint32_t[2]){x, y}, &hit);
            met[stopped ? hit.distance > 1.5f : 2]++;
        }
    NEAR(met[0] / 4096.0, 1 / 3.0, 0.01);
    NEAR(met[1] / 4096.0, 2 / 9.0, 0.02);
    scene_close(&s);
}

static void test_alpha_masks_let_rays_through(void **state)
{
    (void)state;
    struct scene s;
    scene_open(&s, 1);
    // Left half transparent.
    struct ng_image image = {.width = 2, .height = 1, .levels = 1, .format = NG_PIXEL_RGBA8_SRGB, .size = 8};
    static const unsigned char texels[8] = {255, 255, 255, 0, 255, 255, 255, 255};
    image.pixels = malloc(8);
    assert_non_null(image.pixels);
    memcpy(image.pixels, texels, 8);
    ng_asset texture;
    OK(ng_assets_take_image(s.assets, "mask", &image, &texture));
    ng_entity material = scene_material(&s, (const float[3]){1, 1, 1}, 0, 1);
    struct ng_material *m = ng_world_edit(s.world, material, NG_MATERIAL);
    m->base_color_texture = texture;
    m->alpha_mode = NG_ALPHA_MASK;
    add_floor(&s, material);
    scene_frame(&s, 0);
    struct lf_ray left = make_ray(-0.6f, 0.1f, 1, 0, 0, -1), right = make_ray(0.6f, 0.1f, 1, 0, 0, -1);
    struct lf_hit hit;
    assert_false(lf_trace_closest(s.tracer, &left, LF_RAY_ALL, &hit));
    assert_false(lf_trace_closest(s.tracer, &left, LF_RAY_CAMERA, &hit));
    assert_false(lf_trace_occluded(s.tracer, &left));
    assert_true(lf_trace_closest(s.tracer, &right, LF_RAY_ALL, &hit));
    assert_true(lf_trace_closest(s.tracer, &right, LF_RAY_CAMERA, &hit));
    assert_true(lf_trace_occluded(s.tracer, &right));
    scene_close(&s);
}

static void count_hit(void *user, const struct lf_hit *hit)
{
    assert_true(hit->distance > 0);
    ++*(int *)user;
}

static void test_lights_have_exact_shapes(void **state)
{
    (void)state;
    struct scene s;
    scene_open(&s, 1);
    struct ng_light_sphere ball = {.on = true, .color = {1, 1, 1}, .radiance = 1, .radius = 0.5f};
    struct ng_light_disk disk = {.on = true, .color = {1, 1, 1}, .radiance = 1, .radius = 1};
    scene_light(&s, NG_LIGHT_SPHERE, &ball, origin, NULL);
    ng_entity flat = scene_light(&s, NG_LIGHT_DISK, &disk, (const float[3]){4, 0, 0}, NULL);
    ((struct ng_transform *)ng_world_edit(s.world, flat, NG_TRANSFORM))->scale[0] = 0.5f; // an ellipse
    scene_frame(&s, 0);
    struct lf_hit hit;
    for (int i = 0; i < 200; i++) { // a sphere of triangles would be up to 0.2 % smaller
        float angle = 0.0314f * (float)i, r = 0.4999f;
        struct lf_ray inside = make_ray(r * cosf(angle), r * sinf(angle), 2, 0, 0, -1);
        struct lf_ray outside = make_ray(0.5001f * cosf(angle), 0.5001f * sinf(angle), 2, 0, 0, -1);
        assert_true(lf_trace_closest(s.tracer, &inside, LF_RAY_ALL, &hit) && hit.front);
        float length = sqrtf(hit.position[0] * hit.position[0] + hit.position[1] * hit.position[1] +
                             hit.position[2] * hit.position[2]);
        NEAR(length, 0.5, 1e-6);
        NEAR(hit.normal[0], hit.position[0] / length, 1e-5);
        assert_true(lf_trace_occluded(s.tracer, &inside));
        assert_false(lf_trace_occluded(s.tracer, &outside));
        // The disk shines along -Z: from below one sees its front.
        inside = make_ray(4 + 0.499f * cosf(angle), 0.998f * sinf(angle), -2, 0, 0, 1);
        outside = make_ray(4 + 0.501f * cosf(angle), 1.002f * sinf(angle), -2, 0, 0, 1);
        assert_true(lf_trace_closest(s.tracer, &inside, LF_RAY_CAMERA, &hit) && hit.front);
        assert_true(hit.normal[2] == -1);
        assert_false(lf_trace_occluded(s.tracer, &outside));
    }
    // A camera inside of the sphere sees through it; a ray through both meets three surfaces.
    struct lf_ray from_inside = make_ray(0, 0, 0, 0, 1, 0);
    assert_false(lf_trace_closest(s.tracer, &from_inside, LF_RAY_CAMERA, &hit));
    assert_true(lf_trace_closest(s.tracer, &from_inside, LF_RAY_ALL, &hit) && !hit.front);
    int count = 0;
    struct lf_ray through = make_ray(-4, 0, -0.1f, 1, 0, 0);
    lf_trace_emitters(s.tracer, &through, count_hit, &count);
    assert_int_equal(count, 2); // in and out of the sphere; the disk is passed by
    through = make_ray(-4, 0, -0.01f, 8, 0, 0.01f);
    count = 0;
    lf_trace_emitters(s.tracer, &through, count_hit, &count);
    assert_int_equal(count, 3);
    scene_close(&s);
}

static void test_textures_are_filtered_as_the_device_does(void **state)
{
    (void)state;
    static const unsigned char texels[2 * 2 * 4] = {0,   0,   0,   0,   255, 128, 64, 255,
                                                    255, 255, 255, 255, 0,   0,   0,  255};
    struct ng_image image = {.width = 2,
                             .height = 2,
                             .levels = 1,
                             .format = NG_PIXEL_RGBA8,
                             .sampling.wrap_u = NG_WRAP_REPEAT,
                             .pixels = (void *)(uintptr_t)texels};
    struct lf_srgb srgb;
    float rgba[4];
    lf_srgb_make(&srgb);
    lf_texture_at(&srgb, &image, (const float[2]){0.75f, 0.25f}, rgba); // the centre of a texel
    NEAR(rgba[1], 128 / 255.0, 1e-6);
    lf_texture_at(&srgb, &image, (const float[2]){0.5f, 0.5f}, rgba);
    NEAR(rgba[0], 0.5, 1e-6);
    lf_texture_at(&srgb, &image, (const float[2]){1.0f, 0}, rgba); // wraps in u, clamps in v
    NEAR(rgba[0], 0.5, 1e-6);
    NEAR(rgba[3], 0.5, 1e-6);
    lf_texture_at(&srgb, &image, (const float[2]){-3.25f, 7}, rgba);
    NEAR(rgba[0], 0, 1e-6);
    NEAR(rgba[3], 1, 1e-6);
    image.sampling.wrap_u = NG_WRAP_MIRROR;
    lf_texture_at(&srgb, &image, (const float[2]){1.0f, 0.25f}, rgba); // beside its own image
    NEAR(rgba[1], 128 / 255.0, 1e-6);
    lf_texture_at(&srgb, &image, (const float[2]){-1.25f, 0.25f}, rgba);
    NEAR(rgba[1], 128 / 255.0, 1e-6);
    lf_texture_at(&srgb, &image, (const float[2]){1.75f, 0.25f}, rgba);
    NEAR(rgba[1], 0, 1e-6);
    image.sampling.magnify = NG_FILTER_NEAREST;
    lf_texture_at(&srgb, &image, (const float[2]){0.51f, 0.49f}, rgba);
    NEAR(rgba[1], 128 / 255.0, 1e-6);
    lf_texture_at(&srgb, &image, (const float[2]){0.49f, 0.51f}, rgba);
    NEAR(rgba[1], 1, 1e-6);
    image.sampling = (struct ng_sampling){.wrap_u = NG_WRAP_REPEAT};
    lf_texture_at(&srgb, NULL, (const float[2]){0, 0}, rgba);
    assert_true(rgba[0] == 1 && rgba[3] == 1);
    image.format = NG_PIXEL_RGBA8_SRGB;
    lf_texture_at(&srgb, &image, (const float[2]){0.75f, 0.25f}, rgba);
    NEAR(rgba[1], 0.2158605, 1e-5); // decoded
    NEAR(rgba[3], 1, 1e-6);
    lf_texture_at(&srgb, &image, (const float[2]){0.5f, 0.25f}, rgba);
    NEAR(rgba[1], 0.2158605 / 2, 1e-5); // decoded, then filtered
}

// A red texel of the level that a step of so many texels asks for: 0, 0.5, 1 at levels 0, 1, 2.
static void expect_level(struct ng_image *image, const float step[2], float level, float red)
{
    struct lf_srgb srgb;
    float rgba[4];
    lf_srgb_make(&srgb);
    const float uv[2] = {0.5f, 0.5f}, along[2] = {step[0] / 4, step[1] / 4}, across[2] = {0.1f / 4, 0};
    NEAR(lf_texture_seen(&srgb, image, uv, along, across, rgba), level, 1e-5);
    NEAR(rgba[0], red, 1e-5);
    lf_texture_seen(&srgb, image, uv, across, along, rgba); // the longer step decides
    NEAR(rgba[0], red, 1e-5);
}

static void test_pixels_see_smaller_levels(void **state)
{
    (void)state;
    float texels[4 * (16 + 4 + 1)] = {0};
    for (int i = 0; i < 16 + 4 + 1; i++)
        texels[4 * i] = i < 16 ? 0 : i < 20 ? 0.5f : 1;
    struct ng_image image = {
        .width = 4, .height = 4, .levels = 3, .format = NG_PIXEL_RGBA32F, .pixels = texels};
    expect_level(&image, (const float[2]){0.5f, 0}, 0, 0); // texels are larger than pixels
    expect_level(&image, (const float[2]){1, 0}, 0, 0);
    expect_level(&image, (const float[2]){0, 2}, 1, 0.5f);
    expect_level(&image, (const float[2]){2, 2}, 1.5f, 0.75f);
    expect_level(&image, (const float[2]){100, 0}, 2, 1); // the smallest
    expect_level(&image, (const float[2]){NAN, 0}, 0, 0);
    image.sampling.mips = NG_MIP_NEAREST;
    expect_level(&image, (const float[2]){2.7f, 0}, 1, 0.5f);
    expect_level(&image, (const float[2]){2.9f, 0}, 2, 1);
    image.sampling.mips = NG_MIP_NONE;
    expect_level(&image, (const float[2]){100, 0}, 0, 0);
}

// Closest hits of many rays, as numbers that can be compared.
static void shoot(const struct scene *s, float *distances, uint32_t count)
{
    struct ng_rng rng = ng_rng_make(7, 7);
    const float *center = s->snapshot->scene_center;
    float radius = s->snapshot->scene_radius;
    for (uint32_t i = 0; i < count; i++) {
        float p[6];
        for (int k = 0; k < 6; k++)
            p[k] = ng_rng_range(&rng, -1, 1) * radius;
        struct lf_ray ray = make_ray(center[0] + p[0], center[1] + p[1], center[2] + p[2], p[3], p[4], p[5]);
        struct lf_hit hit;
        distances[i] = lf_trace_closest(s->tracer, &ray, LF_RAY_ALL, &hit) ? hit.distance : -1;
    }
}

static void test_updates_follow_what_moved(void **state)
{
    (void)state;
    enum { RAYS = 4000 };
    static float moved[RAYS], fresh[RAYS];
    static const struct {
        const char *path;
        bool turns; // some mesh, whose structure is built anew; all others are refitted
    } files[] = {{"content/unit/character.glb", false},
                 {"content/unit/hierarchy.glb", true},
                 {"content/unit/subdivision.glb", false}};
    for (size_t i = 0; i < NG_COUNT(files); i++) {
        struct scene a, b;
        scene_load(&a, 2, files[i].path);
        scene_load(&b, 2, files[i].path);
        for (int k = 0; k <= 4; k++)
            scene_frame(&a, 0.13 * k);
        struct lf_tracer_stats stats = lf_tracer_stats_of(a.tracer);
        scene_frame(&b, 0.13 * 4);
        shoot(&a, moved, RAYS);
        shoot(&b, fresh, RAYS);
        int hits = 0;
        for (int k = 0; k < RAYS; k++) {
            hits += moved[k] >= 0;
            NEAR(moved[k], fresh[k], 1e-4f * fabsf(fresh[k]));
        }
        assert_true(hits > 20);
        assert_true(files[i].turns ? stats.built > 0 : stats.built == 0);
        scene_close(&a);
        scene_close(&b);
    }
}

static void test_only_what_moved_is_touched(void **state)
{
    (void)state;
    struct scene s;
    scene_open(&s, 1);
    ng_entity material = scene_material(&s, (const float[3]){1, 1, 1}, 0, 1), pieces[5];
    for (int i = 0; i < 5; i++)
        pieces[i] = scene_sphere(&s, (const float[3]){(float)i, 0, 0}, 0.3f, false, material);
    scene_frame(&s, 0);
    struct lf_tracer_stats stats = lf_tracer_stats_of(s.tracer);
    assert_true(stats.instances == 5 && stats.built == 5 && stats.updated == 5);
    scene_frame(&s, 1);
    stats = lf_tracer_stats_of(s.tracer);
    assert_true(stats.built == 0 && stats.updated == 0);
    for (int k = 1; k < 4; k++) {
        ((struct ng_transform *)ng_world_edit(s.world, pieces[2], NG_TRANSFORM))->translation[1] = (float)k;
        scene_frame(&s, 1 + k);
        stats = lf_tracer_stats_of(s.tracer);
        assert_int_equal(stats.updated, 1);
        assert_int_equal(stats.built, 0);
        // Off the sphere's axis, where edges meet.
        struct lf_ray there = make_ray(2.03f, (float)k + 0.05f, 5, 0, 0, -1),
                      gone = make_ray(2.03f, (float)k - 0.95f, 5, 0, 0, -1);
        struct lf_hit hit;
        assert_true(lf_trace_closest(s.tracer, &there, LF_RAY_ALL, &hit) && hit.instance == 2);
        assert_false(lf_trace_occluded(s.tracer, &gone));
    }
    ((struct ng_material *)ng_world_edit(s.world, material, NG_MATERIAL))->roughness = 0.5f;
    scene_frame(&s, 9);
    stats = lf_tracer_stats_of(s.tracer);
    assert_int_equal(stats.updated, 0); // another look moves nothing
    OK(ng_entity_destroy(s.world, pieces[0]));
    scene_frame(&s, 10);
    stats = lf_tracer_stats_of(s.tracer);
    assert_true(stats.instances == 4 && stats.built == 0 && stats.updated == 0);
    scene_sphere(&s, (const float[3]){0, 2, 0}, 0.3f, false, material);
    scene_frame(&s, 11);
    stats = lf_tracer_stats_of(s.tracer);
    assert_true(stats.instances == 5 && stats.built == 1 && stats.updated == 1);
    scene_close(&s);
}

// Of copies in one place rays meet the last, and no other costs anything; of those that blend they meet a
// few.
static void test_copies_in_one_place_are_one(void **state)
{
    (void)state;
    enum { COPIES = 200 };
    const struct lf_ray ray = make_ray(0.1f, 0.2f, 3, 0, 0, -1);
    struct scene s;
    struct lf_hit hit;
    ng_entity copies[COPIES];
    scene_open(&s, 1);
    ng_entity material = scene_material(&s, (const float[3]){1, 1, 1}, 0, 1);
    copies[0] = add_floor(&s, material);
    const struct ng_transform place =
        *(const struct ng_transform *)ng_world_get(s.world, copies[0], NG_TRANSFORM);
    const struct ng_mesh mesh = *(const struct ng_mesh *)ng_world_get(s.world, copies[0], NG_MESH);
    for (int i = 1; i < COPIES; i++) {
        copies[i] = ng_entity_create(s.world);
        OK(ng_world_add(s.world, copies[i], NG_TRANSFORM, &place));
        OK(ng_world_add(s.world, copies[i], NG_MESH, &mesh));
    }
    scene_frame(&s, 0);
    assert_int_equal(lf_tracer_stats_of(s.tracer).built, 1);
    assert_true(lf_trace_closest(s.tracer, &ray, LF_RAY_ALL, &hit) && hit.instance == COPIES - 1);
    // Where the last goes away, the one before is there.
    ((struct ng_transform *)ng_world_edit(s.world, copies[COPIES - 1], NG_TRANSFORM))->translation[2] = -1;
    scene_frame(&s, 1);
    assert_int_equal(lf_tracer_stats_of(s.tracer).built, 1);
    assert_true(lf_trace_closest(s.tracer, &ray, LF_RAY_ALL, &hit) && hit.instance == COPIES - 2);
    // And hides it again.
    ((struct ng_transform *)ng_world_edit(s.world, copies[COPIES - 1], NG_TRANSFORM))->translation[2] = 0;
    scene_frame(&s, 2);
    assert_true(lf_trace_closest(s.tracer, &ray, LF_RAY_ALL, &hit) && hit.instance == COPIES - 1);
    // A mask of the same material cuts the same holes; one that blends covers a part, and so do many.
    struct ng_material *m = ng_world_edit(s.world, material, NG_MATERIAL);
    m->alpha_mode = NG_ALPHA_MASK;
    scene_frame(&s, 3);
    assert_int_equal(lf_tracer_stats_of(s.tracer).built, 0);
    m = ng_world_edit(s.world, material, NG_MATERIAL);
    m->alpha_mode = NG_ALPHA_BLEND, m->alpha = 0.5f;
    scene_frame(&s, 4);
    assert_int_equal(lf_tracer_stats_of(s.tracer).built, NG_MOST_BLENDED_COPIES - 1);
    scene_close(&s);
}

// Few ids for many entities; and where surfaces come between others, room for them is made rarely.
static void test_entities_without_surfaces_cost_nothing(void **state)
{
    (void)state;
    enum { EMPTY = 1000, COPIES = 100 };
    struct scene s;
    scene_open(&s, 1);
    ng_entity material = scene_material(&s, (const float[3]){1, 1, 1}, 0, 1), empty[EMPTY];
    ng_entity first = add_floor(&s, material);
    for (int i = 0; i < EMPTY; i++)
        empty[i] = ng_entity_create(s.world);
    add_floor(&s, material);
    scene_frame(&s, 0);
    assert_in_range(lf_tracer_stats_of(s.tracer).ids, 2, 200);
    struct ng_transform place = *(const struct ng_transform *)ng_world_get(s.world, first, NG_TRANSFORM);
    const struct ng_mesh mesh = *(const struct ng_mesh *)ng_world_get(s.world, first, NG_MESH);
    for (int way = 0; way < 2; way++) {
        uint32_t built = 0;
        for (int i = 0; i < COPIES; i++) {
            ng_entity e = empty[way ? EMPTY - 1 - i : i]; // from the first, from the last
            place.translation[2] -= 1;                    // each in a place of its own
            OK(ng_world_add(s.world, e, NG_TRANSFORM, &place));
            OK(ng_world_add(s.world, e, NG_MESH, &mesh));
            scene_frame(&s, 1);
            built += lf_tracer_stats_of(s.tracer).built;
        }
        assert_true(built >= COPIES && built < 4 * COPIES);
    }
    assert_in_range(lf_tracer_stats_of(s.tracer).ids, 2 * COPIES, 64 * 10 + 2 * COPIES);
    scene_close(&s);
}

// A packet meets what its rays meet one by one, exact shapes included, and passes through one light.
static void test_packets_are_rays(void **state)
{
    (void)state;
    struct scene s;
    scene_open(&s, 1);
    ng_entity material = scene_material(&s, (const float[3]){1, 1, 1}, 0, 1);
    struct ng_light_sphere ball = {.on = true, .color = {1, 1, 1}, .radiance = 1, .radius = 0.5f};
    struct ng_light_disk disk = {.on = true, .color = {1, 1, 1}, .radiance = 1, .radius = 0.8f};
    scene_sphere(&s, (const float[3]){1, 0, 0}, 0.4f, false, material);
    scene_light(&s, NG_LIGHT_SPHERE, &ball, (const float[3]){-1, 0, 0}, NULL);
    scene_light(&s, NG_LIGHT_DISK, &disk, (const float[3]){0, 0, 1}, NULL);
    scene_frame(&s, 0);
    struct ng_rng rng = ng_rng_make(3, 4);
    int met[3] = {0}; // by light: none, ball, disk
    for (int round = 0; round < 200; round++) {
        struct lf_packet p = {.passes = NG_NONE};
        struct lf_hit hits[LF_PACKET];
        struct lf_ray rays[LF_PACKET];
        for (int i = 0; i < LF_PACKET; i++) {
            rays[i] = make_ray(0, 0, 0.2f, ng_rng_range(&rng, -1, 1), ng_rng_range(&rng, -1, 1),
                               ng_rng_range(&rng, -1, 1));
            p.far[i] = rays[i].far = i == 5 ? 0 : 3;
            for (int c = 0; c < 3; c++) {
                p.origin[c][i] = rays[i].origin[c];
                p.direction[c][i] = rays[i].direction[c];
            }
        }
        struct lf_packet passing = p;
        passing.passes = round % 2 ? 1 : 0;
        struct lf_packet any = p, any_passing = passing;
        lf_trace_packet_occluded(s.tracer, &any);
        lf_trace_packet_occluded(s.tracer, &any_passing);
        lf_trace_packet(s.tracer, &p, hits);
        lf_trace_packet(s.tracer, &passing, NULL);
        for (int i = 0; i < LF_PACKET; i++) {
            struct lf_hit one;
            bool alone = i != 5 && lf_trace_closest(s.tracer, &rays[i], LF_RAY_ALL, &one);
            assert_true(alone == p.met[i] && alone == any.met[i] && passing.met[i] == any_passing.met[i]);
            if (!alone)
                continue;
            assert_true(one.instance == hits[i].instance && one.front == hits[i].front);
            NEAR(one.distance, hits[i].distance, 1e-5);
            NEAR(one.distance, p.far[i], 1e-5);
            uint32_t light = s.snapshot->instances[one.instance].light;
            met[light + 1]++; // NG_NONE wraps to 0
            if (light == passing.passes)
                assert_true(!passing.met[i] || passing.far[i] > p.far[i] + 0.01f);
            else
                // Embree may go on with a few of a packet's rays one by one, which rounds in another way.
                assert_true(passing.met[i] && fabsf(passing.far[i] - p.far[i]) <= 1e-5f);
        }
    }
    for (int i = 0; i < 3; i++)
        assert_true(met[i] > 50);
    scene_close(&s);
}

// What every way of tracing says of one ray. With assertions on, Embree ends the process for what is no ray.
static bool met_in_any_way(const struct scene *s, const struct lf_ray *ray)
{
    struct lf_packet p = {.passes = NG_NONE}, any;
    struct lf_ray rays[3] = {*ray, *ray, make_ray(0, 0, -50, 0, 0, -1)};
    struct lf_hit hits[LF_PACKET];
    bool met[3], dark[3];
    int visits = 0;
    for (int c = 0; c < 3; c++) {
        p.origin[c][3] = ray->origin[c];
        p.direction[c][3] = ray->direction[c];
    }
    p.far[3] = ray->far;
    any = p;
    lf_trace_closest_many(s->tracer, rays, 3, met, hits);
    lf_trace_occluded_many(s->tracer, rays, 3, dark);
    lf_trace_packet(s->tracer, &p, hits);
    lf_trace_packet_occluded(s->tracer, &any);
    lf_trace_emitters(s->tracer, ray, count_hit, &visits);
    bool packet = ray->near >= 0 && ray->near <= 0 && (p.met[3] || any.met[3]); // whose rays begin at 0
    return lf_trace_closest(s->tracer, ray, LF_RAY_ALL, hits) ||
           lf_trace_closest(s->tracer, ray, LF_RAY_CAMERA, hits) || lf_trace_occluded(s->tracer, ray) ||
           lf_trace_shadowed(s->tracer, ray, 0) || lf_trace_bare(s->tracer, ray, 1) || met[0] || met[1] ||
           dark[0] || dark[1] || packet || visits;
}

static void test_what_is_no_ray_meets_nothing(void **state)
{
    (void)state;
    struct scene s;
    struct ng_light_sphere ball = {.on = true, .color = {1, 1, 1}, .radiance = 1, .radius = 0.5f};
    scene_open(&s, 1);
    add_floor(&s, scene_material(&s, (const float[3]){1, 1, 1}, 0, 1));
    scene_light(&s, NG_LIGHT_SPHERE, &ball, (const float[3]){0, 0, 1}, NULL);
    scene_frame(&s, 0);
    const struct lf_ray good = make_ray(0, 0, 5, 0, 0, -1);
    assert_true(met_in_any_way(&s, &good));
    const float wrong[] = {NAN, INFINITY, -INFINITY, 1e19f, -1e19f, 1.9e18f, 3e38f};
    for (size_t i = 0; i < NG_COUNT(wrong); i++)
        for (int member = 0; member < 6; member++) {
            struct lf_ray bad = good;
            (member < 3 ? bad.origin : bad.direction)[member % 3] = wrong[i];
            assert_false(met_in_any_way(&s, &bad));
        }
    const float spans[][2] = {{NAN, 9}, {0, NAN}, {-1, 9}, {-INFINITY, 9}, {0, -1}, {0, -INFINITY}, {9, 0}};
    for (size_t i = 0; i < NG_COUNT(spans); i++) {
        struct lf_ray bad = good;
        bad.near = spans[i][0], bad.far = spans[i][1];
        assert_false(met_in_any_way(&s, &bad));
    }
    scene_close(&s);
}

// A scale of zero, by which animations hide things, or one that Embree takes for zero. Several of them in one
// place end its upper level.
static void test_things_come_and_go_by_their_scale(void **state)
{
    (void)state;
    struct scene s;
    struct ng_light_sphere ball = {.on = true, .color = {1, 1, 1}, .radiance = 1, .radius = 0.5f};
    ng_entity pieces[6];
    scene_open(&s, 1);
    ng_entity material = scene_material(&s, (const float[3]){1, 1, 1}, 0, 1);
    for (int i = 0; i < 6; i++)
        pieces[i] = i < 3 ? scene_sphere(&s, (const float[3]){0, 0, 2}, 0.4f, false, material)
                          : scene_light(&s, NG_LIGHT_SPHERE, &ball, (const float[3]){0, 0, -2}, NULL);
    struct lf_ray to_mesh = make_ray(0, 0, 5, 0, 0, -1), to_light = make_ray(0, 0, -5, 0, 0, 1);
    const float scales[] = {1, 0, 1, 1e-41f};
    for (int frame = 0; frame < 4; frame++) { // there, gone, there, gone
        float scale = scales[frame];
        for (int i = 0; i < 6; i++)
            for (int k = 0; k < 3; k++)
                ((struct ng_transform *)ng_world_edit(s.world, pieces[i], NG_TRANSFORM))->scale[k] = scale;
        scene_frame(&s, frame);
        to_mesh.far = to_light.far = 4;
        assert_int_equal(lf_trace_occluded(s.tracer, &to_mesh), scale > 0.5f);
        assert_int_equal(lf_trace_occluded(s.tracer, &to_light), scale > 0.5f);
        // As a scene that begins like that.
        lf_tracer_destroy(&s.tracer);
        OK(lf_tracer_create(&s.tracer));
        OK(lf_tracer_update(s.tracer, s.snapshot));
        assert_int_equal(lf_trace_occluded(s.tracer, &to_mesh), scale > 0.5f);
        assert_int_equal(lf_trace_occluded(s.tracer, &to_light), scale > 0.5f);
    }
    scene_close(&s);
}

// Numbers that no transform should give, in a snapshot all the same: the scene around them stays.
static void test_things_without_a_place_leave_the_others(void **state)
{
    (void)state;
    struct ng_light_sphere ball = {.on = true, .color = {1, 1, 1}, .radiance = 1, .radius = 0.5f};
    struct ng_light_disk disk = {.on = true, .color = {1, 1, 1}, .radiance = 1, .radius = 0.8f};
    const float wrong[] = {NAN, INFINITY, -INFINITY, 1e19f, 3e38f, -3e38f};
    for (size_t i = 0; i < NG_COUNT(wrong); i++)
        for (int refitted = 0; refitted < 2; refitted++) {
            struct scene s;
            scene_open(&s, 1);
            ng_entity material = scene_material(&s, (const float[3]){1, 1, 1}, 0, 1);
            add_floor(&s, material);
            scene_sphere(&s, (const float[3]){0, 0, 2}, 0.4f, false, material);
            scene_light(&s, NG_LIGHT_SPHERE, &ball, (const float[3]){0, 0, 1}, NULL);
            scene_light(&s, NG_LIGHT_DISK, &disk, (const float[3]){0, 0, 1}, NULL);
            scene_frame(&s, 0);
            if (!refitted) {
                lf_tracer_destroy(&s.tracer);
                OK(lf_tracer_create(&s.tracer));
            }
            for (uint32_t k = 1; k < s.snapshot->instance_count; k++) {
                for (int m = 0; m < 12; m++)
                    s.snapshot->instances[k].matrix[m] = wrong[i];
                s.snapshot->instances[k].version++;
            }
            OK(lf_tracer_update(s.tracer, s.snapshot));
            struct lf_ray ray = make_ray(0.9f, 0.9f, 0.2f, 0, 0, -1);
            struct lf_hit hit;
            assert_true(lf_trace_closest(s.tracer, &ray, LF_RAY_ALL, &hit));
            scene_close(&s);
        }
}

static void test_an_empty_scene_is_met_by_nothing(void **state)
{
    (void)state;
    struct scene s;
    struct test_log log;
    test_log_begin(&log);
    scene_open(&s, 1);
    scene_frame(&s, 0);
    struct lf_ray ray = make_ray(0, 0, 0, 1, 0, 0);
    struct lf_hit hit;
    int count = 0;
    assert_false(lf_trace_closest(s.tracer, &ray, LF_RAY_ALL, &hit));
    assert_false(lf_trace_occluded(s.tracer, &ray));
    lf_trace_emitters(s.tracer, &ray, count_hit, &count);
    test_log_end(&log);
    assert_int_equal(count, 0);
    assert_int_equal(log.errors, 0);
    scene_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_hit_says_where_and_what),
        cmocka_unit_test(test_camera_rays_pass_through_backs),
        cmocka_unit_test(test_mirrored_placements_keep_their_front),
        cmocka_unit_test(test_triangles_overrule_normals_that_contradict_them),
        cmocka_unit_test(test_mirrored_placements_mirror_normal_maps),
        cmocka_unit_test(test_metal_never_reflects_into_itself),
        cmocka_unit_test(test_matt_surfaces_keep_their_normals),
        cmocka_unit_test(test_alpha_masks_let_rays_through),
        cmocka_unit_test(test_blended_surfaces_stop_their_part),
        cmocka_unit_test(test_lights_have_exact_shapes),
        cmocka_unit_test(test_textures_are_filtered_as_the_device_does),
        cmocka_unit_test(test_pixels_see_smaller_levels),
        cmocka_unit_test(test_updates_follow_what_moved),
        cmocka_unit_test(test_only_what_moved_is_touched),
        cmocka_unit_test(test_copies_in_one_place_are_one),
        cmocka_unit_test(test_entities_without_surfaces_cost_nothing),
        cmocka_unit_test(test_packets_are_rays),
        cmocka_unit_test(test_what_is_no_ray_meets_nothing),
        cmocka_unit_test(test_things_come_and_go_by_their_scale),
        cmocka_unit_test(test_things_without_a_place_leave_the_others),
        cmocka_unit_test(test_an_empty_scene_is_met_by_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

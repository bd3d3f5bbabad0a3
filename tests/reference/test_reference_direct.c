// Direct light against closed forms: point and cosine laws, polygons, form factors, every light type against
// its own VPLs, shadows, and the split of T_l and T_d.
#include "scene.h"

#include "base/rng.h"
#include "components/light_directional.h"
#include "components/light_disk.h"
#include "components/light_mesh.h"
#include "components/light_rectangle.h"
#include "components/light_sphere.h"
#include "scene/world.h"

#include <math.h>

#define PI 3.14159265358979

static const float up[3] = {0, 0, 1}, origin[3] = {0, 0, 0};

static void test_point_light_follows_the_inverse_square_and_cosine_laws(void **state)
{
    (void)state;
    struct scene s;
    scene_open(&s, 1);
    scene_point(&s, 7, (const float[3]){0, 0, 2});
    scene_frame(&s, 0);
    for (int i = 0; i < 6; i++) {
        const float at[3] = {(float)i, 0, 0};
        double d2 = 4 + (double)(i * i), cosine = 2 / sqrt(d2);
        ESTIMATES(scene_irradiance(&s, at, up, 4, direct), 7 * cosine / d2, 3e-3, 1e-6);
    }
    scene_close(&s);
}

// Irradiance from a uniform polygon (Lambert 1760): half the sum over edges of the angle they are seen under
// times the cosine of the edge plane's normal.
static double polygon_irradiance(float corners[][3], int count, const float at[3], const float n[3])
{
    double sum = 0;
    for (int i = 0; i < count; i++) {
        double a[3], b[3], c[3], aa = 0, bb = 0, ab = 0;
        for (int k = 0; k < 3; k++) {
            a[k] = (double)corners[i][k] - (double)at[k];
            b[k] = (double)corners[(i + 1) % count][k] - (double)at[k];
            aa += a[k] * a[k];
            bb += b[k] * b[k];
            ab += a[k] * b[k];
        }
        for (int k = 0; k < 3; k++)
            c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
        double length = sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
        double angle = acos(ab / sqrt(aa * bb));
        sum += angle * (c[0] * (double)n[0] + c[1] * (double)n[1] + c[2] * (double)n[2]) / length;
    }
    return fabs(sum) / 2;
}

static const struct ng_light_rectangle panel = {
    .on = true, .color = {1, 1, 1}, .radiance = 3, .size = {2, 1}};

static void test_rectangle_light_equals_the_polygon_formula(void **state)
{
    (void)state;
    struct scene s;
    scene_open(&s, 1);
    scene_light(&s, NG_LIGHT_RECTANGLE, &panel, (const float[3]){0, 0, 1.5f}, NULL);
    scene_frame(&s, 0);
    float corners[4][3] = {{-1, -0.5f, 1.5f}, {1, -0.5f, 1.5f}, {1, 0.5f, 1.5f}, {-1, 0.5f, 1.5f}};
    static const float points[4][3] = {{0, 0, 0}, {1, 0.7f, 0}, {-2, 0.3f, 0.2f}, {0.2f, 0, 1.2f}};
    for (int i = 0; i < 4; i++) {
        double expected = 3 * polygon_irradiance(corners, 4, points[i], up);
        ESTIMATES(scene_irradiance(&s, points[i], up, 20000, direct), expected, 3e-3, 0.02);
        ESTIMATES(scene_irradiance(&s, points[i], up, 20000, unshadowed), expected, 3e-3, 0.02);
    }
    scene_close(&s);
}

// Mean irradiance of a rectangle across Z.
static struct estimate mean_irradiance(const struct scene *s, const float center[3], const float size[2],
                                       const float normal[3], uint32_t samples)
{
    enum { POINTS = 1024 };
    struct estimate mean = {0};
    for (uint32_t i = 0; i < POINTS; i++) {
        float u[2];
        ng_light_vpl_point(i, u);
        const float at[3] = {center[0] + (u[0] - 0.5f) * size[0], center[1] + (u[1] - 0.5f) * size[1],
                             center[2]};
        struct estimate e = scene_irradiance(s, at, normal, samples, direct);
        mean.mean += e.mean / POINTS;
        mean.error += e.error * e.error / POINTS / POINTS;
    }
    mean.error = sqrt(mean.error);
    return mean;
}

static void test_parallel_plates_exchange_their_form_factor(void **state)
{
    (void)state;
    struct scene s;
    scene_open(&s, 1);
    struct ng_light_rectangle plate = {.on = true, .color = {1, 1, 1}, .radiance = 1, .size = {1, 1}};
    scene_light(&s, NG_LIGHT_RECTANGLE, &plate, (const float[3]){0, 0, 1}, NULL);
    scene_frame(&s, 0);
    // Two unit squares a unit apart (Howell, configuration C-11).
    double factor = 2 / PI * (log(sqrt(4.0 / 3)) + sqrt(2) * 2 * atan(1 / sqrt(2)) - 2 * atan(1.0));
    ESTIMATES(mean_irradiance(&s, origin, plate.size, up, 64), PI * factor, 3e-3, 0.01);
    scene_close(&s);
}

static void test_perpendicular_rectangles_exchange_their_form_factor(void **state)
{
    (void)state;
    struct scene s;
    scene_open(&s, 1);
    // A wall in x = 0 that shines along +X beside a floor in z = 0: unit squares with a common edge.
    struct ng_light_rectangle wall = {.on = true, .color = {1, 1, 1}, .radiance = 1, .size = {1, 1}};
    const float half = sqrtf(0.5f);
    scene_light(&s, NG_LIGHT_RECTANGLE, &wall, (const float[3]){0, 0, 0.5f},
                (const float[4]){0, -half, 0, half});
    scene_frame(&s, 0);
    const struct estimate e = mean_irradiance(&s, (const float[3]){0.5f, 0, 0}, wall.size, up, 128);
    ESTIMATES(e, PI * 0.200044, 5e-3, 0.01); // Howell, configuration C-14, h = w = 1
    scene_close(&s);
}

static void test_area_light_equals_many_small_ones(void **state)
{
    (void)state;
    struct scene one, many;
    scene_open(&one, 1);
    scene_open(&many, 1);
    scene_light(&one, NG_LIGHT_RECTANGLE, &panel, (const float[3]){0, 0, 1.5f}, NULL);
    struct ng_light_rectangle part = panel;
    part.size[0] /= 4;
    part.size[1] /= 3;
    for (int j = 0; j < 3; j++)
        for (int i = 0; i < 4; i++)
            scene_light(&many, NG_LIGHT_RECTANGLE, &part,
                        (const float[3]){-0.75f + 0.5f * (float)i, ((float)j - 1) / 3, 1.5f}, NULL);
    struct scene *both[2] = {&one, &many};
    for (int i = 0; i < 2; i++) { // with something in the way
        ng_entity dark = scene_material(both[i], origin, 0, 1);
        scene_quad(both[i], (const float[3]){0.1f, -1, 0.7f}, (const float[3]){1, 0, 0},
                   (const float[3]){0, 2, 0}, dark);
        scene_frame(both[i], 0);
    }
    static const float points[3][3] = {{0, 0, 0}, {-0.4f, 0.1f, 0}, {0.8f, 0, 0}};
    for (int i = 0; i < 3; i++) {
        struct estimate a = scene_irradiance(&one, points[i], up, 30000, direct);
        struct estimate b = scene_irradiance(&many, points[i], up, 30000, direct);
        b.error = sqrt(a.error * a.error + b.error * b.error);
        ESTIMATES(b, a.mean, 1e-5, 0.05);
    }
    scene_close(&one);
    scene_close(&many);
}

static void test_unshadowed_light_knows_no_occluders(void **state)
{
    (void)state;
    struct scene s;
    scene_open(&s, 1);
    scene_light(&s, NG_LIGHT_RECTANGLE, &panel, (const float[3]){0, 0, 1.5f}, NULL);
    // A second light hides the first; it shines away and must not count as an occluder either.
    struct ng_light_disk disk = {.on = true, .color = {1, 1, 1}, .radiance = 1, .radius = 3};
    scene_light(&s, NG_LIGHT_DISK, &disk, (const float[3]){0, 0, 0.7f}, (const float[4]){1, 0, 0, 0});
    scene_frame(&s, 0);
    float corners[4][3] = {{-1, -0.5f, 1.5f}, {1, -0.5f, 1.5f}, {1, 0.5f, 1.5f}, {-1, 0.5f, 1.5f}};
    ESTIMATES(scene_irradiance(&s, origin, up, 40000, unshadowed),
              3 * polygon_irradiance(corners, 4, origin, up), 3e-3, 0.02);
    struct estimate shadowed = scene_irradiance(&s, origin, up, 1000, direct);
    assert_true(shadowed.mean == 0);
    scene_close(&s);
}

static void test_a_mesh_may_become_a_light(void **state)
{
    (void)state;
    struct scene s;
    scene_open(&s, 1);
    ng_entity quad = scene_quad(&s, (const float[3]){-2, 2, 1}, (const float[3]){4, 0, 0},
                                (const float[3]){0, -4, 0}, scene_glow(&s, (const float[3]){2, 2, 2}));
    scene_frame_warned(&s, 0);
    float corners[4][3] = {{-2, 2, 1}, {2, 2, 1}, {2, -2, 1}, {-2, -2, 1}};
    double expected = 2 * polygon_irradiance(corners, 4, origin, up);
    const struct ng_light_mesh light = {.on = true, .color = {1, 1, 1}, .scale = 1};
    OK(ng_world_add(s.world, quad, NG_LIGHT_MESH, &light));
    scene_frame(&s, 1);
    ESTIMATES(scene_irradiance(&s, origin, up, 20000, direct), expected, 3e-3, 0.02);
    ESTIMATES(scene_irradiance(&s, origin, up, 20000, unshadowed), expected, 3e-3, 0.02);
    OK(ng_world_remove(s.world, quad, NG_LIGHT_MESH));
    scene_frame(&s, 2);
    struct estimate none = scene_irradiance(&s, origin, up, 1000, unshadowed);
    assert_true(none.mean == 0);
    scene_close(&s);
}

// What the light's own sampling says of a receiver, with all of its VPLs: no BRDF samples in it.
static double vpl_irradiance(const struct scene *s, const float at[3], const float n[3])
{
    double sum = 0;
    for (uint32_t i = 0; i < s->snapshot->light_count; i++) {
        float rgb[3];
        ng_light_irradiance(&s->snapshot->lights[i].source, 1 << 16, at, n, rgb);
        sum += (double)ng_light_mean(rgb);
    }
    return sum;
}

static void test_every_light_type_agrees_with_its_sampling(void **state)
{
    (void)state;
    static const char *const files[] = {"point",  "spot", "directional",        "rectangle",  "disk",
                                        "sphere", "mesh", "rectangle_textured", "environment"};
    for (size_t i = 0; i < NG_COUNT(files); i++) {
        char path[128];
        struct scene s;
        snprintf(path, sizeof path, "content/unit/light_%s.glb", files[i]);
        scene_load(&s, 1, path);
        scene_frame(&s, 0);
        struct lf_reference *r = scene_render(&s, &(struct lf_reference_params){.width = 8, .height = 8}, 0);
        float *positions = scene_layer(r, "position"), *normals = scene_layer(r, "normal");
        int checked = 0;
        for (int p = 20; p < 64; p += 7) {
            const float *at = positions + p * 3, *n = normals + p * 3;
            double expected = vpl_irradiance(&s, at, n);
            if (n[0] * n[0] + n[1] * n[1] + n[2] * n[2] < 0.5f || !(expected > 1e-3))
                continue;
            ESTIMATES(scene_irradiance(&s, at, n, 20000, unshadowed), expected, 5e-3, 0.05);
            checked++;
        }
        assert_true(checked > 0);
        free(positions);
        free(normals);
        lf_reference_destroy(&r);
        scene_close(&s);
    }
}

// What a surface at the origin sends towards `to` of a lamp at `from`, one metre away.
static void scattered(const struct lf_surface *surface, const float from[3], const float to[3], float out[3])
{
    struct scene s;
    scene_open(&s, 1);
    scene_point(&s, 1, from);
    scene_frame(&s, 0);
    struct lf_path_stats stats = {0};
    struct lf_path_scene scene = {.tracer = s.tracer, .lights = &s.lights, .depth = 2, .stats = &stats};
    struct lf_primary primary = {.met = true, .surface = *surface};
    for (int c = 0; c < 3; c++)
        primary.ray.direction[c] = -to[c];
    struct lf_path path = {.primary = &primary};
    lf_paths_trace(&scene, &path, 1);
    memcpy(out, path.radiance.direct, sizeof path.radiance.direct);
    scene_close(&s);
}

static void test_scattering_is_reciprocal(void **state)
{
    (void)state;
    struct ng_rng rng = ng_rng_make(3, 3);
    for (int i = 0; i < 200; i++) {
        struct lf_surface surface = {.normal = {0, 0, 1},
                                     .flat_normal = {0, 0, 1},
                                     .albedo = {0.5f, 0.5f, 0.5f},
                                     .f0 = {0.3f, 0.04f, 1},
                                     .roughness = ng_rng_range(&rng, 0.045f, 1),
                                     .light = NG_NONE,
                                     .front = true};
        float d[2][3], there[3], back[3];
        for (int k = 0; k < 2; k++) {
            float z = ng_rng_range(&rng, 0.01f, 1), phi = ng_rng_range(&rng, 0, 6.283f), r = sqrtf(1 - z * z);
            const float v[3] = {r * cosf(phi), r * sinf(phi), z};
            memcpy(d[k], v, sizeof v);
        }
        scattered(&surface, d[0], d[1], there);
        scattered(&surface, d[1], d[0], back);
        for (int c = 0; c < 3; c++) {
            assert_true(there[c] > 0);
            NEAR(there[c] / d[0][2], back[c] / d[1][2], 1e-3f * there[c] / d[0][2] + 1e-6f);
        }
    }
}

static void test_light_between_two_panels_is_reciprocal(void **state)
{
    (void)state;
    // The power that A sends to B equals what B sends to A at the same radiance, past an obstacle.
    static const float places[2][3] = {{-0.5f, 0.2f, 0}, {0.7f, 0, 1.5f}};
    static const float sizes[2][2] = {{1, 0.5f}, {0.6f, 1.2f}};
    struct estimate flux[2] = {{0}};
    for (int from = 0; from < 2; from++) {
        struct scene s;
        int to = 1 - from;
        scene_open(&s, 1);
        struct ng_light_rectangle light = {.on = true, .color = {1, 1, 1}, .radiance = 1};
        memcpy(light.size, sizes[from], sizeof light.size);
        // The lower one shines upwards: half a turn about X.
        scene_light(&s, NG_LIGHT_RECTANGLE, &light, places[from], from ? NULL : (const float[4]){1, 0, 0, 0});
        ng_entity dark = scene_material(&s, origin, 0, 1);
        scene_quad(&s, (const float[3]){0, -1, 0.8f}, (const float[3]){0.4f, 0, 0}, (const float[3]){0, 2, 0},
                   dark);
        scene_frame(&s, 0);
        const float normal[3] = {0, 0, to ? -1.0f : 1.0f};
        struct estimate e = mean_irradiance(&s, places[to], sizes[to], normal, 32);
        double area = (double)(sizes[to][0] * sizes[to][1]);
        flux[from] = (struct estimate){e.mean * area, e.error * area};
        scene_close(&s);
    }
    struct estimate a = {flux[0].mean, hypot(flux[0].error, flux[1].error)};
    ESTIMATES(a, flux[1].mean, 5e-3, 0.02);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_point_light_follows_the_inverse_square_and_cosine_laws),
        cmocka_unit_test(test_rectangle_light_equals_the_polygon_formula),
        cmocka_unit_test(test_parallel_plates_exchange_their_form_factor),
        cmocka_unit_test(test_perpendicular_rectangles_exchange_their_form_factor),
        cmocka_unit_test(test_area_light_equals_many_small_ones),
        cmocka_unit_test(test_unshadowed_light_knows_no_occluders),
        cmocka_unit_test(test_a_mesh_may_become_a_light),
        cmocka_unit_test(test_every_light_type_agrees_with_its_sampling),
        cmocka_unit_test(test_scattering_is_reciprocal),
        cmocka_unit_test(test_light_between_two_panels_is_reciprocal),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// Whole paths: furnaces, a sphere lit from its centre, convergence, and that pictures are the same bytes
// however they are made.
#include "scene.h"

#include "base/rng.h"
#include "components/camera.h"
#include "components/light_disk.h"
#include "components/light_environment.h"
#include "components/light_rectangle.h"
#include "components/light_sphere.h"
#include "components/transform.h"
#include "lightformer/trace/vec.h"
#include "scene/world.h"
#include "shaders/shared/brdf.h"

#include <math.h>

#define PI 3.14159265358979

static const float origin[3] = {0, 0, 0}, up[3] = {0, 0, 1};

// The BRDF times the cosine of the light, at angles to the normal and an azimuth between them.
static double brdf_cosine(double cos_v, double cos_l, double azimuth, float albedo, float f0, float roughness)
{
    double sin_v = sqrt(1 - cos_v * cos_v), sin_l = sqrt(1 - cos_l * cos_l);
    double h[3] = {sin_v + sin_l * cos(azimuth), sin_l * sin(azimuth), cos_v + cos_l};
    double length = sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
    double vh = (sin_v * h[0] + cos_v * h[2]) / length;
    return cos_l * (double)ng_brdf((float)cos_l, (float)cos_v, (float)(h[2] / length), (float)vh, albedo, f0,
                                   roughness);
}

// Part of uniform light that leaves towards cos_v, by quadrature.
static double reflectance(double cos_v, float albedo, float f0, float roughness)
{
    enum { N = 400 };
    double sum = 0;
    for (int i = 0; i < N; i++)
        for (int k = 0; k < N; k++)
            sum += brdf_cosine(cos_v, (i + 0.5) / N, PI * (k + 0.5) / N, albedo, f0, roughness);
    return sum * 2 * PI / N / N;
}

// ---- furnaces --------------------------------------------------------------------------------------------
static void check_furnace(float base, float metallic, float roughness, double cos_v)
{
    struct scene s;
    scene_open(&s, 1);
    scene_sky(&s);
    const float grey[3] = {base, base, base};
    scene_quad(&s, (const float[3]){-1, -1, 0}, (const float[3]){2, 0, 0}, (const float[3]){0, 2, 0},
               scene_material(&s, grey, metallic, roughness));
    scene_frame(&s, 0);
    struct lf_path_stats stats = {0};
    struct lf_path_scene scene = {.tracer = s.tracer, .lights = &s.lights, .stats = &stats};
    struct lf_ray ray = {.far = INFINITY};
    ray.direction[0] = -sqrtf((float)(1 - cos_v * cos_v));
    ray.direction[2] = -(float)cos_v;
    for (int i = 0; i < 3; i++)
        ray.origin[i] = -ray.direction[i];
    struct lf_primary primary;
    lf_path_begin(&scene, &ray, NULL, &primary);
    assert_true(primary.met);
    double expected =
        reflectance(cos_v, ng_brdf_albedo(base, metallic), ng_brdf_f0(0.04f, base, metallic), roughness);
    ESTIMATES(scene_estimate(&s, &primary, 20000, 0, LF_SAMPLER_INDEPENDENT, 1,
                             offsetof(struct lf_radiance, direct)),
              expected, 2e-3, 0.01);
    scene_close(&s);
}

static void test_white_furnace(void **state)
{
    (void)state;
    static const double angles[] = {1, 0.7, 0.2};
    for (int i = 0; i < 3; i++) {
        check_furnace(1, 0, 1, angles[i]); // diffuse
        check_furnace(0.5f, 0, 0.3f, angles[i]);
        check_furnace(1, 1, 1, angles[i]); // a rough mirror: single scattering loses energy
        check_furnace(1, 1, 0.4f, angles[i]);
    }
    // Nothing is lost where nothing is rough, much where it is: the known loss of single scattering.
    assert_true(reflectance(1, 0, 1, 0.3f) > 0.98);
    assert_true(reflectance(0.7, 0, 1, 1) < 0.7);
}

static void test_nothing_leaves_a_closed_box_without_light(void **state)
{
    (void)state;
    struct scene s;
    scene_open(&s, 1);
    scene_sky(&s);
    scene_sphere(&s, origin, 1, true, scene_material(&s, (const float[3]){1, 1, 1}, 0, 1));
    scene_frame(&s, 0);
    struct lf_reference *r =
        scene_render(&s, &(struct lf_reference_params){.width = 16, .height = 16, .jobs = s.jobs}, 16);
    float *direct = scene_layer(r, "direct"), *indirect = scene_layer(r, "indirect"),
          *depth = scene_layer(r, "depth");
    int inside = 0;
    for (int i = 0; i < 256; i++)
        for (int c = 0; depth[i] > 0 && c < 3; c++, inside++)
            assert_true(direct[i * 3 + c] == 0 && indirect[i * 3 + c] == 0);
    assert_true(inside > 0); // the camera is outside and sees the inner surface
    free(direct);
    free(indirect);
    free(depth);
    lf_reference_destroy(&r);
    scene_close(&s);
}

// ---- a sphere lit from its centre ------------------------------------------------------------------------
#define ANGLES 48

// Radiance that leaves the inner surface at each angle: light of the angle theta arrives at theta, since both
// ends of a chord meet the sphere alike. So the integral equation has one dimension; summed bounce by bounce.
static void solve_sphere(float albedo, float f0, float roughness, double irradiance, double out[ANGLES])
{
    double kernel[ANGLES][ANGLES], bounce[ANGLES], next[ANGLES];
    for (int v = 0; v < ANGLES; v++) {
        double cos_v = (v + 0.5) / ANGLES;
        out[v] = bounce[v] = irradiance * brdf_cosine(cos_v, 1, 0, albedo, f0, roughness);
        for (int l = 0; l < ANGLES; l++) {
            kernel[v][l] = 0;
            for (int k = 0; k < 64; k++)
                kernel[v][l] +=
                    brdf_cosine(cos_v, (l + 0.5) / ANGLES, PI * (k + 0.5) / 64, albedo, f0, roughness) * 2 *
                    PI / 64 / ANGLES;
        }
    }
    for (int n = 0; n < 200; n++) {
        for (int v = 0; v < ANGLES; v++) {
            next[v] = 0;
            for (int l = 0; l < ANGLES; l++)
                next[v] += kernel[v][l] * bounce[l];
            out[v] += next[v];
        }
        memcpy(bounce, next, sizeof bounce);
    }
}

static void check_sphere(float base, float roughness)
{
    struct scene s;
    scene_open(&s, 2);
    scene_point(&s, 2, origin);
    scene_sphere(&s, origin, 2, true, scene_material(&s, (const float[3]){base, base, base}, 0, roughness));
    struct ng_transform *t = ng_world_edit(s.world, s.camera, NG_TRANSFORM);
    t->translation[0] = 1.2f;
    t->translation[2] = 0.6f;
    scene_frame(&s, 0);
    enum { SIZE = 12 };
    struct lf_reference *r =
        scene_render(&s, &(struct lf_reference_params){.width = SIZE, .height = SIZE, .jobs = s.jobs}, 2048);
    float *beauty = scene_layer(r, "beauty"), *variance = scene_layer(r, "variance");
    float *position = scene_layer(r, "position");
    double expected[ANGLES], far = 0;
    solve_sphere(ng_brdf_albedo(base, 0), ng_brdf_f0(0.04f, base, 0), roughness, 2.0 / 4, expected);
    for (int i = 0; i < SIZE * SIZE; i++) {
        const float *p = position + i * 3, *eye = s.snapshot->camera.position;
        const float way[3] = {eye[0] - p[0], eye[1] - p[1], eye[2] - p[2]};
        double cosine = -(double)(way[0] * p[0] + way[1] * p[1] + way[2] * p[2]) /
                        sqrt((double)(way[0] * way[0] + way[1] * way[1] + way[2] * way[2])) / 2;
        double at = cosine * ANGLES - 0.5;
        int k = at < 0 ? 0 : at > ANGLES - 2 ? ANGLES - 2 : (int)at;
        double value = expected[k] + (expected[k + 1] - expected[k]) * (at - k);
        far =
            fmax(far, fabs((double)beauty[i * 3] - value) - 5 * sqrt((double)variance[i * 3]) - 0.01 * value);
        assert_true(variance[i * 3] < 0.0025f * (float)(value * value)); // the test is not idle
    }
    if (far > 0)
        fail_msg("sphere of %g, roughness %g: off by %g", (double)base, (double)roughness, far);
    free(beauty);
    free(variance);
    free(position);
    lf_reference_destroy(&r);
    scene_close(&s);
}

static void test_sphere_lit_from_its_centre(void **state)
{
    (void)state;
    check_sphere(0.5f, 1);
    check_sphere(0.8f, 0.5f);
}

// ---- convergence -----------------------------------------------------------------------------------------
// A panel over a floor, with a wall beside it.
static void make_room(struct scene *s, uint32_t threads)
{
    struct ng_light_rectangle panel = {.on = true, .color = {1, 0.9f, 0.8f}, .radiance = 5, .size = {1, 1}};
    scene_open(s, threads);
    scene_light(s, NG_LIGHT_RECTANGLE, &panel, (const float[3]){0, 0, 2}, NULL);
    ng_entity floor = scene_material(s, (const float[3]){0.7f, 0.6f, 0.5f}, 0, 0.6f);
    ng_entity metal = scene_material(s, (const float[3]){0.9f, 0.5f, 0.3f}, 1, 0.3f);
    scene_quad(s, (const float[3]){-2, -2, 0}, (const float[3]){4, 0, 0}, (const float[3]){0, 4, 0}, floor);
    scene_quad(s, (const float[3]){-1, -2, 0}, (const float[3]){0, 4, 0}, (const float[3]){0, 0, 2}, metal);
    scene_frame(s, 0);
}

static double error_of(const struct scene *s, enum lf_sampler_kind kind, uint32_t samples, double expected)
{
    struct lf_primary p = scene_receiver((const float[3]){0.4f, 0.3f, 0}, up);
    double square = 0;
    enum { TRIES = 200 };
    for (uint64_t seed = 0; seed < TRIES; seed++) {
        double x = scene_estimate(s, &p, samples, 0, kind, seed, offsetof(struct lf_radiance, direct)).mean;
        square += (x - expected) * (x - expected);
    }
    return sqrt(square / TRIES);
}

static void test_error_falls_as_the_square_root_of_samples(void **state)
{
    (void)state;
    struct scene s;
    make_room(&s, 1);
    struct lf_primary p = scene_receiver((const float[3]){0.4f, 0.3f, 0}, up);
    double expected =
        scene_estimate(&s, &p, 1 << 18, 0, LF_SAMPLER_SOBOL, 99, offsetof(struct lf_radiance, direct)).mean;
    double independent[3], sobol[3];
    for (uint32_t i = 0; i < 3; i++) {
        independent[i] = error_of(&s, LF_SAMPLER_INDEPENDENT, 16u << (2 * i), expected);
        sobol[i] = error_of(&s, LF_SAMPLER_SOBOL, 16u << (2 * i), expected);
        assert_true(sobol[i] < independent[i]);
    }
    double order = log(independent[0] / independent[2]) / log(16),
           sobol_order = log(sobol[0] / sobol[2]) / log(16);
    NEAR(order, 0.5, 0.08);
    assert_true(sobol_order > 0.5);
    scene_close(&s);
}

static void test_sobol_points_fill_every_elementary_interval(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 8; seed++)
        for (uint32_t draw = 0; draw < 5; draw++)
            for (uint32_t split = 0; split <= 6; split++) {
                int count[64] = {0};
                for (uint32_t i = 0; i < 64; i++) {
                    float u[2];
                    struct lf_sampler s = lf_sampler_start(LF_SAMPLER_SOBOL, seed, 3, 4, i);
                    for (uint32_t k = 0; k <= draw; k++)
                        lf_sampler_2d(&s, u);
                    assert_true(u[0] >= 0 && u[0] < 1 && u[1] >= 0 && u[1] < 1);
                    uint32_t x = (uint32_t)(u[0] * (float)(1u << split)),
                             y = (uint32_t)(u[1] * (float)(64u >> split));
                    count[y << split | x]++;
                }
                for (int i = 0; i < 64; i++)
                    assert_int_equal(count[i], 1);
            }
}

static void test_single_numbers_are_spread_evenly_too(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 8; seed++) {
        int count[64] = {0};
        for (uint32_t i = 0; i < 64; i++) {
            struct lf_sampler s = lf_sampler_start(LF_SAMPLER_SOBOL, seed, 3, 4, i);
            count[(int)(lf_sampler_1d(&s) * 64)]++;
        }
        for (int i = 0; i < 64; i++)
            assert_int_equal(count[i], 1);
    }
}

// ---- bytes -----------------------------------------------------------------------------------------------
static const char *const light_layers[] = {"beauty", "direct",   "unshadowed",
                                           "shadow", "indirect", "variance"};

static void assert_same_picture(const struct lf_reference *a, const struct lf_reference *b)
{
    for (size_t i = 0; i < NG_COUNT(light_layers); i++) {
        float *x = scene_layer(a, light_layers[i]), *y = scene_layer(b, light_layers[i]);
        assert_memory_equal(x, y, 40 * 24 * 3 * sizeof(float));
        free(x);
        free(y);
    }
}

static void test_threads_do_not_change_a_byte(void **state)
{
    (void)state;
    struct scene one, three;
    make_room(&one, 1);
    make_room(&three, 3);
    for (int antialias = 0; antialias < 2; antialias++) {
        struct lf_reference_params p = {.width = 40, .height = 24, .seed = 5, .antialias = antialias};
        struct lf_reference *a = scene_render(&one, &p, 9);
        p.jobs = three.jobs;
        struct lf_reference *b = scene_render(&three, &p, 9);
        assert_same_picture(a, b);
        p.seed = 6;
        struct lf_reference *c = scene_render(&three, &p, 9);
        float *x = scene_layer(a, "beauty"), *y = scene_layer(c, "beauty");
        assert_memory_not_equal(x, y, 40 * 24 * 3 * sizeof(float));
        free(x);
        free(y);
        lf_reference_destroy(&a);
        lf_reference_destroy(&b);
        lf_reference_destroy(&c);
    }
    scene_close(&one);
    scene_close(&three);
}

// The paths from `primaries`, `together` of them at a time.
static void trace_together(const struct scene *s, const struct lf_wave_kernels *kernels,
                           const struct lf_primary *primaries, uint32_t together,
                           struct lf_radiance out[LF_PATHS])
{
    struct lf_path_stats stats = {0};
    struct lf_path_scene scene = {
        .tracer = s->tracer, .lights = &s->lights, .kernels = kernels, .stats = &stats};
    struct lf_path paths[LF_PATHS];
    for (uint32_t i = 0; i < LF_PATHS; i++)
        paths[i] = (struct lf_path){.primary = &primaries[i],
                                    .sampler = lf_sampler_start(LF_SAMPLER_SOBOL, 7, i, 0, 3)};
    for (uint32_t i = 0; i < LF_PATHS; i += together)
        lf_paths_trace(&scene, paths + i, i + together < LF_PATHS ? together : LF_PATHS - i);
    for (uint32_t i = 0; i < LF_PATHS; i++)
        out[i] = paths[i].radiance;
}

static void look_at_room(const struct scene *s, uint64_t seed, struct lf_primary out[LF_PATHS])
{
    struct lf_path_stats stats = {0};
    struct lf_path_scene scene = {.tracer = s->tracer, .lights = &s->lights, .stats = &stats};
    struct ng_rng rng = ng_rng_make(seed, 1);
    for (uint32_t i = 0; i < LF_PATHS; i++) {
        struct lf_ray ray = {.origin = {0, 0, 5}, .direction = {0, 0, -1}, .far = INFINITY};
        ray.direction[0] = ng_rng_range(&rng, -0.5f, 0.5f);
        ray.direction[1] = ng_rng_range(&rng, -0.5f, 0.5f);
        lf_normalize(ray.direction);
        lf_path_begin(&scene, &ray, NULL, &out[i]);
    }
}

static void test_company_and_instructions_do_not_change_a_byte(void **state)
{
    (void)state;
    static const uint32_t together[] = {LF_PATHS, 1, 5, 37};
    struct scene s;
    make_room(&s, 1);
    // Lights of the other kinds, and surfaces in the same place, of which a ray may meet either.
    struct ng_light_sphere sphere = {.on = true, .color = {1, 1, 1}, .radiance = 3, .radius = 0.2f};
    struct ng_light_disk disk = {.on = true, .color = {1, 1, 1}, .radiance = 2, .radius = 0.3f};
    struct ng_light_environment sky = {.on = true, .color = {0.2f, 0.3f, 1}, .intensity = 0.3f};
    scene_light(&s, NG_LIGHT_SPHERE, &sphere, (const float[3]){1, 1, 1}, NULL);
    scene_light(&s, NG_LIGHT_DISK, &disk, (const float[3]){1, -1, 1.5f}, NULL);
    scene_point(&s, 1, (const float[3]){-0.5f, 0, 1});
    scene_light(&s, NG_LIGHT_ENVIRONMENT, &sky, (const float[3]){0, 0, 0}, NULL);
    for (int i = 0; i < 6; i++) {
        const float paint[3] = {0.1f + 0.15f * (float)i, 0.9f - 0.15f * (float)i, 0.5f};
        scene_quad(&s, (const float[3]){-1.5f, -1.5f, 0.1f}, (const float[3]){3, 0, 0},
                   (const float[3]){0, 3, 0}, scene_material(&s, paint, 0, 0.5f));
        scene_quad(&s, (const float[3]){1.5f, -2, 0}, (const float[3]){0, 0, 2}, (const float[3]){0, 4, 0},
                   scene_material(&s, paint, 0, 0.5f));
    }
    scene_frame(&s, 0);
    for (uint64_t seed = 0; seed < 40; seed++) {
        struct lf_primary primaries[LF_PATHS];
        struct lf_radiance first[LF_PATHS], again[LF_PATHS];
        look_at_room(&s, seed, primaries);
        trace_together(&s, NULL, primaries, LF_PATHS, first);
        for (uint32_t k = 0; lf_wave_kernels_of(k); k++)
            for (size_t i = 0; i < NG_COUNT(together); i++) {
                trace_together(&s, lf_wave_kernels_of(k), primaries, together[i], again);
                assert_memory_equal(first, again, sizeof first);
            }
    }
    scene_close(&s);
}

static void test_a_region_is_a_part_of_the_picture(void **state)
{
    (void)state;
    struct scene s;
    make_room(&s, 2);
    struct lf_reference_params p = {.width = 40, .height = 24, .jobs = s.jobs};
    struct lf_reference *whole = scene_render(&s, &p, 4);
    p.region = (struct lf_region){13, 5, 20, 17};
    struct lf_reference *part = scene_render(&s, &p, 4);
    float *a = scene_layer(whole, "beauty"), *b = scene_layer(part, "beauty");
    for (uint32_t y = 0; y < 17; y++)
        assert_memory_equal(a + ((y + 5) * 40 + 13) * 3, b + (size_t)y * 20 * 3, 20 * 3 * sizeof(float));
    free(a);
    free(b);
    lf_reference_destroy(&whole);
    lf_reference_destroy(&part);
    scene_close(&s);
}

static bool stop_at_once(void *user, const struct lf_reference_progress *progress)
{
    assert_true(progress->samples > 0 && progress->samples <= progress->target);
    ++*(int *)user;
    return false;
}

static void test_resuming_does_not_change_a_byte(void **state)
{
    (void)state;
    char path[512];
    int calls = 0;
    struct scene s;
    test_path(path, sizeof path, "resume.samples");
    remove(path);
    make_room(&s, 2);
    struct lf_reference_params p = {.width = 40, .height = 24, .seed = 5, .jobs = s.jobs};
    struct lf_reference *whole = scene_render(&s, &p, 13), *parts = NULL;
    struct lf_reference_run_params run = {
        .samples = 13, .checkpoint = path, .picture = 77, .progress = stop_at_once, .user = &calls};
    for (int i = 0; i < 20; i++) { // a pass in each sitting
        lf_reference_destroy(&parts);
        OK(lf_reference_create(&p, &parts));
        OK(lf_reference_begin(parts, s.tracer));
        OK(lf_reference_run(parts, &run));
    }
    assert_int_equal(lf_reference_stats_of(parts).samples, 13);
    assert_int_equal(calls, 13);
    assert_same_picture(whole, parts);

    // Of another picture, cut short, or changed in a byte: refused in one line.
    struct test_log log;
    test_log_begin(&log);
    run.picture = 78;
    assert_int_equal(lf_reference_run(parts, &run), NG_ERROR_FORMAT);
    run.picture = 77;
    FILE *f = fopen(path, "r+b");
    assert_non_null(f);
    assert_int_equal(fseek(f, 1000, SEEK_SET), 0);
    int byte = fgetc(f);
    assert_int_equal(fseek(f, 1000, SEEK_SET), 0);
    fputc(byte ^ 1, f);
    fclose(f);
    assert_int_equal(lf_reference_run(parts, &run), NG_ERROR_FORMAT);
    test_log_end(&log);
    assert_int_equal(log.errors, 2);
    assert_non_null(strstr(log.text, "of another picture"));
    assert_non_null(strstr(log.text, "not a whole checkpoint"));
    lf_reference_destroy(&whole);
    lf_reference_destroy(&parts);
    scene_close(&s);
}

static void test_beauty_is_the_exact_sum_of_its_parts(void **state)
{
    (void)state;
    struct scene s;
    make_room(&s, 2);
    struct lf_reference *r =
        scene_render(&s, &(struct lf_reference_params){.width = 40, .height = 24, .jobs = s.jobs}, 8);
    float *beauty = scene_layer(r, "beauty"), *direct = scene_layer(r, "direct");
    float *indirect = scene_layer(r, "indirect"), *emission = scene_layer(r, "emission");
    float *unshadowed = scene_layer(r, "unshadowed"), *shadow = scene_layer(r, "shadow");
    double bounced = 0;
    for (int i = 0; i < 40 * 24 * 3; i++) {
        assert_true(beauty[i] == direct[i] + indirect[i] + emission[i]);
        assert_true(direct[i] <= unshadowed[i] * 1.0001f);
        assert_true(shadow[i] == (unshadowed[i] > 0 ? direct[i] / unshadowed[i] : 1));
        bounced += (double)indirect[i];
    }
    assert_true(bounced > 0);
    free(beauty);
    free(direct);
    free(indirect);
    free(emission);
    free(unshadowed);
    free(shadow);
    lf_reference_destroy(&r);
    scene_close(&s);
}

static void test_depth_counts_segments(void **state)
{
    (void)state;
    struct scene s;
    make_room(&s, 2);
    for (uint32_t depth = 1; depth <= 3; depth++) {
        struct lf_reference *r = scene_render(
            &s, &(struct lf_reference_params){.width = 16, .height = 16, .depth = depth, .jobs = s.jobs}, 8);
        float *direct = scene_layer(r, "direct"), *indirect = scene_layer(r, "indirect");
        double sum[2] = {0};
        for (int i = 0; i < 16 * 16 * 3; i++) {
            sum[0] += (double)direct[i];
            sum[1] += (double)indirect[i];
        }
        assert_true((sum[0] > 0) == (depth >= 2));
        assert_true((sum[1] > 0) == (depth >= 3));
        free(direct);
        free(indirect);
        lf_reference_destroy(&r);
    }
    scene_close(&s);
}

static void test_emission_without_a_light_is_indirect(void **state)
{
    (void)state;
    struct scene s;
    scene_open(&s, 1);
    // Faces down, all around the receiver: it sees nothing else of the upper half.
    scene_quad(&s, (const float[3]){-500, 500, 1}, (const float[3]){1000, 0, 0},
               (const float[3]){0, -1000, 0}, scene_glow(&s, (const float[3]){2, 2, 2}));
    scene_frame_warned(&s, 0);
    struct estimate direct = scene_irradiance(&s, origin, up, 100, direct);
    assert_true(direct.mean == 0);
    ESTIMATES(scene_irradiance(&s, origin, up, 4000, indirect), 2 * PI, 5e-3, 0.01);
    scene_close(&s);
}

static void test_clamp_limits_indirect_light_alone(void **state)
{
    (void)state;
    enum { SIZE = 16, VALUES = SIZE * SIZE * 3 };
    struct scene s;
    make_room(&s, 2);
    struct lf_reference_params p = {.width = SIZE, .height = SIZE, .jobs = s.jobs};
    struct lf_reference *whole = scene_render(&s, &p, 1);
    p.clamp = 0.05f;
    struct lf_reference *clamped = scene_render(&s, &p, 1);
    float *indirect = scene_layer(whole, "indirect"), *less = scene_layer(clamped, "indirect");
    float *direct = scene_layer(whole, "direct"), *same = scene_layer(clamped, "direct");
    int limited = 0;
    for (int i = 0; i < VALUES; i += 3) {
        float most = lf_max3(indirect + i), expected = most > p.clamp ? p.clamp / most : 1;
        for (int c = 0; c < 3; c++)
            NEAR(less[i + c], indirect[i + c] * expected, 1e-6);
        limited += most > p.clamp;
    }
    assert_true(limited > 0 && limited < SIZE * SIZE);
    assert_memory_equal(direct, same, VALUES * sizeof *direct);
    free(indirect);
    free(less);
    free(direct);
    free(same);
    lf_reference_destroy(&whole);
    lf_reference_destroy(&clamped);
    scene_close(&s);
}

// A wall that shines fills the left half of four pixels. The tent around a pixel's centre reaches the centres
// beside it, and leaves an eighth beyond the pixel's edge.
static void test_antialiasing_is_a_tent(void **state)
{
    (void)state;
    static const double expected[2][4] = {{1, 1, 0, 0}, {1, 0.875, 0.125, 0}};
    struct scene s;
    scene_open(&s, 1);
    scene_quad(&s, (const float[3]){-50, -50, 0}, (const float[3]){50, 0, 0}, (const float[3]){0, 100, 0},
               scene_glow(&s, (const float[3]){1, 1, 1}));
    scene_frame_warned(&s, 0);
    for (int antialias = 0; antialias < 2; antialias++) {
        float *emission = scene_render_layer(
            &s, &(struct lf_reference_params){.width = 4, .height = 1, .antialias = antialias, .depth = 1},
            256, "emission");
        for (int i = 0; i < 4; i++)
            NEAR(emission[i * 3], expected[antialias][i], antialias ? 0.01 : 0);
        free(emission);
    }
    scene_close(&s);
}

static void test_a_time_limit_ends_between_passes(void **state)
{
    (void)state;
    struct scene s;
    make_room(&s, 2);
    struct lf_reference *r;
    OK(lf_reference_create(&(struct lf_reference_params){.width = 8, .height = 8, .jobs = s.jobs}, &r));
    OK(lf_reference_begin(r, s.tracer));
    OK(lf_reference_run(r, &(struct lf_reference_run_params){.samples = UINT32_MAX, .time_limit = 0.1}));
    struct lf_reference_stats stats = lf_reference_stats_of(r);
    assert_true(stats.samples > 0 && stats.samples < UINT32_MAX && stats.seconds >= 0.1);
    float *samples = scene_layer(r, "samples");
    assert_true(samples[0] == (float)stats.samples && samples[63] == (float)stats.samples);
    free(samples);
    lf_reference_destroy(&r);
    scene_close(&s);
}

static void test_a_sample_that_is_no_number_stops_the_picture(void **state)
{
    (void)state;
    struct scene s;
    scene_open(&s, 2);
    ng_entity broken = scene_material(&s, (const float[3]){NAN, 0.5f, 0.5f}, 0, 1);
    scene_quad(&s, (const float[3]){-3, -3, 0}, (const float[3]){6, 0, 0}, (const float[3]){0, 6, 0}, broken);
    scene_point(&s, 2, (const float[3]){0, 0, 2});
    scene_frame(&s, 0);
    struct lf_reference *r;
    struct test_log log;
    OK(lf_reference_create(
        &(struct lf_reference_params){.width = 33, .height = 20, .seed = 12, .jobs = s.jobs}, &r));
    OK(lf_reference_begin(r, s.tracer));
    test_log_begin(&log);
    assert_int_equal(lf_reference_run(r, &(struct lf_reference_run_params){.samples = 4}), NG_ERROR_FORMAT);
    test_log_end(&log);
    assert_int_equal(log.errors, 1);
    assert_non_null(strstr(log.text, "pixel 0, 0, sample 0, seed 12"));
    lf_reference_destroy(&r);
    scene_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_white_furnace),
        cmocka_unit_test(test_nothing_leaves_a_closed_box_without_light),
        cmocka_unit_test(test_sphere_lit_from_its_centre),
        cmocka_unit_test(test_error_falls_as_the_square_root_of_samples),
        cmocka_unit_test(test_sobol_points_fill_every_elementary_interval),
        cmocka_unit_test(test_single_numbers_are_spread_evenly_too),
        cmocka_unit_test(test_threads_do_not_change_a_byte),
        cmocka_unit_test(test_company_and_instructions_do_not_change_a_byte),
        cmocka_unit_test(test_a_region_is_a_part_of_the_picture),
        cmocka_unit_test(test_resuming_does_not_change_a_byte),
        cmocka_unit_test(test_beauty_is_the_exact_sum_of_its_parts),
        cmocka_unit_test(test_depth_counts_segments),
        cmocka_unit_test(test_emission_without_a_light_is_indirect),
        cmocka_unit_test(test_clamp_limits_indirect_light_alone),
        cmocka_unit_test(test_antialiasing_is_a_tent),
        cmocka_unit_test(test_a_time_limit_ends_between_passes),
        cmocka_unit_test(test_a_sample_that_is_no_number_stops_the_picture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

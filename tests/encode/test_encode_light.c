// Unshadowed direct light of every type of light against the path tracer's T_l, and the kernels against each
// other.
#include "picture.h"

#include "base/rng.h"
#include "components/light_directional.h"
#include "components/light_disk.h"
#include "components/light_environment.h"
#include "components/light_mesh.h"
#include "components/light_point.h"
#include "components/light_rectangle.h"
#include "components/light_sphere.h"
#include "components/light_spot.h"
#include "lightformer/clues/kernels.h"
#include "scene/world.h"

#include <math.h>

enum { SIZE = 40 };

// A floor and a ball of one material, seen from (0, 0, 5).
static void open_scene(struct scene *s, float metallic, float roughness)
{
    scene_open(s, 2);
    ng_entity material = scene_material(s, (const float[3]){0.8f, 0.6f, 0.4f}, metallic, roughness);
    scene_quad(s, (const float[3]){-3, -1, 3}, (const float[3]){6, 0, 0}, (const float[3]){0, 0, -6},
               material);
    scene_sphere(s, (const float[3]){0, -0.2f, 0}, 0.8f, false, material);
}

// Mean square of the difference, relative as the project's RSE is.
static double error_of(const struct scene *s, const struct picture *p, uint32_t spp)
{
    float *truth = scene_render_layer(
        s, &(struct lf_reference_params){.width = SIZE, .height = SIZE, .depth = 2, .jobs = s->jobs}, spp,
        "unshadowed");
    double mean = 0, error = 0;
    for (int i = 0; i < 3 * SIZE * SIZE; i++)
        mean += (double)truth[i] / (3 * SIZE * SIZE);
    assert_true(mean > 0);
    for (size_t i = 0; i < SIZE * SIZE; i++)
        for (uint32_t c = 0; c < 3; c++) {
            double ours = 0, b = (double)truth[3 * i + c] / mean;
            for (uint32_t l = 0; l < p->lights; l++)
                ours += (double)((picture_view(p, l, LF_INPUT_VIEW_DIFFUSE, c)[i] +
                                  picture_view(p, l, LF_INPUT_VIEW_GLOSSY, c)[i]) *
                                 picture_unit(p, l));
            ours /= mean;
            error += (ours - b) * (ours - b) / (b * b + 0.01) / (3 * SIZE * SIZE);
        }
    free(truth);
    return error;
}

static const struct ng_light_point point = {.on = true, .color = {1, 0.5f, 0.2f}, .intensity = 3};
static const struct ng_light_spot spot = {
    .on = true, .color = {1, 1, 1}, .intensity = 3, .inner_angle = 0.4f, .outer_angle = 0.8f};
static const struct ng_light_directional sun = {.on = true, .color = {1, 1, 0.5f}, .irradiance = 2};
static const struct ng_light_rectangle rectangle = {
    .on = true, .color = {1, 0.5f, 0.2f}, .radiance = 2, .size = {1.5f, 0.6f}};
static const struct ng_light_disk disk = {.on = true, .color = {1, 1, 1}, .radiance = 2, .radius = 0.6f};
static const struct ng_light_sphere ball = {.on = true, .color = {1, 1, 1}, .radiance = 2, .radius = 0.4f};
static const struct ng_light_environment sky = {.on = true, .color = {0.4f, 0.6f, 1}, .intensity = 1};

static const struct {
    const char *name;
    ng_component type;
    const void *light;
    float bound; // of the error
} lights[] = {
    {"point", NG_LIGHT_POINT, &point, 1e-5f},
    {"spot", NG_LIGHT_SPOT, &spot, 1e-5f},
    {"sun", NG_LIGHT_DIRECTIONAL, &sun, 1e-5f},
    {"rectangle", NG_LIGHT_RECTANGLE, &rectangle, 2e-3f},
    {"disk", NG_LIGHT_DISK, &disk, 2e-3f},
    {"sphere", NG_LIGHT_SPHERE, &ball, 2e-3f},
    {"environment", NG_LIGHT_ENVIRONMENT, &sky, 2e-3f},
};

static const struct {
    float metallic, roughness;
    double slack; // smooth metal is nearly black but for a few highlights, whose tails weigh all the more
} materials[] = {{0, 0.9f, 1}, {0, 0.2f, 1}, {1, 0.45f, 1}, {1, 0.1f, 10}};

static void unshadowed_light_is_the_path_tracers(void **state)
{
    NG_UNUSED(state);
    for (size_t m = 0; m < NG_COUNT(materials); m++)
        for (size_t l = 0; l < NG_COUNT(lights); l++) {
            struct scene s;
            struct picture p = {0};
            open_scene(&s, materials[m].metallic, materials[m].roughness);
            scene_light(&s, lights[l].type, lights[l].light, (const float[3]){0.3f, 1.6f, 0.4f}, scene_down);
            scene_frame(&s, 0);
            picture_encode(&p, &s, SIZE, SIZE);
            double error = error_of(&s, &p, lights[l].bound < 1e-4f ? 8 : 400);
            print_message("%s, metallic %g, roughness %g: %.2g\n", lights[l].name,
                          (double)materials[m].metallic, (double)materials[m].roughness, error);
            if (!(error < (double)lights[l].bound * materials[m].slack))
                fail_msg("too far from the path tracer");
            picture_close(&p);
            scene_close(&s);
        }
}

// An emissive mesh has no closed form: its direct VPLs and rays through the emitters share the work.
static void emissive_meshes_too(void **state)
{
    NG_UNUSED(state);
    for (size_t m = 0; m < NG_COUNT(materials); m++) {
        struct scene s;
        struct picture p = {0};
        open_scene(&s, materials[m].metallic, materials[m].roughness);
        ng_entity e = scene_quad(&s, (const float[3]){-0.5f, 1.5f, -0.3f}, (const float[3]){1, 0, 0},
                                 (const float[3]){0, 0, 0.8f}, scene_glow(&s, (const float[3]){2, 2, 2}));
        OK(ng_world_add(s.world, e, NG_LIGHT_MESH,
                        &(struct ng_light_mesh){.on = true, .color = {1, 1, 1}, .scale = 1}));
        scene_frame(&s, 0);
        picture_encode(&p, &s, SIZE, SIZE);
        double error = error_of(&s, &p, 400);
        print_message("mesh, metallic %g, roughness %g: %.2g\n", (double)materials[m].metallic,
                      (double)materials[m].roughness, error);
        assert_true(error < 2e-3);
        picture_close(&p);
        scene_close(&s);
    }
}

// ---- near lamps ------------------------------------------------------------------------------------------

static const struct ng_light_rectangle strip = {
    .on = true, .color = {1, 0.5f, 0.2f}, .radiance = 2, .size = {0.05f, 2}};
static const struct ng_light_rectangle small = {
    .on = true, .color = {1, 1, 1}, .radiance = 2, .size = {0.8f, 0.5f}};

static void add_near_lamp(struct scene *s, int kind, float height)
{
    const float at[3] = {0.1f, height - 1, 0.2f};
    const float ball_at[3] = {0.1f, height - 1 + ball.radius, 0.2f};
    ng_entity e;
    switch (kind) {
    case 0:
        scene_light(s, NG_LIGHT_RECTANGLE, &rectangle, at, scene_down);
        break;
    case 1:
        scene_light(s, NG_LIGHT_RECTANGLE, &strip, at, scene_down);
        break;
    case 2:
        scene_light(s, NG_LIGHT_RECTANGLE, &small, at, scene_down);
        break;
    case 3:
        scene_light(s, NG_LIGHT_DISK, &disk, at, scene_down);
        break;
    case 4:
        scene_light(s, NG_LIGHT_SPHERE, &ball, ball_at, NULL);
        break;
    default:
        e = scene_quad(s, (const float[3]){-0.5f, height - 1, -0.3f}, (const float[3]){1, 0, 0},
                       (const float[3]){0, 0, 0.8f}, scene_glow(s, (const float[3]){2, 2, 2}));
        OK(ng_world_add(s->world, e, NG_LIGHT_MESH,
                        &(struct ng_light_mesh){.on = true, .color = {1, 1, 1}, .scale = 1}));
    }
}

// From a hand's breadth down to millimetres: no sample of a lamp shows, and nothing is brighter than the
// lamp.
static void near_lamps_light_like_far_ones(void **state)
{
    static const float heights[] = {0.003f, 0.012f, 0.05f, 0.2f},
                       materials_near[][2] = {{0, 0.9f}, {0, 0.2f}, {1, 0.6f}};
    NG_UNUSED(state);
    for (int kind = 0; kind < 6; kind++)
        for (size_t m = 0; m < NG_COUNT(materials_near); m++)
            for (size_t h = 0; h < NG_COUNT(heights); h++) {
                struct scene s;
                struct picture p = {0};
                scene_open(&s, 2);
                scene_quad(&s, (const float[3]){-3, -1, 3}, (const float[3]){6, 0, 0},
                           (const float[3]){0, 0, -6},
                           scene_material(&s, (const float[3]){0.8f, 0.6f, 0.4f}, materials_near[m][0],
                                          materials_near[m][1]));
                add_near_lamp(&s, kind, heights[h]);
                scene_frame(&s, 0);
                picture_encode(&p, &s, SIZE, SIZE);
                double error = error_of(&s, &p, 200);
                print_message("kind %d, %g m, metallic %g, roughness %g: %.2g\n", kind, (double)heights[h],
                              (double)materials_near[m][0], (double)materials_near[m][1], error);
                if (!(error < 0.12)) // tens to hundreds, where samples show
                    fail_msg("too far from the path tracer");
                picture_close(&p);
                scene_close(&s);
            }
}

// ---- kernels ---------------------------------------------------------------------------------------------

static void random_unit(struct ng_rng *rng, float v[3][LF_LANES], int i)
{
    float length = 0;
    for (int c = 0; c < 3; c++) {
        v[c][i] = ng_rng_range(rng, -1, 1);
        length += v[c][i] * v[c][i];
    }
    for (int c = 0; c < 3; c++)
        v[c][i] /= sqrtf(length);
}

static struct lf_shading_points random_points(struct ng_rng *rng)
{
    struct lf_shading_points p;
    for (int i = 0; i < LF_LANES; i++) {
        random_unit(rng, p.normal, i);
        random_unit(rng, p.view, i);
        random_unit(rng, p.flat, i);
        for (int c = 0; c < 3; c++) {
            p.position[c][i] = ng_rng_range(rng, -1, 1);
            p.albedo[c][i] = ng_rng_float(rng);
            p.f0[c][i] = ng_rng_float(rng);
        }
        p.roughness[i] = ng_rng_float(rng);
    }
    return p;
}

static struct lf_emitter random_shape(struct ng_rng *rng, enum lf_emitter_kind emitter)
{
    struct lf_emitter s = {.kind = emitter,
                           .sample_count = 7,
                           .cone_scale = 2,
                           .normal = {0, -1, 0},
                           .u = {2, 0, 0},
                           .v = {0, 0, 3},
                           .area = 0.7f,
                           .radius = 0.2f,
                           .coarseness = ng_rng_float(rng),
                           .radiance = {1, 2, 3}};
    for (int k = 0; k < 7; k++)
        for (int c = 0; c < 3; c++) {
            s.samples[k].position[c] = ng_rng_range(rng, -1, 1);
            s.samples[k].normal[c] = c == 1 ? -1 : 0;
            s.samples[k].weight[c] = ng_rng_float(rng);
            s.samples[k].density = 10;
        }
    return s;
}

static void random_window(struct ng_rng *rng, struct lf_ray_window *out)
{
    for (int j = 0; j < LF_INTERLEAVE_TAPS; j++) {
        for (int i = 0; i < LF_RAY_COLUMNS; i++) {
            for (int c = 0; c < 3; c++) {
                out->from[c][j][i] = ng_rng_float(rng) - 0.5f;
                out->normal[c][j][i] = c == 1 ? 1 : 0;
                out->to[c][j][i] = ng_rng_float(rng) - (c == 1 ? 0.1f : 0.5f);
            }
            out->density[j][i] = 10 * ng_rng_float(rng);
            out->met[j][i] = ng_rng_float(rng) < 0.5f ? 1 : 0;
            out->there[j][i] = ng_rng_float(rng) < 0.8f ? 1 : 0;
        }
        out->across[j] = out->down[j] = ng_rng_float(rng);
    }
}

// Planes of a patch that sixteen pixels look at; those that are read besides lie around.
#define PATCH_WIDTH  (LF_LANES + 2 * LF_INTERLEAVE_HALF)
#define PATCH_HEIGHT LF_INTERLEAVE_TAPS
#define PATCH_AT     (LF_INTERLEAVE_HALF * PATCH_WIDTH + LF_INTERLEAVE_HALF)
struct patch {
    float planes[11][PATCH_HEIGHT * PATCH_WIDTH];
};

static struct lf_neighbourhood random_patch(struct ng_rng *rng, struct patch *p)
{
    struct lf_neighbourhood n = {.stride = PATCH_WIDTH};
    const float **planes[] = {&n.position[0], &n.position[1], &n.position[2], &n.normal[0],
                              &n.normal[1],   &n.normal[2],   &n.mask,        &n.distance,
                              &n.roughness,   &n.part,        &n.weight};
    for (size_t i = 0; i < NG_COUNT(planes); i++) {
        for (int k = 0; k < PATCH_HEIGHT * PATCH_WIDTH; k++)
            p->planes[i][k] = ng_rng_float(rng);
        *planes[i] = p->planes[i] + PATCH_AT;
    }
    for (int k = 0; k < PATCH_HEIGHT * PATCH_WIDTH; k++) {
        const float normal[3] = {0.02f * p->planes[3][k], 1, 0.02f * p->planes[5][k]};
        float length = sqrtf(normal[0] * normal[0] + 1 + normal[2] * normal[2]);
        for (int c = 0; c < 3; c++)
            p->planes[3 + c][k] = normal[c] / length;
        p->planes[1][k] *= 0.01f;
        p->planes[6][k] = p->planes[6][k] < 0.9f;
        p->planes[10][k] = p->planes[10][k] < 0.3f ? 0 : p->planes[10][k];
    }
    return n;
}

// What a pixel of a patch takes of another, in double precision.
static double patch_weight(const struct lf_neighbourhood *n, int to, int other, bool specular)
{
    double height = 0, cosine = 0, chord = 0, roughness = n->roughness[to], alpha = roughness * roughness;
    for (int c = 0; c < 3; c++) {
        double a = n->normal[c][to], b = n->normal[c][other];
        height += ((double)n->position[c][other] - n->position[c][to]) * a;
        cosine += a * b;
        chord += (a - b) * (a - b);
    }
    height /= 0.01 * n->distance[to];
    alpha = alpha > 1e-3 ? alpha : 1e-3;
    double spread = 1 + chord * (1 - chord / 4) / ((1 - chord / 2) * (1 - chord / 2) * alpha * alpha);
    double overlap = alpha < 0.1 && spread > 1.0005 ? 0 : 1 / (spread * spread);
    return (double)n->weight[other] * n->mask[other] * pow(cosine, 8) / (1 + pow(height, 4)) *
           (specular ? overlap : 1);
}

static void neighbours_count_as_far_as_they_are_alike(void **state)
{
    static const double window[LF_INTERLEAVE_TAPS] = {0.5, 1, 1, 1, 0.5};
    NG_UNUSED(state);
    struct ng_rng rng = ng_rng_make(2, 1);
    struct patch patch;
    for (int round = 0; round < 20; round++) {
        const struct lf_neighbourhood n = random_patch(&rng, &patch);
        float mean[LF_LANES];
        bool specular = round % 2;
        lf_kernels_of(0)->average(&n, specular, mean);
        for (int i = 0; i < LF_LANES; i++) {
            double sum = 0, weights = 0;
            for (int k = 0; k < LF_INTERLEAVE_TAPS * LF_INTERLEAVE_TAPS; k++) {
                int x = k % LF_INTERLEAVE_TAPS, y = k / LF_INTERLEAVE_TAPS;
                int other = (y - LF_INTERLEAVE_HALF) * PATCH_WIDTH + x - LF_INTERLEAVE_HALF + i;
                double weight = window[x] * window[y] * patch_weight(&n, i, other, specular);
                weights += weight;
                sum += weight * n.part[other];
            }
            assert_float_equal(mean[i], weights > 0 ? (float)(sum / weights) : n.part[i], 2e-4);
        }
    }
}

// Of a lamp of radiance and area 3 two metres above, and of a sun of 5 W/m2 from the side.
static void light_arrives_by_cosines_and_distance(void **state)
{
    NG_UNUSED(state);
    struct lf_shading_points p = {.normal = {[1] = {0}}};
    for (int i = 0; i < LF_LANES; i++) {
        p.position[0][i] = 0.25f * (float)i;
        p.normal[1][i] = p.flat[1][i] = i == 3 ? -1 : 1; // that one lies on its face
    }
    const struct lf_light_sample lamp = {.position = {0, 2, 0}, .normal = {0, -1, 0}, .weight = {3, 3, 3}};
    const struct lf_light_sample slanted = {.normal = {0.8f, -0.6f, 0}, .weight = {3, 5, 7}};
    struct lf_aim aim;
    lf_kernels_of(0)->arrive(&lamp, false, &p, &aim);
    for (int i = 0; i < LF_LANES; i++) {
        float x = p.position[0][i], square = x * x + 4;
        assert_float_equal(aim.distance[i], sqrtf(square), 1e-5);
        assert_float_equal(aim.direction[0][i], -x / sqrtf(square), 1e-6);
        assert_float_equal(aim.weight[i], i == 3 ? 0 : 3 * 4 / (square * square), 1e-5);
    }
    lf_kernels_of(0)->arrive(&slanted, true, &p, &aim);
    assert_float_equal(aim.direction[1][5], 0.6f, 1e-6);
    assert_float_equal(aim.weight[5], 5 * 0.6f, 1e-5);
    assert_float_equal(aim.weight[3], 0, 0);
}

// To the last bit, on whatever CPU this is.
static void instruction_sets_agree(void **state)
{
    NG_UNUSED(state);
    struct ng_rng rng = ng_rng_make(1, 1);
    struct lf_rsm_source sources[5];
    int rays_seen = 0;
    for (int round = 0; round < 200; round++) {
        struct lf_shading_points points = random_points(&rng);
        struct lf_emitter shape = random_shape(&rng, (enum lf_emitter_kind)(round % 6));
        for (int k = 0; k < 5; k++)
            sources[k] = (struct lf_rsm_source){.position = {ng_rng_float(&rng), 0.2f, 0.1f * (float)k},
                                                .normal = {0, 1, 0},
                                                .flux = {1, 2, 3},
                                                .area = 0.1f};
        struct lf_lit first, lit;
        float bounce_first[3][LF_LANES], bounce[3][LF_LANES];
        bool lobes = round % 4 < 2 && shape.kind > LF_EMITTER_DIRECTION;
        double sum = 0;
        lf_kernels_of(0)->direct(&shape, &points, lobes, &first);
        lf_kernels_of(0)->rsm_gather(sources, 5, &points, bounce_first);
        float u[3][LF_LANES];
        for (int i = 0; i < LF_LANES; i++)
            for (int c = 0; c < 3; c++)
                u[c][i] = lf_brdf_samples[i][c];
        struct lf_aim aim_first, aim;
        lf_kernels_of(0)->aim(&shape, &points, u, &aim_first);
        struct lf_ray_window window;
        random_window(&rng, &window);
        float grain[LF_LANES], rays_first[LF_RAY_TAPS][LF_LANES], rays[LF_RAY_TAPS][LF_LANES];
        for (int i = 0; i < LF_LANES; i++)
            grain[i] = 0.02f + ng_rng_float(&rng);
        lf_kernels_of(0)->reflect(&points, grain, &window, rays_first);
        struct lf_aim arrive_first, arrive;
        lf_kernels_of(0)->arrive(&shape.samples[0], round % 2, &points, &arrive_first);
        struct patch patch;
        const struct lf_neighbourhood pixels = random_patch(&rng, &patch);
        float mean_first[LF_LANES], mean[LF_LANES];
        lf_kernels_of(0)->average(&pixels, round % 2, mean_first);
        for (int k = 0; k < LF_RAY_TAPS; k++)
            for (int i = 0; i < LF_LANES; i++) {
                int row = k / LF_INTERLEAVE_TAPS, column = i + k % LF_INTERLEAVE_TAPS;
                assert_true(rays_first[k][i] >= 0 && isfinite(rays_first[k][i]) &&
                            (window.there[row][column] > 0 || rays_first[k][i] == 0));
                rays_seen += rays_first[k][i] > 0;
            }
        for (int i = 0; i < LF_LANES; i++)
            sum += (double)(first.diffuse[0][i] + bounce_first[0][i]);
        assert_true(sum > 0);
        for (uint32_t k = 1; lf_kernels_of(k); k++) {
            lf_kernels_of(k)->direct(&shape, &points, lobes, &lit);
            lf_kernels_of(k)->rsm_gather(sources, 5, &points, bounce);
            assert_memory_equal(&first, &lit, sizeof lit);
            assert_memory_equal(bounce_first, bounce, sizeof bounce);
            lf_kernels_of(k)->reflect(&points, grain, &window, rays);
            assert_memory_equal(rays_first, rays, sizeof rays);
            lf_kernels_of(k)->aim(&shape, &points, u, &aim);
            assert_memory_equal(&aim_first, &aim, sizeof aim);
            lf_kernels_of(k)->arrive(&shape.samples[0], round % 2, &points, &arrive);
            assert_memory_equal(&arrive_first, &arrive, sizeof arrive);
            lf_kernels_of(k)->average(&pixels, round % 2, mean);
            assert_memory_equal(mean_first, mean, sizeof mean);
        }
    }
    assert_true(rays_seen > 1000);
    uint32_t sets = 0;
    while (lf_kernels_of(sets))
        print_message("%s\n", lf_kernels_of(sets++)->name);
    assert_string_equal(lf_kernels_of(sets - 1)->name, "plain");
}

// The table that the kernels have as constants.
static void sixteen_directions_are_the_spirals(void **state)
{
    NG_UNUSED(state);
    float spiral[LF_BRDF_SAMPLES][3];
    lf_brdf_spiral(LF_BRDF_SAMPLES, spiral);
    assert_memory_equal(spiral, lf_brdf_samples, sizeof spiral);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(unshadowed_light_is_the_path_tracers),
        cmocka_unit_test(emissive_meshes_too),
        cmocka_unit_test(near_lamps_light_like_far_ones),
        cmocka_unit_test(sixteen_directions_are_the_spirals),
        cmocka_unit_test(light_arrives_by_cosines_and_distance),
        cmocka_unit_test(neighbours_count_as_far_as_they_are_alike),
        cmocka_unit_test(instruction_sets_agree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

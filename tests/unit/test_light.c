// Light types against closed forms: power, densities, irradiance, direct VPLs, proxies, degenerate input.
#include "test.h"

#include "base/rng.h"
#include "components/components.h"
#include "components/light_directional.h"
#include "components/light_disk.h"
#include "components/light_environment.h"
#include "components/light_mesh.h"
#include "components/light_point.h"
#include "components/light_rectangle.h"
#include "components/light_sphere.h"
#include "components/light_spot.h"
#include "light/light.h"

#include <math.h>

#define NEAR(a, b, e)     assert_true(fabs((double)(a) - (double)(b)) <= (e))
#define RELATIVE(a, b, e) assert_true(fabs((double)(a) - (double)(b)) <= (e)*fabs((double)(b)))

static const double pi = 3.14159265358979323846;

static struct ng_light_source make(ng_component component, const void *params, size_t size)
{
    struct ng_light_source s = {
        .type = ng_light_type_of(component), .scene_center = {1, 2, 3}, .scene_radius = 10};
    assert_non_null(s.type);
    assert_true(size <= sizeof s.params);
    memcpy(s.params, params, size);
    s.matrix[0] = s.matrix[5] = s.matrix[10] = s.matrix[15] = 1;
    return s;
}
#define MAKE(id, type, ...) make(id, &(type){__VA_ARGS__}, sizeof(type))

static void prepare(struct ng_light_source *s)
{
    assert_int_equal(ng_light_prepare(s), NG_OK);
}

// Columns of a placement that turns about y, then x, scales and moves.
static void place(struct ng_light_source *s, float yaw, float pitch, float sx, float sy, float sz, float x,
                  float y, float z)
{
    float cy = cosf(yaw), sn = sinf(yaw), cp = cosf(pitch), sp = sinf(pitch);
    const float m[16] = {cy * sx,
                         0,
                         -sn * sx,
                         0,
                         sn * sp * sy,
                         cp * sy,
                         cy * sp * sy,
                         0,
                         sn * cp * sz,
                         -sp * sz,
                         cy * cp * sz,
                         0,
                         x,
                         y,
                         z,
                         1};
    memcpy(s->matrix, m, sizeof m);
}

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// ---- all types -------------------------------------------------------------------------------------------
// KNOWN sources of chosen numbers, which have closed forms; after them every type that there is with the
// numbers of its component's defaults, twice if it takes an image. A new type is among them by itself.
enum { KNOWN = 10, MOST = KNOWN + 2 * NG_COMPONENT_COUNT };

struct sources {
    struct ng_light_source s[MOST];
    int count;
};

static float random_map[16 * 8][4],
    quad[2][3][3] = {{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}}, {{-1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}},
    quad_uv[2][3][2] = {{{0, 1}, {1, 1}, {1, 0}}, {{0, 1}, {1, 0}, {0, 0}}};

static struct ng_light_image map_image(void)
{
    struct ng_rng rng = ng_rng_make(5, 5);
    for (size_t i = 0; i < NG_COUNT(random_map); i++)
        for (int c = 0; c < 4; c++)
            random_map[i][c] = ng_rng_float(&rng) < 0.6f ? 0 : ng_rng_range(&rng, 0, 4);
    return (struct ng_light_image){
        .width = 16, .height = 8, .format = NG_LIGHT_TEXEL_FLOAT32, .pixels = random_map};
}

static void emissive(struct ng_light_source *s, bool textured, bool double_sided)
{
    s->triangle_count = 2;
    s->triangles = quad[0][0];
    s->triangle_uvs = quad_uv[0][0];
    s->emission[0] = 1, s->emission[1] = 2, s->emission[2] = 3;
    s->double_sided = double_sided;
    if (textured)
        s->image = map_image();
}

static void make_known(struct ng_light_source s[KNOWN])
{
    s[0] = MAKE(NG_LIGHT_POINT, struct ng_light_point, .on = true, .color = {1, 0.5f, 0.25f}, .intensity = 3);
    s[1] = MAKE(NG_LIGHT_SPOT, struct ng_light_spot, .on = true, .color = {1, 0.5f, 0.25f}, .intensity = 3,
                .inner_angle = 0.3f, .outer_angle = 0.6f);
    s[2] = MAKE(NG_LIGHT_DIRECTIONAL, struct ng_light_directional, .on = true, .color = {1, 0.5f, 0.25f},
                .irradiance = 3);
    s[3] = MAKE(NG_LIGHT_RECTANGLE, struct ng_light_rectangle, .on = true, .color = {1, 0.5f, 0.25f},
                .radiance = 3, .size = {2, 0.5f});
    s[4] = s[3];
    s[4].image = map_image();
    s[5] = MAKE(NG_LIGHT_DISK, struct ng_light_disk, .on = true, .color = {1, 0.5f, 0.25f}, .radiance = 3,
                .radius = 0.7f);
    s[6] = MAKE(NG_LIGHT_SPHERE, struct ng_light_sphere, .on = true, .color = {1, 0.5f, 0.25f}, .radiance = 3,
                .radius = 0.7f);
    s[7] = MAKE(NG_LIGHT_MESH, struct ng_light_mesh, .on = true, .color = {1, 0.5f, 0.25f}, .scale = 3);
    emissive(&s[7], true, false);
    s[8] = s[7];
    s[8].double_sided = true;
    s[9] = MAKE(NG_LIGHT_ENVIRONMENT, struct ng_light_environment, .on = true, .color = {1, 0.5f, 0.25f},
                .intensity = 3);
    s[9].image = map_image();
}

static void add_defaults(struct sources *all, const struct ng_light_type *type)
{
    static const struct ng_component_desc *const components[] = {
#define X(NAME, name) &ng_##name##_component,
        NG_COMPONENT_LIST(X)
#undef X
    };
    const struct ng_component_desc *desc = components[type->component];
    struct ng_light_source *s = &all->s[all->count++];
    *s = make(type->component, desc->defaults, desc->size);
    if (type->emissive_mesh)
        emissive(s, false, false);
    if (!type->image && !type->emissive_mesh)
        return;
    all->s[all->count] = *s;
    all->s[all->count++].image = map_image();
}

// At an odd placement.
static void make_all(struct sources *all)
{
    all->count = KNOWN;
    make_known(all->s);
    for (int i = 0; ng_light_types[i]; i++)
        add_defaults(all, ng_light_types[i]);
    for (int i = 0; i < all->count; i++) {
        place(&all->s[i], 0.7f, -0.4f, 1.3f, 1.3f, 1.3f, 0.5f, 2, -1);
        prepare(&all->s[i]);
        assert_true(ng_light_power(&all->s[i]) > 0);
    }
}

static void finish_all(struct sources *all)
{
    for (int i = 0; i < all->count; i++)
        ng_light_finish(&all->s[i]);
}

static void test_types_are_found(void **state)
{
    (void)state;
    for (int i = 0; ng_light_types[i]; i++) {
        assert_ptr_equal(ng_light_type_of(ng_light_types[i]->component), ng_light_types[i]);
        assert_true(!i || strcmp(ng_light_types[i - 1]->name, ng_light_types[i]->name) < 0);
    }
    // What is a light by its component's name is one here, and the other way round.
    for (ng_component c = 0; c < NG_COMPONENT_COUNT; c++)
        assert_true(ng_component_is_light(c) == (ng_light_type_of(c) != NULL));
    assert_true(ng_component_is_light(NG_LIGHT_POINT));
}

// The mean of the samples' power is the light's power, for each channel.
static void test_samples_carry_the_power(void **state)
{
    (void)state;
    struct sources all;
    make_all(&all);
    for (int i = 0; i < all.count; i++) {
        const struct ng_light_source *s = &all.s[i];
        float power[3];
        double sum[3] = {0};
        ng_light_power_rgb(s, power);
        for (uint32_t k = 0; k < 16384; k++) {
            struct ng_light_sample sample;
            float u[2];
            ng_light_vpl_point(k, u);
            ng_light_sample_at(s, u, &sample);
            for (int c = 0; c < 3; c++)
                sum[c] += (double)sample.power[c] / 16384;
        }
        for (int c = 0; c < 3; c++)
            RELATIVE(sum[c], power[c], 0.01);
        RELATIVE(ng_light_power(s), (power[0] + power[1] + power[2]) / 3, 1e-6);
    }
    finish_all(&all);
}

// A light that is off or dim is, at unit brightness, the same to the last bit.
static void test_unit_lights_forget_their_brightness(void **state)
{
    (void)state;
    struct sources all;
    make_all(&all);
    for (int i = 0; i < all.count; i++) {
        struct ng_light_source unit, again, off = all.s[i];
        ng_light_unit(&all.s[i], &unit);
        if (i < KNOWN)
            RELATIVE(ng_light_power(&unit) * 3, ng_light_power(&all.s[i]), 1e-6);
        memset(off.params, 0, 1); // every light's component begins with its switch
        assert_true(ng_light_power(&off) == 0);
        ng_light_unit(&off, &again);
        assert_memory_equal(&unit, &again, sizeof unit);
        assert_true(ng_light_power(&unit) > 0);
    }
    finish_all(&all);
}

// A ray shot at a sample finds the light with the density and the radiance that the sample had.
static void test_hits_agree_with_samples(void **state)
{
    (void)state;
    struct sources all;
    make_all(&all);
    for (int i = 0; i < all.count; i++) {
        const struct ng_light_source *s = &all.s[i];
        struct ng_rng rng = ng_rng_make(3, (uint64_t)i);
        int seen = 0;
        for (int k = 0; k < 500; k++) {
            float u[2] = {ng_rng_float(&rng), ng_rng_float(&rng)}, receiver[3], rgb[3];
            struct ng_light_sample sample;
            struct ng_light_incident in;
            for (int c = 0; c < 3; c++)
                receiver[c] = ng_rng_range(&rng, -6, 6);
            ng_light_sample_at(s, u, &sample);
            ng_light_incident_at(s, &sample, receiver, &in);
            struct ng_light_hit hit = {.distance = in.distance};
            memcpy(hit.position, sample.position, sizeof hit.position);
            memcpy(hit.direction, in.direction, sizeof hit.direction);
            if (s->triangle_count) { // the square's lower triangle is the first
                float x = sample.position[0], y = sample.position[1];
                hit.triangle = x < y;
                hit.barycentric[0] = hit.triangle ? (x + 1) / 2 : (x - y) / 2;
                hit.barycentric[1] = hit.triangle ? (y - x) / 2 : (y + 1) / 2;
            }
            if (s->type->delta) {
                assert_true(in.pdf == 0 && ng_light_pdf_at(s, &hit) == 0);
                continue;
            }
            if (in.pdf == 0)
                continue;
            // A sample at the very edge of a cell may fall to its neighbour.
            float pdf = ng_light_pdf_at(s, &hit);
            ng_light_seen_at(s, &hit, rgb);
            seen += fabsf(pdf - in.pdf) < 2e-3f * in.pdf &&
                    fabsf(rgb[1] - sample.radiance[1]) < 1e-2f * (1 + rgb[1]);
        }
        assert_true(s->type->delta || seen > 120);
    }
    finish_all(&all);
}

// Densities integrate to 1 over the light: the mean of 1 / pdf is its area, or the sphere of directions.
static void test_densities_integrate_to_the_area(void **state)
{
    (void)state;
    struct sources all;
    make_all(&all);
    const double scale = 1.3 * 1.3;
    const double area[KNOWN] = {1, 1, 1, scale, 0, scale * pi * 0.49, scale * 4 * pi * 0.49, 4, 8, 0};
    for (int i = 0; i < KNOWN; i++) {
        double sum = 0;
        for (uint32_t k = 0; area[i] > 0 && k < 65536; k++) {
            struct ng_light_sample sample;
            float u[2];
            ng_light_vpl_point(k, u);
            ng_light_sample_at(&all.s[i], u, &sample);
            assert_true(sample.pdf > 0);
            sum += 1 / (double)sample.pdf / 65536;
        }
        if (area[i] > 0)
            RELATIVE(sum, area[i], 0.02);
    }
    finish_all(&all);
}

static void test_vpls_are_the_same_every_time(void **state)
{
    (void)state;
    struct sources all, again;
    static struct ng_light_sample a[300], b[300];
    make_all(&all);
    make_all(&again);
    for (int i = 0; i < all.count; i++) {
        struct ng_light_source *s = &all.s[i];
        ng_light_vpls(s, 300, a);
        ng_light_vpls(&again.s[i], 300, b);
        assert_memory_equal(a, b, sizeof a);
        ng_light_vpls(s, 100, b); // fewer VPLs are the first of more
        assert_memory_equal(a, b, 100 * sizeof a[0]);
        prepare(s); // once more, into memory that was used
        ng_light_vpls(s, 300, b);
        assert_memory_equal(a, b, sizeof a);
    }
    finish_all(&all);
    finish_all(&again);
}

static void test_vpl_points_are_stratified(void **state)
{
    (void)state;
    for (uint32_t split = 0; split <= 8; split++) { // every elementary interval of 256 points holds one
        int cells[256] = {0};
        for (uint32_t i = 0; i < 256; i++) {
            float u[2];
            ng_light_vpl_point(i, u);
            assert_true(u[0] > 0 && u[0] < 1 && u[1] > 0 && u[1] < 1);
            uint32_t x = (uint32_t)(u[0] * (float)(1u << split)),
                     y = (uint32_t)(u[1] * (float)(256u >> split));
            cells[y << split | x]++;
        }
        for (int i = 0; i < 256; i++)
            assert_int_equal(cells[i], 1);
    }
}

// ---- power -----------------------------------------------------------------------------------------------
static void test_power_closed_forms(void **state)
{
    (void)state;
    struct sources all;
    make_all(&all);
    const struct ng_light_source *s = all.s;
    const double mean = 1.75 / 3 * 3, scale = 1.3 * 1.3;
    RELATIVE(ng_light_power(&s[0]), 4 * pi * mean, 1e-5);
    RELATIVE(ng_light_power(&s[2]), pi * 100 * mean, 1e-5);
    RELATIVE(ng_light_power(&s[3]), pi * scale * mean, 1e-5);
    RELATIVE(ng_light_power(&s[5]), pi * scale * pi * 0.49 * mean, 1e-5);
    RELATIVE(ng_light_power(&s[6]), pi * scale * 4 * pi * 0.49 * mean, 1e-5);
    RELATIVE(ng_light_power(&s[8]), 2 * ng_light_power(&s[7]), 1e-6);
    finish_all(&all);
    struct ng_light_source sky = MAKE(NG_LIGHT_ENVIRONMENT, struct ng_light_environment, .on = true,
                                      .color = {1, 0.5f, 0.25f}, .intensity = 3);
    prepare(&sky);
    RELATIVE(ng_light_power(&sky), pi * 100 * 4 * pi * mean, 1e-5);
    ng_light_finish(&sky);
}

static void test_spot_power_by_quadrature(void **state)
{
    (void)state;
    const float angles[][2] = {{0.3f, 0.6f}, {0, 0.5f}, {0.5f, 0.5f}, {1.2f, 1.5f}, {0, 0.02f}, {0.2f, 3}};
    for (size_t i = 0; i < NG_COUNT(angles); i++) {
        struct ng_light_source s =
            MAKE(NG_LIGHT_SPOT, struct ng_light_spot, .on = true, .color = {1, 1, 1}, .intensity = 2,
                 .inner_angle = angles[i][0], .outer_angle = angles[i][1]);
        struct ng_light_sample sample;
        ng_light_sample_at(&s, (float[2]){0.5f, 0.5f}, &sample);
        double sum = 0, step = (double)angles[i][1] / 20000;
        for (int k = 0; k < 20000; k++) { // distance 1: irradiance is intensity
            double theta = (k + 0.5) * step;
            float receiver[3] = {(float)sin(theta), 0, -(float)cos(theta)};
            struct ng_light_incident in;
            ng_light_incident_at(&s, &sample, receiver, &in);
            sum += 2 * pi * sin(theta) * step * (double)in.irradiance[0];
        }
        RELATIVE(ng_light_power(&s), sum, 2e-3);
    }
}

// ---- irradiance ------------------------------------------------------------------------------------------
static void irradiance(const struct ng_light_source *s, float x, float y, float z, float nz, float rgb[3])
{
    ng_light_irradiance(s, 16384, (float[3]){x, y, z}, (float[3]){0, 0, nz}, rgb);
}

static void test_inverse_square(void **state)
{
    (void)state;
    struct ng_light_source s =
        MAKE(NG_LIGHT_POINT, struct ng_light_point, .on = true, .color = {1, 1, 1}, .intensity = 5);
    float near[3], far[3];
    irradiance(&s, 0, 0, -2, 1, near);
    irradiance(&s, 0, 0, -6, 1, far);
    RELATIVE(near[0], 5.0 / 4, 1e-5);
    RELATIVE(near[0] / far[0], 9, 1e-5);
    irradiance(&s, 0, 0, -2, -1, near); // turned away
    assert_true(near[0] == 0);
}

// A disk of radius r seen from distance d on its axis: E = pi L r^2 / (r^2 + d^2).
static void test_disk_irradiance(void **state)
{
    (void)state;
    struct ng_light_source s = MAKE(NG_LIGHT_DISK, struct ng_light_disk, .on = true, .color = {1, 1, 1},
                                    .radiance = 2, .radius = 1.5f);
    float rgb[3];
    irradiance(&s, 0, 0, -1, 1, rgb);
    RELATIVE(rgb[0], pi * 2 * 2.25 / 3.25, 2e-3);
    irradiance(&s, 0, 0, 1, -1, rgb); // behind
    assert_true(rgb[0] == 0);
}

// A square of half side 1 from distance d on its axis: Siegel and Howell, C-11, times four quarters.
static void test_rectangle_irradiance(void **state)
{
    (void)state;
    struct ng_light_source s = MAKE(NG_LIGHT_RECTANGLE, struct ng_light_rectangle, .on = true,
                                    .color = {1, 1, 1}, .radiance = 2, .size = {2, 1});
    prepare(&s);
    const double a = 1, b = 0.5, d = 0.8; // half sides, distance
    double x = a / d, y = b / d, rx = sqrt(1 + x * x), ry = sqrt(1 + y * y);
    double quarter = (x / rx * atan(y / rx) + y / ry * atan(x / ry)) / (2 * pi);
    float rgb[3];
    irradiance(&s, 0, 0, -0.8f, 1, rgb);
    RELATIVE(rgb[0], pi * 2 * 4 * quarter, 2e-3);
    ng_light_finish(&s);
}

// A sphere wholly above the horizon: E = pi L (r / d)^2 cos.
static void test_sphere_irradiance(void **state)
{
    (void)state;
    struct ng_light_source s = MAKE(NG_LIGHT_SPHERE, struct ng_light_sphere, .on = true, .color = {1, 1, 1},
                                    .radiance = 2, .radius = 0.5f);
    float rgb[3];
    irradiance(&s, 0, 0, -1.2f, 1, rgb);
    RELATIVE(rgb[0], pi * 2 * 0.25 / 1.44, 5e-3);
    irradiance(&s, 1, 0, -1.2f, 1, rgb);
    RELATIVE(rgb[0], pi * 2 * 0.25 / 2.44 * 1.2 / sqrt(2.44), 5e-3);
}

// Uniform radiance all around gives pi L, a directional light its irradiance times the cosine.
static void test_infinite_irradiance(void **state)
{
    (void)state;
    struct ng_light_source sky = MAKE(NG_LIGHT_ENVIRONMENT, struct ng_light_environment, .on = true,
                                      .color = {1, 1, 1}, .intensity = 3);
    struct ng_light_source sun = MAKE(NG_LIGHT_DIRECTIONAL, struct ng_light_directional, .on = true,
                                      .color = {1, 1, 1}, .irradiance = 3);
    float rgb[3];
    prepare(&sky);
    irradiance(&sky, 5, 5, 5, 1, rgb);
    RELATIVE(rgb[0], pi * 3, 2e-3);
    irradiance(&sun, 0, 0, 0, 1, rgb);
    RELATIVE(rgb[0], 3, 1e-4);
    irradiance(&sun, 0, 0, 0, -1, rgb);
    assert_true(rgb[0] == 0);
    ng_light_finish(&sky);
}

// A triangulated square is the rectangle light of its size, seen from the side of its front.
static void test_mesh_equals_rectangle(void **state)
{
    (void)state;
    struct ng_light_source mesh =
        MAKE(NG_LIGHT_MESH, struct ng_light_mesh, .on = true, .color = {1, 1, 1}, .scale = 2);
    struct ng_light_source rectangle = MAKE(NG_LIGHT_RECTANGLE, struct ng_light_rectangle, .on = true,
                                            .color = {1, 2, 3}, .radiance = 2, .size = {2, 2});
    emissive(&mesh, false, false);
    place(&rectangle, (float)pi, 0, 1, 1, 1, 0, 0, 0); // faces +Z, as the mesh does
    prepare(&mesh);
    prepare(&rectangle);
    float a[3], b[3];
    irradiance(&mesh, 0.3f, -0.2f, 0.7f, -1, a);
    irradiance(&rectangle, 0.3f, -0.2f, 0.7f, -1, b);
    for (int i = 0; i < 3; i++)
        RELATIVE(a[i], b[i], 5e-3);
    RELATIVE(ng_light_power(&mesh), ng_light_power(&rectangle), 1e-5);
    ng_light_finish(&mesh);
    ng_light_finish(&rectangle);
}

// ---- importance ------------------------------------------------------------------------------------------
// Samples fall on texels in proportion to what the texels emit.
static void test_environment_follows_its_map(void **state)
{
    (void)state;
    static float map[8][16][4];
    for (int y = 0; y < 8; y++)
        for (int x = 0; x < 16; x++)
            map[y][x][0] = map[y][x][1] = map[y][x][2] = y == 2 && x == 12 ? 100.0f : 0.01f;
    struct ng_light_source s = MAKE(NG_LIGHT_ENVIRONMENT, struct ng_light_environment, .on = true,
                                    .color = {1, 1, 1}, .intensity = 1);
    s.image =
        (struct ng_light_image){.width = 16, .height = 8, .format = NG_LIGHT_TEXEL_FLOAT32, .pixels = map};
    prepare(&s);
    // The bright texel is to the right of the centre (-Z) by 4.5 texels of 22.5 degrees, above the horizon.
    double theta = pi * 2.5 / 8, phi = 2 * pi * 4.5 / 16;
    const float bright[3] = {(float)(sin(theta) * sin(phi)), (float)cos(theta),
                             -(float)(sin(theta) * cos(phi))};
    int close = 0;
    struct ng_light_sample samples[512];
    ng_light_vpls(&s, 512, samples);
    for (int i = 0; i < 512; i++)
        close += -dot(samples[i].normal, bright) > cosf(0.6f);
    assert_true(close > 490);
    struct ng_light_proxy proxy;
    ng_light_proxy_of(&s, &proxy);
    assert_true(-dot(proxy.direction, bright) > 0.995f);
    // Turned a quarter about +Y, the bright spot turns with it.
    place(&s, (float)pi / 2, 0, 1, 1, 1, 0, 0, 0);
    float turned[3] = {bright[2], bright[1], -bright[0]};
    ng_light_proxy_of(&s, &proxy);
    assert_true(-dot(proxy.direction, turned) > 0.995f);
    struct ng_light_hit hit = {.direction = {turned[0], turned[1], turned[2]}};
    float rgb[3];
    ng_light_seen_at(&s, &hit, rgb);
    NEAR(rgb[0], 100, 1);
    ng_light_finish(&s);
}

static void test_environment_histogram(void **state)
{
    (void)state;
    enum { N = 200000 };
    struct ng_light_source s = MAKE(NG_LIGHT_ENVIRONMENT, struct ng_light_environment, .on = true,
                                    .color = {1, 1, 1}, .intensity = 1);
    s.image = map_image();
    prepare(&s);
    static double expected[8][16], got[8][16];
    memset(expected, 0, sizeof expected);
    memset(got, 0, sizeof got);
    double total = 0;
    for (int j = 0; j < 256; j++) // what the map emits, by brute force
        for (int i = 0; i < 512; i++) {
            double theta = (j + 0.5) * pi / 256, phi = ((i + 0.5) / 512 - 0.5) * 2 * pi;
            struct ng_light_hit hit = {.direction = {(float)(sin(theta) * sin(phi)), (float)cos(theta),
                                                     -(float)(sin(theta) * cos(phi))}};
            float rgb[3];
            ng_light_seen_at(&s, &hit, rgb);
            expected[j / 32][i / 32] += (double)ng_light_mean(rgb) * sin(theta);
            total += (double)ng_light_mean(rgb) * sin(theta);
        }
    struct ng_rng rng = ng_rng_make(1, 1);
    for (int k = 0; k < N; k++) {
        struct ng_light_sample sample;
        ng_light_sample_at(&s, (float[2]){ng_rng_float(&rng), ng_rng_float(&rng)}, &sample);
        double u = 0.5 + atan2(-(double)sample.normal[0], (double)sample.normal[2]) / (2 * pi);
        double v = acos(-(double)sample.normal[1]) / pi;
        got[(int)(v * 8) & 7][(int)(u * 16) & 15] += 1.0 / N;
    }
    for (int y = 0; y < 8; y++)
        for (int x = 0; x < 16; x++)
            NEAR(got[y][x], expected[y][x] / total, 0.003);
    RELATIVE(ng_light_power(&s), pi * 100 * total * (pi / 256) * (2 * pi / 512), 2e-3);
    ng_light_finish(&s);
}

// A map larger than the grid keeps its power, and samples still see only what the map holds.
static void test_large_map(void **state)
{
    (void)state;
    enum { W = 2500, H = 3 };
    static float map[H][W][4];
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++)
            map[y][x][0] = map[y][x][1] = map[y][x][2] = x == 1700 ? 1000.0f : 0;
    struct ng_light_source s = MAKE(NG_LIGHT_RECTANGLE, struct ng_light_rectangle, .on = true,
                                    .color = {1, 1, 1}, .radiance = 1, .size = {1, 1});
    s.image =
        (struct ng_light_image){.width = W, .height = H, .format = NG_LIGHT_TEXEL_FLOAT32, .pixels = map};
    prepare(&s);
    RELATIVE(ng_light_power(&s), pi * 1000.0 / W, 1e-4);
    struct ng_light_sample samples[256];
    ng_light_vpls(&s, 256, samples);
    double power = 0;
    for (int i = 0; i < 256; i++) {
        NEAR(samples[i].position[0], 0.5 - 1700.5 / W, 3.5 / W);
        power += (double)samples[i].power[0] / 256;
    }
    RELATIVE(power, pi * 1000.0 / W, 0.05);
    ng_light_finish(&s);
}

// The rectangle's picture is upright for one whom it shines at: row 0 at +Y, column 0 at +X.
static void test_texture_orientation_and_formats(void **state)
{
    (void)state;
    static const unsigned char bytes[4][4] = {
        {255, 0, 0, 255}, {0, 0, 0, 255}, {0, 0, 0, 255}, {0, 128, 0, 255}};
    struct ng_light_source s = MAKE(NG_LIGHT_RECTANGLE, struct ng_light_rectangle, .on = true,
                                    .color = {1, 1, 1}, .radiance = 1, .size = {2, 2});
    s.image =
        (struct ng_light_image){.width = 2, .height = 2, .format = NG_LIGHT_TEXEL_UNORM8, .pixels = bytes};
    for (int srgb = 0; srgb < 2; srgb++) {
        s.image.format = srgb ? NG_LIGHT_TEXEL_SRGB8 : NG_LIGHT_TEXEL_UNORM8;
        prepare(&s);
        struct ng_light_hit hit = {.position = {0.9f, 0.9f, 0}, .direction = {0, 0, 1}, .distance = 1};
        float rgb[3];
        ng_light_seen_at(&s, &hit, rgb);
        assert_true(rgb[0] == 1 && rgb[1] == 0);
        hit.position[0] = hit.position[1] = -0.9f;
        ng_light_seen_at(&s, &hit, rgb);
        NEAR(rgb[1], srgb ? 0.21586 : 128 / 255.0, 1e-4);
        hit.direction[2] = -1; // from behind
        ng_light_seen_at(&s, &hit, rgb);
        assert_true(rgb[1] == 0);
    }
    ng_light_finish(&s);
}

// One bright spot in a large triangle is found, and its power is that of the texture.
static void test_mesh_texture_importance(void **state)
{
    (void)state;
    enum { SIZE = 64 };
    static float texture[SIZE][SIZE][4];
    for (int y = 20; y < 24; y++)
        for (int x = 40; x < 44; x++)
            texture[y][x][0] = texture[y][x][1] = texture[y][x][2] = 50;
    struct ng_light_source s =
        MAKE(NG_LIGHT_MESH, struct ng_light_mesh, .on = true, .color = {1, 1, 1}, .scale = 1);
    emissive(&s, false, false);
    s.emission[1] = s.emission[2] = 1;
    s.image = (struct ng_light_image){
        .width = SIZE, .height = SIZE, .format = NG_LIGHT_TEXEL_FLOAT32, .pixels = texture};
    prepare(&s);
    RELATIVE(ng_light_power(&s), pi * 4 * 50 * 16.0 / (SIZE * SIZE), 0.03);
    const double x = 42.0 / SIZE * 2 - 1, y = 1 - 22.0 / SIZE * 2;
    struct ng_light_sample samples[512];
    ng_light_vpls(&s, 512, samples);
    int close = 0;
    for (int i = 0; i < 512; i++)
        close += fabs((double)samples[i].position[0] - x) < 0.12 &&
                 fabs((double)samples[i].position[1] - y) < 0.12;
    assert_true(close > 400);
    struct ng_light_proxy proxy;
    ng_light_proxy_of(&s, &proxy);
    NEAR(proxy.position[0], x, 0.01);
    NEAR(proxy.position[1], y, 0.01);
    NEAR(proxy.position[2], 5e-5, 1e-6);
    ng_light_finish(&s);
}

// ---- proxies ---------------------------------------------------------------------------------------------
static void test_proxies(void **state)
{
    (void)state;
    struct sources all;
    struct ng_light_proxy proxy[MOST];
    make_all(&all);
    const struct ng_light_source *s = all.s;
    for (int i = 0; i < all.count; i++) {
        ng_light_proxy_of(&s[i], &proxy[i]);
        NEAR(dot(proxy[i].direction, proxy[i].direction), 1, 1e-5);
        NEAR(dot(proxy[i].up, proxy[i].up), 1, 1e-5);
        NEAR(dot(proxy[i].up, proxy[i].direction), 0, 1e-5);
    }
    // In the limit the proxy of an area light is the mean of its VPLs, plus the step off its surface.
    for (int i = 3; i <= 8; i++) {
        static struct ng_light_sample vpls[16384];
        double mean[3] = {0}, weight = 0;
        ng_light_vpls(&s[i], 16384, vpls);
        for (int k = 0; k < 16384; k++) {
            weight += (double)ng_light_mean(vpls[k].power);
            for (int c = 0; c < 3; c++)
                mean[c] += (double)ng_light_mean(vpls[k].power) * (double)vpls[k].position[c];
        }
        for (int c = 0; c < 3; c++)
            NEAR(proxy[i].position[c], mean[c] / weight, 0.025);
        assert_int_equal(proxy[i].views, NG_VIEWS_CUBE);
    }
    assert_int_equal(proxy[0].views, NG_VIEWS_CUBE);
    assert_int_equal(proxy[1].views, NG_VIEWS_SINGLE_PERSPECTIVE);
    NEAR(proxy[1].fov, 1.2, 1e-6);
    assert_int_equal(proxy[2].views, NG_VIEWS_SINGLE_ORTHOGRAPHIC);
    assert_int_equal(proxy[9].views, NG_VIEWS_SINGLE_ORTHOGRAPHIC);
    NEAR(proxy[2].extent, 10, 0);
    for (int c = 0; c < 3; c++) // the orthographic views begin where they enter the scene's sphere
        NEAR(proxy[2].position[c] + 10 * proxy[2].direction[c], s[2].scene_center[c], 1e-4);
    finish_all(&all);
}

static void test_uniform_environment_looks_down(void **state)
{
    (void)state;
    struct ng_light_source s = MAKE(NG_LIGHT_ENVIRONMENT, struct ng_light_environment, .on = true,
                                    .color = {1, 1, 1}, .intensity = 1);
    struct ng_light_proxy proxy;
    prepare(&s);
    ng_light_proxy_of(&s, &proxy);
    NEAR(proxy.direction[1], -1, 1e-6);
    ng_light_finish(&s);
}

static void test_wide_spot_takes_a_cube(void **state)
{
    (void)state;
    struct ng_light_source s = MAKE(NG_LIGHT_SPOT, struct ng_light_spot, .on = true, .color = {1, 1, 1},
                                    .intensity = 1, .inner_angle = 0, .outer_angle = 1.5f);
    struct ng_light_proxy proxy;
    ng_light_proxy_of(&s, &proxy);
    assert_int_equal(proxy.views, NG_VIEWS_CUBE);
}

// The emitting side stays the entity's -Z when its placement mirrors.
static void test_mirrored_rectangle(void **state)
{
    (void)state;
    struct ng_light_source s = MAKE(NG_LIGHT_RECTANGLE, struct ng_light_rectangle, .on = true,
                                    .color = {1, 1, 1}, .radiance = 1, .size = {1, 1});
    struct ng_light_sample sample;
    prepare(&s);
    for (int mirror = 0; mirror < 2; mirror++) {
        place(&s, 0, 0, mirror ? -1 : 1, 1, 1, 0, 0, 0);
        ng_light_sample_at(&s, (float[2]){0.5f, 0.5f}, &sample);
        assert_true(sample.normal[2] == -1);
    }
    ng_light_finish(&s);
}

// ---- degenerate input ------------------------------------------------------------------------------------
static void assert_dark(struct ng_light_source *s)
{
    prepare(s);
    assert_true(ng_light_power(s) == 0);
    for (uint32_t i = 0; i < 8; i++) {
        struct ng_light_sample sample;
        struct ng_light_incident in;
        struct ng_light_proxy proxy;
        float u[2], rgb[3];
        ng_light_vpl_point(i, u);
        ng_light_sample_at(s, u, &sample);
        assert_true(sample.pdf == 0 && sample.radiance[0] == 0 && sample.power[0] == 0);
        ng_light_incident_at(s, &sample, (float[3]){1, 1, 1}, &in);
        assert_true(in.irradiance[0] == 0 && in.pdf == 0);
        ng_light_seen_at(s, &(struct ng_light_hit){.direction = {0, 0, 1}, .distance = 1}, rgb);
        assert_true(rgb[0] == 0);
        ng_light_proxy_of(s, &proxy);
        for (int c = 0; c < 3; c++)
            assert_true(isfinite(proxy.position[c]) && isfinite(proxy.direction[c]));
    }
    ng_light_finish(s);
}

static void test_dark_lights(void **state)
{
    (void)state;
    struct ng_light_source cases[] = {
        MAKE(NG_LIGHT_POINT, struct ng_light_point, .on = false, .color = {1, 1, 1}, .intensity = 1),
        MAKE(NG_LIGHT_POINT, struct ng_light_point, .on = true, .color = {1, 1, 1}, .intensity = 0),
        MAKE(NG_LIGHT_POINT, struct ng_light_point, .on = true, .color = {1, NAN, 1}, .intensity = 1),
        MAKE(NG_LIGHT_POINT, struct ng_light_point, .on = true, .color = {-1, -1, -1}, .intensity = 1),
        MAKE(NG_LIGHT_POINT, struct ng_light_point, .on = true, .color = {1, 1, 1}, .intensity = INFINITY),
        MAKE(NG_LIGHT_SPOT, struct ng_light_spot, .on = true, .color = {1, 1, 1}, .intensity = 1,
             .inner_angle = 0, .outer_angle = 0),
        MAKE(NG_LIGHT_SPOT, struct ng_light_spot, .on = true, .color = {1, 1, 1}, .intensity = 1,
             .inner_angle = 0, .outer_angle = NAN),
        MAKE(NG_LIGHT_RECTANGLE, struct ng_light_rectangle, .on = true, .color = {1, 1, 1}, .radiance = 1,
             .size = {0, 1}),
        MAKE(NG_LIGHT_RECTANGLE, struct ng_light_rectangle, .on = true, .color = {1, 1, 1}, .radiance = 1,
             .size = {1e30f, 1e30f}),
        MAKE(NG_LIGHT_DISK, struct ng_light_disk, .on = true, .color = {1, 1, 1}, .radiance = 1, .radius = 0),
        MAKE(NG_LIGHT_SPHERE, struct ng_light_sphere, .on = true, .color = {1, 1, 1}, .radiance = 1,
             .radius = NAN),
        MAKE(NG_LIGHT_MESH, struct ng_light_mesh, .on = true, .color = {1, 1, 1}, .scale = 1),
        MAKE(NG_LIGHT_ENVIRONMENT, struct ng_light_environment, .on = true, .color = {0, 0, 0},
             .intensity = 1),
        MAKE(NG_LIGHT_DIRECTIONAL, struct ng_light_directional, .on = true, .color = {1, 1, 1},
             .irradiance = NAN),
    };
    for (size_t i = 0; i < NG_COUNT(cases); i++)
        assert_dark(&cases[i]);
}

static void test_dark_meshes_and_maps(void **state)
{
    (void)state;
    static float flat[2][3][3], broken[2][3][3], black[4][4], wild[4][4] = {{NAN, -1, INFINITY, 0}};
    memcpy(broken, quad, sizeof quad);
    broken[0][0][0] = broken[1][0][0] = NAN;
    struct ng_light_source s =
        MAKE(NG_LIGHT_MESH, struct ng_light_mesh, .on = true, .color = {1, 1, 1}, .scale = 1);
    emissive(&s, false, false);
    s.triangles = flat[0][0];
    assert_dark(&s);
    s = MAKE(NG_LIGHT_MESH, struct ng_light_mesh, .on = true, .color = {1, 1, 1}, .scale = 1);
    emissive(&s, false, false);
    s.triangles = broken[0][0];
    assert_dark(&s);
    s = MAKE(NG_LIGHT_ENVIRONMENT, struct ng_light_environment, .on = true, .color = {1, 1, 1},
             .intensity = 1);
    s.image =
        (struct ng_light_image){.width = 2, .height = 2, .format = NG_LIGHT_TEXEL_FLOAT32, .pixels = black};
    assert_dark(&s);
    // Infinities and NaNs of a map are tamed, not spread.
    s = MAKE(NG_LIGHT_ENVIRONMENT, struct ng_light_environment, .on = true, .color = {1, 1, 1},
             .intensity = 1);
    s.image =
        (struct ng_light_image){.width = 2, .height = 2, .format = NG_LIGHT_TEXEL_FLOAT32, .pixels = wild};
    prepare(&s);
    float rgb[3];
    ng_light_power_rgb(&s, rgb);
    assert_true(rgb[0] == 0 && rgb[1] == 0 && isfinite(rgb[2]) && rgb[2] > 0);
    ng_light_finish(&s);
}

// A receiver on the light itself, or a degenerate placement: no division by zero.
static void test_receiver_on_the_light(void **state)
{
    (void)state;
    struct ng_light_source s =
        MAKE(NG_LIGHT_POINT, struct ng_light_point, .on = true, .color = {1, 1, 1}, .intensity = 1);
    struct ng_light_sample sample;
    struct ng_light_incident in;
    ng_light_sample_at(&s, (float[2]){0, 0}, &sample);
    ng_light_incident_at(&s, &sample, sample.position, &in);
    assert_true(in.irradiance[0] == 0);
    struct ng_light_source sky = MAKE(NG_LIGHT_ENVIRONMENT, struct ng_light_environment, .on = true,
                                      .color = {1, 1, 1}, .intensity = 1);
    memset(sky.matrix, 0, sizeof sky.matrix);
    prepare(&sky);
    ng_light_sample_at(&sky, (float[2]){0.5f, 0.5f}, &sample);
    assert_true(sample.pdf == 0);
    ng_light_finish(&sky);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_types_are_found),
        cmocka_unit_test(test_samples_carry_the_power),
        cmocka_unit_test(test_hits_agree_with_samples),
        cmocka_unit_test(test_densities_integrate_to_the_area),
        cmocka_unit_test(test_vpls_are_the_same_every_time),
        cmocka_unit_test(test_vpl_points_are_stratified),
        cmocka_unit_test(test_power_closed_forms),
        cmocka_unit_test(test_spot_power_by_quadrature),
        cmocka_unit_test(test_inverse_square),
        cmocka_unit_test(test_disk_irradiance),
        cmocka_unit_test(test_rectangle_irradiance),
        cmocka_unit_test(test_sphere_irradiance),
        cmocka_unit_test(test_infinite_irradiance),
        cmocka_unit_test(test_mesh_equals_rectangle),
        cmocka_unit_test(test_environment_follows_its_map),
        cmocka_unit_test(test_environment_histogram),
        cmocka_unit_test(test_large_map),
        cmocka_unit_test(test_texture_orientation_and_formats),
        cmocka_unit_test(test_mesh_texture_importance),
        cmocka_unit_test(test_proxies),
        cmocka_unit_test(test_uniform_environment_looks_down),
        cmocka_unit_test(test_wide_spot_takes_a_cube),
        cmocka_unit_test(test_mirrored_rectangle),
        cmocka_unit_test(test_unit_lights_forget_their_brightness),
        cmocka_unit_test(test_dark_lights),
        cmocka_unit_test(test_dark_meshes_and_maps),
        cmocka_unit_test(test_receiver_on_the_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// The shared BRDF: normalisation, reciprocity, energy, and samples against quadrature.
#include "test.h"

#include "base/rng.h"
#include "shaders/shared/brdf.h"

static const float roughnesses[] = {0.1f, 0.2f, 0.4f, 0.7f, 1.0f};
static const float cosines[] = {0.1f, 0.3f, 0.6f, 0.95f};

static struct ng_local_direction view(float nv)
{
    return (struct ng_local_direction){sqrtf(1 - nv * nv), 0, nv};
}

static struct ng_local_direction half_of(struct ng_local_direction a, struct ng_local_direction b)
{
    struct ng_local_direction h = {a.x + b.x, a.y + b.y, a.z + b.z};
    float length = sqrtf(h.x * h.x + h.y * h.y + h.z * h.z);
    return (struct ng_local_direction){h.x / length, h.y / length, h.z / length};
}

static float dot(struct ng_local_direction a, struct ng_local_direction b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// Integral over the hemisphere of directions by a fine grid, in double: uniform in phi and, so that the peak
// of smooth surfaces is resolved around any direction, in the half vector's angle.
typedef double (*integrand)(const void *user, struct ng_local_direction l);

static double integrate_hemisphere(integrand f, const void *user, int steps)
{
    double sum = 0;
    for (int i = 0; i < steps; i++)
        for (int j = 0; j < 2 * steps; j++) {
            double theta = (i + 0.5) / steps * 3.14159265358979 / 2,
                   phi = (j + 0.5) / steps * 3.14159265358979;
            struct ng_local_direction l = {(float)(sin(theta) * cos(phi)), (float)(sin(theta) * sin(phi)),
                                           (float)cos(theta)};
            sum += f(user, l) * sin(theta);
        }
    return sum * (3.14159265358979 / 2 / steps) * (3.14159265358979 / steps);
}

static double d_cosine(const void *user, struct ng_local_direction h)
{
    return (double)(ng_brdf_d(h.z, ng_brdf_alpha(*(const float *)user)) * h.z);
}

static void test_distribution_is_normalised(void **state)
{
    (void)state;
    for (size_t i = 0; i < NG_COUNT(roughnesses); i++) {
        double integral = integrate_hemisphere(d_cosine, &roughnesses[i], roughnesses[i] < 0.2f ? 1500 : 400);
        assert_true(fabs(integral - 1) < 2e-3);
    }
}

static void test_reciprocity(void **state)
{
    (void)state;
    struct ng_rng rng = ng_rng_make(1, 2);
    for (int i = 0; i < 1000; i++) {
        struct ng_local_direction a = ng_brdf_sample_cosine(ng_rng_float(&rng), ng_rng_float(&rng));
        struct ng_local_direction b = ng_brdf_sample_cosine(ng_rng_float(&rng), ng_rng_float(&rng));
        struct ng_local_direction h = half_of(a, b);
        float roughness = ng_rng_range(&rng, 0.2f, 1), f0 = ng_rng_float(&rng), albedo = ng_rng_float(&rng);
        float ab = ng_brdf(a.z, b.z, h.z, dot(a, h), albedo, f0, roughness);
        float ba = ng_brdf(b.z, a.z, h.z, dot(b, h), albedo, f0, roughness);
        assert_true(fabsf(ab - ba) <= 1e-3f * ab + 1e-7f);
    }
    assert_true(ng_brdf(-0.1f, 0.5f, 0.5f, 0.5f, 1, 0.04f, 0.5f) == 0);
    assert_true(ng_brdf(0.5f, 0.0f, 0.5f, 0.5f, 1, 0.04f, 0.5f) == 0);
}

struct surface {
    float nv, roughness, albedo, f0;
};

static double reflected(const void *user, struct ng_local_direction l)
{
    const struct surface *s = user;
    struct ng_local_direction v = view(s->nv), h = half_of(v, l);
    return (double)(ng_brdf(l.z, v.z, h.z, dot(v, h), s->albedo, s->f0, s->roughness) * l.z);
}

// Specular reflectance by importance sampling: mean of F * G2 / G1.
static double sampled_specular(const struct surface *s, uint32_t count)
{
    struct ng_rng rng = ng_rng_make(7, 1);
    struct ng_local_direction v = view(s->nv);
    double sum = 0;
    for (uint32_t i = 0; i < count; i++) {
        float u1 = ng_rng_float(&rng), u2 = ng_rng_float(&rng);
        struct ng_local_direction h = ng_brdf_sample_half(v, s->roughness, u1, u2);
        struct ng_local_direction l = ng_brdf_reflect(v, h);
        float f = ng_brdf_specular(l.z, v.z, h.z, dot(v, h), s->f0, s->roughness);
        float pdf = ng_brdf_sample_pdf(v.z, h.z, s->roughness);
        sum += l.z > 0 ? (double)(f * l.z / pdf) : 0;
    }
    return sum / count;
}

static void test_specular_energy_sampled_and_by_quadrature(void **state)
{
    (void)state;
    for (size_t i = 1; i < NG_COUNT(roughnesses); i++)
        for (size_t k = 0; k < NG_COUNT(cosines); k++) {
            struct surface s = {.nv = cosines[k], .roughness = roughnesses[i], .f0 = 1};
            double quadrature = integrate_hemisphere(reflected, &s, 500),
                   sampled = sampled_specular(&s, 40000);
            assert_true(quadrature <= 1.002);
            assert_true(fabs(quadrature - sampled) < 0.01);
        }
    // Smooth, where no grid resolves the peak: nearly all is reflected, never more than all.
    struct surface mirror = {.nv = 0.7f, .roughness = 0, .f0 = 1};
    double r = sampled_specular(&mirror, 20000);
    assert_true(r > 0.99 && r < 1.001);
}

static double sample_density(const void *user, struct ng_local_direction l)
{
    const struct surface *s = user;
    struct ng_local_direction v = view(s->nv);
    return (double)ng_brdf_sample_pdf(v.z, half_of(v, l).z, s->roughness);
}

// The density of reflected directions integrates to the share of samples above the surface.
static void test_sampling_density(void **state)
{
    (void)state;
    for (size_t i = 1; i < NG_COUNT(roughnesses); i++)
        for (size_t k = 0; k < NG_COUNT(cosines); k++) {
            struct surface s = {.nv = cosines[k], .roughness = roughnesses[i]};
            struct ng_rng rng = ng_rng_make(3, k);
            int above = 0;
            for (int n = 0; n < 20000; n++) {
                float u1 = ng_rng_float(&rng), u2 = ng_rng_float(&rng);
                struct ng_local_direction v = view(s.nv);
                above += ng_brdf_reflect(v, ng_brdf_sample_half(v, s.roughness, u1, u2)).z > 0;
            }
            assert_true(fabs(integrate_hemisphere(sample_density, &s, 500) - above / 20000.0) < 0.015);
        }
}

// A white furnace. The specular part keeps energy at every angle; the sum with a white diffuse part does when
// averaged over a uniform sky, up to the 5 % that brdf.h states.
static void test_white_furnace(void **state)
{
    (void)state;
    for (size_t i = 1; i < NG_COUNT(roughnesses); i++) {
        double sky = 0;
        for (int k = 0; k < 16; k++) {
            struct surface s = {sqrtf(((float)k + 0.5f) / 16), roughnesses[i], 1, 0.04f};
            double r = integrate_hemisphere(reflected, &s, 200);
            assert_true(r < 1.9);
            sky += r / 16;
        }
        assert_true(sky > 0.9 && sky < 1.05);
    }
}

static void test_specular_albedo_fit(void **state)
{
    (void)state;
    double square = 0;
    int count = 0;
    for (float nv = 0.02f; nv < 1; nv += 0.07f)
        for (float roughness = 0.045f; roughness < 1; roughness += 0.1f)
            for (int k = 0; k < 3; k++) {
                struct surface s = {.nv = nv, .roughness = roughness, .f0 = (float[]){0.04f, 0.5f, 1}[k]};
                double error =
                    (double)ng_brdf_specular_albedo(nv, s.f0, roughness) - sampled_specular(&s, 4000);
                assert_true(fabs(error) < 0.08);
                square += error * error;
                count++;
            }
    assert_true(sqrt(square / count) < 0.02);
}

static struct ng_local_direction random_direction(struct ng_rng *rng)
{
    float z = ng_rng_range(rng, -1, 1), phi = ng_rng_range(rng, 0, 6.2831853f), s = sqrtf(1 - z * z);
    return (struct ng_local_direction){s * cosf(phi), s * sinf(phi), z};
}

// The geometric normal is (0, 0, 1).
static struct ng_local_direction lifted(struct ng_local_direction n, float lift)
{
    float z = n.z + lift, length = sqrtf(n.x * n.x + n.y * n.y + z * z);
    return (struct ng_local_direction){n.x / length, n.y / length, z / length};
}

// A mirror's reflection leads out, just so where it would not; all other normals stay.
static void test_lifted_normals_reflect_outwards(void **state)
{
    (void)state;
    struct ng_rng rng = ng_rng_make(5, 1);
    int count = 0;
    for (int i = 0; i < 100000; i++) {
        struct ng_local_direction n = random_direction(&rng), v = random_direction(&rng);
        v.z = fabsf(v.z);
        float height = 2 * dot(n, v) * n.z - v.z, lift = ng_brdf_lift(n.z, v.z, dot(n, v), 1);
        float least = fminf(0.9f * v.z, NG_LEAST_MIRROR);
        assert_true(isfinite(lift));
        assert_true(ng_brdf_lift(n.z, v.z, dot(n, v), 0) == 0);
        if (height >= least) {
            assert_true(lift == 0);
            continue;
        }
        struct ng_local_direction to = lifted(n, lift),
                                  half = lifted(n, ng_brdf_lift(n.z, v.z, dot(n, v), 0.5f));
        count++;
        assert_true(dot(to, v) > 0);
        if (v.z > 1e-3f && n.z > -0.999f)
            assert_true(fabsf(2 * dot(to, v) * to.z - v.z - least) < 1e-4f);
        if (n.z > -0.9f) // half way
            assert_true(fabsf(dot(half, n) - dot(half, to)) < 1e-3f);
    }
    assert_true(count > 20000);
    // From the edge, and where both normals are one, or opposite.
    for (float vg = -1e-3f; vg < 1; vg += 0.1f)
        for (float ng = -1; ng <= 1; ng += 1)
            assert_true(isfinite(ng_brdf_lift(ng, vg, ng * vg, 1)));
}

static void test_extremes_are_finite(void **state)
{
    (void)state;
    for (float nv = 0; nv <= 1; nv += 0.25f)
        for (float roughness = -1; roughness <= 2; roughness += 0.5f) {
            assert_true(isfinite(ng_brdf(nv, nv, 1, nv, 1, 1, roughness)));
            assert_true(isfinite(ng_brdf_sample_pdf(nv, 1, roughness)));
            struct ng_local_direction h = ng_brdf_sample_half(view(nv), roughness, 0.999999f, 0.999999f);
            assert_true(isfinite(h.x) && isfinite(h.y) && isfinite(h.z));
        }
    struct ng_local_direction l = ng_brdf_sample_cosine(0.3f, 0);
    assert_true(l.z == 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_distribution_is_normalised),
        cmocka_unit_test(test_reciprocity),
        cmocka_unit_test(test_specular_energy_sampled_and_by_quadrature),
        cmocka_unit_test(test_sampling_density),
        cmocka_unit_test(test_white_furnace),
        cmocka_unit_test(test_specular_albedo_fit),
        cmocka_unit_test(test_lifted_normals_reflect_outwards),
        cmocka_unit_test(test_extremes_are_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// Figures against closed forms and values computed by hand.
#include "test.h"

#include "asset/exr.h"
#include "asset/png.h"
#include "base/rng.h"
#include "lightformer/metrics/metrics.h"

#include <math.h>

// A picture over the caller's pixels.
static struct lf_picture picture(const char *name, uint32_t width, uint32_t height, float *pixels)
{
    struct lf_picture p = {.width = width, .height = height, .pixels = pixels};
    snprintf(p.name, sizeof p.name, "%s", name);
    return p;
}

// Compares two rows of `pixels` pixels.
static struct lf_metrics compare(float *a, float *b, uint32_t pixels)
{
    struct lf_picture pa = picture("a", pixels, 1, a), pb = picture("b", pixels, 1, b);
    struct lf_metrics m;
    assert_int_equal(lf_metrics_compute(&(struct lf_metrics_params){.a = &pa, .b = &pb}, &m), NG_OK);
    return m;
}

static void assert_near(double value, double expected)
{
    if (!(fabs(value - expected) <= 1e-6 * fmax(1.0, fabs(expected))))
        fail_msg("%.9g should be %.9g", value, expected);
}

static void test_equal(void **state)
{
    NG_UNUSED(state);
    float a[] = {0.5f, 0, 3, 1, 2, 1e4f}, b[] = {0.5f, 0, 3, 1, 2, 1e4f};
    struct lf_metrics m = compare(a, b, 2);
    assert_true(m.rse == 0 && m.l1 == 0 && m.mean_ratio == 1 && m.pixels == 2);
    assert_true(isinf(m.psnr) && m.psnr > 0);
}

// B = 1 everywhere and A = c: (c - 1)^2 / 1.01, |c - 1|, c; and grey 0.18 loses 0.04 in the tone map.
static void test_uniform(void **state)
{
    NG_UNUSED(state);
    float a[] = {2, 2, 2}, b[] = {1, 1, 1};
    struct lf_metrics m = compare(a, b, 1);
    assert_near(m.rse, 1 / 1.01);
    assert_near(m.l1, 1);
    assert_near(m.mean_ratio, 2);
    assert_near(m.psnr, 14.3692201); // -20 log10(srgb(0.32) - srgb(0.14))
}

// Every figure is relative to the reference's mean, so a common scale changes none.
static void test_scale(void **state)
{
    NG_UNUSED(state);
    float a[] = {1, 2, 3, 4, 5, 6}, b[] = {2, 2, 3, 5, 4, 8}, ka[6], kb[6];
    for (int i = 0; i < 6; i++) {
        ka[i] = a[i] * 1024;
        kb[i] = b[i] * 1024;
    }
    struct lf_metrics m = compare(a, b, 2), k = compare(ka, kb, 2);
    assert_near(k.rse, m.rse);
    assert_near(k.l1, m.l1);
    assert_near(k.psnr, m.psnr);
    assert_near(k.mean_ratio, m.mean_ratio);
}

// Over the mean 2, B is 0.5 and 1.5, A is 1 and 1.5: half of 0.25 / 0.26.
static void test_by_hand(void **state)
{
    NG_UNUSED(state);
    float a[] = {2, 2, 2, 3, 3, 3}, b[] = {1, 1, 1, 3, 3, 3};
    struct lf_metrics m = compare(a, b, 2);
    assert_near(m.rse, 0.5 * 0.25 / 0.26);
    assert_near(m.l1, 0.25);
    assert_near(m.mean_ratio, 1.25);
}

// Channels of (9, 1, 0.25) at exposure 0.18 are compressed and desaturated; negative light counts as none.
static void test_tone_map(void **state)
{
    NG_UNUSED(state);
    float a[] = {9, 1, 0.25f}, b[] = {1, 1, 1};
    assert_near(compare(a, b, 1).psnr, 9.6217280);
    float negative[] = {-5, -5, -5}, none[] = {0, 0, 0};
    assert_near(compare(negative, b, 1).psnr, compare(none, b, 1).psnr);
}

enum { NOISY_PIXELS = 20000 };

// Light 1 with noise of standard deviation 0.02.
static void add_noise(uint64_t seed, float *out)
{
    struct ng_rng rng = ng_rng_make(seed, 0);
    for (size_t i = 0; i < (size_t)NOISY_PIXELS * 3; i++)
        out[i] = 1.0f + 0.02f * sqrtf(3.0f) * (2.0f * ng_rng_float(&rng) - 1.0f);
}

// A = 1.02 and B = 1 +- 0.02: one reference gives about 4e-4 + 4e-4, the second one takes the noise's half
// away.
static void test_two_references(void **state)
{
    NG_UNUSED(state);
    static float a[NOISY_PIXELS * 3], b[NOISY_PIXELS * 3], b2[NOISY_PIXELS * 3];
    for (size_t i = 0; i < NG_COUNT(a); i++)
        a[i] = 1.02f;
    add_noise(1, b);
    add_noise(2, b2);
    assert_true(compare(a, b, NOISY_PIXELS).rse > 7e-4);
    struct lf_picture pa = picture("a", NOISY_PIXELS, 1, a), pb = picture("b", NOISY_PIXELS, 1, b);
    struct lf_picture pb2 = picture("b2", NOISY_PIXELS, 1, b2);
    struct lf_metrics m;
    assert_int_equal(lf_metrics_compute(&(struct lf_metrics_params){.a = &pa, .b = &pb, .b2 = &pb2}, &m),
                     NG_OK);
    assert_float_equal(m.rse, 4e-4f, 3e-5f);
    assert_float_equal(m.mean_ratio, 1.02f, 2e-4f);
}

// By hand: over the mean 2, a = 1, b1 = 0.5, b2 = 1.5 gives (0.5)(-0.5) / 1.01: negative, and not clamped.
static void test_two_references_by_hand(void **state)
{
    NG_UNUSED(state);
    float a[] = {2, 2, 2}, b[] = {1, 1, 1}, b2[] = {3, 3, 3};
    struct lf_picture pa = picture("a", 1, 1, a), pb = picture("b", 1, 1, b), pb2 = picture("b2", 1, 1, b2);
    struct lf_metrics m;
    assert_int_equal(lf_metrics_compute(&(struct lf_metrics_params){.a = &pa, .b = &pb, .b2 = &pb2}, &m),
                     NG_OK);
    assert_near(m.rse, -0.25 / 1.01);
    assert_true(m.l1 == 0 && m.mean_ratio == 1);
}

static void test_one_reference_given_twice_is_a_warning(void **state)
{
    NG_UNUSED(state);
    float a[] = {2, 2, 2}, b[] = {1, 1, 1}, b2[] = {1, 1, 1};
    struct lf_picture pa = picture("a", 1, 1, a), pb = picture("b", 1, 1, b), pb2 = picture("b2", 1, 1, b2);
    struct lf_metrics m;
    struct test_log log;
    for (int warnings = 1; warnings >= 0; warnings--) {
        test_log_begin(&log);
        assert_int_equal(lf_metrics_compute(&(struct lf_metrics_params){.a = &pa, .b = &pb, .b2 = &pb2}, &m),
                         NG_OK);
        test_log_end(&log);
        assert_int_equal(log.warnings, warnings);
        b2[2] = 1.5f; // noise of its own
    }
}

// What is masked out has no share in anything, not even where it is not a number.
static void test_mask(void **state)
{
    NG_UNUSED(state);
    float a[] = {2, 2, 2, NAN, 7, 7}, b[] = {1, 1, 1, 50, INFINITY, 50}, mask[] = {0, 0, 0.25f, 0, 0, 0};
    struct lf_picture pa = picture("a", 2, 1, a), pb = picture("b", 2, 1, b), pm = picture("m", 2, 1, mask);
    struct lf_metrics m;
    assert_int_equal(lf_metrics_compute(&(struct lf_metrics_params){.a = &pa, .b = &pb, .mask = &pm}, &m),
                     NG_OK);
    assert_near(m.rse, 1 / 1.01);
    assert_near(m.mean_ratio, 2);
    assert_int_equal(m.pixels, 1);
}

// Fails with one message that says `expected`.
static void assert_refused(const struct lf_metrics_params *params, const char *expected)
{
    struct test_log log;
    struct lf_metrics m;
    test_log_begin(&log);
    assert_int_not_equal(lf_metrics_compute(params, &m), NG_OK);
    test_log_end(&log);
    assert_int_equal(log.errors, 1);
    if (!strstr(log.text, expected))
        fail_msg("\"%s\" does not say \"%s\"", log.text, expected);
}

static void test_refused(void **state)
{
    NG_UNUSED(state);
    float ones[] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1}, zeros[12] = {0}, bad[12] = {0};
    bad[10] = NAN; // a channel of pixel (1, 1)
    struct lf_picture one = picture("one", 2, 2, ones), black = picture("black", 2, 2, zeros);
    struct lf_picture wide = picture("wide", 4, 1, ones), nan = picture("nan", 2, 2, bad);
    struct lf_picture png = picture("shown.png", 2, 2, ones);
    png.display = true;
    assert_refused(&(struct lf_metrics_params){.a = &wide, .b = &one},
                   "wide is 4 x 1 pixels, but one is 2 x 2");
    assert_refused(&(struct lf_metrics_params){.a = &one, .b = &one, .b2 = &wide}, "wide is 4 x 1");
    assert_refused(&(struct lf_metrics_params){.a = &one, .b = &one, .mask = &wide}, "wide is 4 x 1");
    assert_refused(&(struct lf_metrics_params){.a = &nan, .b = &one}, "nan: pixel (1, 1) is 0 nan 0");
    assert_refused(&(struct lf_metrics_params){.a = &one, .b = &nan}, "nan: pixel (1, 1)");
    assert_refused(&(struct lf_metrics_params){.a = &one, .b = &one, .mask = &black}, "no pixel is left");
    assert_refused(&(struct lf_metrics_params){.a = &one, .b = &black}, "black: the mean is 0");
    assert_refused(&(struct lf_metrics_params){.a = &png, .b = &one}, "shown.png is tone-mapped and one is");
    assert_refused(&(struct lf_metrics_params){.a = &one, .b = &png}, "shown.png is tone-mapped and one is");
}

// ---- Files

// One pixel with beauty 1 2 3, a layer of R, G, B, one of X, Y, Z, one of a UINT, one of X and Y.
static void write_layers(const char *path)
{
    static const float values[] = {1, 2, 3, 4, 5, 6, 7, 8, 9};
    static const uint32_t id = 70000;
    const struct ng_exr_channel channels[] = {
        {"R", NG_EXR_FLOAT, &values[0], 0},         {"G", NG_EXR_FLOAT, &values[1], 0},
        {"B", NG_EXR_FLOAT, &values[2], 0},         {"A", NG_EXR_FLOAT, &values[8], 0},
        {"indirect.R", NG_EXR_HALF, &values[3], 0}, {"indirect.G", NG_EXR_HALF, &values[4], 0},
        {"indirect.B", NG_EXR_HALF, &values[5], 0}, {"normal.X", NG_EXR_FLOAT, &values[6], 0},
        {"normal.Y", NG_EXR_FLOAT, &values[7], 0},  {"normal.Z", NG_EXR_FLOAT, &values[8], 0},
        {"entity.id", NG_EXR_UINT, &id, 0},         {"motion.X", NG_EXR_FLOAT, &values[0], 0},
        {"motion.Y", NG_EXR_FLOAT, &values[0], 0},
    };
    assert_int_equal(ng_exr_write(path, &(struct ng_exr_params){1, 1, channels, NG_COUNT(channels), NULL, 0}),
                     NG_OK);
}

static void test_layers(void **state)
{
    NG_UNUSED(state);
    static const struct {
        const char *layer;
        float expected[3];
    } cases[] = {
        {NULL, {1, 2, 3}}, {"indirect", {4, 5, 6}}, {"normal", {7, 8, 9}}, {"entity", {7e4f, 7e4f, 7e4f}}};
    char path[512];
    test_path(path, sizeof path, "layers.exr");
    write_layers(path);
    for (size_t i = 0; i < NG_COUNT(cases); i++) {
        struct lf_picture p;
        assert_int_equal(lf_picture_load(path, cases[i].layer, &p), NG_OK);
        assert_true(p.width == 1 && p.height == 1 && !p.display);
        assert_memory_equal(p.pixels, cases[i].expected, sizeof cases[i].expected);
        lf_picture_finish(&p);
        assert_null(p.pixels);
    }
}

static void assert_not_loaded(const char *path, const char *layer, const char *expected)
{
    struct test_log log;
    struct lf_picture p;
    test_log_begin(&log);
    assert_int_not_equal(lf_picture_load(path, layer, &p), NG_OK);
    test_log_end(&log);
    assert_null(p.pixels);
    assert_int_equal(log.errors, 1);
    if (!strstr(log.text, expected))
        fail_msg("\"%s\" does not say \"%s\"", log.text, expected);
}

static void test_bad_files(void **state)
{
    NG_UNUSED(state);
    char path[512], text[512];
    test_path(path, sizeof path, "bad.exr");
    test_path(text, sizeof text, "text.exr");
    write_layers(path);
    FILE *f = fopen(text, "w");
    assert_non_null(f);
    fputs("not a picture", f);
    fclose(f);
    assert_not_loaded(path, "shadow", "no layer \"shadow\"; it has entity, indirect, motion, normal");
    assert_not_loaded(path, "in", "no layer \"in\"");
    assert_not_loaded(path, "motion", "the 2 channels of motion are neither");
    assert_not_loaded(text, NULL, "neither an OpenEXR nor a PNG file");
    assert_not_loaded("/none.exr", NULL, "/none.exr");
}

// A PNG is shown as it is: bytes 100 and 110 are 10/255 apart, whatever the reference's mean.
static void test_png(void **state)
{
    NG_UNUSED(state);
    char path[2][512];
    struct lf_picture p[2];
    for (int i = 0; i < 2; i++) {
        unsigned char rgb[3] = {(unsigned char)(100 + 10 * i), (unsigned char)(100 + 10 * i),
                                (unsigned char)(100 + 10 * i)};
        test_path(path[i], sizeof path[i], i ? "b.png" : "a.png");
        assert_int_equal(ng_png_write(path[i], &(struct ng_png_params){1, 1, 3, rgb, NULL, 0}), NG_OK);
        assert_int_equal(lf_picture_load(path[i], NULL, &p[i]), NG_OK);
        assert_true(p[i].display);
    }
    struct lf_metrics m;
    assert_int_equal(lf_metrics_compute(&(struct lf_metrics_params){.a = &p[0], .b = &p[1]}, &m), NG_OK);
    assert_float_equal(m.psnr, 28.1308036, 1e-4);
    assert_float_equal(m.mean_ratio, 0.1274377f / 0.1559265f, 1e-5); // the sRGB curve at 100/255 and 110/255
    lf_picture_finish(&p[0]);
    lf_picture_finish(&p[1]);
    assert_not_loaded(path[0], "indirect", "a PNG has no layers");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_equal),
        cmocka_unit_test(test_uniform),
        cmocka_unit_test(test_scale),
        cmocka_unit_test(test_by_hand),
        cmocka_unit_test(test_tone_map),
        cmocka_unit_test(test_two_references),
        cmocka_unit_test(test_two_references_by_hand),
        cmocka_unit_test(test_one_reference_given_twice_is_a_warning),
        cmocka_unit_test(test_mask),
        cmocka_unit_test(test_refused),
        cmocka_unit_test(test_layers),
        cmocka_unit_test(test_bad_files),
        cmocka_unit_test(test_png),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

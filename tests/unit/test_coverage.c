// Thresholds of what covers a part of a pixel: without streaks, and those of two surfaces without relation.
#include "render/subpixel.h"
#include "shaders/shared/coverage.h"
#include "test.h"

#include <math.h>

#define SURFACES 200

// How far apart two thresholds are on the circle [0, 1).
static float distance(float a, float b)
{
    float d = fabsf(a - b);
    return fminf(d, 1 - d);
}

// Pixels whose thresholds are alike are far apart, as in the plastic number's own sequence.
static void near_pixels_differ(void **state)
{
    NG_UNUSED(state);
    for (uint32_t s = 0; s < SURFACES; s++)
        for (int x = -5; x <= 5; x++)
            for (int y = 0; y <= 5; y++) {
                float d = distance(ng_coverage_threshold((uint32_t)(x + 9), (uint32_t)y, s, 0),
                                   ng_coverage_threshold(9, 0, s, 0));
                assert_true((x == 0 && y == 0) || d * (float)(x * x + y * y) > 0.2f);
            }
}

static float share_of_both(uint32_t a, uint32_t b)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < 32 * 32; i++)
        count += ng_coverage_threshold(i % 32, i / 32, a, 0) < 0.5f &&
                 ng_coverage_threshold(i % 32, i / 32, b, 0) < 0.5f;
    return (float)count / (32 * 32);
}

// Two halves cover a quarter together, but for the few pairs of surfaces that have one wave.
static void surfaces_do_not_hide_each_other(void **state)
{
    uint32_t related = 0;
    NG_UNUSED(state);
    for (uint32_t s = 0; s < SURFACES; s++)
        related += fabsf(share_of_both(s, s + 1) - 0.25f) > 0.03f;
    assert_true(related < SURFACES / 10);
}

// Of pictures that are averaged each shows another part of what blends: so many in a row the share that they
// should, everywhere.
static void pictures_share_a_pixel(void **state)
{
    NG_UNUSED(state);
    for (uint32_t pixel = 0; pixel < 64; pixel++) {
        uint32_t count = 0;
        for (uint32_t number = 0; number < 16; number++)
            count += ng_coverage_threshold(pixel % 8, pixel / 8, 7, number) < 0.3f;
        assert_in_range(count, 4, 6);
    }
}

// Shifts of pictures: the first goes through the middle of pixels, and the first few have the mean and the
// width of the tent that they are to sample.
static void shifts_are_a_tent(void **state)
{
    double sum[2] = {0}, squares[2] = {0};
    NG_UNUSED(state);
    for (uint32_t n = 0; n < 65; n++) {
        float shift[2];
        ng_subpixel_shift(n, shift);
        for (int i = 0; i < 2; i++) {
            assert_true(n > 0 ? fabsf(shift[i]) <= 1 : shift[i] == 0);
            sum[i] += (double)shift[i];
            squares[i] += (double)shift[i] * (double)shift[i];
        }
    }
    for (int i = 0; i < 2; i++) {
        assert_true(fabs(sum[i]) < 1e-4);
        assert_true(fabs(squares[i] / 65 - 1.0 / 6) < 0.02);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(near_pixels_differ),
        cmocka_unit_test(surfaces_do_not_hide_each_other),
        cmocka_unit_test(pictures_share_a_pixel),
        cmocka_unit_test(shifts_are_a_tent),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

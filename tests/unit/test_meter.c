// The light meter's arithmetic (shaders/shared/meter.h), which shaders and the path tracer share.
#include "shaders/shared/meter.h"
#include "test.h"

#define PIXELS 100.0f

// The exposure of a picture of which `bright` pixels of a hundred have a luminance, and the others another
// one.
static float exposure_of(float bright, float luminance, float other)
{
    const float counts[2] = {PIXELS - bright, bright}, luminances[2] = {other, luminance};
    float before = 0, sum = 0, shares = 0;
    for (int i = 0; i < 2; i++) { // from the darker one
        float share = ng_meter_share(before, counts[i], PIXELS);
        sum += share * floorf(ng_meter_bin(luminances[i]));
        shares += share;
        before += counts[i];
    }
    return ng_meter_exposure(sum, shares);
}

static void exposure_brings_light_to_the_key(void **state)
{
    NG_UNUSED(state);
    for (float luminance = 1e-6f; luminance < 1e9f; luminance *= 10)
        assert_true(fabsf(exposure_of(60, luminance, luminance / 100) * luminance / NG_METER_KEY - 1) <
                    0.05f);
}

static void lamps_and_shade_do_not_count(void **state)
{
    NG_UNUSED(state);
    assert_true(fabsf(exposure_of(4, 1e6f, 1) / exposure_of(0, 1, 1) - 1) < 0.01f);
    assert_true(fabsf(exposure_of(96, 1, 1e-6f) / exposure_of(100, 1, 1) - 1) < 0.01f);
}

static void indirect_light_is_not_white(void **state)
{
    NG_UNUSED(state);
    assert_float_equal(ng_meter_both(4, 4), 4, 0);
    assert_float_equal(ng_meter_both(4, 2.5f), 4, 0);             // as without indirect light
    assert_float_equal(ng_meter_both(4000, 1), NG_METER_OVER, 0); // hardly any light is direct
    assert_float_equal(ng_meter_both(0, 3), 3, 0);                // none is
    assert_float_equal(ng_meter_both(3, 0), 3, 0);
    assert_float_equal(ng_meter_exposure(0, 0), 0, 0);
    assert_float_equal(ng_meter_both(0, 0), 0, 0); // darkness
}

static void a_sky_does_not_count_behind_surfaces(void **state)
{
    NG_UNUSED(state);
    assert_float_equal(ng_meter_picture(4, 100, 1), 4, 1e-5f);
    assert_float_equal(ng_meter_picture(4, 100, NG_METER_SEEN), 4, 1e-5f);
    assert_float_equal(ng_meter_picture(4, 100, 0), 100, 1e-4f);
    assert_float_equal(ng_meter_picture(4, 100, NG_METER_SEEN / 2), 20,
                       1e-4f); // no leap where it comes in sight
    assert_float_equal(ng_meter_picture(4, 0, 0), 4, 0);
    assert_float_equal(ng_meter_picture(0, 3, 0), 3, 0);
    assert_float_equal(ng_meter_picture(0, 0, 0), 1, 0); // darkness
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exposure_brings_light_to_the_key),
        cmocka_unit_test(lamps_and_shade_do_not_count),
        cmocka_unit_test(indirect_light_is_not_white),
        cmocka_unit_test(a_sky_does_not_count_behind_surfaces),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// What the window of `lightformer view` is made of, without a window: where panels stand, how fast pictures
// come.
#include "test.h"

#include "base/rng.h"
#include "editor/layout.h"
#include "tools/lightformer/view_rate.h"
#include "tools/lightformer/view_tier.h"

#include <math.h>
#include <stdbool.h>

static bool overlap(const struct ng_panel *a, const struct ng_panel *b)
{
    bool apart = a->at[0] + a->size[0] <= b->at[0] || b->at[0] + b->size[0] <= a->at[0] ||
                 a->at[1] + a->size[1] <= b->at[1] || b->at[1] + b->size[1] <= a->at[1];
    return !apart;
}

static void panels_neither_overlap_nor_cover_the_picture(void **state)
{
    NG_UNUSED(state);
    struct ng_rng rng = ng_rng_make(1, 2);
    for (int n = 0; n < 2000; n++) {
        struct ng_panel panels[8];
        uint32_t count = 1 + ng_rng_below(&rng, 8);
        float width = (float)(64 + ng_rng_below(&rng, 2000)), height = (float)(64 + ng_rng_below(&rng, 1200));
        for (uint32_t i = 0; i < count; i++)
            panels[i] = (struct ng_panel){
                {(float)(20 + ng_rng_below(&rng, 600)), (float)(20 + ng_rng_below(&rng, 900))},
                {-1, -1},
                {-1, -1}};
        ng_layout_panels(width, height, panels, count);
        for (uint32_t i = 0; i < count; i++) {
            const struct ng_panel *p = &panels[i];
            assert_true(p->at[0] >= 0 && p->at[1] >= 0 && p->size[0] >= 0 && p->size[1] >= 0);
            assert_true(p->at[0] + p->size[0] <= fmaxf(0.6f * width, 160) + 8.01f &&
                        p->at[0] + p->size[0] <= width);
            assert_true(p->at[1] + p->size[1] <= fmaxf(height - 44, 60)); // captions are below
            assert_true(p->size[0] <= p->wanted[0] && p->size[1] <= p->wanted[1]);
            for (uint32_t k = 0; k < i; k++)
                assert_false(overlap(p, &panels[k]));
        }
    }
}

static void panels_get_what_they_want_where_there_is_room(void **state)
{
    NG_UNUSED(state);
    struct ng_panel panels[] = {{.wanted = {300, 400}}, {.wanted = {250, 200}}, {.wanted = {200, 500}}};
    ng_layout_panels(1600, 900, panels, 3);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 2; k++)
            assert_true(panels[i].size[k] == panels[i].wanted[k]);
    assert_true(panels[1].at[0] == panels[0].at[0] && panels[2].at[0] > panels[0].at[0] + 300);
    ng_layout_panels(600, 500, panels, 3); // one column, shared: the small one is whole
    assert_true(panels[2].at[0] == panels[0].at[0] && panels[1].size[1] < 200 && panels[0].size[1] > 100);
}

static void figures_are_of_the_last_second(void **state)
{
    NG_UNUSED(state);
    static struct view_rate r;
    assert_int_equal(view_rate_of(&r, 5).fps, 0);
    for (int i = 0; i < 3000; i++) // slow ones long ago, then 100 a second
        view_rate_add(&r, i < 1000 ? i * 0.1 : 100 + (i - 1000) * 0.01, i < 1000 ? 90 : 7);
    struct view_figures f = view_rate_of(&r, 100 + 1999 * 0.01);
    assert_in_range(f.fps, 99, 101);
    assert_true(f.ms == 7);
    view_rate_add(&r, 130, 500);
    f = view_rate_of(&r, 130.5);
    assert_true(f.fps == 1 && f.ms == 500);
    f = view_rate_of(&r, 140); // nothing came since
    assert_true(f.fps == 0 && f.ms == 500);
}

// What a machine takes for a picture of a level: for surfaces and for light, of all pixels, and besides.
struct machine {
    double surfaces, light, rest;
};
static double take(const struct machine *m, const struct view_tier *t, uint32_t level)
{
    const struct view_pixels p = view_tier_pixels(t, level, (const uint32_t[]){10000, 10000});
    return m->rest + m->surfaces * p.picture[0] * p.picture[1] * 1e-8 +
           m->light * p.light[0] * p.light[1] * 1e-8;
}

// However fast it is: soon in time, then still, with as many pixels as fit.
static void tiers_settle_in_time(void **state)
{
    NG_UNUSED(state);
    const struct machine machines[] = {{2, 3, 1},      {20, 60, 19}, {40, 20, 50},    {80, 300, 20},
                                       {90, 1300, 10}, {90, 50, 5},  {1000, 4000, 20}};
    for (size_t n = 0; n < 2 * NG_COUNT(machines); n++)
        for (uint32_t begin = 0; begin < VIEW_TIERS; begin += 5) {
            const struct machine *m = &machines[n / 2];
            struct view_tier t = {.level = begin, .upsamples = n % 2};
            double ms = 0;
            uint32_t changes = 0;
            for (int i = 0; i < 100; i++) {
                uint32_t level = t.level;
                if (i % 30 == 0)
                    view_tier_add_whole(&t, take(m, &t, 0));
                ms = take(m, &t, level);
                view_tier_add(&t, level, ms);
                changes += i >= 60 && t.level != level;
            }
            assert_int_equal(changes, 0);
            assert_true(ms <= VIEW_MOVING_MS);
            assert_true(t.level == 0 || take(m, &t, t.level - 1) > 0.6 * VIEW_MOVING_MS);
        }
}

// Times that vary by a fifth, and a slow picture now and then, make few changes.
static void tiers_do_not_flutter(void **state)
{
    NG_UNUSED(state);
    for (int upsamples = 0; upsamples < 2; upsamples++) {
        const struct machine m = {100, 800, 10};
        struct ng_rng rng = ng_rng_make(3, 4);
        struct view_tier t = {.upsamples = upsamples};
        uint32_t changes = 0;
        view_tier_add_whole(&t, take(&m, &t, 0));
        for (int n = 0; n < 600; n++) {
            uint32_t level = t.level;
            double ms = take(&m, &t, level) * (double)ng_rng_range(&rng, 0.9f, 1.1f);
            view_tier_add(&t, level, n % 100 == 50 ? 150 : ms);
            changes += n >= 20 && t.level != level;
        }
        assert_true(changes <= 4 * 6); // down and, in a step or two, up again for each slow one
    }
}

static void tiers_have_a_size(void **state)
{
    NG_UNUSED(state);
    struct view_tier t = {0};
    struct view_pixels p = view_tier_pixels(&t, 0, (const uint32_t[]){1279, 719});
    assert_true(p.picture[0] == 1279 && p.picture[1] == 719 && p.light[0] == 1279 && p.light[1] == 719);
    p = view_tier_pixels(&t, 4, (const uint32_t[]){1600, 900});
    assert_true(p.picture[0] == 900 && p.picture[1] == 506 && p.light[0] == 900 && p.light[1] == 506);
    p = view_tier_pixels(&t, VIEW_TIERS - 1, (const uint32_t[]){1, 3});
    assert_true(p.picture[0] == 1 && p.picture[1] == 1);
    t.upsamples = true;
    p = view_tier_pixels(&t, 0, (const uint32_t[]){800, 600});
    assert_true(p.picture[0] == 800 && p.light[0] == 800);
    p = view_tier_pixels(&t, 1, (const uint32_t[]){800, 600});
    assert_true(p.picture[0] == 800 && p.picture[1] == 600 && p.light[0] == 400 && p.light[1] == 300);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(panels_neither_overlap_nor_cover_the_picture),
        cmocka_unit_test(panels_get_what_they_want_where_there_is_room),
        cmocka_unit_test(figures_are_of_the_last_second),
        cmocka_unit_test(tiers_settle_in_time),
        cmocka_unit_test(tiers_do_not_flutter),
        cmocka_unit_test(tiers_have_a_size),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// What the window of `lightformer view` is made of, without a window: where panels stand, how fast pictures
// come.
#include "test.h"

#include "base/rng.h"
#include "editor/layout.h"
#include "tools/lightformer/view_rate.h"

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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(panels_neither_overlap_nor_cover_the_picture),
        cmocka_unit_test(panels_get_what_they_want_where_there_is_room),
        cmocka_unit_test(figures_are_of_the_last_second),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

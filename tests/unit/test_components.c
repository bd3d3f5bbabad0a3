// The engine's components: their field tables, and placements computed from transforms.
#include "test.h"

#include "base/rng.h"
#include "components/components.h"
#include "components/placement.h"
#include "components/placement_system.h"
#include "components/transform.h"
#include "scene/history.h"
#include "scene/query.h"
#include "scene/system.h"

#include <math.h>

#define OK(expr) assert_int_equal((expr), NG_OK)

static const ng_entity none = {0};

static int setup(void **state)
{
    struct ng_world *world;
    OK(ng_world_create(NULL, &world));
    OK(ng_components_register(world));
    OK(ng_placement_system_add(world));
    *state = world;
    return 0;
}

static int teardown(void **state)
{
    struct ng_world *world = *state;
    ng_world_destroy(&world);
    return 0;
}

// ---- field tables ----------------------------------------------------------------------------------------
static void ids_are_the_names(void **state)
{
    struct ng_world *world = *state;
#define X(NAME, name_) assert_string_equal(ng_world_component(world, NG_##NAME)->name, #name_);
    NG_COMPONENT_LIST(X)
#undef X
    assert_int_equal(ng_world_component_count(world), NG_COMPONENT_COUNT);

    struct test_log log;
    test_log_begin(&log);
    assert_int_equal(ng_components_register(world), NG_ERROR_USAGE);
    assert_non_null(strstr(log.text, "must be the first"));
    test_log_end(&log);
}

// A member without a line in the table would be neither saved nor undone by field: only padding may be
// uncovered.
static void tables_cover_their_structs(void **state)
{
    for (ng_component c = 0; c < NG_COMPONENT_COUNT; c++) {
        const struct ng_component_desc *desc = ng_world_component(*state, c);
        uint32_t end = 0;
        assert_true(desc->doc && desc->doc[0]);
        for (uint32_t i = 0; i < desc->field_count; i++) {
            const struct ng_field *f = &desc->fields[i];
            if (f->offset < end || f->offset - end >= 8 || (i == 0 && f->offset))
                fail_msg("%s.%s: %u bytes before it are in no field", desc->name, f->name, f->offset - end);
            if (f->type == NG_FIELD_BOOL || f->type == NG_FIELD_TEXT)
                assert_true(f->offset == end);
            assert_true(f->doc && f->doc[0] && f->unit && f->min <= f->max);
            end = f->offset + ng_field_size(f->type);
        }
        assert_true(desc->size - end < desc->align);
    }
}

static void defaults_are_valid(void **state)
{
    struct ng_world *world = *state;
    ng_entity e = ng_entity_create(world);
    for (ng_component c = 0; c < NG_COMPONENT_COUNT; c++) {
        const struct ng_component_desc *desc = ng_world_component(world, c);
        OK(ng_world_add(world, e, c, NULL));
        const char *value = ng_world_get(world, e, c);
        for (uint32_t i = 0; i < desc->field_count; i++) {
            char reason[NG_REASON_SIZE];
            if (!ng_field_check(&desc->fields[i], value + desc->fields[i].offset, reason))
                fail_msg("%s.%s: %s", desc->name, desc->fields[i].name, reason);
        }
    }
}

// ---- placements ------------------------------------------------------------------------------------------
static ng_entity at(struct ng_world *world, ng_entity parent, float x, float y, float z)
{
    ng_entity e = ng_entity_create(world);
    struct ng_transform t = {.translation = {x, y, z}, .rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}};
    OK(ng_world_add(world, e, NG_TRANSFORM, &t));
    OK(ng_world_set_parent(world, e, parent, none));
    return e;
}

static void run(struct ng_world *world)
{
    OK(ng_world_run(world, 0));
}

static void placed(struct ng_world *world, ng_entity e, float x, float y, float z)
{
    const struct ng_placement *p = ng_world_get(world, e, NG_PLACEMENT);
    assert_non_null(p);
    if (fabsf(p->matrix[12] - x) + fabsf(p->matrix[13] - y) + fabsf(p->matrix[14] - z) > 1e-5f)
        fail_msg("placed at %g %g %g, not %g %g %g", (double)p->matrix[12], (double)p->matrix[13],
                 (double)p->matrix[14], (double)x, (double)y, (double)z);
}

static struct ng_transform *transform(struct ng_world *world, ng_entity e)
{
    return ng_world_edit(world, e, NG_TRANSFORM);
}

static void local_is_translate_rotate_scale(void **state)
{
    struct ng_world *world = *state;
    ng_entity parent = at(world, none, 10, 0, 0), child = at(world, parent, 1, 2, 3);
    float s = sqrtf(0.5f);
    memcpy(transform(world, parent)->rotation, (float[]){0, s, 0, s}, 16); // 90 degrees about Y: X to -Z
    memcpy(transform(world, parent)->scale, (float[]){2, 3, 4}, 12);
    run(world);
    placed(world, child, 10 + 12, 6, -2);
    const struct ng_placement *p = ng_world_get(world, parent, NG_PLACEMENT);
    const float expected[16] = {0, 0, -2, 0, 0, 3, 0, 0, 4, 0, 0, 0, 10, 0, 0, 1};
    for (int i = 0; i < 16; i++)
        assert_true(fabsf(p->matrix[i] - expected[i]) < 1e-5f);
}

static void only_what_moved_gets_a_tick(void **state)
{
    struct ng_world *world = *state;
    ng_entity a = at(world, none, 1, 0, 0), b = at(world, a, 1, 0, 0), c = at(world, b, 1, 0, 0),
              other = at(world, none, 5, 0, 0);
    run(world);
    placed(world, c, 3, 0, 0);
    uint32_t since = ng_world_stamp(world);
    run(world);
    assert_true(ng_world_component_changed_at(world, NG_PLACEMENT) <= since);
    transform(world, b)->translation[0] = 2;
    transform(world, other)->translation[0] = 5; // an edit that changes nothing
    run(world);
    placed(world, c, 4, 0, 0);
    assert_true(ng_world_changed_at(world, a, NG_PLACEMENT) <= since);
    assert_true(ng_world_changed_at(world, b, NG_PLACEMENT) > since);
    assert_true(ng_world_changed_at(world, c, NG_PLACEMENT) > since);
    assert_true(ng_world_changed_at(world, other, NG_PLACEMENT) <= since);
}

static void the_hierarchy_moves_placements(void **state)
{
    struct ng_world *world = *state;
    ng_entity a = at(world, none, 1, 0, 0), plain = ng_entity_create(world), c = at(world, plain, 0, 1, 0);
    run(world);
    placed(world, c, 0, 1, 0);
    assert_false(ng_world_has(world, plain, NG_PLACEMENT));
    OK(ng_world_set_parent(world, plain, a, none)); // it has no transform: its child must notice
    run(world);
    placed(world, c, 1, 1, 0);
    OK(ng_world_add(world, plain, NG_TRANSFORM, NULL));
    transform(world, plain)->translation[2] = 7;
    run(world);
    placed(world, c, 1, 1, 7);
    OK(ng_world_remove(world, plain, NG_TRANSFORM));
    run(world);
    placed(world, c, 1, 1, 0);
    assert_false(ng_world_has(world, plain, NG_PLACEMENT));
    OK(ng_world_set_parent(world, c, none, none));
    run(world);
    placed(world, c, 0, 1, 0);
    OK(ng_world_remove(world, a, NG_PLACEMENT)); // taken away or overwritten by somebody: put right
    *(struct ng_placement *)ng_world_edit(world, c, NG_PLACEMENT) = (struct ng_placement){.matrix = {3}};
    run(world);
    placed(world, a, 1, 0, 0);
    placed(world, c, 0, 1, 0);
}

static void undo_moves_placements_back(void **state)
{
    struct ng_world *world = *state;
    ng_entity a = at(world, none, 1, 0, 0), b = at(world, a, 1, 0, 0);
    run(world);
    OK(ng_world_begin(world, "Move and delete"));
    transform(world, a)->translation[0] = 9;
    OK(ng_entity_destroy(world, b));
    OK(ng_world_commit(world));
    run(world);
    placed(world, a, 9, 0, 0);
    OK(ng_world_undo(world));
    run(world);
    placed(world, a, 1, 0, 0);
    placed(world, b, 2, 0, 0);
}

static void places_are_within_a_range(void **state)
{
    struct ng_world *world = *state;
    const float wrong[] = {1e18f, -3e38f, INFINITY, -INFINITY, NAN};
    ng_entity a = at(world, none, 0, 0, 0), b = at(world, a, 1, 0, 0), c = at(world, b, 1, 0, 0);
    ng_entity still = at(world, none, 1, 2, 3);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        for (size_t k = 0; k < sizeof(struct ng_transform) / sizeof(float); k++) {
            const struct ng_transform before =
                *(const struct ng_transform *)ng_world_get(world, a, NG_TRANSFORM);
            const ng_entity all[3] = {a, b, c};
            for (int e = 0; e < 3; e++)
                ((float *)ng_world_edit(world, all[e], NG_TRANSFORM))[k] = wrong[i];
            run(world);
            for (int e = 0; e < 3; e++) {
                const struct ng_placement *p = ng_world_get(world, all[e], NG_PLACEMENT);
                for (int m = 0; m < 16; m++)
                    assert_true(fabsf(p->matrix[m]) <= NG_PLACEMENT_MAX); // not of NaN
                assert_true(p->matrix[3] == 0 && p->matrix[15] == 1);
                memcpy(ng_world_edit(world, all[e], NG_TRANSFORM), &before, sizeof before);
            }
        }
    placed(world, still, 1, 2, 3);
}

static void incremental_equals_anew(void **state)
{
    struct ng_world *world = *state;
    enum { COUNT = 400 };
    ng_entity e[COUNT];
    struct ng_rng rng = ng_rng_make(1, 0);
    for (uint32_t i = 0; i < COUNT; i++)
        e[i] = at(world, i ? e[ng_rng_below(&rng, i)] : none, (float)ng_rng_below(&rng, 9), 1, 0);
    struct test_log log;
    test_log_begin(&log); // some parents are refused: cycles
    for (int step = 0; step < 300; step++) {
        ng_entity a = e[ng_rng_below(&rng, COUNT)], b = e[ng_rng_below(&rng, COUNT)];
        switch (ng_rng_below(&rng, 3)) {
        case 0:
            assert_true(ng_world_set_parent(world, a, b, none) != NG_ERROR_MEMORY);
            break;
        case 1:
            if (ng_world_has(world, a, NG_TRANSFORM))
                OK(ng_world_remove(world, a, NG_TRANSFORM));
            else
                OK(ng_world_add(world, a, NG_TRANSFORM, NULL));
            break;
        default:
            if (transform(world, a))
                transform(world, a)->translation[1] = (float)ng_rng_below(&rng, 5);
        }
        if (step % 3)
            continue;
        run(world);
        for (int i = 0; i < COUNT; i++) {
            if (!ng_world_has(world, e[i], NG_TRANSFORM)) {
                assert_false(ng_world_has(world, e[i], NG_PLACEMENT));
                continue;
            }
            float sum[3] = {0}; // no rotation, no scale: placements are sums
            for (ng_entity up = e[i]; !ng_entity_is_null(up); up = ng_world_parent(world, up)) {
                const struct ng_transform *t = ng_world_get(world, up, NG_TRANSFORM);
                for (int k = 0; t && k < 3; k++)
                    sum[k] += t->translation[k];
            }
            placed(world, e[i], sum[0], sum[1], sum[2]);
        }
    }
    test_log_end(&log);
}

int main(void)
{
#define TEST(f) cmocka_unit_test_setup_teardown(f, setup, teardown)
    const struct CMUnitTest tests[] = {
        TEST(ids_are_the_names),           TEST(tables_cover_their_structs),
        TEST(defaults_are_valid),          TEST(local_is_translate_rotate_scale),
        TEST(only_what_moved_gets_a_tick), TEST(the_hierarchy_moves_placements),
        TEST(undo_moves_placements_back),  TEST(places_are_within_a_range),
        TEST(incremental_equals_anew),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// The world's rules, one test a rule. (tests/property holds them against a model.)
#include "test.h"

#include <math.h>

#include "base/jobs.h"
#include "scene/event.h"
#include "scene/history.h"
#include "scene/query.h"
#include "scene/system.h"
#include "scene/world.h"

struct point {
    float x, y;
};
struct body {
    bool awake;
    int32_t count;
    uint32_t kind;
    float mass;
    float turn[4];
    char label[NG_TEXT_SIZE];
};

static const char *const kinds[] = {"rigid", "soft", NULL};
static const struct ng_field body_fields[] = {
    NG_FIELD(struct body, awake, NG_FIELD_BOOL, "", 0, 0, "simulated"),
    NG_FIELD(struct body, count, NG_FIELD_I32, "", -5, 5, "a number"),
    NG_FIELD_CHOICE(struct body, kind, kinds, "what it is made of"),
    NG_FIELD(struct body, mass, NG_FIELD_F32, "kg", 0.5f, 100.0f, "mass"),
    NG_FIELD(struct body, turn, NG_FIELD_QUAT, "", 0, 0, "rotation"),
    NG_FIELD(struct body, label, NG_FIELD_TEXT, "", 0, 0, "text"),
};
static const struct body body_defaults = {.mass = 1.0f, .turn = {0, 0, 0, 1}, .label = "stone"};

static const struct ng_component_desc descs[] = {
    {.name = "point", .size = sizeof(struct point), .align = _Alignof(struct point)},
    {.name = "body",
     .size = sizeof(struct body),
     .align = _Alignof(struct body),
     .defaults = &body_defaults,
     .fields = body_fields,
     .field_count = NG_COUNT(body_fields)},
    {.name = "tag"},
    {.name = "cache",
     .size = sizeof(struct point),
     .align = _Alignof(struct point),
     .flags = NG_COMPONENT_DERIVED},
};
enum { POINT, BODY, TAG, CACHE };

static const ng_entity none = {0};
static struct test_log test_logged;

static int setup(void **state)
{
    struct ng_world *world;
    assert_int_equal(ng_world_create(NULL, &world), NG_OK);
    for (uint32_t i = 0; i < NG_COUNT(descs); i++) {
        ng_component id;
        assert_int_equal(ng_world_register(world, &descs[i], &id), NG_OK);
        assert_int_equal(id, i);
    }
    *state = world;
    test_log_begin(&test_logged);
    return 0;
}

static int teardown(void **state)
{
    struct ng_world *world = *state;
    ng_world_destroy(&world);
    assert_null(world);
    test_log_end(&test_logged);
    return 0;
}

#define OK(expr)       assert_int_equal((expr), NG_OK)
#define FAILS(r, expr) assert_int_equal((expr), (r))
#define SAME(a, b)     assert_true((a).id == (b).id)

// Exactly one error was logged since the last call, and it has this text.
static void logged(const char *text)
{
    if (test_logged.errors != 1 || !strstr(test_logged.text, text))
        fail_msg("expected one error with \"%s\", got %d:\n%s", text, test_logged.errors, test_logged.text);
    test_logged = (struct test_log){0};
}

static ng_entity point_at(struct ng_world *world, float x)
{
    ng_entity e = ng_entity_create(world);
    OK(ng_world_add(world, e, POINT, &(struct point){x, 0}));
    return e;
}

static float x_of(struct ng_world *world, ng_entity e)
{
    const struct point *p = ng_world_get(world, e, POINT);
    assert_non_null(p);
    return p->x;
}

// ---- entities and values ---------------------------------------------------------------------------------
static void stale_ids_are_found(void **state)
{
    struct ng_world *world = *state;
    ng_entity old = point_at(world, 1);
    OK(ng_entity_destroy(world, old));
    ng_entity fresh = point_at(world, 2);
    assert_int_equal(ng_entity_index(old), ng_entity_index(fresh));
    assert_false(ng_entity_alive(world, old));
    assert_null(ng_world_get(world, old, POINT));
    assert_null(ng_world_edit(world, old, POINT));
    assert_false(ng_world_has(world, old, POINT));
    assert_int_equal(ng_world_changed_at(world, old, POINT), 0);
    SAME(ng_world_parent(world, old), none);
    FAILS(NG_ERROR_USAGE, ng_entity_destroy(world, old));
    logged("does not exist");
    FAILS(NG_ERROR_USAGE, ng_world_add(world, old, TAG, NULL));
    logged("component tag");
    FAILS(NG_ERROR_USAGE, ng_world_set_parent(world, fresh, old, none));
    logged("is not alive");
    FAILS(NG_ERROR_USAGE, ng_entity_destroy(world, none));
    logged("does not exist");
    SAME(ng_world_entity_at(world, ng_entity_index(fresh)), fresh);
    SAME(ng_world_entity_at(world, 1000000), none);
    assert_int_equal(ng_world_entity_count(world), 1);
}

static void values_survive_moves_between_tables(void **state)
{
    struct ng_world *world = *state;
    ng_entity e[3000];
    for (int i = 0; i < 3000; i++)
        e[i] = point_at(world, (float)i);
    for (int i = 0; i < 3000; i += 3)
        OK(ng_world_add(world, e[i], BODY, NULL));
    for (int i = 0; i < 3000; i += 5)
        OK(ng_entity_destroy(world, e[i]));
    for (int i = 0; i < 3000; i += 6)
        if (i % 5)
            OK(ng_world_remove(world, e[i], BODY));
    for (int i = 0; i < 3000; i++) {
        assert_int_equal(ng_entity_alive(world, e[i]), i % 5 != 0);
        if (i % 5) {
            assert_true(x_of(world, e[i]) == (float)i);
            assert_int_equal(ng_world_has(world, e[i], BODY), i % 3 == 0 && i % 6 != 0);
        }
    }
    const struct body *body = ng_world_get(world, e[3], BODY);
    assert_string_equal(body->label, "stone"); // the defaults
}

static void adding_twice_replaces_the_value(void **state)
{
    struct ng_world *world = *state;
    ng_entity e = point_at(world, 1);
    OK(ng_world_add(world, e, POINT, &(struct point){7, 0}));
    assert_true(x_of(world, e) == 7);
    OK(ng_world_set(world, e, POINT, NULL));
    assert_true(x_of(world, e) == 0);
}

static void components_are_checked(void **state)
{
    struct ng_world *world = *state;
    ng_entity e = point_at(world, 1);
    ng_component id;
    FAILS(NG_ERROR_USAGE, ng_world_add(world, e, 4, NULL));
    logged("component 4 is not registered");
    FAILS(NG_ERROR_USAGE, ng_world_remove(world, e, BODY));
    logged("has no body to remove");
    FAILS(NG_ERROR_USAGE, ng_world_set(world, e, BODY, NULL));
    logged("has no body to set");
    FAILS(NG_ERROR_USAGE, ng_world_register(world, &descs[0], &id));
    logged("registered already");
    struct ng_component_desc bad = {.name = "bad", .size = 4, .fields = body_fields, .field_count = 2};
    FAILS(NG_ERROR_USAGE, ng_world_register(world, &bad, &id));
    logged("outside its 4 bytes");
    assert_null(ng_world_component(world, 4));
    assert_false(ng_world_find_component(world, "nothing", &id));
    assert_true(ng_world_find_component(world, "tag", &id) && id == TAG);
}

// ---- fields ----------------------------------------------------------------------------------------------
static void fields_are_typed_and_checked(void **state)
{
    struct ng_world *world = *state;
    ng_entity e = ng_entity_create(world);
    OK(ng_world_add(world, e, BODY, NULL));
    float mass = 4, got = 0;
    OK(ng_world_set_field(world, e, "body.mass", NG_FIELD_F32, &mass));
    OK(ng_world_get_field(world, e, "body.mass", NG_FIELD_F32, &got));
    assert_true(got == 4);
    char label[NG_TEXT_SIZE];
    OK(ng_world_get_field(world, e, "body.label", NG_FIELD_TEXT, label));
    assert_string_equal(label, "stone");

    struct {
        const char *path;
        enum ng_field_type type;
        const void *value;
        ng_result result;
        const char *text;
    } bad[] = {
        {"body.mass", NG_FIELD_F32, &(float){101}, NG_ERROR_FORMAT, "101 is outside 0.5 to 100"},
        {"body.mass", NG_FIELD_F32, &(float){NAN}, NG_ERROR_FORMAT, "not a finite number"},
        {"body.mass", NG_FIELD_I32, &(int32_t){1}, NG_ERROR_FORMAT, "of type f32, not i32"},
        {"body.count", NG_FIELD_I32, &(int32_t){-6}, NG_ERROR_FORMAT, "-6 is outside -5 to 5"},
        {"body.kind", NG_FIELD_ENUM, &(uint32_t){2}, NG_ERROR_FORMAT, "2 is outside 0 to 1"},
        {"body.awake", NG_FIELD_BOOL, &(unsigned char){2}, NG_ERROR_FORMAT, "2 is outside 0 to 1"},
        {"body.turn", NG_FIELD_QUAT, &(float[4]){1, 1, 0, 0}, NG_ERROR_FORMAT, "length is 1.41421, not 1"},
        {"body.label", NG_FIELD_TEXT, memset(label, 'a', sizeof label), NG_ERROR_FORMAT, "longer than 63"},
        {"body.size", NG_FIELD_F32, &mass, NG_ERROR_NOT_FOUND, "no such field"},
        {"body", NG_FIELD_F32, &mass, NG_ERROR_NOT_FOUND, "no such field"},
        {"soul.mass", NG_FIELD_F32, &mass, NG_ERROR_NOT_FOUND, "no component soul"},
        {"point.x", NG_FIELD_F32, &mass, NG_ERROR_NOT_FOUND, "no such field"},
    };
    for (size_t i = 0; i < NG_COUNT(bad); i++) {
        FAILS(bad[i].result, ng_world_set_field(world, e, bad[i].path, bad[i].type, bad[i].value));
        logged(bad[i].text);
    }
    FAILS(NG_ERROR_NOT_FOUND,
          ng_world_set_field(world, point_at(world, 0), "body.mass", NG_FIELD_F32, &mass));
    logged("does not have this component");
    OK(ng_world_get_field(world, e, "body.mass", NG_FIELD_F32, &got));
    assert_true(got == 4); // no refusal changed anything
}

// ---- hierarchy -------------------------------------------------------------------------------------------
static void children_keep_their_order(void **state)
{
    struct ng_world *world = *state;
    ng_entity p = ng_entity_create(world), a = ng_entity_create(world), b = ng_entity_create(world),
              c = ng_entity_create(world);
    OK(ng_world_set_parent(world, a, p, none));
    OK(ng_world_set_parent(world, b, p, a));
    OK(ng_world_set_parent(world, c, b, none));
    SAME(ng_world_first_child(world, p), b);
    SAME(ng_world_next_sibling(world, b), a);
    SAME(ng_world_previous_sibling(world, a), b);
    SAME(ng_world_last_child(world, p), a);
    SAME(ng_world_parent(world, c), b);
    SAME(ng_world_first_child(world, none), p);
    ng_entity order[] = {p, b, c, a}, e = p;
    for (int i = 0; i < 4; i++, e = ng_world_next_below(world, p, e))
        SAME(e, order[i]);
    SAME(e, none);
    SAME(ng_world_next_below(world, none, a), none); // the last of all
    SAME(ng_world_next_below(world, b, c), none);
    SAME(ng_world_next_below(world, p, (ng_entity){0x9999999900ffffff}), none); // an id never given

    FAILS(NG_ERROR_USAGE, ng_world_set_parent(world, p, c, none));
    logged("cannot be put below itself");
    FAILS(NG_ERROR_USAGE, ng_world_set_parent(world, p, p, none));
    logged("cannot be put below itself");
    FAILS(NG_ERROR_USAGE, ng_world_set_parent(world, a, none, c));
    logged("is not a child");
    OK(ng_entity_destroy(world, b));
    assert_false(ng_entity_alive(world, c));
    SAME(ng_world_first_child(world, p), a);
}

static void deep_trees_are_walked_without_recursion(void **state)
{
    struct ng_world *world = *state;
    enum { DEPTH = 200000 };
    ng_entity top = ng_entity_create(world), parent = top;
    for (int i = 1; i < DEPTH; i++) {
        // Built from the leaf up, since the cycle check costs the depth.
        ng_entity e = ng_entity_create(world);
        OK(ng_world_set_parent(world, parent, e, none));
        parent = e;
    }
    OK(ng_world_begin(world, "delete"));
    OK(ng_entity_destroy(world, parent));
    OK(ng_world_commit(world));
    assert_int_equal(ng_world_entity_count(world), 0);
    OK(ng_world_undo(world));
    assert_int_equal(ng_world_entity_count(world), DEPTH);
    assert_true(ng_entity_alive(world, top));
}

// ---- ticks -----------------------------------------------------------------------------------------------
static void ticks_tell_what_changed_since(void **state)
{
    struct ng_world *world = *state;
    ng_entity a = point_at(world, 1), b = point_at(world, 2);
    uint32_t since = ng_world_stamp(world);
    assert_int_equal(ng_world_stamp(world), since); // nothing happened between
    assert_true(ng_world_changed_at(world, a, POINT) <= since);
    OK(ng_world_set(world, b, POINT, &(struct point){3, 0}));
    assert_true(ng_world_changed_at(world, b, POINT) > since);
    assert_true(ng_world_changed_at(world, a, POINT) <= since);
    assert_true(ng_world_component_changed_at(world, POINT) > since);
    since = ng_world_stamp(world);
    OK(ng_world_add(world, a, BODY, NULL)); // moves the row; the point did not change
    assert_true(ng_world_changed_at(world, a, POINT) <= since);
    assert_true(ng_world_changed_at(world, a, BODY) > since);
    OK(ng_world_set_parent(world, a, b, none));
    assert_true(ng_world_parent_changed_at(world, a) > since);
    assert_true(ng_world_parent_changed_at(world, b) <= since);
}

static void changed_loops_visit_changed_rows_only(void **state)
{
    struct ng_world *world = *state;
    struct ng_query_desc desc = {.terms = {NG_READ(POINT)}, .term_count = 1};
    struct ng_query *query;
    ng_entity e[10000];
    for (int i = 0; i < 10000; i++)
        e[i] = point_at(world, (float)i);
    OK(ng_query_create(world, &desc, &query));
    uint32_t since = ng_world_stamp(world), chunks = 0, rows = 0;
    ng_query_each_changed(it, query, since) fail();
    ((struct point *)ng_world_write(world, e[7000], POINT))->x = 9;
    ng_query_each_changed(it, query, since)
    {
        chunks++;
        for (uint32_t i = 0; i < it.count; i++)
            if (ng_query_row_changed(&it, i)) {
                SAME(it.entities[i], e[7000]);
                rows++;
            }
    }
    assert_int_equal(chunks, 1);
    assert_int_equal(rows, 1);
}

// A stamp taken inside a loop must not hide what the loop marks afterwards.
static void marks_after_a_stamp_are_later(void **state)
{
    struct ng_world *world = *state;
    struct ng_query_desc desc = {.terms = {NG_WRITE(POINT)}, .term_count = 1};
    struct ng_query *query;
    ng_entity e = point_at(world, 1);
    OK(ng_query_create(world, &desc, &query));
    uint32_t inside = 0;
    ng_query_each (it, query) {
        inside = ng_world_stamp(world);
        ng_query_mark(&it, 0, 0);
    }
    assert_true(ng_world_changed_at(world, e, POINT) > inside);
    assert_true(ng_world_component_changed_at(world, POINT) > inside);
    assert_true(ng_world_stamp(world) >= ng_world_changed_at(world, e, POINT));
}

// ---- queries ---------------------------------------------------------------------------------------------
static void terms_choose_tables(void **state)
{
    struct ng_world *world = *state;
    const uint32_t sets[] = {1, 2, 3, 5, 7};
    for (size_t s = 0; s < NG_COUNT(sets); s++) {
        ng_entity e = ng_entity_create(world);
        for (ng_component c = 0; c < 3; c++)
            if (sets[s] & 1u << c)
                OK(ng_world_add(world, e, c, NULL));
    }
    struct {
        struct ng_query_desc desc;
        uint64_t count;
    } cases[] = {
        {{.term_count = 0}, 5},
        {{.terms = {NG_READ(POINT)}, .term_count = 1}, 4},
        {{.terms = {NG_READ(POINT), NG_WITHOUT(BODY)}, .term_count = 2}, 2},
        {{.terms = {NG_READ(POINT), NG_READ_OPTIONAL(BODY)}, .term_count = 2}, 4},
        {{.terms = {NG_WITH(TAG), NG_WRITE(BODY)}, .term_count = 2}, 1},
    };
    for (size_t i = 0; i < NG_COUNT(cases); i++) {
        struct ng_query *query;
        OK(ng_query_create(world, &cases[i].desc, &query));
        uint64_t seen = 0;
        ng_query_each (it, query)
            seen += it.count;
        assert_int_equal(seen, cases[i].count);
        assert_int_equal(ng_query_count(query), cases[i].count);
        ng_query_destroy(&query);
    }
    struct ng_query *query;
    struct ng_query_desc unknown = {.terms = {NG_READ(9)}, .term_count = 1};
    FAILS(NG_ERROR_USAGE, ng_query_create(world, &unknown, &query));
    logged("component 9 is not registered");
}

static void optional_columns_are_null_where_missing(void **state)
{
    struct ng_world *world = *state;
    struct ng_query_desc desc = {.terms = {NG_READ(POINT), NG_WRITE_OPTIONAL(BODY)}, .term_count = 2};
    struct ng_query *query;
    OK(ng_query_create(world, &desc, &query)); // before its tables exist
    point_at(world, 1);
    OK(ng_world_add(world, point_at(world, 2), BODY, NULL));
    int with = 0, without = 0;
    ng_query_each (it, query) {
        const struct point *p = it.columns[0];
        assert_int_equal(it.count, 1);
        assert_true(p[0].x == (it.columns[1] ? 2.0f : 1.0f));
        with += it.columns[1] != NULL;
        without += it.columns[1] == NULL;
        ng_query_mark_all(&it, 1);
        ng_query_mark(&it, 1, 0);
    }
    assert_int_equal(with, 1);
    assert_int_equal(without, 1);
}

static void structure_waits_for_the_loop_to_end(void **state)
{
    struct ng_world *world = *state;
    struct ng_query_desc desc = {.terms = {NG_READ(POINT)}, .term_count = 1};
    struct ng_query *query;
    OK(ng_query_create(world, &desc, &query));
    ng_entity a = point_at(world, 1), b = point_at(world, 2), made = none;
    uint32_t visited = 0;
    ng_query_each (it, query) {
        visited += it.count;
        made = ng_entity_create(world);
        assert_false(ng_entity_alive(world, made));
        OK(ng_world_add(world, made, POINT, &(struct point){5, 0}));
        OK(ng_world_set_parent(world, made, a, none));
        OK(ng_world_remove(world, a, POINT));
        OK(ng_entity_destroy(world, b));
        OK(ng_entity_destroy(world, b)); // two may want the same
        OK(ng_world_add(world, b, TAG, NULL));
        assert_true(ng_world_has(world, a, POINT) && ng_entity_alive(world, b));
    }
    assert_int_equal(visited, 2);
    assert_true(x_of(world, made) == 5);
    SAME(ng_world_parent(world, made), a);
    assert_false(ng_world_has(world, a, POINT));
    assert_false(ng_entity_alive(world, b));
    assert_int_equal(test_logged.errors, 0);

    struct ng_query_iter it = ng_query_begin(query); // a loop left early
    assert_true(ng_query_next(&it));
    OK(ng_entity_destroy(world, made));
    ng_query_stop(&it);
    assert_false(ng_entity_alive(world, made));
}

static void square_chunk(void *user, struct ng_query_iter *it, uint32_t worker)
{
    NG_UNUSED(worker);
    struct ng_world *world = user;
    struct point *p = it->columns[0];
    for (uint32_t i = 0; i < it->count; i++) {
        p[i].y = p[i].x * p[i].x;
        if ((uint32_t)p[i].x % 2)
            ng_query_mark(it, 0, i);
    }
    if (it->entities[0].id == ng_world_first_child(world, none).id)
        assert_true(ng_entity_create(world).id == 0); // refused here
}

static void jobs_run_every_chunk_once(void **state)
{
    struct ng_world *world = *state;
    struct ng_query_desc desc = {.terms = {NG_WRITE(POINT)}, .term_count = 1};
    struct ng_query *query;
    struct ng_jobs *jobs;
    ng_entity e[10000];
    for (int i = 0; i < 10000; i++) {
        e[i] = point_at(world, (float)i);
        if (i % 3 == 1)
            OK(ng_world_add(world, e[i], TAG, NULL));
    }
    OK(ng_query_create(world, &desc, &query));
    OK(ng_jobs_create(&(struct ng_jobs_params){.threads = 3}, &jobs));
    uint32_t since = ng_world_stamp(world);
    ng_query_run_parallel(query, jobs, square_chunk, world);
    ng_jobs_destroy(&jobs);
    logged("cannot be created inside");
    for (int i = 0; i < 10000; i++) {
        const struct point *p = ng_world_get(world, e[i], POINT);
        assert_true(p->y == (float)i * (float)i);
        assert_int_equal(ng_world_changed_at(world, e[i], POINT) > since, i % 2);
    }
    assert_true(ng_world_component_changed_at(world, POINT) > since);
}

// ---- events ----------------------------------------------------------------------------------------------
struct heard {
    char text[256];
};

static void hear(void *user, struct ng_world *world, const struct ng_event *event)
{
    struct heard *heard = user;
    size_t n = strlen(heard->text);
    const struct point *p = event->last ? event->last : ng_world_get(world, event->entity, POINT);
    snprintf(heard->text + n, sizeof heard->text - n, "%c%g ",
             event->kind == NG_EVENT_ADD      ? '+'
             : event->kind == NG_EVENT_REMOVE ? '-'
                                              : '=',
             p ? (double)p->x : -1.0);
}

static void destroy_on_change(void *user, struct ng_world *world, const struct ng_event *event)
{
    NG_UNUSED(user);
    OK(ng_entity_destroy(world, event->entity));
}

static void events_come_in_order_and_removal_has_the_value(void **state)
{
    struct ng_world *world = *state;
    struct heard heard = {0};
    OK(ng_world_observe(world, &(struct ng_observer_desc){.component = POINT, .fn = hear, .user = &heard}));
    ng_entity a = point_at(world, 1), b = point_at(world, 2), c = point_at(world, 3);
    OK(ng_world_add(world, a, BODY, NULL)); // not observed
    OK(ng_world_set(world, c, POINT, &(struct point){30, 0}));
    OK(ng_world_set(world, c, POINT, &(struct point){31, 0})); // one change with the one before
    OK(ng_world_remove(world, a, POINT));
    OK(ng_world_set_parent(world, c, b, none));
    OK(ng_entity_destroy(world, b));
    assert_string_equal(heard.text, "");
    ng_world_dispatch(world);
    assert_string_equal(heard.text, "+-1 +-1 +-1 =-1 -1 -31 -2 "); // adds are read late: gone by now
    heard = (struct heard){0};

    OK(ng_world_observe(world, &(struct ng_observer_desc){
                                   .component = POINT, .kinds = NG_EVENT_CHANGE, .fn = destroy_on_change}));
    ng_entity d = point_at(world, 4);
    ng_world_dispatch(world);
    OK(ng_world_set(world, d, POINT, &(struct point){5, 0}));
    ng_world_dispatch(world); // delivers what the observer causes as well
    assert_string_equal(heard.text, "+4 =5 -5 ");
    FAILS(NG_ERROR_USAGE, ng_world_observe(world, &(struct ng_observer_desc){.component = 77, .fn = hear}));
    logged("not registered");
}

// ---- history ---------------------------------------------------------------------------------------------
static void a_drag_is_one_entry(void **state)
{
    struct ng_world *world = *state;
    ng_entity e = point_at(world, 1);
    OK(ng_world_begin(world, "Move"));
    for (int i = 0; i < 1000; i++)
        ((struct point *)ng_world_edit(world, e, POINT))->x = (float)i;
    OK(ng_world_commit(world));
    assert_string_equal(ng_world_undo_label(world), "Move");
    uint32_t since = ng_world_stamp(world);
    OK(ng_world_undo(world));
    assert_true(x_of(world, e) == 1);
    assert_true(ng_world_changed_at(world, e, POINT) > since); // time does not go back
    assert_null(ng_world_undo_label(world));
    FAILS(NG_ERROR_NOT_FOUND, ng_world_undo(world));
    OK(ng_world_redo(world));
    assert_true(x_of(world, e) == 999);
    FAILS(NG_ERROR_NOT_FOUND, ng_world_redo(world));
    OK(ng_world_undo(world));
    OK(ng_world_begin(world, "Nothing"));
    OK(ng_world_commit(world));
    assert_string_equal(ng_world_redo_label(world), "Move"); // an empty transaction is none
    OK(ng_world_begin(world, "Other"));
    OK(ng_world_add(world, e, TAG, NULL));
    OK(ng_world_commit(world));
    assert_null(ng_world_redo_label(world));
    assert_int_equal(test_logged.errors, 0);
}

static void destroyed_subtrees_come_back_as_they_were(void **state)
{
    struct ng_world *world = *state;
    ng_entity p = point_at(world, 1), a = point_at(world, 2), b = point_at(world, 3), c = point_at(world, 4);
    OK(ng_world_set_parent(world, a, p, none));
    OK(ng_world_set_parent(world, b, p, none));
    OK(ng_world_set_parent(world, c, a, none));
    OK(ng_world_add(world, a, CACHE, NULL));
    OK(ng_world_begin(world, "Delete"));
    OK(ng_entity_destroy(world, a));
    OK(ng_world_commit(world));
    ng_entity other = point_at(world, 9); // must not take the id that undo needs
    OK(ng_world_undo(world));
    assert_true(x_of(world, a) == 2 && x_of(world, c) == 4 && x_of(world, other) == 9);
    SAME(ng_world_first_child(world, p), a);
    SAME(ng_world_next_sibling(world, a), b);
    SAME(ng_world_parent(world, c), a);
    assert_false(ng_world_has(world, a, CACHE)); // derived: not kept, computed anew
    OK(ng_world_redo(world));
    assert_false(ng_entity_alive(world, a) || ng_entity_alive(world, c));
}

// Each step of one transaction counts, also where they concern one component.
static void redo_repeats_every_step(void **state)
{
    struct ng_world *world = *state;
    ng_entity e = ng_entity_create(world);
    OK(ng_world_begin(world, "Add, remove, add"));
    OK(ng_world_add(world, e, POINT, &(struct point){1, 0}));
    OK(ng_world_remove(world, e, POINT));
    OK(ng_world_add(world, e, POINT, &(struct point){2, 0}));
    OK(ng_world_set(world, e, POINT, &(struct point){3, 0}));
    OK(ng_world_commit(world));
    for (int i = 0; i < 2; i++) {
        OK(ng_world_undo(world));
        assert_false(ng_world_has(world, e, POINT));
        OK(ng_world_redo(world));
        assert_true(x_of(world, e) == 3);
    }
}

static void cancel_takes_everything_back(void **state)
{
    struct ng_world *world = *state;
    ng_entity e = point_at(world, 1);
    OK(ng_world_begin(world, "Mess"));
    ng_entity made = point_at(world, 2);
    OK(ng_world_set_parent(world, e, made, none));
    OK(ng_world_remove(world, e, POINT));
    OK(ng_world_add(world, e, TAG, NULL));
    assert_true(ng_world_in_transaction(world));
    OK(ng_world_cancel(world));
    assert_false(ng_entity_alive(world, made));
    assert_true(x_of(world, e) == 1 && !ng_world_has(world, e, TAG));
    SAME(ng_world_parent(world, e), none);
    assert_null(ng_world_undo_label(world));
    assert_null(ng_world_redo_label(world));
    assert_int_equal(ng_entity_index(ng_entity_create(world)),
                     ng_entity_index(made)); // its slot is free again
}

static void history_is_checked_and_bounded(void **state)
{
    struct ng_world *world = *state;
    FAILS(NG_ERROR_USAGE, ng_world_commit(world));
    logged("no transaction is open");
    OK(ng_world_begin(world, "A"));
    FAILS(NG_ERROR_USAGE, ng_world_begin(world, "B"));
    logged("\"A\" is open");
    FAILS(NG_ERROR_USAGE, ng_world_undo(world));
    logged("not while transaction \"A\" is open");
    OK(ng_world_commit(world));
    for (int i = 0; i < 300; i++) {
        OK(ng_world_begin(world, "Add"));
        point_at(world, 1);
        OK(ng_world_commit(world));
    }
    int undone = 0;
    while (ng_world_undo(world) == NG_OK)
        undone++;
    assert_int_equal(undone, 256);
    assert_int_equal(ng_world_entity_count(world), 300 - 256);
    ng_world_clear_history(world);
    assert_null(ng_world_redo_label(world));
}

// A number that is no entity's, and its changes.
struct number {
    int value, alive; // changes that are not finished
    int done;         // of the last that was
};
struct number_change {
    struct number *of;
    int other;
    uint64_t bytes;
};

static void number_exchange(void *change, bool forward)
{
    struct number_change *c = change;
    int now = c->of->value;
    NG_UNUSED(forward);
    c->of->value = c->other;
    c->other = now;
}

static void number_finish(void *change, bool done)
{
    struct number_change *c = change;
    c->of->alive--;
    c->of->done = done;
    free(c);
}

static uint64_t number_bytes(const void *change)
{
    return ((const struct number_change *)change)->bytes;
}

static ng_result number_set(struct ng_world *world, struct number *n, int value, uint64_t bytes)
{
    static const struct ng_change_type type = {number_exchange, number_finish, number_bytes};
    struct number_change *c = malloc(sizeof *c);
    assert_non_null(c);
    *c = (struct number_change){.of = n, .other = n->value, .bytes = bytes};
    ng_result r = ng_world_record(world, &type, c);
    if (r != NG_OK) {
        free(c);
        return r;
    }
    n->value = value;
    n->alive++;
    return NG_OK;
}

static void others_take_part_in_history(void **state)
{
    struct ng_world *world = *state;
    struct number n = {0};
    FAILS(NG_ERROR_USAGE, number_set(world, &n, 1, 0)); // no transaction
    assert_int_equal(ng_world_transaction(world), 0);
    OK(ng_world_begin(world, "two"));
    uint64_t first = ng_world_transaction(world);
    ng_entity e = point_at(world, 1);
    OK(number_set(world, &n, 1, 100000));
    OK(number_set(world, &n, 2, 100000));
    OK(ng_world_commit(world));
    assert_true(ng_world_history_bytes(world) >= 200000);
    OK(ng_world_undo(world));
    assert_int_equal(n.value, 0);
    assert_false(ng_entity_alive(world, e));
    OK(ng_world_redo(world));
    assert_int_equal(n.value, 2);
    OK(ng_world_begin(world, "never mind"));
    assert_true(ng_world_transaction(world) > first);
    OK(number_set(world, &n, 3, 0));
    OK(ng_world_cancel(world));
    assert_int_equal(n.value, 2);
    assert_int_equal(n.alive, 2);
    assert_false(n.done);
    // Too many bytes: the oldest go, the newest stays whatever it holds.
    ng_world_limit_history(world, 500000);
    for (int i = 0; i < 3; i++) {
        OK(ng_world_begin(world, "large"));
        OK(number_set(world, &n, 10 + i, i < 2 ? 200000 : 900000));
        OK(ng_world_commit(world));
        assert_int_equal(n.alive, 3 - i);
    }
    assert_true(n.done);
    OK(ng_world_undo(world));
    assert_int_equal(n.value, 11);
    FAILS(NG_ERROR_NOT_FOUND, ng_world_undo(world));
    ng_world_limit_history(world, 0);
    ng_world_clear_history(world);
    assert_int_equal(n.alive, 0);
    assert_false(n.done);
    assert_int_equal(ng_world_history_bytes(world), 0);
}

static void undo_passes_over_what_is_gone(void **state)
{
    struct ng_world *world = *state;
    ng_entity e = point_at(world, 1), keep = point_at(world, 2);
    OK(ng_world_begin(world, "Move"));
    OK(ng_world_set(world, e, POINT, &(struct point){5, 0}));
    OK(ng_world_set(world, keep, POINT, &(struct point){6, 0}));
    OK(ng_world_set_parent(world, keep, e, none));
    OK(ng_world_commit(world));
    OK(ng_world_set_parent(world, keep, none, none));
    OK(ng_entity_destroy(world, e)); // not recorded
    ng_entity reused = point_at(world, 7);
    OK(ng_world_undo(world));
    assert_true(x_of(world, keep) == 2 && x_of(world, reused) == 7);
    OK(ng_world_redo(world));
    assert_true(x_of(world, keep) == 6 && x_of(world, reused) == 7);
}

// ---- systems ---------------------------------------------------------------------------------------------
static ng_result note(void *user, struct ng_world *world, double time)
{
    NG_UNUSED(world);
    NG_UNUSED(time);
    struct heard *heard = *(struct heard **)user;
    strncat(heard->text, (const char *)user + sizeof(struct heard *), 8);
    return NG_OK;
}

static ng_result forget_to_stop(void *user, struct ng_world *world, double time)
{
    NG_UNUSED(world);
    NG_UNUSED(time);
    struct ng_query_iter it = ng_query_begin(user);
    assert_true(ng_query_next(&it));
    return NG_OK;
}

static void phases_run_in_order(void **state)
{
    struct ng_world *world = *state;
    struct heard heard = {0};
    struct {
        struct heard *heard;
        char name[8];
    } users[] = {{&heard, "late "}, {&heard, "input "}, {&heard, "place "}, {&heard, "more "}};
    enum ng_phase phases[] = {NG_PHASE_LATE, NG_PHASE_INPUT, NG_PHASE_PLACE, NG_PHASE_INPUT};
    for (size_t i = 0; i < NG_COUNT(users); i++)
        OK(ng_world_add_system(
            world, &(struct ng_system_desc){
                       .name = users[i].name, .phase = phases[i], .run = note, .user = &users[i]}));
    OK(ng_world_run(world, 0));
    assert_string_equal(heard.text, "input more place late ");

    struct ng_query *query;
    OK(ng_query_create(world, &(struct ng_query_desc){0}, &query));
    ng_entity_create(world);
    OK(ng_world_add_system(world,
                           &(struct ng_system_desc){.name = "leaky", .run = forget_to_stop, .user = query}));
    FAILS(NG_ERROR_USAGE, ng_world_run(world, 0));
    logged("system leaky left a query loop");
}

static void bookkeeping_is_small(void **state)
{
    struct ng_world *world = *state;
    for (int i = 0; i < 100000; i++)
        OK(ng_world_add(world, point_at(world, 0), CACHE, NULL));
    struct ng_world_memory memory = ng_world_memory(world);
    assert_true(memory.bookkeeping <= 64 * 100000);
    assert_true(memory.values >= 16 * 100000 && memory.values < 17 * 100000);
}

int main(void)
{
#define TEST(f) cmocka_unit_test_setup_teardown(f, setup, teardown)
    const struct CMUnitTest tests[] = {
        TEST(stale_ids_are_found),
        TEST(values_survive_moves_between_tables),
        TEST(adding_twice_replaces_the_value),
        TEST(components_are_checked),
        TEST(fields_are_typed_and_checked),
        TEST(children_keep_their_order),
        TEST(deep_trees_are_walked_without_recursion),
        TEST(ticks_tell_what_changed_since),
        TEST(changed_loops_visit_changed_rows_only),
        TEST(marks_after_a_stamp_are_later),
        TEST(terms_choose_tables),
        TEST(optional_columns_are_null_where_missing),
        TEST(structure_waits_for_the_loop_to_end),
        TEST(jobs_run_every_chunk_once),
        TEST(events_come_in_order_and_removal_has_the_value),
        TEST(a_drag_is_one_entry),
        TEST(destroyed_subtrees_come_back_as_they_were),
        TEST(redo_repeats_every_step),
        TEST(cancel_takes_everything_back),
        TEST(history_is_checked_and_bounded),
        TEST(others_take_part_in_history),
        TEST(undo_passes_over_what_is_gone),
        TEST(phases_run_in_order),
        TEST(bookkeeping_is_small),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// The world against a naive model: random operations, and after each one everything that can be asked is
// asked.
//
// The model is an array of entities in one global order; children of p are those of the array whose parent is
// p, in that order. It can be copied, so undo is a copy put back. Arguments: nothing, or one seed.
#include "test.h"

#include "base/rng.h"
#include "scene/event.h"
#include "scene/history.h"
#include "scene/query.h"
#include "scene/world.h"

#define OPERATIONS    20000
#define SEEDS         6
#define LIVE_MAX      48                               // no more are created
#define NODE_MAX      (LIVE_MAX * (HISTORY_LIMIT + 2)) // but undo may bring more back
#define HISTORY_LIMIT 12

enum { A, B, TAG, CACHE, COMPONENTS };
static const struct ng_component_desc descs[COMPONENTS] = {
    {.name = "a", .size = 4, .align = 4},
    {.name = "b", .size = 4, .align = 4},
    {.name = "tag"},
    {.name = "cache", .size = 4, .align = 4, .flags = NG_COMPONENT_DERIVED},
};

struct node {
    ng_entity id, parent;
    bool has[COMPONENTS];
    uint32_t value[COMPONENTS];
};

struct model {
    struct node nodes[NODE_MAX];
    uint32_t count;
};

struct fuzz {
    struct ng_world *world;
    struct ng_query *queries[4];
    struct ng_rng rng;
    struct model now, before, begun; // before: this operation; begun: the transaction
    bool open, recorded;
    bool loose; // changes outside transactions leave the history alone
    struct {
        struct model before, after;
    } history[HISTORY_LIMIT];
    uint32_t done, entries;
    // What a tick may say has changed since the last stamp.
    uint32_t since;
    struct {
        ng_entity id;
        bool must[COMPONENTS];
    } touched[4096];
    uint32_t touched_count;
    bool may_all; // undo stamps what it wrote back, changed or not
    // Built from events alone.
    struct node heard[4096];
    uint32_t heard_count, changes_heard;
    bool exact_last; // a removal's value must be the one before the operation
};

// ---- the model -------------------------------------------------------------------------------------------
static struct node *node_of(struct model *m, ng_entity id)
{
    for (uint32_t i = 0; i < m->count; i++)
        if (m->nodes[i].id.id == id.id)
            return &m->nodes[i];
    return NULL;
}

static bool model_is_below(struct model *m, ng_entity top, ng_entity e)
{
    for (; e.id; e = node_of(m, e)->parent)
        if (e.id == top.id)
            return true;
    return false;
}

static void model_move(struct model *m, ng_entity e, ng_entity parent, ng_entity before)
{
    struct node node = *node_of(m, e);
    uint32_t at = (uint32_t)(node_of(m, e) - m->nodes);
    memmove(&m->nodes[at], &m->nodes[at + 1], (--m->count - at) * sizeof node);
    uint32_t to = before.id ? (uint32_t)(node_of(m, before) - m->nodes) : m->count;
    memmove(&m->nodes[to + 1], &m->nodes[to], (m->count++ - to) * sizeof node);
    node.parent = parent;
    m->nodes[to] = node;
}

static void model_destroy(struct model *m, ng_entity e)
{
    struct model old = *m;
    m->count = 0;
    for (uint32_t i = 0; i < old.count; i++)
        if (!model_is_below(&old, e, old.nodes[i].id))
            m->nodes[m->count++] = old.nodes[i];
}

static void touch(struct fuzz *f, ng_entity id, int c)
{
    uint32_t k = f->touched_count++;
    assert_true(k < NG_COUNT(f->touched));
    f->touched[k].id = id;
    memset(f->touched[k].must, 0, sizeof f->touched[k].must);
    f->touched[k].must[c] = true;
}

// Undo and redo leave derived values as they are, and restored entities without.
static void model_restore(struct fuzz *f, const struct model *old)
{
    struct model now = f->now;
    f->now = *old;
    for (uint32_t i = 0; i < f->now.count; i++) {
        struct node *to = &f->now.nodes[i], *from = node_of(&now, to->id);
        to->has[CACHE] = from && from->has[CACHE];
        to->value[CACHE] = from ? from->value[CACHE] : 0;
        for (int c = 0; c < COMPONENTS; c++)
            if (to->has[c] && (!from || !from->has[c] || from->value[c] != to->value[c]))
                touch(f, to->id, c);
    }
}

static void model_read_back(struct fuzz *f)
{
    const ng_entity root = {0};
    f->now.count = f->touched_count = 0;
    for (ng_entity e = ng_world_first_child(f->world, root); e.id;
         e = ng_world_next_below(f->world, root, e)) {
        assert_true(f->now.count < NODE_MAX);
        struct node *node = &f->now.nodes[f->now.count++];
        *node = (struct node){.id = e, .parent = ng_world_parent(f->world, e)};
        for (ng_component c = 0; c < COMPONENTS; c++) {
            node->has[c] = ng_world_has(f->world, e, c);
            if (node->has[c])
                memcpy(&node->value[c], ng_world_get(f->world, e, c), descs[c].size);
        }
    }
}

// The model follows an undo, a redo or a cancel that leads to `state`.
static void model_return(struct fuzz *f, const struct model *state)
{
    f->exact_last = false; // many changes in one operation
    f->may_all = true;
    if (f->loose)
        model_read_back(f);
    else
        model_restore(f, state);
}

static bool was_touched(const struct fuzz *f, ng_entity id, int c)
{
    for (uint32_t k = 0; k < f->touched_count; k++)
        if (f->touched[k].id.id == id.id && f->touched[k].must[c])
            return true;
    return false;
}

static void restamp(struct fuzz *f)
{
    f->since = ng_world_stamp(f->world);
    f->touched_count = 0;
    f->may_all = false;
}

// ---- events ----------------------------------------------------------------------------------------------
static struct node *heard_of(struct fuzz *f, ng_entity id)
{
    for (uint32_t i = 0; i < f->heard_count; i++)
        if (f->heard[i].id.id == id.id)
            return &f->heard[i];
    assert_true(f->heard_count < NG_COUNT(f->heard));
    f->heard[f->heard_count] = (struct node){.id = id};
    return &f->heard[f->heard_count++];
}

static void hear(void *user, struct ng_world *world, const struct ng_event *event)
{
    NG_UNUSED(world);
    struct fuzz *f = user;
    bool *has = &heard_of(f, event->entity)->has[event->component];
    if (event->kind == NG_EVENT_CHANGE) {
        f->changes_heard++;
        return;
    }
    assert_int_equal(*has, event->kind == NG_EVENT_REMOVE);
    *has = event->kind == NG_EVENT_ADD;
    const struct node *before = node_of(&f->before, event->entity);
    if (event->kind == NG_EVENT_REMOVE && f->exact_last && event->component != TAG)
        assert_memory_equal(event->last, &before->value[event->component], 4);
}

// ---- asking everything -----------------------------------------------------------------------------------
static void check_children(struct fuzz *f, ng_entity parent)
{
    ng_entity child = ng_world_first_child(f->world, parent), last = {0};
    for (uint32_t i = 0; i < f->now.count; i++) {
        if (f->now.nodes[i].parent.id != parent.id)
            continue;
        assert_true(child.id == f->now.nodes[i].id.id);
        assert_true(ng_world_parent(f->world, child).id == parent.id);
        assert_true(ng_world_previous_sibling(f->world, child).id == last.id);
        last = child;
        child = ng_world_next_sibling(f->world, child);
    }
    assert_true(child.id == 0);
    assert_true(ng_world_last_child(f->world, parent).id == last.id);
}

static void check_node(struct fuzz *f, const struct node *node)
{
    assert_true(ng_entity_alive(f->world, node->id));
    for (ng_component c = 0; c < COMPONENTS; c++) {
        assert_int_equal(ng_world_has(f->world, node->id, c), node->has[c]);
        assert_int_equal(heard_of(f, node->id)->has[c], node->has[c]);
        bool changed = ng_world_changed_at(f->world, node->id, c) > f->since;
        if (!node->has[c]) {
            assert_false(changed);
            continue;
        }
        if (descs[c].size)
            assert_memory_equal(ng_world_get(f->world, node->id, c), &node->value[c], 4);
        bool must = was_touched(f, node->id, (int)c);
        assert_true(must ? changed : !changed || f->may_all);
    }
}

static const struct ng_query_desc query_descs[4] = {
    {.terms = {NG_READ(A)}, .term_count = 1},
    {.terms = {NG_READ(A), NG_WITHOUT(B)}, .term_count = 2},
    {.terms = {NG_READ(A), NG_READ(B), NG_WITH(TAG)}, .term_count = 3},
    {.terms = {NG_READ_OPTIONAL(TAG), NG_WRITE(CACHE)}, .term_count = 2},
};

static bool model_matches(const struct node *node, const struct ng_query_desc *desc)
{
    for (uint32_t t = 0; t < desc->term_count; t++)
        if (!desc->terms[t].optional &&
            node->has[desc->terms[t].component] != (desc->terms[t].kind != NG_TERM_WITHOUT))
            return false;
    return true;
}

static void check_query(struct fuzz *f, int q)
{
    const struct ng_query_desc *desc = &query_descs[q];
    uint32_t seen = 0, expected = 0, changed = 0, changed_expected = 0;
    ng_query_each (it, f->queries[q])
        for (uint32_t i = 0; i < it.count; i++, seen++) {
            const struct node *node = node_of(&f->now, it.entities[i]);
            assert_true(node && model_matches(node, desc));
            for (uint32_t t = 0; t < desc->term_count; t++)
                if (it.columns[t])
                    assert_memory_equal((char *)it.columns[t] + 4 * i, &node->value[desc->terms[t].component],
                                        4);
        }
    ng_query_each_changed(it, f->queries[q], f->since) for (uint32_t i = 0; i < it.count; i++) changed +=
        ng_query_row_changed(&it, i);
    for (uint32_t i = 0; i < f->now.count; i++) {
        const struct node *node = &f->now.nodes[i];
        if (!model_matches(node, desc))
            continue;
        expected++;
        bool any = f->since == 0;
        for (uint32_t t = 0; t < desc->term_count; t++)
            any |= desc->terms[t].kind == NG_TERM_READ &&
                   ng_world_changed_at(f->world, node->id, desc->terms[t].component) > f->since;
        changed_expected += any;
    }
    assert_int_equal(seen, expected);
    assert_int_equal(ng_query_count(f->queries[q]), expected);
    assert_int_equal(changed, changed_expected);
}

static void check(struct fuzz *f)
{
    ng_world_dispatch(f->world);
    assert_int_equal(ng_world_entity_count(f->world), f->now.count);
    check_children(f, (ng_entity){0});
    for (uint32_t i = 0; i < f->now.count; i++) {
        check_node(f, &f->now.nodes[i]);
        check_children(f, f->now.nodes[i].id);
    }
    for (uint32_t i = 0; i < f->before.count; i++) {
        ng_entity id = f->before.nodes[i].id;
        if (node_of(&f->now, id))
            continue;
        assert_false(ng_entity_alive(f->world, id));
        for (int c = 0; c < COMPONENTS; c++)
            assert_false(heard_of(f, id)->has[c]);
    }
    for (int q = 0; q < 4; q++)
        check_query(f, q);
    assert_int_equal(ng_world_in_transaction(f->world), f->open);
    assert_int_equal(ng_world_undo_label(f->world) != NULL, f->done > 0);
    assert_int_equal(ng_world_redo_label(f->world) != NULL, f->done < f->entries);
}

// ---- operations ------------------------------------------------------------------------------------------
#define OK(expr) assert_int_equal((expr), NG_OK)

static uint32_t below(struct fuzz *f, uint32_t n)
{
    return ng_rng_below(&f->rng, n);
}

static ng_entity any_entity(struct fuzz *f)
{
    return f->now.count ? f->now.nodes[below(f, f->now.count)].id : (ng_entity){0};
}

// A change outside a transaction is one that undo does not know: it starts a new history, unless loose.
static void about_to_change(struct fuzz *f)
{
    if (f->open) {
        f->recorded = true;
    } else if (!f->loose) {
        ng_world_clear_history(f->world);
        f->done = f->entries = 0;
    }
}

static void op_create(struct fuzz *f)
{
    if (f->now.count >= LIVE_MAX)
        return;
    about_to_change(f);
    ng_entity e = ng_entity_create(f->world);
    assert_true(e.id && !node_of(&f->now, e));
    f->now.nodes[f->now.count++] = (struct node){.id = e};
}

static void op_destroy(struct fuzz *f)
{
    ng_entity e = any_entity(f);
    if (!e.id)
        return;
    about_to_change(f);
    OK(ng_entity_destroy(f->world, e));
    model_destroy(&f->now, e);
}

static void op_add(struct fuzz *f)
{
    ng_entity e = any_entity(f);
    ng_component c = below(f, COMPONENTS);
    uint32_t value = ng_rng_u32(&f->rng);
    if (!e.id)
        return;
    if (c != CACHE)
        about_to_change(f);
    OK(ng_world_add(f->world, e, c, &value));
    struct node *node = node_of(&f->now, e);
    node->has[c] = true;
    node->value[c] = c == TAG ? 0 : value;
    touch(f, e, (int)c);
}

static void op_remove(struct fuzz *f)
{
    ng_entity e = any_entity(f);
    ng_component c = below(f, COMPONENTS);
    if (!e.id || !node_of(&f->now, e)->has[c])
        return;
    if (c != CACHE)
        about_to_change(f);
    OK(ng_world_remove(f->world, e, c));
    struct node *node = node_of(&f->now, e);
    node->has[c] = false;
    node->value[c] = 0;
}

static void op_edit(struct fuzz *f)
{
    ng_entity e = any_entity(f);
    ng_component c = below(f, 2);
    uint32_t value = ng_rng_u32(&f->rng);
    if (!e.id || !node_of(&f->now, e)->has[c])
        return;
    about_to_change(f);
    f->changes_heard = 0;
    if (below(f, 2))
        OK(ng_world_set(f->world, e, c, &value));
    else
        memcpy(ng_world_edit(f->world, e, c), &value, 4);
    ng_world_dispatch(f->world);
    assert_int_equal(f->changes_heard, 1);
    node_of(&f->now, e)->value[c] = value;
    touch(f, e, (int)c);
}

static void op_move(struct fuzz *f)
{
    ng_entity e = any_entity(f), parent = below(f, 3) ? any_entity(f) : (ng_entity){0}, before = {0};
    if (!e.id)
        return;
    for (uint32_t i = 0; i < f->now.count && below(f, 2); i++)
        if (f->now.nodes[i].parent.id == parent.id)
            before = f->now.nodes[i].id;
    if (model_is_below(&f->now, e, parent)) {
        assert_int_equal(ng_world_set_parent(f->world, e, parent, before), NG_ERROR_USAGE);
        return;
    }
    if (e.id == before.id) { // it is there: nothing to record
        OK(ng_world_set_parent(f->world, e, parent, before));
        return;
    }
    about_to_change(f);
    OK(ng_world_set_parent(f->world, e, parent, before));
    model_move(&f->now, e, parent, before);
}

// A loop writes some rows of the derived component.
static void op_loop_write(struct fuzz *f)
{
    ng_query_each (it, f->queries[3])
        for (uint32_t i = 0; i < it.count; i++) {
            if (below(f, 4))
                continue;
            uint32_t value = ng_rng_u32(&f->rng);
            ((uint32_t *)it.columns[1])[i] = value;
            ng_query_mark(&it, 1, i);
            node_of(&f->now, it.entities[i])->value[CACHE] = value;
            touch(f, it.entities[i], CACHE);
        }
}

// Structural changes from inside a loop, seen by the world only after it.
static void op_deferred(struct fuzz *f)
{
    struct model old = f->now;
    bool open = f->open;
    f->exact_last = false; // several changes in one operation
    bool recorded = f->recorded;
    about_to_change(f); // before the loop, in which the history cannot be cleared
    f->recorded = recorded;
    struct ng_query_iter it = ng_query_begin(f->queries[0]);
    if (!ng_query_next(&it))
        return;
    f->open = true;
    for (uint32_t n = 1 + below(f, 6); n; n--) {
        void (*const ops[])(struct fuzz *) = {op_create, op_destroy, op_add, op_remove};
        ops[below(f, NG_COUNT(ops))](f);
        for (uint32_t i = 0; i < old.count; i++)
            assert_true(ng_entity_alive(f->world, old.nodes[i].id));
    }
    f->open = open;
    ng_query_stop(&it);
}

static void op_begin(struct fuzz *f)
{
    if (f->open)
        return;
    OK(ng_world_begin(f->world, "transaction"));
    f->open = true;
    f->recorded = false;
    f->begun = f->now;
}

static void op_commit(struct fuzz *f)
{
    if (!f->open)
        return;
    OK(ng_world_commit(f->world));
    f->open = false;
    bool entry =
        f->done < HISTORY_LIMIT ? ng_world_undo_label(f->world) && !ng_world_redo_label(f->world) : true;
    if (!f->recorded || !entry)
        return;
    if (f->done == HISTORY_LIMIT) {
        memmove(&f->history[0], &f->history[1], (HISTORY_LIMIT - 1) * sizeof f->history[0]);
        f->done--;
    }
    f->history[f->done].before = f->begun;
    f->history[f->done++].after = f->now;
    f->entries = f->done;
}

static void op_cancel(struct fuzz *f)
{
    if (!f->open)
        return;
    OK(ng_world_cancel(f->world));
    f->open = false;
    model_return(f, &f->begun);
}

static void op_undo(struct fuzz *f)
{
    ng_result expected = f->open ? NG_ERROR_USAGE : f->done ? NG_OK : NG_ERROR_NOT_FOUND;
    assert_int_equal(ng_world_undo(f->world), expected);
    if (expected == NG_OK)
        model_return(f, &f->history[--f->done].before);
}

static void op_redo(struct fuzz *f)
{
    ng_result expected = f->open ? NG_ERROR_USAGE : f->done < f->entries ? NG_OK : NG_ERROR_NOT_FOUND;
    assert_int_equal(ng_world_redo(f->world), expected);
    if (expected == NG_OK)
        model_return(f, &f->history[f->done++].after);
}

struct operation {
    void (*run)(struct fuzz *);
    uint32_t weight;
};

static const struct operation changes[] = {
    {op_create, 10},    {op_destroy, 3},  {op_add, 20},   {op_remove, 8}, {op_edit, 20}, {op_move, 12},
    {op_loop_write, 4}, {op_deferred, 5}, {op_commit, 7}, {op_cancel, 2}, {op_undo, 1},  {restamp, 4},
};
// Between transactions, mostly: changes there would forget the history.
static const struct operation steps[] = {{op_begin, 4}, {op_undo, 5}, {op_redo, 4}};

static const struct operation *pick(struct fuzz *f, const struct operation *from, size_t count)
{
    uint32_t total = 0;
    for (size_t i = 0; i < count; i++)
        total += from[i].weight;
    uint32_t at = below(f, total);
    while (at >= from->weight)
        at -= from++->weight;
    return from;
}

static void run_operation(struct fuzz *f)
{
    bool step = !f->open && below(f, 32);
    const struct operation *op = step ? pick(f, steps, NG_COUNT(steps)) : pick(f, changes, NG_COUNT(changes));
    f->before = f->now;
    f->exact_last = true;
    op->run(f);
    check(f);
    if (f->heard_count > NG_COUNT(f->heard) - 256 || f->touched_count > NG_COUNT(f->touched) - 512) {
        restamp(f);
        uint32_t kept = 0; // ids that are gone for now have nothing: leave them out
        for (uint32_t i = 0; i < f->heard_count; i++)
            if (ng_entity_alive(f->world, f->heard[i].id))
                f->heard[kept++] = f->heard[i];
        f->heard_count = kept;
    }
}

static void run_seed(uint64_t seed)
{
    struct fuzz *f = calloc(1, sizeof *f);
    struct test_log log;
    assert_non_null(f);
    test_log_begin(&log); // refused operations are part of the game
    f->rng = ng_rng_make(seed, 0);
    f->loose = seed % 3 == 0;
    OK(ng_world_create(&(struct ng_world_params){.history_limit = HISTORY_LIMIT}, &f->world));
    for (size_t c = 0; c < COMPONENTS; c++) {
        ng_component id;
        OK(ng_world_register(f->world, &descs[c], &id));
        OK(ng_world_observe(f->world, &(struct ng_observer_desc){.component = id, .fn = hear, .user = f}));
    }
    for (int q = 0; q < 4; q++)
        OK(ng_query_create(f->world, &query_descs[q], &f->queries[q]));
    for (int i = 0; i < OPERATIONS; i++)
        run_operation(f);
    ng_world_destroy(&f->world);
    test_log_end(&log);
    free(f);
}

static void world_equals_model(void **state)
{
    NG_UNUSED(state);
    for (uint64_t seed = 1; seed <= SEEDS; seed++) {
        print_message("seed %d\n", (int)seed);
        run_seed(seed);
    }
}

int main(int argc, char **argv)
{
    if (argc > 1) {
        run_seed(strtoull(argv[1], NULL, 10));
        return 0;
    }
    const struct CMUnitTest tests[] = {cmocka_unit_test(world_equals_model)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// Queries: loops over all entities that have given components.
//
//     struct ng_query_desc desc = {.terms = {NG_READ(VELOCITY), NG_WRITE(POSITION)}, .term_count = 2};
//     NG_TRY(ng_query_create(world, &desc, &query));
//     ng_query_each(it, query) {                          // once a chunk of at most NG_CHUNK_ROWS rows
//         const struct velocity *v = it.columns[0];
//         struct position *p = it.columns[1];
//         for (uint32_t i = 0; i < it.count; i++)
//             p[i].x += v[i].x;
//         ng_query_mark_all(&it, 1);                      // these rows of term 1 changed
//     }
//
// A query keeps the list of tables that match it; new tables are added when they come into being, so that a
// loop never searches. Tables are visited in the order they were made, rows in table order: deterministic,
// but not an order to give meaning to. A query belongs to its world and dies with it at the latest.
#ifndef NG_SCENE_QUERY_H
#define NG_SCENE_QUERY_H

#include "base/extern_c.h"
#include "scene/world.h"

NG_EXTERN_C_BEGIN

struct ng_query;
struct ng_jobs;

#define NG_QUERY_MAX_TERMS 8
#define NG_CHUNK_ROWS      4096

enum ng_term_kind {
    NG_TERM_READ,    // has it; its changes count in ng_query_begin_changed
    NG_TERM_WRITE,   // has it, and the loop changes it (rows must be marked)
    NG_TERM_WITH,    // has it; no column is given
    NG_TERM_WITHOUT, // does not have it
};

struct ng_term {
    ng_component component;
    enum ng_term_kind kind;
    bool optional; // of READ and WRITE: may be missing, its column is then null
};

#define NG_TERM(component_, kind_, optional_)                                                                \
    {                                                                                                        \
        .component = (component_), .kind = (kind_), .optional = (optional_)                                  \
    }
#define NG_READ(component)           NG_TERM(component, NG_TERM_READ, false)
#define NG_WRITE(component)          NG_TERM(component, NG_TERM_WRITE, false)
#define NG_WITH(component)           NG_TERM(component, NG_TERM_WITH, false)
#define NG_WITHOUT(component)        NG_TERM(component, NG_TERM_WITHOUT, false)
#define NG_READ_OPTIONAL(component)  NG_TERM(component, NG_TERM_READ, true)
#define NG_WRITE_OPTIONAL(component) NG_TERM(component, NG_TERM_WRITE, true)

struct ng_query_desc {
    struct ng_term terms[NG_QUERY_MAX_TERMS];
    uint32_t term_count;
};

// One chunk of a loop. Columns and ticks are indexed by term, then by row.
struct ng_query_iter {
    struct ng_world *world;
    uint32_t count; // rows of this chunk
    // [count] of each. Null where a term wants no column or its component is missing; values also null for a
    // tag. The values of READ terms are not to be written.
    const ng_entity *entities;
    void *columns[NG_QUERY_MAX_TERMS];
    const uint32_t *ticks[NG_QUERY_MAX_TERMS]; // when each value last changed
    // The place in the loop; not the caller's business.
    struct ng_query *query;
    uint32_t *marks[NG_QUERY_MAX_TERMS], *high[NG_QUERY_MAX_TERMS];
    uint32_t match, chunk, since;
    const uint32_t *tick;
};

// Errors: unknown component, too many terms (USAGE), memory.
NG_NODISCARD ng_result ng_query_create(struct ng_world *world, const struct ng_query_desc *desc,
                                       struct ng_query **out);
void ng_query_destroy(struct ng_query **query);

// Starts a loop; ng_query_next moves to its next chunk and is false at the end. From begin to end the world
// puts structural changes off. A loop left early (break, return) must call ng_query_stop.
struct ng_query_iter ng_query_begin(struct ng_query *query);
// The same, over chunks in which a READ term changed after tick `since`; ask ng_query_row_changed for each
// row. Tables and chunks without a change cost one comparison a term.
struct ng_query_iter ng_query_begin_changed(struct ng_query *query, uint32_t since);
bool ng_query_next(struct ng_query_iter *it);
void ng_query_stop(struct ng_query_iter *it);

#define ng_query_each(it_, query_)                                                                           \
    for (struct ng_query_iter it_ = ng_query_begin(query_); ng_query_next(&it_);)
#define ng_query_each_changed(it_, query_, since_)                                                           \
    for (struct ng_query_iter it_ = ng_query_begin_changed(query_, since_); ng_query_next(&it_);)

// Whether a READ term of this row changed after the loop's `since`.
bool ng_query_row_changed(const struct ng_query_iter *it, uint32_t row);

// Says that the loop changed a row, or all rows, of WRITE term `term`. Such changes have ticks, but make no
// event and are not recorded by a transaction: loops compute, people edit.
static inline void ng_query_mark(struct ng_query_iter *it, uint32_t term, uint32_t row)
{
    if (it->marks[term]) // null where an optional term is missing
        it->marks[term][row] = *it->high[term] = *it->tick;
}
void ng_query_mark_all(struct ng_query_iter *it, uint32_t term);

// Entities that match now.
uint64_t ng_query_count(const struct ng_query *query);

// Calls `fn` once a chunk, on all workers of a pool (null: in place), and returns when all are done. `fn` may
// get any value, and write and mark rows of its own chunk; it must not change structure, edit or begin a
// loop.
typedef void (*ng_query_fn)(void *user, struct ng_query_iter *chunk, uint32_t worker);
void ng_query_run_parallel(struct ng_query *query, struct ng_jobs *jobs, ng_query_fn fn, void *user);

NG_EXTERN_C_END

#endif

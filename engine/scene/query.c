// Queries: a list of matching tables, and loops over their chunks.
#include "scene/world_internal.h"

#include "base/jobs.h"

#include <stdlib.h>

struct ng_match {
    struct ng_table *table;
    uint32_t columns[NG_QUERY_MAX_TERMS]; // NG_NONE: the table has no such column, or the term wants none
    uint32_t first_chunk;                 // among all chunks of the query, while it runs in parallel
};

struct ng_query {
    struct ng_world *world;
    struct ng_query_desc desc;
    uint64_t with, without; // sets of components
    uint32_t read, write;   // sets of terms
    NG_ARRAY(struct ng_match) matches;
};

// ---- matching --------------------------------------------------------------------------------------------
static bool matches(const struct ng_query *query, uint64_t set)
{
    return (set & query->with) == query->with && !(set & query->without);
}

// Room for the match must have been reserved.
static void add_match(struct ng_query *query, struct ng_table *table)
{
    struct ng_match match = {.table = table};
    for (uint32_t t = 0; t < query->desc.term_count; t++) {
        ng_component component = query->desc.terms[t].component;
        bool column = (query->read | query->write) & 1u << t && table->set & ng_bit(component);
        match.columns[t] = column ? ng_table_column(table, component) : NG_NONE;
    }
    query->matches.items[query->matches.count++] = match;
}

bool ng_queries_add_table(struct ng_world *world, struct ng_table *table)
{
    for (size_t i = 0; i < world->queries.count; i++)
        if (!ng_array_reserve(&world->queries.items[i]->matches, world->queries.items[i]->matches.count + 1))
            return false;
    for (size_t i = 0; i < world->queries.count; i++)
        if (matches(world->queries.items[i], table->set))
            add_match(world->queries.items[i], table);
    return true;
}

static void add_term(struct ng_query *query, uint32_t t)
{
    const struct ng_term *term = &query->desc.terms[t];
    if (term->kind == NG_TERM_WITHOUT)
        query->without |= ng_bit(term->component);
    else if (!term->optional)
        query->with |= ng_bit(term->component);
    if (term->kind == NG_TERM_READ)
        query->read |= 1u << t;
    if (term->kind == NG_TERM_WRITE)
        query->write |= 1u << t;
}

ng_result ng_query_create(struct ng_world *world, const struct ng_query_desc *desc, struct ng_query **out)
{
    *out = NULL;
    NG_REQUIRE(desc->term_count <= NG_QUERY_MAX_TERMS, "a query has at most %d terms", NG_QUERY_MAX_TERMS);
    for (uint32_t t = 0; t < desc->term_count; t++)
        NG_REQUIRE(desc->terms[t].component < world->component_count, "component %u is not registered",
                   desc->terms[t].component);
    struct ng_query *query = calloc(1, sizeof *query);
    if (!query || !ng_array_reserve(&query->matches, world->tables.count) ||
        !ng_array_push(&world->queries, query)) {
        if (query)
            ng_array_finish(&query->matches);
        free(query);
        return ng_out_of_memory("a query");
    }
    query->world = world;
    query->desc = *desc;
    for (uint32_t t = 0; t < desc->term_count; t++)
        add_term(query, t);
    for (size_t i = 0; i < world->tables.count; i++)
        if (matches(query, world->tables.items[i]->set))
            add_match(query, world->tables.items[i]);
    *out = query;
    return NG_OK;
}

void ng_query_destroy(struct ng_query **query_)
{
    struct ng_query *query = *query_;
    *query_ = NULL;
    if (!query)
        return;
    struct ng_world *world = query->world;
    for (size_t i = 0; i < world->queries.count; i++)
        if (world->queries.items[i] == query) {
            ng_array_swap_remove(&world->queries, i);
            break;
        }
    ng_array_finish(&query->matches);
    free(query);
}

void ng_queries_finish(struct ng_world *world)
{
    for (size_t i = 0; i < world->queries.count; i++) {
        ng_array_finish(&world->queries.items[i]->matches);
        free(world->queries.items[i]);
    }
    ng_array_finish(&world->queries);
}

uint64_t ng_query_count(const struct ng_query *query)
{
    uint64_t count = 0;
    for (size_t i = 0; i < query->matches.count; i++)
        count += query->matches.items[i].table->count;
    return count;
}

// ---- loops -----------------------------------------------------------------------------------------------
struct ng_query_iter ng_query_begin_changed(struct ng_query *query, uint32_t since)
{
    struct ng_world *world = query->world;
    ng_world_lock(world);
    if (query->write)
        ng_world_use_tick(world);
    return (struct ng_query_iter){.world = world, .query = query, .since = since, .tick = &world->tick};
}

struct ng_query_iter ng_query_begin(struct ng_query *query)
{
    return ng_query_begin_changed(query, 0); // ticks begin at 1: everything has changed since 0
}

static bool table_changed(const struct ng_query *query, const struct ng_match *match, uint32_t since)
{
    for (uint32_t t = 0; t < query->desc.term_count; t++)
        if (query->read & 1u << t && match->columns[t] != NG_NONE &&
            match->table->columns[match->columns[t]].high > since)
            return true;
    return since == 0;
}

static bool chunk_changed(const struct ng_query *query, const struct ng_match *match, uint32_t chunk,
                          uint32_t since)
{
    for (uint32_t t = 0; t < query->desc.term_count; t++)
        if (query->read & 1u << t && match->columns[t] != NG_NONE &&
            match->table->chunks.items[chunk].columns[match->columns[t]].high > since)
            return true;
    return since == 0;
}

static void load_chunk(struct ng_query_iter *it, const struct ng_match *match, uint32_t chunk)
{
    struct ng_chunk *from = &match->table->chunks.items[chunk];
    it->count = ng_chunk_rows(match->table, chunk);
    it->entities = from->entities;
    for (uint32_t t = 0; t < it->query->desc.term_count; t++) {
        uint32_t c = match->columns[t];
        struct ng_column *column = c != NG_NONE ? &from->columns[c] : NULL;
        it->columns[t] = column && match->table->columns[c].size ? column->values : NULL;
        it->ticks[t] = column ? column->ticks : NULL;
        bool write = column && it->query->write & 1u << t;
        it->marks[t] = write ? column->ticks : NULL;
        it->high[t] = write ? &column->high : NULL;
    }
}

// What was marked in a chunk counts for its table too. Not done by the mark itself: chunks belong to one
// worker each, tables to several.
static void fold_marks(const struct ng_query *query, const struct ng_match *match, uint32_t chunk)
{
    for (uint32_t t = 0; t < query->desc.term_count; t++) {
        if (!(query->write & 1u << t) || match->columns[t] == NG_NONE)
            continue;
        uint32_t high = match->table->chunks.items[chunk].columns[match->columns[t]].high;
        struct ng_table_column *column = &match->table->columns[match->columns[t]];
        if (column->high < high)
            column->high = high;
    }
}

// The chunk that the loop is at, if it is at one, is done with.
static void leave_chunk(struct ng_query_iter *it)
{
    if (it->chunk)
        fold_marks(it->query, &it->query->matches.items[it->match], it->chunk - 1);
}

bool ng_query_next(struct ng_query_iter *it)
{
    struct ng_query *query = it->query;
    leave_chunk(it);
    for (; it->match < query->matches.count; it->match++, it->chunk = 0) {
        const struct ng_match *match = &query->matches.items[it->match];
        if (!it->chunk && !table_changed(query, match, it->since))
            continue;
        for (uint32_t count = ng_table_chunk_count(match->table); it->chunk < count;) {
            uint32_t chunk = it->chunk++;
            if (!chunk_changed(query, match, chunk, it->since))
                continue;
            load_chunk(it, match, chunk);
            return true;
        }
    }
    it->chunk = 0;
    ng_world_unlock(it->world);
    return false;
}

void ng_query_stop(struct ng_query_iter *it)
{
    leave_chunk(it);
    ng_world_unlock(it->world);
}

bool ng_query_row_changed(const struct ng_query_iter *it, uint32_t row)
{
    for (uint32_t t = 0; t < it->query->desc.term_count; t++)
        if (it->query->read & 1u << t && it->ticks[t] && it->ticks[t][row] > it->since)
            return true;
    return it->since == 0;
}

void ng_query_mark_all(struct ng_query_iter *it, uint32_t term)
{
    uint32_t *marks = it->marks[term], tick = *it->tick, count = it->count;
    if (!marks)
        return; // optional, and missing here
    for (uint32_t row = 0; row < count; row++)
        marks[row] = tick;
    *it->high[term] = tick;
}

// ---- on all cores ----------------------------------------------------------------------------------------
struct parallel {
    struct ng_query *query;
    ng_query_fn fn;
    void *user;
};

// The match that has the query's chunk number `chunk`.
static uint32_t match_of_chunk(const struct ng_query *query, uint32_t chunk)
{
    uint32_t low = 0, high = (uint32_t)query->matches.count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (query->matches.items[middle].first_chunk <= chunk)
            low = middle;
        else
            high = middle;
    }
    return low;
}

static void run_chunks(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    const struct parallel *p = user;
    for (uint32_t i = begin; i < end; i++) {
        struct ng_query_iter it = {
            .world = p->query->world, .query = p->query, .tick = &p->query->world->tick};
        it.match = match_of_chunk(p->query, i);
        const struct ng_match *match = &p->query->matches.items[it.match];
        load_chunk(&it, match, i - match->first_chunk);
        p->fn(p->user, &it, worker);
    }
}

void ng_query_run_parallel(struct ng_query *query, struct ng_jobs *jobs, ng_query_fn fn, void *user)
{
    struct ng_world *world = query->world;
    NG_REQUIRE_OR(!world->parallel, , "ng_query_run_parallel cannot be called from inside itself");
    uint32_t chunks = 0;
    for (size_t i = 0; i < query->matches.count; i++) {
        query->matches.items[i].first_chunk = chunks;
        chunks += ng_table_chunk_count(query->matches.items[i].table);
    }
    if (query->write)
        ng_world_use_tick(world);
    world->parallel = true;
    ng_jobs_for(jobs, chunks, 1, run_chunks, &(struct parallel){query, fn, user});
    world->parallel = false;
    for (size_t i = 0; i < query->matches.count; i++)
        for (uint32_t c = 0; c < ng_table_chunk_count(query->matches.items[i].table); c++)
            fold_marks(query, &query->matches.items[i], c);
}

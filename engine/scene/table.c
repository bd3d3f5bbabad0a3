// Tables: all entities with one set of components, each component in a column of its own.
//
// Chunks keep the cost of growing and the spare room small, give jobs their portions, and carry a high-water
// mark of ticks, so that a search for changes passes over 4096 rows with one comparison.
#include "scene/world_internal.h"

#include "base/hash.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#define FIRST_ROWS 16
#define ALIGN      64 // a cache line: columns start where vector loads like it

static size_t aligned(size_t size)
{
    return (size + ALIGN - 1) & ~(size_t)(ALIGN - 1);
}

// Bytes of a chunk's parts; the order in memory is columns, ids, then per column ticks and values.
static size_t head_size(const struct ng_table *table)
{
    return aligned(table->column_count * sizeof(struct ng_column));
}

static size_t chunk_size(const struct ng_table *table, uint32_t rows)
{
    size_t size = head_size(table) + aligned(rows * sizeof(ng_entity));
    for (uint32_t c = 0; c < table->column_count; c++)
        size += aligned(rows * sizeof(uint32_t)) + aligned((size_t)rows * table->columns[c].size);
    return size;
}

static bool chunk_init(struct ng_chunk *chunk, const struct ng_table *table, uint32_t rows)
{
    unsigned char *p = aligned_alloc(ALIGN, chunk_size(table, rows));
    if (!p)
        return false;
    *chunk = (struct ng_chunk){.capacity = rows, .columns = (void *)p};
    p += head_size(table);
    chunk->entities = (void *)p;
    p += aligned(rows * sizeof(ng_entity));
    for (uint32_t c = 0; c < table->column_count; c++) {
        chunk->columns[c] = (struct ng_column){.ticks = (void *)p};
        p += aligned(rows * sizeof(uint32_t));
        chunk->columns[c].values = p;
        p += aligned((size_t)rows * table->columns[c].size);
    }
    return true;
}

// A larger copy of a table's first chunk.
static bool chunk_grow(struct ng_chunk *chunk, const struct ng_table *table)
{
    struct ng_chunk old = *chunk;
    if (!chunk_init(chunk, table, old.capacity * 4)) {
        *chunk = old;
        return false;
    }
    memcpy(chunk->entities, old.entities, old.capacity * sizeof(ng_entity));
    for (uint32_t c = 0; c < table->column_count; c++) {
        const struct ng_column *from = &old.columns[c];
        memcpy(chunk->columns[c].ticks, from->ticks, old.capacity * sizeof(uint32_t));
        memcpy(chunk->columns[c].values, from->values, (size_t)old.capacity * table->columns[c].size);
        chunk->columns[c].high = from->high;
    }
    free(old.columns);
    return true;
}

static struct ng_table *table_create(const struct ng_world *world, uint64_t set)
{
    uint32_t columns = (uint32_t)__builtin_popcountll(set);
    struct ng_table *table = calloc(1, sizeof *table + columns * sizeof(struct ng_table_column));
    if (!table)
        return NULL;
    table->set = set;
    for (; set; set &= set - 1) {
        ng_component component = (ng_component)__builtin_ctzll(set);
        table->columns[table->column_count++] = (struct ng_table_column){
            .component = component,
            .size = world->components[component].desc->size,
        };
    }
    return table;
}

void ng_table_destroy(struct ng_table *table)
{
    for (size_t i = 0; i < table->chunks.count; i++)
        free(table->chunks.items[i].columns);
    ng_array_finish(&table->chunks);
    free(table);
}

// The place of a set in the hash table: where it is, or the empty place where it would go.
static uint32_t *place_of_set(const struct ng_world *world, uint64_t set)
{
    uint32_t mask = world->table_by_set.capacity - 1;
    uint32_t i = (uint32_t)ng_hash_u64(set) & mask;
    uint32_t *places = world->table_by_set.tables;
    while (places[i] != NG_NONE && world->tables.items[places[i]]->set != set)
        i = (i + 1) & mask;
    return &places[i];
}

static bool grow_table_by_set(struct ng_world *world)
{
    uint32_t capacity = world->table_by_set.capacity ? world->table_by_set.capacity * 2 : 64;
    uint32_t *places = malloc(capacity * sizeof *places);
    if (!places)
        return false;
    memset(places, 0xff, capacity * sizeof *places); // NG_NONE
    free(world->table_by_set.tables);
    world->table_by_set.tables = places;
    world->table_by_set.capacity = capacity;
    for (uint32_t i = 0; i < world->tables.count; i++)
        *place_of_set(world, world->tables.items[i]->set) = i;
    return true;
}

struct ng_table *ng_table_get(struct ng_world *world, uint64_t set)
{
    if (world->tables.count * 2 >= world->table_by_set.capacity && !grow_table_by_set(world))
        return NULL;
    uint32_t *place = place_of_set(world, set);
    if (*place != NG_NONE)
        return world->tables.items[*place];
    if (!ng_array_reserve(&world->tables, world->tables.count + 1))
        return NULL;
    struct ng_table *table = table_create(world, set);
    if (!table)
        return NULL;
    if (!ng_queries_add_table(world, table)) {
        ng_table_destroy(table);
        return NULL;
    }
    table->index = *place = (uint32_t)world->tables.count;
    world->tables.items[world->tables.count++] = table;
    return table;
}

static struct ng_chunk *chunk_of(const struct ng_table *table, uint32_t row)
{
    return &table->chunks.items[row / NG_CHUNK_ROWS];
}

static bool make_room(struct ng_table *table)
{
    size_t chunk = table->count / NG_CHUNK_ROWS;
    if (chunk == table->chunks.count) {
        struct ng_chunk fresh;
        if (!ng_array_reserve(&table->chunks, chunk + 1) ||
            !chunk_init(&fresh, table, chunk ? NG_CHUNK_ROWS : FIRST_ROWS))
            return false;
        table->chunks.items[table->chunks.count++] = fresh;
    }
    struct ng_chunk *last = &table->chunks.items[chunk];
    return table->count % NG_CHUNK_ROWS < last->capacity || chunk_grow(last, table);
}

bool ng_table_append(struct ng_table *table, ng_entity e)
{
    if (!make_room(table))
        return false;
    uint32_t row = table->count++;
    chunk_of(table, row)->entities[row % NG_CHUNK_ROWS] = e;
    return true;
}

ng_entity ng_table_remove(struct ng_table *table, uint32_t row)
{
    assert(row < table->count);
    uint32_t last = table->count - 1;
    ng_entity moved = {0};
    if (row != last) {
        moved = chunk_of(table, last)->entities[last % NG_CHUNK_ROWS];
        ng_table_copy_row(table, row, table, last);
        chunk_of(table, row)->entities[row % NG_CHUNK_ROWS] = moved;
    }
    table->count = last;
    // One empty chunk stays, so that adding and removing at a boundary does not allocate each time.
    while (table->chunks.count > ng_table_chunk_count(table) + 1u)
        free(table->chunks.items[--table->chunks.count].columns);
    return moved;
}

void *ng_table_value(const struct ng_table *table, uint32_t row, uint32_t column)
{
    return chunk_of(table, row)->columns[column].values +
           (size_t)(row % NG_CHUNK_ROWS) * table->columns[column].size;
}

uint32_t ng_table_tick(const struct ng_table *table, uint32_t row, uint32_t column)
{
    return chunk_of(table, row)->columns[column].ticks[row % NG_CHUNK_ROWS];
}

void ng_table_set_tick(struct ng_table *table, uint32_t row, uint32_t column, uint32_t tick)
{
    struct ng_column *c = &chunk_of(table, row)->columns[column];
    c->ticks[row % NG_CHUNK_ROWS] = tick;
    if (c->high < tick)
        c->high = tick;
    if (table->columns[column].high < tick)
        table->columns[column].high = tick;
}

void ng_table_copy_row(struct ng_table *to, uint32_t to_row, const struct ng_table *from, uint32_t from_row)
{
    for (uint64_t both = to->set & from->set; both; both &= both - 1) {
        ng_component component = (ng_component)__builtin_ctzll(both);
        uint32_t a = ng_table_column(to, component), b = ng_table_column(from, component);
        memcpy(ng_table_value(to, to_row, a), ng_table_value(from, from_row, b), to->columns[a].size);
        ng_table_set_tick(to, to_row, a, ng_table_tick(from, from_row, b));
    }
}

void ng_table_memory(const struct ng_table *table, struct ng_world_memory *sum)
{
    sum->bookkeeping += sizeof *table + table->column_count * sizeof(struct ng_table_column) +
                        table->chunks.capacity * sizeof(struct ng_chunk);
    for (size_t i = 0; i < table->chunks.count; i++) {
        uint32_t rows = table->chunks.items[i].capacity;
        size_t values = 0;
        for (uint32_t c = 0; c < table->column_count; c++)
            values += (size_t)rows * table->columns[c].size;
        sum->values += values;
        sum->bookkeeping += chunk_size(table, rows) - values;
    }
}

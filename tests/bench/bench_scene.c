// What the ECS costs, as ratios within one run:
//   iterate      a query over two components, against the same loop over hand-written arrays (target 1.1)
//   unchanged    asking 100,000 rows what changed when nothing did, against iterating them (target 0.01)
//   bookkeeping  bytes an entity of two components, everything but its values (target 64)
//
// `marked` is `iterate` with a change tick written for every row. The two sides of a ratio are timed in
// turns, so that what else the machine does meets both. Argument: entities to iterate (1,000,000). Prints
// JSON.
#include "base/result.h"
#include "base/system.h"
#include "scene/query.h"

#include <stdio.h>
#include <stdlib.h>

#define PAIRS 101
#define ROWS  100000

struct position {
    float x, y, z;
};
struct velocity {
    float x, y, z;
};
enum { POSITION, VELOCITY };

static const struct ng_component_desc descs[] = {
    {.name = "position", .size = sizeof(struct position), .align = 4},
    {.name = "velocity", .size = sizeof(struct velocity), .align = 4},
};

struct bench {
    struct ng_world *world;
    struct ng_query *move, *moved;
    struct position *positions; // the same by hand
    struct velocity *velocities;
    uint32_t count;
};

static ng_result bench_init(struct bench *b, uint32_t count)
{
    const struct ng_query_desc move = {.terms = {NG_READ(VELOCITY), NG_WRITE(POSITION)}, .term_count = 2};
    const struct ng_query_desc moved = {.terms = {NG_READ(VELOCITY), NG_READ(POSITION)}, .term_count = 2};
    ng_component id;
    *b = (struct bench){.count = count};
    NG_TRY(ng_world_create(NULL, &b->world));
    for (size_t i = 0; i < NG_COUNT(descs); i++)
        NG_TRY(ng_world_register(b->world, &descs[i], &id));
    NG_TRY(ng_query_create(b->world, &move, &b->move));
    NG_TRY(ng_query_create(b->world, &moved, &b->moved));
    b->positions = calloc(count, sizeof *b->positions);
    b->velocities = calloc(count, sizeof *b->velocities);
    if (!b->positions || !b->velocities)
        return NG_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; i++) {
        b->velocities[i] = (struct velocity){(float)i, 1, 2};
        ng_entity e = ng_entity_create(b->world);
        NG_TRY(ng_world_add(b->world, e, POSITION, NULL));
        NG_TRY(ng_world_add(b->world, e, VELOCITY, &b->velocities[i]));
    }
    return NG_OK;
}

static void bench_finish(struct bench *b)
{
    ng_world_destroy(&b->world);
    free(b->positions);
    free(b->velocities);
}

// The loop that both sides run; never inlined, so that both run the same machine code.
__attribute__((noinline)) static void advance(struct position *restrict p, const struct velocity *restrict v,
                                              uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        p[i].x += v[i].x * 0.01f;
        p[i].y += v[i].y * 0.01f;
        p[i].z += v[i].z * 0.01f;
    }
}

static void by_hand(struct bench *b)
{
    advance(b->positions, b->velocities, b->count);
}

static void by_query(struct bench *b)
{
    ng_query_each (it, b->move)
        advance(it.columns[1], it.columns[0], it.count);
}

static void by_query_marked(struct bench *b)
{
    ng_query_each (it, b->move) {
        advance(it.columns[1], it.columns[0], it.count);
        ng_query_mark_all(&it, 1);
    }
}

// Keeps a result that is otherwise unused.
static volatile uint32_t sink;

static void ask_what_changed(struct bench *b)
{
    uint32_t since = ng_world_stamp(b->world), changed = 0;
    ng_query_each_changed(it, b->moved, since) for (uint32_t row = 0; row < it.count; row++) changed +=
        ng_query_row_changed(&it, row);
    sink = changed;
}

static uint64_t time_of(struct bench *b, void (*f)(struct bench *))
{
    uint64_t start = ng_clock_ns();
    f(b);
    return ng_clock_ns() - start;
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Time of f over time of g: the median of many pairs, in which each goes first as often as the other.
static double ratio(struct bench *b, void (*f)(struct bench *), void (*g)(struct bench *))
{
    double ratios[PAIRS];
    for (int i = 0; i < PAIRS; i++) {
        uint64_t first = time_of(b, i % 2 ? f : g), second = time_of(b, i % 2 ? g : f);
        double above = (double)(i % 2 ? first : second), below = (double)(i % 2 ? second : first);
        ratios[i] = above / (below > 0 ? below : 1);
    }
    qsort(ratios, PAIRS, sizeof ratios[0], by_value);
    return ratios[PAIRS / 2];
}

static ng_result run(uint32_t count)
{
    struct bench large, rows = {0};
    ng_result r = bench_init(&large, count);
    if (r == NG_OK)
        r = bench_init(&rows, count < ROWS ? count : ROWS);
    if (r == NG_OK) {
        struct ng_world_memory memory = ng_world_memory(large.world);
        printf("{\"entities\": %u, \"ratios\": {\"iterate\": %.3f, \"marked\": %.3f, \"unchanged\": %.5f}, "
               "\"bookkeeping_bytes\": %.1f}\n",
               count, ratio(&large, by_query, by_hand), ratio(&large, by_query_marked, by_hand),
               ratio(&rows, ask_what_changed, by_query), (double)memory.bookkeeping / count);
    }
    bench_finish(&large);
    bench_finish(&rows);
    return r;
}

int main(int argc, char **argv)
{
    unsigned long count = argc > 1 ? strtoul(argv[1], NULL, 10) : 1000000;
    if (count < 1 || count > 100000000 || argc > 2) {
        fprintf(stderr, "usage: bench_scene [ENTITIES]   (1 to 100000000)\n");
        return 2;
    }
    return run((uint32_t)count) == NG_OK ? 0 : 1;
}

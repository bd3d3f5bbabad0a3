// What the ECS costs, as ratios within one run:
//   iterate      a query over two components, against the same loop over hand-written arrays (target 1.1)
//   unchanged    asking 100,000 rows what changed when nothing did, against iterating them (target 0.01)
//   bookkeeping  bytes an entity of two components, everything but its values (target 64)
//
// The two sides of a ratio alternate, and the ratio is that of their medians: what else the machine does
// meets both. Argument: entities to iterate (1,000,000). Prints JSON.
#include "base/result.h"
#include "base/system.h"
#include "scene/query.h"

#include <stdio.h>
#include <stdlib.h>

#define REPETITIONS 41
#define MIDDLE      (REPETITIONS / 2)
#define ROWS        100000

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

// Keeps a result that is otherwise unused.
static volatile uint32_t sink;

static void ask_what_changed(struct bench *b)
{
    uint32_t since = ng_world_stamp(b->world), changed = 0;
    ng_query_each_changed(it, b->moved, since) for (uint32_t row = 0; row < it.count; row++) changed +=
        ng_query_row_changed(&it, row);
    sink = changed;
}

static int by_value(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

// Median time of f over that of g.
static double ratio(struct bench *b, void (*f)(struct bench *), void (*g)(struct bench *))
{
    void (*const sides[2])(struct bench *) = {f, g};
    uint64_t ns[2][REPETITIONS];
    for (int i = 0; i < REPETITIONS; i++)
        for (int k = 0; k < 2; k++) {
            int side = (i + k) % 2; // each goes first as often as the other
            uint64_t start = ng_clock_ns();
            sides[side](b);
            ns[side][i] = ng_clock_ns() - start;
        }
    for (int side = 0; side < 2; side++)
        qsort(ns[side], REPETITIONS, sizeof ns[side][0], by_value);
    uint64_t above = ns[0][MIDDLE], below = ns[1][MIDDLE];
    return (double)above / (double)(below ? below : 1);
}

static ng_result run(uint32_t count)
{
    struct bench large, rows = {0};
    ng_result r = bench_init(&large, count);
    if (r == NG_OK)
        r = bench_init(&rows, count < ROWS ? count : ROWS);
    if (r == NG_OK) {
        struct ng_world_memory memory = ng_world_memory(large.world);
        printf("{\"entities\": %u, \"ratios\": {\"iterate\": %.3f, \"unchanged\": %.5f}, "
               "\"bookkeeping_bytes\": %.1f}\n",
               count, ratio(&large, by_query, by_hand), ratio(&rows, ask_what_changed, by_query),
               (double)memory.bookkeeping / count);
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

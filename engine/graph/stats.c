// Figures of passes by name, over all frames. Names found by a hash table that only grows.
#include "graph/graph_internal.h"

#include "base/hash.h"
#include "gpu/device.h"
#include "gpu/timer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Slots of the table: index + 1 into stats, 0 empty; a power of two, at most half full.
static bool grow_table(struct ng_graph *g)
{
    size_t size = g->stat_slots.count ? g->stat_slots.count * 2 : 64;
    g->stat_slots.count = 0;
    if (!ng_array_resize(&g->stat_slots, size))
        return false;
    for (size_t i = 0; i < g->stats.count; i++) {
        size_t k = g->stats.items[i].hash & (size - 1);
        while (g->stat_slots.items[k])
            k = (k + 1) & (size - 1);
        g->stat_slots.items[k] = (uint32_t)i + 1;
    }
    return true;
}

// Timers cut names, so these are compared up to what a timer keeps.
#define NAME_LENGTH (sizeof((struct ng_gpu_timing *)0)->name - 1)

// The entry of a name; where there is none, a new one if `add`, else null.
static struct ng_pass_stats *lookup(struct ng_graph *g, const char *name, bool add)
{
    size_t length = strlen(name);
    length = length < NAME_LENGTH ? length : NAME_LENGTH;
    uint64_t hash = ng_hash_bytes(0, name, length);
    if (g->stats.count * 2 >= g->stat_slots.count && !grow_table(g))
        return NULL;
    size_t mask = g->stat_slots.count - 1, k = hash & mask;
    for (; g->stat_slots.items[k]; k = (k + 1) & mask) {
        struct pass_stat *s = &g->stats.items[g->stat_slots.items[k] - 1];
        if (s->hash == hash && !strncmp(s->name, name, NAME_LENGTH))
            return &s->stats;
    }
    char *copy = add ? calloc(1, length + 1) : NULL;
    if (!copy || !ng_array_push(&g->stats, (struct pass_stat){.name = copy, .hash = hash})) {
        free(copy);
        return NULL;
    }
    snprintf(copy, length + 1, "%s", name);
    g->stat_slots.items[k] = (uint32_t)g->stats.count;
    struct ng_pass_stats *stats = &g->stats.items[g->stats.count - 1].stats;
    stats->name = copy;
    return stats;
}

struct ng_pass_stats *graph_stat(struct ng_graph *g, const char *name)
{
    return lookup(g, name, true);
}

// The device's timers hold scopes of others, too.
void graph_read_timers(struct ng_graph *g)
{
    uint32_t count = 0;
    const struct ng_gpu_timing *timings = g->params.gpu ? ng_gpu_timings(g->params.gpu, &count) : NULL;
    for (uint32_t i = 0; i < count; i++) {
        struct ng_pass_stats *s = lookup(g, timings[i].name, false);
        if (s)
            s->gpu_ms = timings[i].gpu_ms;
    }
}

void graph_count_skipped(struct ng_graph *g)
{
    for (uint32_t i = 0; i < g->plan.pass_count; i++) {
        struct ng_pass_stats *s =
            g->plan.passes[i].step == NG_PLAN_NONE ? graph_stat(g, g->plan.passes[i].name) : NULL;
        if (s)
            s->skipped++;
    }
}

const struct ng_pass_stats *ng_graph_stats(struct ng_graph *g, size_t *count)
{
    graph_read_timers(g);
    *count = ng_array_resize(&g->stats_view, g->stats.count) ? g->stats.count : 0;
    for (size_t i = 0; i < *count; i++)
        g->stats_view.items[i] = g->stats.items[i].stats;
    return g->stats_view.items;
}

struct ng_graph_counters ng_graph_counters(const struct ng_graph *g)
{
    struct ng_graph_counters c = {.frames = g->executed, .objects_created = g->objects_created};
    for (size_t i = 0; i < g->blocks.count; i++)
        c.transient_bytes += g->blocks.items[i].memory.size;
    for (size_t i = 0; i < g->kept.count; i++)
        c.persistent_bytes += graph_kept_bytes(&g->kept.items[i]);
    return c;
}

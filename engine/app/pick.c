#include "app/pick.h"

#include "base/log.h"
#include "graph/graph.h"
#include "render/snapshot.h"

#include <math.h>
#include <string.h>

const char *const ng_pick_resources[2] = {"gbuffer/position", "gbuffer/entity"};

static void forget(struct ng_pick *p)
{
    p->width = p->height = 0;
    p->things.count = 0;
}

static ng_result copy_pixels(struct ng_pick *p, struct ng_graph *graph)
{
    struct ng_graph_memory positions, entities;
    NG_TRY(ng_graph_readback_get(graph, ng_pick_resources[0], &positions));
    NG_TRY(ng_graph_readback_get(graph, ng_pick_resources[1], &entities));
    if (!ng_array_resize(&p->positions, positions.size / sizeof(float)) ||
        !ng_array_resize(&p->entities, entities.size / sizeof(uint32_t)))
        return ng_out_of_memory("what is under the pointer");
    memcpy(p->positions.items, positions.data, positions.size);
    memcpy(p->entities.items, entities.data, entities.size);
    p->width = positions.width;
    p->height = positions.height;
    return NG_OK;
}

static ng_result copy_things(struct ng_pick *p, const struct ng_snapshot *s)
{
    if (!ng_array_resize(&p->things, s->instance_count))
        return ng_out_of_memory("what is under the pointer");
    for (uint32_t i = 0; i < s->instance_count; i++) {
        struct ng_pick_bounds *t = &p->things.items[i];
        t->entity = ng_entity_index(s->instances[i].entity);
        memcpy(t->low, s->instances[i].bounds_min, sizeof t->low);
        memcpy(t->high, s->instances[i].bounds_max, sizeof t->high);
    }
    memcpy(p->center, s->scene_center, sizeof p->center);
    p->radius = s->scene_radius;
    return NG_OK;
}

void ng_pick_remember(struct ng_pick *p, struct ng_graph *graph, const struct ng_snapshot *snapshot)
{
    if (copy_things(p, snapshot) != NG_OK || copy_pixels(p, graph) != NG_OK)
        forget(p);
}

void ng_pick_finish(struct ng_pick *p)
{
    ng_array_finish(&p->positions);
    ng_array_finish(&p->entities);
    ng_array_finish(&p->things);
    forget(p);
}

// Index of the pixel; false: outside.
static bool pixel_at(const struct ng_pick *p, float x, float y, size_t *out)
{
    if (!(x >= 0 && y >= 0 && x < (float)p->width && y < (float)p->height))
        return false;
    *out = (size_t)y * p->width + (size_t)x;
    return true;
}

bool ng_pick_point(const struct ng_pick *p, float x, float y, float world[3])
{
    size_t pixel;
    if (!pixel_at(p, x, y, &pixel) || p->positions.items[pixel * 4 + 3] == 0)
        return false;
    memcpy(world, &p->positions.items[pixel * 4], 3 * sizeof *world);
    return true;
}

bool ng_pick_thing(const struct ng_pick *p, float x, float y, float center[3], float *radius)
{
    size_t pixel;
    if (!pixel_at(p, x, y, &pixel))
        return false;
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, sum = 0;
    for (size_t i = 0; i < p->things.count; i++) { // a thing of several materials has several instances
        const struct ng_pick_bounds *t = &p->things.items[i];
        for (int k = 0; k < 3 && t->entity == p->entities.items[pixel]; k++) {
            low[k] = fminf(low[k], t->low[k]);
            high[k] = fmaxf(high[k], t->high[k]);
        }
    }
    for (int k = 0; k < 3; k++) {
        center[k] = (low[k] + high[k]) / 2;
        sum += (high[k] - low[k]) * (high[k] - low[k]) / 4;
    }
    *radius = sqrtf(sum);
    return low[0] <= high[0];
}

#include "bench_scene.h"

#include "base/array.h"
#include "base/log.h"
#include "components/components.h"
#include "components/mesh.h"
#include "components/subdivision.h"
#include "components/transform.h"
#include "light/light.h"
#include "scene/world.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define LIGHT_STEP 0.04f // metres between copies of a light

struct entities {
    NG_ARRAY(ng_entity) list;
};

static bool is_light(const struct ng_world *world, ng_entity e)
{
    for (uint32_t i = 0; ng_light_types[i]; i++)
        if (ng_world_has(world, e, ng_light_types[i]->component))
            return true;
    return false;
}

static bool is_piece(const struct ng_world *world, ng_entity e)
{
    return ng_world_has(world, e, NG_SUBDIVISION) && ng_world_has(world, e, NG_MESH) &&
           ng_world_has(world, e, NG_TRANSFORM);
}

// Depth first: the order of the scene's file.
static ng_result find(const struct ng_world *world, bool (*wanted)(const struct ng_world *, ng_entity),
                      struct entities *out)
{
    const ng_entity root = {0};
    for (ng_entity e = ng_world_first_child(world, root); !ng_entity_is_null(e);
         e = ng_world_next_below(world, root, e))
        if (wanted(world, e) && !ng_array_push(&out->list, e))
            return ng_out_of_memory("the scene of a benchmark");
    return NG_OK;
}

// A sibling with the same components, of which an animation knows nothing.
static ng_result copy_entity(struct ng_world *world, ng_entity from, ng_entity *out)
{
    uint64_t set = ng_world_components(world, from);
    *out = ng_entity_create(world);
    for (ng_component c = 0; c < ng_world_component_count(world); c++) {
        if (!(set >> c & 1) || (ng_world_component(world, c)->flags & NG_COMPONENT_DERIVED))
            continue;
        NG_TRY(ng_world_add(world, *out, c, NULL));
        const struct ng_component_desc *desc = ng_world_component(world, c);
        if (desc->size)
            NG_TRY(ng_world_set(world, *out, c, ng_world_get(world, from, c)));
    }
    return ng_world_set_parent(world, *out, ng_world_parent(world, from), (ng_entity){0});
}

static ng_result set_lights(struct ng_world *world, const struct entities *own, uint32_t count,
                            ng_entity *out)
{
    uint32_t there = (uint32_t)own->list.count;
    memset(out, 0, count * sizeof *out);
    for (uint32_t i = 0; i < there && i < count; i++)
        out[i] = own->list.items[i];
    for (uint32_t i = count; i < there; i++)
        NG_TRY(ng_entity_destroy(world, own->list.items[i]));
    for (uint32_t i = there; i < count && there; i++) {
        NG_TRY(copy_entity(world, own->list.items[i % there], &out[i]));
        struct ng_transform *t = ng_world_edit(world, out[i], NG_TRANSFORM);
        uint32_t round = i / there;
        if (t)
            t->translation[0] += LIGHT_STEP * (float)round;
    }
    return NG_OK;
}

ng_result bench_scene_set_lights(struct ng_world *world, uint32_t count, ng_entity *out, uint32_t *kinds)
{
    struct entities own = {0};
    ng_result result = find(world, is_light, &own);
    *kinds = own.list.count < count ? (uint32_t)own.list.count : count;
    if (result == NG_OK)
        result = set_lights(world, &own, count, out);
    ng_array_finish(&own.list);
    return result;
}

static ng_result switch_light(struct ng_world *world, ng_entity e, bool on)
{
    for (uint32_t i = 0; ng_light_types[i]; i++) {
        ng_component c = ng_light_types[i]->component;
        char path[NG_TEXT_SIZE + 8];
        if (!ng_world_has(world, e, c))
            continue;
        snprintf(path, sizeof path, "%s.on", ng_world_component(world, c)->name);
        NG_TRY(ng_world_set_field(world, e, path, NG_FIELD_BOOL, &on));
    }
    return NG_OK;
}

ng_result bench_scene_switch_lights(struct ng_world *world, const ng_entity *lights, uint32_t total,
                                    uint32_t first, uint32_t count)
{
    for (uint32_t i = 0; i < total; i++)
        NG_TRY(switch_light(world, lights[i], (i + total - first) % total < count));
    return NG_OK;
}

static uint32_t side_of(uint32_t square)
{
    uint32_t side = 1;
    while ((side + 1) * (side + 1) <= square)
        side++;
    return side;
}

// The flock is the whole set, made smaller and laid out as tiles of the space that it had.
static void place_copy(struct ng_transform *t, const struct ng_transform *from, uint32_t index, uint32_t side,
                       float extent)
{
    float shrink = 1 / (float)side, tile = 2 * extent * shrink;
    uint32_t column = index % side, row = index / side;
    *t = *from;
    for (int i = 0; i < 3; i++) {
        t->translation[i] *= shrink;
        t->scale[i] *= shrink;
    }
    t->translation[0] += tile * ((float)column + 0.5f) - extent;
    t->translation[2] += tile * ((float)row + 0.5f) - extent;
}

static float extent_of(const struct ng_world *world, const struct entities *pieces)
{
    float extent = 0;
    for (size_t i = 0; i < pieces->list.count; i++) {
        const struct ng_transform *t = ng_world_get(world, pieces->list.items[i], NG_TRANSFORM);
        for (int axis = 0; axis < 3; axis += 2)
            extent = fmaxf(extent, fabsf(t->translation[axis]));
    }
    return extent * 8 / 7; // to the edge of the outermost squares
}

static ng_result make_flock(struct ng_world *world, ng_entity piece, uint32_t copies, float extent)
{
    const struct ng_transform model = *(const struct ng_transform *)ng_world_get(world, piece, NG_TRANSFORM);
    uint32_t side = side_of(copies);
    struct ng_subdivision *s = ng_world_edit(world, piece, NG_SUBDIVISION);
    s->level = 0;
    for (uint32_t i = 0; i < side * side; i++) {
        ng_entity copy = piece;
        if (i)
            NG_TRY(copy_entity(world, piece, &copy));
        struct ng_transform t;
        place_copy(&t, &model, i, side, extent);
        NG_TRY(ng_world_set(world, copy, NG_TRANSFORM, &t));
    }
    return NG_OK;
}

ng_result bench_scene_set_copies(struct ng_world *world, uint32_t copies, uint32_t *pieces)
{
    struct entities found = {0};
    ng_result result = find(world, is_piece, &found);
    float extent = extent_of(world, &found);
    for (size_t i = 0; i < found.list.count && result == NG_OK; i++)
        result = make_flock(world, found.list.items[i], copies, extent);
    *pieces = (uint32_t)found.list.count * side_of(copies) * side_of(copies);
    ng_array_finish(&found.list);
    return result;
}

// Placements: walk the subtrees below what changed, and write what comes out different.
//
// A walk covers everything below its top, so an entity with something dirty above it needs none of its own.
// That is found by looking up the hierarchy, which ends at once where a whole subtree is dirty (its parent
// is), and costs the depth where a single entity moved.
#include "components/placement_system.h"

#include "base/array.h"
#include "base/log.h"
#include "components/components.h"
#include "components/placement.h"
#include "components/transform.h"
#include "scene/query.h"
#include "scene/system.h"

#include <cglm/cglm.h>
#include <stdlib.h>
#include <string.h>

struct placement_system {
    struct ng_query *unplaced, *orphaned, *placed;
    NG_ARRAY(ng_entity) dirty;
    uint32_t since; // everything up to this tick has been seen
};

static void keep_within(mat4 m, float most)
{
    for (int column = 0; column < 4; column++) {
        for (int row = 0; row < 3; row++)
            m[column][row] = ng_keep_within(m[column][row], most);
        m[column][3] = column == 3 ? 1.0f : 0.0f;
    }
}

static void local_matrix(const struct ng_transform *transform, mat4 out)
{
    versor rotation;
    memcpy(rotation, transform->rotation, sizeof rotation);
    glm_quat_mat4(rotation, out);
    for (int axis = 0; axis < 3; axis++)
        glm_vec4_scale(out[axis], transform->scale[axis], out[axis]);
    memcpy(out[3], transform->translation, sizeof transform->translation);
    keep_within(out, NG_TRANSFORM_MAX);
}

static void world_matrix(mat4 parent, const struct ng_transform *transform, mat4 out)
{
    local_matrix(transform, out);
    glm_mat4_mul(parent, out, out);
    keep_within(out, NG_PLACEMENT_MAX);
}

struct ng_placement ng_placement_of(const struct ng_transform *transform)
{
    struct ng_placement placement;
    mat4 matrix;
    world_matrix(GLM_MAT4_IDENTITY, transform, matrix);
    memcpy(placement.matrix, matrix, sizeof matrix);
    return placement;
}

// The matrix of the nearest ancestor that has one.
static void parent_matrix(const struct ng_world *world, ng_entity e, mat4 out)
{
    while (!ng_entity_is_null(e = ng_world_parent(world, e))) {
        const struct ng_placement *placement = ng_world_get(world, e, NG_PLACEMENT);
        if (placement) {
            memcpy(out, placement->matrix, sizeof placement->matrix);
            return;
        }
    }
    glm_mat4_identity(out);
}

static bool same_matrix(mat4 a, const float b[16])
{
    for (int i = 0; i < 16; i++)
        if (a[i / 4][i % 4] != b[i])
            return false;
    return true;
}

static void place(struct ng_world *world, ng_entity e)
{
    const struct ng_transform *transform = ng_world_get(world, e, NG_TRANSFORM);
    const struct ng_placement *placement = ng_world_get(world, e, NG_PLACEMENT);
    if (!transform || !placement)
        return;
    mat4 parent, matrix;
    parent_matrix(world, e, parent);
    world_matrix(parent, transform, matrix);
    if (!same_matrix(matrix, placement->matrix)) {
        struct ng_placement *changed = ng_world_write(world, e, NG_PLACEMENT);
        memcpy(changed->matrix, matrix, sizeof matrix);
    }
}

static bool changed(const struct placement_system *s, const struct ng_world *world, ng_entity e)
{
    return ng_world_changed_at(world, e, NG_TRANSFORM) > s->since ||
           ng_world_changed_at(world, e, NG_PLACEMENT) > s->since ||
           ng_world_parent_changed_at(world, e) > s->since;
}

static bool changed_above(const struct placement_system *s, const struct ng_world *world, ng_entity e)
{
    while (!ng_entity_is_null(e = ng_world_parent(world, e)))
        if (changed(s, world, e))
            return true;
    return false;
}

static ng_result push_dirty(struct placement_system *s, ng_entity e)
{
    return ng_array_push(&s->dirty, e) ? NG_OK : ng_out_of_memory("placements");
}

// ---- keeping transform and placement together ------------------------------------------------------------
static ng_result place_unplaced(struct placement_system *s, struct ng_world *world)
{
    ng_result r = NG_OK;
    ng_query_each (it, s->unplaced)
        for (uint32_t i = 0; i < it.count; i++) {
            ng_result added = ng_world_add(world, it.entities[i], NG_PLACEMENT, NULL);
            r = r == NG_OK ? added : r;
        }
    return r;
}

// What was below an entity that lost its transform must be placed anew.
static ng_result unplace_orphaned(struct placement_system *s, struct ng_world *world)
{
    ng_result r = NG_OK;
    ng_query_each (it, s->orphaned)
        for (uint32_t i = 0; i < it.count && r == NG_OK; i++) {
            r = ng_world_remove(world, it.entities[i], NG_PLACEMENT);
            if (r == NG_OK)
                r = push_dirty(s, it.entities[i]);
        }
    return r;
}

// ---- what changed ----------------------------------------------------------------------------------------
static ng_result find_changed(struct placement_system *s)
{
    ng_result r = NG_OK;
    ng_query_each_changed(it, s->placed, s->since) for (uint32_t i = 0; i < it.count && r == NG_OK;
                                                        i++) if (ng_query_row_changed(&it, i)) r =
        push_dirty(s, it.entities[i]);
    return r;
}

// Entities without a transform count too: they may stand between two that have one.
static ng_result find_moved(struct placement_system *s, const struct ng_world *world)
{
    const ng_entity root = {0};
    if (ng_world_parent_changed_at(world, root) <= s->since)
        return NG_OK;
    for (ng_entity e = ng_world_first_child(world, root); !ng_entity_is_null(e);
         e = ng_world_next_below(world, root, e))
        if (ng_world_parent_changed_at(world, e) > s->since)
            NG_TRY(push_dirty(s, e));
    return NG_OK;
}

static ng_result run(void *user, struct ng_world *world, double time)
{
    NG_UNUSED(time);
    struct placement_system *s = user;
    s->dirty.count = 0;
    NG_TRY(place_unplaced(s, world));
    NG_TRY(unplace_orphaned(s, world));
    NG_TRY(find_changed(s));
    NG_TRY(find_moved(s, world));
    for (size_t i = 0; i < s->dirty.count; i++) {
        ng_entity top = s->dirty.items[i];
        if (changed_above(s, world, top))
            continue;
        for (ng_entity e = top; !ng_entity_is_null(e); e = ng_world_next_below(world, top, e))
            place(world, e);
    }
    s->since = ng_world_stamp(world);
    return NG_OK;
}

// ---- life ------------------------------------------------------------------------------------------------
static void finish(void *user)
{
    struct placement_system *s = user;
    ng_query_destroy(&s->unplaced);
    ng_query_destroy(&s->orphaned);
    ng_query_destroy(&s->placed);
    ng_array_finish(&s->dirty);
    free(s);
}

static ng_result init(struct placement_system *s, struct ng_world *world)
{
    static const struct ng_query_desc unplaced = {.terms = {NG_WITH(NG_TRANSFORM), NG_WITHOUT(NG_PLACEMENT)},
                                                  .term_count = 2};
    static const struct ng_query_desc orphaned = {.terms = {NG_WITH(NG_PLACEMENT), NG_WITHOUT(NG_TRANSFORM)},
                                                  .term_count = 2};
    // Placements are read as well: one that somebody else wrote is put right.
    static const struct ng_query_desc placed = {.terms = {NG_READ(NG_TRANSFORM), NG_READ(NG_PLACEMENT)},
                                                .term_count = 2};
    NG_TRY(ng_query_create(world, &unplaced, &s->unplaced));
    NG_TRY(ng_query_create(world, &orphaned, &s->orphaned));
    NG_TRY(ng_query_create(world, &placed, &s->placed));
    return ng_world_add_system(
        world, &(struct ng_system_desc){
                   .name = "placement", .phase = NG_PHASE_PLACE, .run = run, .finish = finish, .user = s});
}

ng_result ng_placement_system_add(struct ng_world *world)
{
    struct placement_system *s = calloc(1, sizeof *s);
    if (!s)
        return ng_out_of_memory("placements");
    ng_result r = init(s, world);
    if (r != NG_OK)
        finish(s);
    return r;
}

// Pieces: one a visible mesh entity, in the order of entity indices, beside the snapshot's instances. The
// list is made anew only when entities come, go or change what they are made of; otherwise a frame costs what
// changed in it.
#include "base/log.h"
#include "components/mesh.h"
#include "components/placement.h"
#include "render/extract_internal.h"

#include <cglm/cglm.h>
#include <stdlib.h>
#include <string.h>

static const float identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

const float *ng_extract_placement(const struct ng_extractor *x, ng_entity e)
{
    const struct ng_placement *p = ng_world_get(x->world, e, NG_PLACEMENT);
    return p ? p->matrix : identity;
}

void ng_extract_rows(const float matrix[16], float rows[12])
{
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 4; column++)
            rows[row * 4 + column] = ng_keep_within(matrix[column * 4 + row], NG_PLACEMENT_MAX);
}

// The box of the moved box (Arvo 1990): each axis takes the smaller and larger product a term.
void ng_extract_bounds(struct ng_snapshot_instance *instance, const struct ng_snapshot_mesh *mesh)
{
    for (int row = 0; row < 3; row++) {
        const float *m = instance->matrix + row * 4;
        instance->bounds_min[row] = instance->bounds_max[row] = m[3];
        for (int k = 0; k < 3; k++) {
            float a = m[k] * mesh->bounds_min[k], b = m[k] * mesh->bounds_max[k];
            instance->bounds_min[row] += a < b ? a : b;
            instance->bounds_max[row] += a < b ? b : a;
        }
    }
}

static bool mirrors(const float m[16])
{
    float cross[3];
    glm_vec3_cross((float *)m, (float *)m + 4, cross);
    return glm_vec3_dot(cross, (float *)m + 8) < 0;
}

static void set_flag(struct ng_snapshot_instance *instance, uint32_t flag, bool on)
{
    instance->flags = on ? instance->flags | flag : instance->flags & ~flag;
}

void ng_extract_set_mirrored(struct ng_snapshot_instance *instance, const float matrix[16])
{
    set_flag(instance, NG_INSTANCE_MIRRORED, mirrors(matrix));
}

const struct ng_snapshot_mesh *ng_extract_piece_mesh(const struct ng_piece *piece)
{
    return piece->deformed ? &piece->deformed->mesh : &piece->shape->mesh;
}

// ---- motion ----------------------------------------------------------------------------------------------
ng_result ng_extract_touch(struct ng_extractor *x, uint32_t index)
{
    struct ng_snapshot_instance *instance = &x->instances.items[index];
    if (instance->flags & NG_INSTANCE_MOVED)
        return NG_OK;
    instance->flags |= NG_INSTANCE_MOVED;
    instance->version = ++x->clock;
    x->snapshot.geometry_version = x->clock;
    if (index < x->pieces.count) // which emitters are lamps is found later
        x->snapshot.surface_version = x->clock;
    return ng_array_push(&x->moved, index) ? NG_OK : ng_out_of_memory("the frame's scene");
}

void ng_extract_settle(struct ng_extractor *x)
{
    for (size_t i = 0; i < x->moved.count; i++) {
        uint32_t index = x->moved.items[i];
        struct ng_snapshot_instance *instance = &x->instances.items[index];
        instance->flags &= ~(uint32_t)NG_INSTANCE_MOVED;
        memcpy(instance->previous_matrix, instance->matrix, sizeof instance->matrix);
        x->mesh_array.items[instance->mesh].previous_positions = NULL;
        if (index < x->pieces.count && x->pieces.items[index].deformed)
            x->pieces.items[index].deformed->mesh.previous_positions = NULL;
    }
    x->moved.count = 0;
}

// Joints have placed its vertices.
static bool in_world_space(const struct ng_piece *piece)
{
    return piece->deformed && piece->deformed->pose;
}

// Takes a piece's placement from the world.
static ng_result place_piece(struct ng_extractor *x, uint32_t index)
{
    struct ng_snapshot_instance *instance = &x->instances.items[index];
    const float *matrix = ng_extract_placement(x, instance->entity);
    float rows[12];
    if (in_world_space(&x->pieces.items[index]))
        return NG_OK;
    ng_extract_rows(matrix, rows);
    if (ng_extract_same(rows, instance->matrix, sizeof rows))
        return NG_OK;
    memcpy(instance->matrix, rows, sizeof rows);
    ng_extract_set_mirrored(instance, matrix);
    ng_extract_bounds(instance, ng_extract_piece_mesh(&x->pieces.items[index]));
    return ng_extract_touch(x, index);
}

// ---- listing ---------------------------------------------------------------------------------------------
static int compare_pieces(const void *a, const void *b)
{
    uint32_t x = ng_entity_index(((const struct ng_piece *)a)->entity);
    uint32_t y = ng_entity_index(((const struct ng_piece *)b)->entity);
    return (x > y) - (x < y);
}

static ng_result collect_pieces(struct ng_extractor *x)
{
    x->pieces.count = 0;
    ng_query_each (it, x->meshes) {
        const struct ng_mesh *meshes = it.columns[0];
        for (uint32_t i = 0; i < it.count; i++) {
            struct ng_piece piece = {.entity = it.entities[i], .material = meshes[i].material};
            if (meshes[i].visible && !ng_array_push(&x->pieces, piece)) {
                ng_query_stop(&it);
                return ng_out_of_memory("the frame's scene");
            }
        }
    }
    if (x->pieces.count > 1)
        qsort(x->pieces.items, x->pieces.count, sizeof x->pieces.items[0], compare_pieces);
    return NG_OK;
}

// Gives every piece its shape; those without one are left out.
static ng_result shape_pieces(struct ng_extractor *x)
{
    size_t kept = 0;
    for (size_t i = 0; i < x->pieces.count; i++) {
        struct ng_piece piece = x->pieces.items[i];
        NG_TRY(ng_extract_shape(x, piece.entity, &piece.shape));
        if (!piece.shape)
            continue;
        piece.shape_key = piece.shape->mesh.key;
        piece.shape_revision = piece.shape->mesh.revision;
        x->pieces.items[kept++] = piece;
    }
    x->pieces.count = kept;
    return NG_OK;
}

// The material that a piece shows: its own, or the emitter's where a light says how bright it is: that of the
// mesh, or that of all meshes of the material.
static uint32_t shown_material(const struct ng_extractor *x, const struct ng_piece *piece, uint32_t *light)
{
    *light = ng_index_map_get(&x->mesh_light_of, piece->entity.id);
    if (*light == UINT32_MAX && ng_extract_lights_material(x, piece->material))
        *light = ng_index_map_get(&x->mesh_light_of, piece->material.id);
    if (*light == UINT32_MAX) {
        *light = NG_NONE;
        return ng_extract_material_index(x, piece->material);
    }
    return (uint32_t)x->records.count + x->slots.items[*light].emitter;
}

static void warn_emission(struct ng_extractor *x, const struct ng_piece *piece, const struct ng_material *m)
{
    char name[NG_TEXT_SIZE];
    float emission[3];
    ng_extract_emission(m, emission);
    bool emits = emission[0] > 0 || emission[1] > 0 || emission[2] > 0;
    if (emits && ng_extract_warn_once(x, piece->entity, NG_WARN_EMISSION))
        ng_log_warn(
            "mesh '%s' emits but is no light: only the reference sees its light; give it a light_mesh",
            ng_extract_name(x, piece->entity, name));
}

// Takes on what the piece's material looks like now; true if it reflects differently.
static bool show_material(struct ng_extractor *x, uint32_t index)
{
    struct ng_piece *piece = &x->pieces.items[index];
    struct ng_snapshot_instance *instance = &x->instances.items[index];
    const struct ng_material_record *record =
        &x->records.items[ng_extract_material_index(x, piece->material)];
    bool is_light = instance->light != NG_NONE;
    uint64_t reflection = is_light ? record->emitter : record->reflection;
    uint64_t emission = is_light ? 0 : record->emission;
    bool reflects = piece->reflection != reflection;
    if (piece->emission != emission)
        x->snapshot.emission_version = ++x->clock;
    piece->reflection = reflection;
    piece->emission = emission;
    set_flag(instance, NG_INSTANCE_DOUBLE_SIDED, record->value.double_sided);
    set_flag(instance, NG_INSTANCE_MASKED, ng_extract_lets_through(&record->value));
    return reflects;
}

// Fills the instance of a listed piece and marks it where it is not what it was. `old` and `was` are null for
// a new one.
static ng_result list_piece(struct ng_extractor *x, uint32_t index, struct ng_piece *old,
                            const struct ng_snapshot_instance *was)
{
    struct ng_piece *piece = &x->pieces.items[index];
    struct ng_snapshot_instance *instance = &x->instances.items[index];
    bool deformed = old && old->deformed;
    NG_TRY(ng_extract_deform_piece(x, piece, old));
    bool same_deformed = deformed ? !old->deformed : !piece->deformed;

    *instance = was ? *was : (struct ng_snapshot_instance){.entity = piece->entity};
    set_flag(instance, NG_INSTANCE_MOVED, false);
    instance->material = shown_material(x, piece, &instance->light);
    if (instance->light == NG_NONE)
        warn_emission(x, piece, &x->records.items[instance->material].value);
    if (old) {
        piece->reflection = old->reflection;
        piece->emission = old->emission;
    }
    bool same_material = !show_material(x, index);

    if (in_world_space(piece))
        ng_extract_rows(identity, instance->matrix);
    else {
        ng_extract_set_mirrored(instance,
                                ng_extract_placement(x, piece->entity)); // joints may have said else
        NG_TRY(place_piece(x, index));
    }
    ng_extract_bounds(instance, ng_extract_piece_mesh(piece));
    if (!was || !same_deformed)
        memcpy(instance->previous_matrix, instance->matrix, sizeof instance->matrix);
    bool same = was && same_deformed && same_material && old->shape_key == piece->shape_key &&
                old->shape_revision == piece->shape_revision;
    return same ? NG_OK : ng_extract_touch(x, index);
}

// Emitters follow the pieces; a light that stays keeps its instance's history.
static ng_result list_emitters(struct ng_extractor *x, size_t *stayed)
{
    uint32_t index = (uint32_t)x->pieces.count;
    for (size_t i = 0; i < x->slots.count; i++) {
        struct ng_light_slot *slot = &x->slots.items[i];
        if (slot->shape == NG_SHAPE_BUILTIN)
            continue;
        struct ng_snapshot_instance *instance = &x->instances.items[index];
        bool known = slot->instance != NG_NONE;
        *instance = known ? x->old_instances.items[slot->instance]
                          : (struct ng_snapshot_instance){.entity = slot->entity};
        set_flag(instance, NG_INSTANCE_MOVED, false);
        instance->light = (uint32_t)i;
        instance->material = (uint32_t)x->records.count + slot->emitter;
        slot->instance = index++;
        *stayed += known;
        if (!known)
            NG_TRY(ng_extract_touch(x, slot->instance));
    }
    return NG_OK;
}

static ng_result list_mesh(struct ng_extractor *x, const struct ng_snapshot_mesh *mesh, uint32_t *index)
{
    *index = (uint32_t)x->mesh_array.count;
    return ng_array_push(&x->mesh_array, *mesh) ? NG_OK : ng_out_of_memory("the frame's scene");
}

// Lists the meshes that instances show, shared ones once.
static ng_result list_meshes(struct ng_extractor *x)
{
    x->mesh_array.count = 0;
    for (size_t i = 0; i < x->shapes.count; i++)
        x->shapes.items[i]->index = NG_NONE;
    for (size_t i = 0; i < NG_SHAPE_BUILTIN; i++)
        x->builtin[i]->index = NG_NONE;
    for (uint32_t i = 0; i < x->pieces.count; i++) {
        struct ng_piece *piece = &x->pieces.items[i];
        uint32_t *index = piece->deformed ? &x->instances.items[i].mesh : &piece->shape->index;
        if (piece->deformed || *index == NG_NONE)
            NG_TRY(list_mesh(x, ng_extract_piece_mesh(piece), index));
        x->instances.items[i].mesh = *index;
    }
    for (size_t i = 0; i < x->slots.count; i++) {
        const struct ng_light_slot *slot = &x->slots.items[i];
        if (slot->shape == NG_SHAPE_BUILTIN)
            continue;
        struct ng_shape *shape = x->builtin[slot->shape];
        if (shape->index == NG_NONE)
            NG_TRY(list_mesh(x, &shape->mesh, &shape->index));
        x->instances.items[slot->instance].mesh = shape->index;
    }
    return NG_OK;
}

static size_t count_emitters(const struct ng_extractor *x)
{
    size_t count = 0;
    for (size_t i = 0; i < x->slots.count; i++)
        count += x->slots.items[i].shape != NG_SHAPE_BUILTIN;
    return count;
}

ng_result ng_extract_list_pieces(struct ng_extractor *x)
{
    NG_SWAP(x->pieces, x->old_pieces);
    NG_SWAP(x->instances, x->old_instances);
    ng_extract_mark_shapes(x);
    ng_extract_mark_poses(x);
    NG_TRY(collect_pieces(x));
    NG_TRY(shape_pieces(x));
    if (!ng_array_resize(&x->instances, x->pieces.count + count_emitters(x)))
        return ng_out_of_memory("the frame's scene");
    size_t stayed = 0, before = x->old_instances.count;
    for (uint32_t i = 0; i < x->pieces.count; i++) {
        uint32_t at = ng_index_map_get(&x->piece_of, x->pieces.items[i].entity.id);
        bool known = at != UINT32_MAX;
        stayed += known;
        NG_TRY(list_piece(x, i, known ? &x->old_pieces.items[at] : NULL,
                          known ? &x->old_instances.items[at] : NULL));
    }
    NG_TRY(list_emitters(x, &stayed));
    if (stayed != before) // something vanished
        x->snapshot.geometry_version = x->snapshot.surface_version = ++x->clock;
    for (size_t i = 0; i < x->old_pieces.count; i++)
        ng_extract_free_deformed(&x->old_pieces.items[i].deformed);
    x->old_pieces.count = x->old_instances.count = 0;
    ng_extract_sweep_shapes(x);
    ng_extract_sweep_poses(x);
    ng_index_map_clear(&x->piece_of);
    for (uint32_t i = 0; i < x->pieces.count; i++)
        if (!ng_index_map_set(&x->piece_of, x->pieces.items[i].entity.id, i))
            return ng_out_of_memory("the frame's scene");
    for (size_t i = 0; i < x->slots.count; i++)
        x->slots.items[i].looked = 0; // whose mesh is whose may be another
    return list_meshes(x);
}

// ---- following -------------------------------------------------------------------------------------------
static ng_result follow_materials(struct ng_extractor *x)
{
    for (uint32_t i = 0; i < x->pieces.count; i++)
        if (show_material(x, i))
            NG_TRY(ng_extract_touch(x, i));
    return NG_OK;
}

// Pieces whose shape has got other points. Those that deform follow when they do.
static ng_result follow_points(struct ng_extractor *x)
{
    for (uint32_t i = 0; i < x->pieces.count; i++) {
        struct ng_piece *piece = &x->pieces.items[i];
        struct ng_snapshot_instance *instance = &x->instances.items[i];
        if (piece->shape_revision == piece->shape->mesh.revision)
            continue;
        piece->shape_revision = piece->shape->mesh.revision;
        if (piece->deformed)
            continue;
        x->mesh_array.items[instance->mesh] = piece->shape->mesh;
        ng_extract_bounds(instance, &piece->shape->mesh);
        NG_TRY(ng_extract_touch(x, i));
    }
    return NG_OK;
}

ng_result ng_extract_follow_pieces(struct ng_extractor *x, bool assets_changed)
{
    if (assets_changed)
        NG_TRY(follow_points(x));
    if (x->materials_changed)
        NG_TRY(follow_materials(x));
    ng_query_each_changed(it, x->placed, x->since)
    {
        for (uint32_t i = 0; i < it.count; i++) {
            uint32_t index =
                ng_query_row_changed(&it, i) ? ng_index_map_get(&x->piece_of, it.entities[i].id) : UINT32_MAX;
            ng_result r = index == UINT32_MAX ? NG_OK : place_piece(x, index);
            if (r != NG_OK) {
                ng_query_stop(&it);
                return r;
            }
        }
    }
    return NG_OK;
}

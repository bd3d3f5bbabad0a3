// Pieces: one a visible mesh entity, in the order of entity indices, beside the snapshot's instances. The
// list is made anew only when entities come, go or change what they are made of; otherwise a frame costs what
// changed in it. A palette is read once for all pieces of its skeleton; a skinned piece is posed only if it
// differs from the one it was last posed with.
#include "base/jobs.h"
#include "base/log.h"
#include "components/mesh.h"
#include "components/placement.h"
#include "components/skin.h"
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
    return piece->skin ? &piece->skin->mesh : &piece->shape->mesh;
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
        if (index < x->pieces.count && x->pieces.items[index].skin)
            x->pieces.items[index].skin->mesh.previous_positions = NULL;
    }
    x->moved.count = 0;
}

// Takes a rigid piece's placement from the world.
static ng_result place_piece(struct ng_extractor *x, uint32_t index)
{
    struct ng_snapshot_instance *instance = &x->instances.items[index];
    const float *matrix = ng_extract_placement(x, instance->entity);
    float rows[12];
    if (x->pieces.items[index].skin)
        return NG_OK;
    ng_extract_rows(matrix, rows);
    if (ng_extract_same(rows, instance->matrix, sizeof rows))
        return NG_OK;
    memcpy(instance->matrix, rows, sizeof rows);
    ng_extract_set_mirrored(instance, matrix);
    ng_extract_bounds(instance, ng_extract_piece_mesh(&x->pieces.items[index]));
    return ng_extract_touch(x, index);
}

// ---- skins -----------------------------------------------------------------------------------------------
void ng_extract_free_skin(struct ng_skinned **skin)
{
    if (*skin)
        free((*skin)->memory);
    free(*skin);
    *skin = NULL;
}

static void free_pose(struct ng_pose *pose)
{
    free(pose->palette);
    free(pose->wanted);
    free(pose->joint_world);
    free(pose);
}

// Drops the poses that no piece follows.
static void sweep_poses(struct ng_extractor *x)
{
    size_t kept = 0;
    ng_index_map_clear(&x->pose_of);
    for (size_t i = 0; i < x->poses.count; i++) {
        struct ng_pose *pose = x->poses.items[i];
        if (!pose->used) {
            free_pose(pose);
            continue;
        }
        x->poses.items[kept] = pose;
        (void)ng_index_map_set(&x->pose_of, pose->skeleton.id, (uint32_t)kept++); // does not grow
    }
    x->poses.count = kept;
}

void ng_extract_finish_poses(struct ng_extractor *x)
{
    for (size_t i = 0; i < x->poses.count; i++)
        free_pose(x->poses.items[i]);
    ng_array_finish(&x->poses);
    ng_index_map_finish(&x->pose_of);
}

static ng_result make_pose(struct ng_extractor *x, ng_asset skeleton, uint32_t joints, struct ng_pose **out)
{
    struct ng_pose *pose = calloc(1, sizeof *pose);
    if (!pose)
        return ng_out_of_memory("the frame's scene");
    pose->skeleton = skeleton;
    pose->joint_count = joints;
    pose->palette = calloc((size_t)joints + 1, sizeof *pose->palette);
    pose->wanted = calloc((size_t)joints + 1, sizeof *pose->wanted);
    pose->joint_world = calloc((size_t)joints + 1, 16 * sizeof(float));
    if (!pose->palette || !pose->wanted || !pose->joint_world || !ng_array_push(&x->poses, pose)) {
        free_pose(pose);
        return ng_out_of_memory("the frame's scene");
    }
    *out = pose;
    return ng_index_map_set(&x->pose_of, skeleton.id, (uint32_t)x->poses.count - 1)
               ? NG_OK
               : ng_out_of_memory("the frame's scene");
}

static ng_result find_pose(struct ng_extractor *x, ng_asset skeleton, uint32_t joints, struct ng_pose **out)
{
    uint32_t index = ng_index_map_get(&x->pose_of, skeleton.id);
    if (index == UINT32_MAX)
        return make_pose(x, skeleton, joints, out);
    *out = x->poses.items[index];
    return NG_OK;
}

// One block of floats for everything that a skinned piece needs.
static ng_result make_skin(struct ng_extractor *x, struct ng_pose *pose, const struct ng_shape *shape,
                           struct ng_skinned **out)
{
    size_t n = shape->mesh.vertex_count, cage = shape->refiner ? shape->cage->vertex_count : 0;
    struct ng_skinned *s = calloc(1, sizeof *s);
    *out = s;
    if (!s)
        return ng_out_of_memory("the frame's scene");
    s->memory = calloc(n * 13 + cage * 3 + 1, sizeof(float));
    if (!s->memory) {
        ng_extract_free_skin(out);
        return ng_out_of_memory("the frame's scene");
    }
    float *at = s->memory;
    s->positions[0] = at;
    s->positions[1] = at += n * 3;
    s->normals = at += n * 3;
    s->tangents = at += n * 3;
    s->cage = at + n * 4;
    s->pose = pose;
    s->mesh = shape->mesh;
    s->mesh.key = ++x->clock;
    s->mesh.dynamic = true;
    s->mesh.rest_positions = shape->mesh.positions;
    s->mesh.positions = s->positions[0];
    s->mesh.normals = s->normals;
    s->mesh.tangents = s->tangents;
    return NG_OK;
}

// The skeleton that a mesh entity can follow; null (after a warning) where it cannot.
static const struct ng_skeleton *usable_skeleton(struct ng_extractor *x, ng_entity e,
                                                 const struct ng_shape *shape)
{
    const struct ng_skin *skin = ng_world_get(x->world, e, NG_SKIN);
    const struct ng_skeleton *skeleton = skin ? ng_assets_skeleton(x->assets, skin->skin) : NULL;
    const char *reason = NULL;
    char name[NG_TEXT_SIZE];
    if (!skin)
        return NULL;
    if (!skeleton)
        reason = "its skeleton is missing";
    else if (!shape->source->joints || !shape->source->weights)
        reason = "its geometry has no joints and weights";
    else if (shape->joints_needed > skeleton->joint_count)
        reason = "its geometry refers to joints that the skeleton does not have";
    else if (shape->refiner && !shape->cage_joints)
        reason = "its subdivision cage has no vertex map";
    if (reason && ng_extract_warn_once(x, e, NG_WARN_SKIN))
        ng_log_warn("mesh '%s' does not follow its skin: %s", ng_extract_name(x, e, name), reason);
    return reason ? NULL : skeleton;
}

// Reads where the joints are, and gives the palette a new version where it is another.
static void follow_joints(struct ng_extractor *x, struct ng_pose *pose)
{
    const struct ng_skeleton *skeleton = ng_assets_skeleton(x->assets, pose->skeleton);
    if (!skeleton || skeleton->joint_count != pose->joint_count)
        return;
    for (uint32_t j = 0; j < pose->joint_count; j++)
        memcpy(pose->joint_world + (size_t)j * 16, ng_extract_placement(x, skeleton->joints[j]),
               16 * sizeof(float));
    ng_skin_palette(pose->joint_count, pose->joint_world, skeleton->inverse_bind, pose->wanted);
    if (pose->version &&
        ng_extract_same(pose->palette, pose->wanted, pose->joint_count * sizeof *pose->palette))
        return;
    NG_SWAP(pose->palette, pose->wanted);
    pose->version = ++x->clock;
}

static struct ng_skin_params skin_params(struct ng_piece *piece)
{
    const struct ng_geometry *g = piece->shape->source;
    struct ng_skinned *s = piece->skin;
    struct ng_skin_params p = {.joint_count = s->pose->joint_count, .palette = s->pose->palette};
    if (piece->shape->refiner) {
        p.vertex_count = piece->shape->cage->vertex_count;
        p.joints = piece->shape->cage_joints;
        p.weights = piece->shape->cage_weights;
        p.positions = piece->shape->cage->positions;
        p.out_positions = s->cage;
        return p;
    }
    p.vertex_count = g->vertex_count;
    p.joints = g->joints;
    p.weights = g->weights;
    p.positions = g->positions;
    p.normals = g->normals;
    p.tangents = g->tangents;
    p.out_positions = s->positions[s->now];
    p.out_normals = s->normals;
    p.out_tangents = s->tangents;
    return p;
}

// Finds the pieces whose joints moved, and readies their buffers.
static ng_result find_posing(struct ng_extractor *x)
{
    x->posing.count = x->skinning.count = 0;
    for (size_t i = 0; i < x->poses.count; i++)
        follow_joints(x, x->poses.items[i]);
    for (uint32_t i = 0; i < x->pieces.count; i++) {
        struct ng_skinned *s = x->pieces.items[i].skin;
        if (!s || s->posed == s->pose->version)
            continue;
        s->mesh.previous_positions = s->posed ? s->positions[s->now] : NULL;
        s->now = !s->now;
        s->posed = s->pose->version;
        if (!ng_array_push(&x->posing, i) || !ng_array_push(&x->skinning, skin_params(&x->pieces.items[i])))
            return ng_out_of_memory("the frame's scene");
    }
    return NG_OK;
}

static void bound_posed(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    struct ng_extractor *x = user;
    for (uint32_t i = begin; i < end; i++) {
        struct ng_snapshot_mesh *m = &x->pieces.items[x->posing.items[i]].skin->mesh;
        if (m->vertex_count)
            memcpy(m->bounds_min, m->positions, sizeof m->bounds_min);
        memcpy(m->bounds_max, m->bounds_min, sizeof m->bounds_max);
        for (size_t v = 1; v < m->vertex_count; v++)
            for (size_t k = 0; k < 3; k++) {
                float p = m->positions[v * 3 + k];
                m->bounds_min[k] = p < m->bounds_min[k] ? p : m->bounds_min[k];
                m->bounds_max[k] = p > m->bounds_max[k] ? p : m->bounds_max[k];
            }
    }
}

ng_result ng_extract_pose(struct ng_extractor *x)
{
    NG_TRY(find_posing(x));
    ng_skin_batch(x->jobs, x->skinning.items, (uint32_t)x->skinning.count);
    for (size_t i = 0; i < x->posing.count; i++) {
        struct ng_piece *piece = &x->pieces.items[x->posing.items[i]];
        struct ng_skinned *s = piece->skin;
        s->mesh.positions = s->positions[s->now];
        s->mesh.revision = ++x->clock;
        if (piece->shape->refiner)
            ng_refiner_apply(piece->shape->refiner, x->jobs,
                             &(struct ng_refiner_vertices){.cage = s->cage,
                                                           .positions = s->positions[s->now],
                                                           .normals = s->normals,
                                                           .tangents = s->tangents});
    }
    ng_jobs_for(x->jobs, (uint32_t)x->posing.count, 1, bound_posed, x);
    for (size_t i = 0; i < x->posing.count; i++) {
        uint32_t index = x->posing.items[i];
        const struct ng_skinned *s = x->pieces.items[index].skin;
        struct ng_snapshot_instance *instance = &x->instances.items[index];
        x->mesh_array.items[instance->mesh] = s->mesh;
        ng_extract_bounds(instance, &s->mesh);
        // Joints under a mirroring parent turn all triangles around; the first joint speaks for them.
        set_flag(instance, NG_INSTANCE_MIRRORED,
                 s->pose->joint_count && mirrors((const float *)s->pose->palette));
        NG_TRY(ng_extract_touch(x, index));
    }
    return NG_OK;
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
        x->pieces.items[kept++] = piece;
    }
    x->pieces.count = kept;
    return NG_OK;
}

// Takes over the skin of the old piece, or makes one.
static ng_result skin_piece(struct ng_extractor *x, struct ng_piece *piece, struct ng_piece *old)
{
    const struct ng_skeleton *skeleton = usable_skeleton(x, piece->entity, piece->shape);
    if (!skeleton)
        return NG_OK;
    ng_asset id = ((const struct ng_skin *)ng_world_get(x->world, piece->entity, NG_SKIN))->skin;
    struct ng_pose *pose;
    NG_TRY(find_pose(x, id, skeleton->joint_count, &pose));
    pose->used = true;
    if (old && old->skin && old->skin->pose == pose && old->shape_key == piece->shape_key) {
        piece->skin = old->skin;
        old->skin = NULL;
        return NG_OK;
    }
    return make_skin(x, pose, piece->shape, &piece->skin);
}

// The material that a piece shows: its own, or the emitter's where a light says how bright it is.
static uint32_t shown_material(const struct ng_extractor *x, const struct ng_piece *piece, uint32_t *light)
{
    *light = ng_index_map_get(&x->mesh_light_of, piece->entity.id);
    if (*light == UINT32_MAX) {
        *light = NG_NONE;
        return ng_extract_material_index(x, piece->material);
    }
    return (uint32_t)x->records.count + x->slots.items[*light].emitter;
}

static void warn_emission(struct ng_extractor *x, const struct ng_piece *piece, const struct ng_material *m)
{
    char name[NG_TEXT_SIZE];
    bool emits = m->emissive_strength > 0 && (m->emissive[0] > 0 || m->emissive[1] > 0 || m->emissive[2] > 0);
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
    uint64_t emission = instance->light == NG_NONE ? record->emission : 0;
    bool reflects = piece->reflection != record->reflection;
    if (piece->emission != emission)
        x->snapshot.emission_version = ++x->clock;
    piece->reflection = record->reflection;
    piece->emission = emission;
    set_flag(instance, NG_INSTANCE_DOUBLE_SIDED, record->value.double_sided);
    set_flag(instance, NG_INSTANCE_MASKED, record->value.alpha_mask);
    return reflects;
}

// Fills the instance of a listed piece and marks it where it is not what it was. `old` and `was` are null for
// a new one.
static ng_result list_piece(struct ng_extractor *x, uint32_t index, struct ng_piece *old,
                            const struct ng_snapshot_instance *was)
{
    struct ng_piece *piece = &x->pieces.items[index];
    struct ng_snapshot_instance *instance = &x->instances.items[index];
    bool had_skin = old && old->skin;
    NG_TRY(skin_piece(x, piece, old));
    bool same_skin = had_skin ? !old->skin : !piece->skin;

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

    if (piece->skin)
        ng_extract_rows(identity, instance->matrix);
    else
        NG_TRY(place_piece(x, index));
    ng_extract_bounds(instance, ng_extract_piece_mesh(piece));
    if (!was || !same_skin)
        memcpy(instance->previous_matrix, instance->matrix, sizeof instance->matrix);
    bool same = was && same_skin && same_material && old->shape_key == piece->shape_key;
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
        uint32_t *index = piece->skin ? &x->instances.items[i].mesh : &piece->shape->index;
        if (piece->skin || *index == NG_NONE)
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
    for (size_t i = 0; i < x->poses.count; i++)
        x->poses.items[i]->used = false;
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
        x->snapshot.geometry_version = ++x->clock;
    for (size_t i = 0; i < x->old_pieces.count; i++)
        ng_extract_free_skin(&x->old_pieces.items[i].skin);
    x->old_pieces.count = x->old_instances.count = 0;
    ng_extract_sweep_shapes(x);
    sweep_poses(x);
    ng_index_map_clear(&x->piece_of);
    for (uint32_t i = 0; i < x->pieces.count; i++)
        if (!ng_index_map_set(&x->piece_of, x->pieces.items[i].entity.id, i))
            return ng_out_of_memory("the frame's scene");
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

ng_result ng_extract_follow_pieces(struct ng_extractor *x)
{
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

// Pieces that deform: by morph targets, by joints, or by both, in that order. A palette is read once for all
// pieces of its skeleton; a piece is deformed only where palette or weights differ from the last ones.
#include "base/jobs.h"
#include "base/log.h"
#include "components/skin.h"
#include "render/extract_internal.h"

#include <stdlib.h>
#include <string.h>

// ---- poses -----------------------------------------------------------------------------------------------
static void free_pose(struct ng_pose *pose)
{
    free(pose->palette);
    free(pose->wanted);
    free(pose->joint_world);
    free(pose);
}

void ng_extract_mark_poses(struct ng_extractor *x)
{
    for (size_t i = 0; i < x->poses.count; i++)
        x->poses.items[i]->used = false;
}

void ng_extract_sweep_poses(struct ng_extractor *x)
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

// ---- pieces ----------------------------------------------------------------------------------------------
void ng_extract_free_deformed(struct ng_deformed **deformed)
{
    if (*deformed)
        free((*deformed)->memory);
    free(*deformed);
    *deformed = NULL;
}

static const float *rest_of(const struct ng_shape *shape)
{
    return shape->mesh.rest_positions ? shape->mesh.rest_positions : shape->mesh.positions;
}

static bool morphs(const struct ng_shape *shape)
{
    return shape->source->target_count && (!shape->refiner || shape->cage_deltas);
}

// One block of floats for everything that a piece needs.
static ng_result make_deformed(struct ng_extractor *x, struct ng_pose *pose, const struct ng_shape *shape,
                               struct ng_deformed **out)
{
    size_t n = shape->mesh.vertex_count, cage = shape->refiner ? shape->cage->vertex_count : 0;
    size_t morphed = !pose || !morphs(shape) ? 0 : shape->refiner ? cage * 3 : n * 10;
    struct ng_deformed *s = calloc(1, sizeof *s);
    *out = s;
    if (!s)
        return ng_out_of_memory("the frame's scene");
    s->memory = calloc(n * 13 + cage * 3 + morphed + 1, sizeof(float));
    if (!s->memory) {
        ng_extract_free_deformed(out);
        return ng_out_of_memory("the frame's scene");
    }
    float *at = s->memory;
    s->positions[0] = at;
    s->positions[1] = at += n * 3;
    s->normals = at += n * 3;
    s->tangents = at += n * 3;
    s->cage = at += n * 4;
    s->morphed = morphed ? at + cage * 3 : NULL;
    s->pose = pose;
    s->mesh = shape->mesh;
    s->mesh.key = ++x->clock;
    s->mesh.dynamic = true;
    s->mesh.rest_positions = rest_of(shape);
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

static void warn_unmapped(struct ng_extractor *x, const struct ng_piece *piece)
{
    char name[NG_TEXT_SIZE];
    if (piece->shape->source->target_count && piece->shape->source->delta_count && !morphs(piece->shape) &&
        ng_extract_warn_once(x, piece->entity, NG_WARN_MORPH))
        ng_log_warn("mesh '%s' does not follow its morph targets: its subdivision cage has no vertex map",
                    ng_extract_name(x, piece->entity, name));
}

ng_result ng_extract_deform_piece(struct ng_extractor *x, struct ng_piece *piece, struct ng_piece *old)
{
    const struct ng_skeleton *skeleton = usable_skeleton(x, piece->entity, piece->shape);
    struct ng_pose *pose = NULL;
    warn_unmapped(x, piece);
    if (skeleton) {
        ng_asset id = ((const struct ng_skin *)ng_world_get(x->world, piece->entity, NG_SKIN))->skin;
        NG_TRY(find_pose(x, id, skeleton->joint_count, &pose));
        pose->used = true;
    }
    if (!pose && !morphs(piece->shape))
        return NG_OK;
    if (old && old->deformed && old->deformed->pose == pose && old->shape_key == piece->shape_key) {
        piece->deformed = old->deformed;
        old->deformed = NULL;
        return NG_OK;
    }
    return make_deformed(x, pose, piece->shape, &piece->deformed);
}

// ---- deforming -------------------------------------------------------------------------------------------
static struct ng_morph_params morph_params(struct ng_piece *piece)
{
    const struct ng_geometry *g = piece->shape->source;
    struct ng_deformed *s = piece->deformed;
    size_t n = g->vertex_count;
    uint32_t targets = g->target_count < NG_MORPH_TARGETS ? g->target_count : NG_MORPH_TARGETS;
    return (struct ng_morph_params){.vertex_count = g->vertex_count,
                                    .target_count = targets,
                                    .weights = s->weights.weights,
                                    .target_ends = g->target_ends,
                                    .delta_vertices = g->delta_vertices,
                                    .delta_positions = g->delta_positions,
                                    .delta_normals = g->delta_normals,
                                    .delta_tangents = g->delta_tangents,
                                    .positions = g->positions,
                                    .normals = g->normals,
                                    .tangents = g->tangents,
                                    .out_positions = s->morphed ? s->morphed : s->positions[s->now],
                                    .out_normals = s->morphed ? s->morphed + n * 3 : s->normals,
                                    .out_tangents = s->morphed ? s->morphed + n * 6 : s->tangents};
}

// A cage morphs, then joints move it, then it is refined.
static struct ng_morph_params cage_morph_params(struct ng_piece *piece)
{
    const struct ng_shape *shape = piece->shape;
    struct ng_deformed *s = piece->deformed;
    uint32_t targets = shape->source->target_count;
    return (struct ng_morph_params){.vertex_count = shape->cage->vertex_count,
                                    .target_count = targets < NG_MORPH_TARGETS ? targets : NG_MORPH_TARGETS,
                                    .weights = s->weights.weights,
                                    .target_ends = shape->cage_target_ends,
                                    .delta_vertices = shape->cage_delta_vertices,
                                    .delta_positions = shape->cage_deltas,
                                    .positions = shape->cage->positions,
                                    .out_positions = s->morphed ? s->morphed : s->cage};
}

static struct ng_skin_params skin_params(struct ng_piece *piece)
{
    const struct ng_geometry *g = piece->shape->source;
    struct ng_deformed *s = piece->deformed;
    struct ng_skin_params p = {.joint_count = s->pose->joint_count, .palette = s->pose->palette};
    if (piece->shape->refiner) {
        p.vertex_count = piece->shape->cage->vertex_count;
        p.joints = piece->shape->cage_joints;
        p.weights = piece->shape->cage_weights;
        p.joints1 = piece->shape->cage_joints1;
        p.weights1 = piece->shape->cage_weights1;
        p.positions = s->morphed ? s->morphed : piece->shape->cage->positions;
        p.out_positions = s->cage;
        return p;
    }
    size_t n = p.vertex_count = g->vertex_count;
    p.joints = g->joints;
    p.weights = g->weights;
    p.joints1 = g->joints1;
    p.weights1 = g->weights1;
    p.positions = s->morphed ? s->morphed : g->positions;
    p.normals = s->morphed ? s->morphed + n * 3 : g->normals;
    p.tangents = s->morphed ? s->morphed + n * 6 : g->tangents;
    p.out_positions = s->positions[s->now];
    p.out_normals = s->normals;
    p.out_tangents = s->tangents;
    return p;
}

// Takes on the weights of this frame; true if they are others.
static bool follow_weights(struct ng_extractor *x, const struct ng_piece *piece)
{
    const struct ng_geometry *g = piece->shape->source;
    const struct ng_morph *morph = ng_world_get(x->world, piece->entity, NG_MORPH);
    bool others = false;
    for (uint32_t t = 0; morphs(piece->shape) && t < g->target_count && t < NG_MORPH_TARGETS; t++) {
        bool empty = g->target_ends[t] == (t ? g->target_ends[t - 1] : 0);
        float now = morph && !empty ? morph->weights[t] + 0.0f : 0; // no -0
        others |= !ng_extract_same(&piece->deformed->weights.weights[t], &now, sizeof now);
        piece->deformed->weights.weights[t] = now;
    }
    return others;
}

// Readies the buffers of a piece that is to be deformed.
static ng_result list_deforming(struct ng_extractor *x, uint32_t index)
{
    struct ng_piece *piece = &x->pieces.items[index];
    struct ng_deformed *s = piece->deformed;
    s->mesh.previous_positions = s->made ? s->positions[s->now] : NULL;
    s->now = !s->now;
    s->made = true;
    s->posed = s->pose ? s->pose->version : 0;
    s->posed_revision = piece->shape->mesh.revision;
    s->mesh.rest_positions = rest_of(piece->shape);
    bool ok = ng_array_push(&x->posing, index);
    if (ok && morphs(piece->shape))
        ok = ng_array_push(&x->morphing,
                           piece->shape->refiner ? cage_morph_params(piece) : morph_params(piece));
    ok = ok && (!s->pose || ng_array_push(&x->skinning, skin_params(piece)));
    return ok ? NG_OK : ng_out_of_memory("the frame's scene");
}

// Finds the pieces whose weights, joints or points are others.
static ng_result find_deforming(struct ng_extractor *x)
{
    x->posing.count = x->morphing.count = x->skinning.count = 0;
    for (size_t i = 0; i < x->poses.count; i++)
        follow_joints(x, x->poses.items[i]);
    for (uint32_t i = 0; i < x->pieces.count; i++) {
        const struct ng_piece *piece = &x->pieces.items[i];
        const struct ng_deformed *s = piece->deformed;
        if (!s)
            continue;
        bool weighted = follow_weights(x, piece);
        bool same = s->made && (!s->pose || s->posed == s->pose->version) &&
                    s->posed_revision == piece->shape->mesh.revision && !weighted;
        if (!same)
            NG_TRY(list_deforming(x, i));
    }
    return NG_OK;
}

static void bound_posed(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    struct ng_extractor *x = user;
    for (uint32_t i = begin; i < end; i++) {
        struct ng_snapshot_mesh *m = &x->pieces.items[x->posing.items[i]].deformed->mesh;
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
    NG_TRY(find_deforming(x));
    ng_morph_batch(x->jobs, x->morphing.items, (uint32_t)x->morphing.count);
    ng_skin_batch(x->jobs, x->skinning.items, (uint32_t)x->skinning.count);
    for (size_t i = 0; i < x->posing.count; i++) {
        struct ng_piece *piece = &x->pieces.items[x->posing.items[i]];
        struct ng_deformed *s = piece->deformed;
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
        const struct ng_deformed *s = x->pieces.items[index].deformed;
        struct ng_snapshot_instance *instance = &x->instances.items[index];
        x->mesh_array.items[instance->mesh] = s->mesh;
        ng_extract_bounds(instance, &s->mesh);
        // Joints under a mirroring parent turn all triangles around; the first joint speaks for them. A
        // palette without joints has a matrix of zeros, which mirrors nothing.
        if (s->pose)
            ng_extract_set_mirrored(instance, (const float *)s->pose->palette);
        NG_TRY(ng_extract_touch(x, index));
    }
    return NG_OK;
}

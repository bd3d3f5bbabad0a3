// The instances of the tracer's scenes: each has a slot, which remembers what it was made from, so that an
// update touches what differs.
//
// What a ray meets must follow from the snapshot alone, not from how the scene came to be (README.md). So the
// id of a geometry, which decides the order in Embree's structures, follows from the entity: an instance
// keeps it whatever comes and goes around it.
#include "base/log.h"
#include "lightformer/trace/embree_internal.h"

#include <stdlib.h>

#define MOST_SURFACES 4u // of one entity: a mesh, a sphere, a disk, a rectangle

// ---- One slot --------------------------------------------------------------------------------------------

static enum lf_shape shape_of(const struct ng_snapshot *snapshot, const struct ng_snapshot_instance *instance)
{
    if (instance->light == NG_NONE)
        return LF_SHAPE_TRIANGLES;
    const struct ng_light_source *source = &snapshot->lights[instance->light].source;
    struct ng_light_surface surface = {.shape = NG_LIGHT_SHAPE_RECTANGLE};
    source->type->surface(source, &surface);
    return surface.shape == NG_LIGHT_SHAPE_SPHERE ? LF_SHAPE_SPHERE
           : surface.shape == NG_LIGHT_SHAPE_DISK ? LF_SHAPE_DISK
                                                  : LF_SHAPE_TRIANGLES;
}

// Whether a slot's geometry can become what the instance is now. What cannot be refitted to the same
// structure that a new one has is made anew: what becomes an emitter or ceases to be one, since each scene
// builds its own structure around the mesh at rest. A mesh whose points were edited has the same place at
// rest.
static bool is_slot_of(const struct lf_trace_slot *s, const struct ng_snapshot *snapshot,
                       const struct ng_snapshot_instance *instance)
{
    const struct ng_snapshot_mesh *mesh = &snapshot->meshes[instance->mesh];
    return ng_entity_same(s->entity, instance->entity) && s->mesh_key == mesh->key &&
           s->vertex_count == mesh->vertex_count && s->index_count == mesh->index_count &&
           s->emits == (instance->light != NG_NONE) && s->seen.shape == shape_of(snapshot, instance);
}

static void drop(struct lf_tracer *t, struct lf_trace_slot *s)
{
    t->by_id.items[s->id] = NULL;
    t->stats.triangles -= s->seen.shape == LF_SHAPE_TRIANGLES ? s->index_count / 3 : 0;
    t->stats.shared -= s->shared != NULL;
    if (s->attached) {
        rtcDetachGeometry(t->scene, s->id);
        if (s->emits)
            rtcDetachGeometry(t->emitters, s->id);
    }
    if (s->geometry)
        rtcReleaseGeometry(s->geometry);
    free(s);
}

// Reads what an instance is now; true if its place or form is another.
static bool read_instance(struct lf_trace_slot *s, const struct ng_snapshot *snapshot)
{
    const struct ng_snapshot_instance *instance = &snapshot->instances[s->instance];
    const struct ng_snapshot_mesh *mesh = &snapshot->meshes[instance->mesh];
    bool moved = s->mesh_revision != mesh->revision;
    for (int i = 0; i < 12; i++)
        moved |= s->matrix[i] != instance->matrix[i];
    s->mesh_revision = mesh->revision;
    s->version = instance->version;
    memcpy(s->matrix, instance->matrix, sizeof s->matrix);
    return moved;
}

static void commit_geometry(struct lf_trace_slot *s)
{
    if (s->shared)
        lf_sharing_place(s);
    else if (s->seen.shape == LF_SHAPE_TRIANGLES)
        lf_triangles_mask(&s->triangles, s->seen.flags & NG_INSTANCE_MASKED);
    rtcCommitGeometry(s->geometry);
}

static ng_result make_geometry(struct lf_tracer *t, const struct ng_snapshot *snapshot,
                               struct lf_trace_slot *s)
{
    uint32_t index = snapshot->instances[s->instance].mesh;
    const struct ng_snapshot_mesh *mesh = &snapshot->meshes[index];
    if (s->seen.shape != LF_SHAPE_TRIANGLES) {
        s->geometry = rtcNewGeometry(t->device, RTC_GEOMETRY_TYPE_USER);
        lf_shape_set(s->geometry, s);
        return NG_OK;
    }
    t->stats.triangles += s->index_count / 3;
    if (s->may_share && t->by_mesh.items[index]) {
        t->stats.shared++;
        return lf_sharing_attach(t, t->by_mesh.items[index], mesh, s);
    }
    bool built;
    ng_result r = lf_triangles_make(t->device, mesh, &s->triangles);
    s->geometry = s->triangles.geometry;
    return r == NG_OK ? lf_triangles_move(&s->triangles, s->matrix, mesh, &built) : r;
}

// Where its id is free.
static ng_result make_slot(struct lf_tracer *t, const struct ng_snapshot *snapshot, uint32_t index)
{
    const struct ng_snapshot_instance *instance = &snapshot->instances[index];
    const struct ng_snapshot_mesh *mesh = &snapshot->meshes[instance->mesh];
    struct lf_trace_slot *s = calloc(1, sizeof *s);
    if (!s)
        return ng_out_of_memory("ray tracing");
    *s = (struct lf_trace_slot){.instance = index,
                                .id = t->ids.items[index],
                                .seen.shape = shape_of(snapshot, instance),
                                .entity = instance->entity,
                                .mesh_key = mesh->key,
                                .vertex_count = mesh->vertex_count,
                                .index_count = mesh->index_count,
                                .may_share = lf_may_share(snapshot, index),
                                .emits = instance->light != NG_NONE};
    t->by_id.items[s->id] = t->shown.items[index] = s;
    t->stats.updated++;
    t->stats.built++;
    lf_instance_read(snapshot, index, &s->seen);
    read_instance(s, snapshot);
    NG_TRY(make_geometry(t, snapshot, s));
    commit_geometry(s);
    s->attached = true;
    rtcAttachGeometryByID(t->scene, s->geometry, s->id);
    if (s->emits)
        rtcAttachGeometryByID(t->emitters, s->geometry, s->id);
    return NG_OK;
}

static ng_result follow(struct lf_tracer *t, const struct ng_snapshot *snapshot, struct lf_trace_slot *s)
{
    const struct ng_snapshot_instance *instance = &snapshot->instances[s->instance];
    uint32_t before = s->seen.flags;
    lf_instance_read(snapshot, s->instance, &s->seen); // the snapshot's arrays may be elsewhere
    if (s->version == instance->version)
        return NG_OK;
    bool moved = read_instance(s, snapshot), built = false;
    if (!moved && ((before ^ s->seen.flags) & NG_INSTANCE_MASKED) == 0)
        return NG_OK; // it reflects in another way
    t->stats.updated++;
    if (s->triangles.geometry)
        NG_TRY(lf_triangles_move(&s->triangles, s->matrix, &snapshot->meshes[instance->mesh], &built));
    t->stats.built += built;
    commit_geometry(s);
    return NG_OK;
}

// ---- All of them -----------------------------------------------------------------------------------------

// Counts the surfaces of each entity; how many indices of entities there are, and a power of two that no
// entity has more surfaces than.
static ng_result count_surfaces(struct lf_tracer *t, const struct ng_snapshot *snapshot, uint32_t *entities,
                                uint32_t *most)
{
    *entities = 0, *most = 1;
    for (uint32_t i = 0; i < snapshot->instance_count; i++)
        if (ng_entity_index(snapshot->instances[i].entity) >= *entities)
            *entities = ng_entity_index(snapshot->instances[i].entity) + 1;
    t->surfaces.count = 0;
    if (!ng_array_resize(&t->surfaces, *entities))
        return ng_out_of_memory("ray tracing");
    for (uint32_t i = 0; i < snapshot->instance_count; i++) {
        uint32_t surfaces = ++t->surfaces.items[ng_entity_index(snapshot->instances[i].entity)];
        NG_REQUIRE(surfaces <= MOST_SURFACES, "ray tracing: an entity has more than %u surfaces",
                   MOST_SURFACES);
        while (*most < surfaces)
            *most *= 2;
    }
    return NG_OK;
}

// The id of each instance's geometry, from its entity and how many surfaces of it are listed after. Ids that
// no geometry has take time in every commit, so there are no more of them than the snapshot needs; where that
// changes, as with the first light on the entity of a mesh, all ids do, and everything is built anew.
static ng_result name_instances(struct lf_tracer *t, const struct ng_snapshot *snapshot)
{
    uint32_t entities, most;
    NG_TRY(count_surfaces(t, snapshot, &entities, &most));
    size_t ids = LF_TRACE_FIRST_ID + (size_t)entities * most;
    if (!ng_array_resize(&t->ids, snapshot->instance_count) ||
        (ids > t->by_id.count && !ng_array_resize(&t->by_id, ids)))
        return ng_out_of_memory("ray tracing");
    for (uint32_t i = 0; i < snapshot->instance_count; i++) {
        uint32_t entity = ng_entity_index(snapshot->instances[i].entity);
        t->ids.items[i] = LF_TRACE_FIRST_ID + entity * most + --t->surfaces.items[entity];
    }
    return NG_OK;
}

// The slot of an instance, if it is to stay; what can be shared of it may be another thing than before.
static struct lf_trace_slot *find(struct lf_tracer *t, const struct ng_snapshot *snapshot, uint32_t index,
                                  bool *changed)
{
    struct lf_trace_slot *s = t->by_id.items[t->ids.items[index]];
    if (!s || !is_slot_of(s, snapshot, &snapshot->instances[index])) {
        *changed = true;
        return NULL;
    }
    if (s->version != snapshot->instances[index].version) {
        bool may_share = lf_may_share(snapshot, index);
        *changed |= s->may_share != may_share;
        s->may_share = may_share;
    }
    s->instance = index;
    s->shown = true;
    return s;
}

ng_result lf_slots_find(struct lf_tracer *t, const struct ng_snapshot *snapshot, bool *changed)
{
    NG_TRY(name_instances(t, snapshot));
    if (!ng_array_resize(&t->before, t->shown.count))
        return ng_out_of_memory("ray tracing");
    for (size_t i = 0; i < t->shown.count; i++)
        t->before.items[i] = t->shown.items[i];
    if (!ng_array_resize(&t->shown, snapshot->instance_count))
        return ng_out_of_memory("ray tracing");
    for (uint32_t i = 0; i < snapshot->instance_count; i++)
        t->shown.items[i] = find(t, snapshot, i, changed);
    for (size_t i = 0; i < t->before.count; i++) {
        struct lf_trace_slot *s = t->before.items[i];
        if (!s->shown) {
            *changed = true;
            drop(t, s);
        } else
            s->shown = false;
    }
    return NG_OK;
}

void lf_slots_drop_otherwise_shared(struct lf_tracer *t, const struct ng_snapshot *snapshot)
{
    for (size_t i = 0; i < t->shown.count; i++) {
        struct lf_trace_slot *s = t->shown.items[i];
        if (!s || s->seen.shape != LF_SHAPE_TRIANGLES)
            continue;
        const struct lf_shared *wanted = s->may_share ? t->by_mesh.items[snapshot->instances[i].mesh] : NULL;
        if (s->shared == wanted)
            continue;
        t->shown.items[i] = NULL;
        drop(t, s);
    }
}

ng_result lf_slots_follow(struct lf_tracer *t, const struct ng_snapshot *snapshot)
{
    for (uint32_t i = 0; i < snapshot->instance_count; i++)
        NG_TRY(t->shown.items[i] ? follow(t, snapshot, t->shown.items[i]) : make_slot(t, snapshot, i));
    return NG_OK;
}

bool lf_slots_settle(struct lf_tracer *t, const struct ng_snapshot *snapshot)
{
    bool any = false;
    for (size_t i = 0; i < t->shown.count; i++) {
        struct lf_trace_slot *s = t->shown.items[i];
        if (!s->triangles.at_rest)
            continue;
        any = true;
        lf_triangles_settle(&s->triangles, s->matrix, &snapshot->meshes[snapshot->instances[i].mesh]);
        commit_geometry(s);
    }
    return any;
}

void lf_slots_forget(struct lf_tracer *t)
{
    for (size_t i = 0; i < t->by_id.count; i++)
        if (t->by_id.items[i])
            drop(t, t->by_id.items[i]);
    ng_array_finish(&t->by_id);
    ng_array_finish(&t->shown);
    ng_array_finish(&t->before);
    ng_array_finish(&t->ids);
    ng_array_finish(&t->surfaces);
    t->stats.triangles = t->stats.shared = 0;
}

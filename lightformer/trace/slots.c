// The instances of the tracer's scenes: each has a slot, which remembers what it was made from, so that an
// update touches what differs.
//
// What a ray meets must follow from the snapshot alone, not from how the scene came to be (README.md). So the
// id of a geometry, which decides the order in Embree's structures, grows with the entity's index: an
// instance keeps it when others come and go around it.
#include "base/log.h"
#include "lightformer/trace/embree_internal.h"

#include <stdlib.h>

#define MOST_SURFACES 4u  // of one entity: a mesh, a sphere, a disk, a rectangle
#define LARGEST_GAP   64u // between the places of two entities

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
static bool is_slot_of(const struct lf_tracer *t, const struct lf_trace_slot *s,
                       const struct ng_snapshot *snapshot, uint32_t index)
{
    const struct ng_snapshot_instance *instance = &snapshot->instances[index];
    const struct ng_snapshot_mesh *mesh = &snapshot->meshes[instance->mesh];
    return ng_entity_same(s->entity, instance->entity) && s->mesh_key == mesh->key &&
           s->vertex_count == mesh->vertex_count && s->index_count == mesh->index_count &&
           s->hidden == t->copies.hidden.items[index] && s->emits == (instance->light != NG_NONE) &&
           s->seen.shape == shape_of(snapshot, instance);
}

static void drop(struct lf_tracer *t, struct lf_trace_slot *s)
{
    t->by_id.items[s->id] = NULL;
    t->stats.triangles -= s->seen.shape == LF_SHAPE_TRIANGLES && !s->hidden ? s->index_count / 3 : 0;
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
                                .hidden = t->copies.hidden.items[index],
                                .may_share = lf_may_share(t, snapshot, index),
                                .emits = instance->light != NG_NONE};
    t->by_id.items[s->id] = t->shown.items[index] = s;
    lf_instance_read(snapshot, index, &s->seen);
    read_instance(s, snapshot);
    if (s->hidden)
        return NG_OK;
    t->stats.updated++;
    t->stats.built++;
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
    if (s->hidden)
        return NG_OK;
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

// Counts the surfaces of each entity. `*most`: a power of two that no entity has more of; `*unplaced`: some
// entity has no place yet.
static ng_result count_surfaces(struct lf_tracer *t, const struct ng_snapshot *snapshot, uint32_t *most,
                                bool *unplaced)
{
    uint32_t entities = 0;
    for (uint32_t i = 0; i < snapshot->instance_count; i++)
        if (ng_entity_index(snapshot->instances[i].entity) >= entities)
            entities = ng_entity_index(snapshot->instances[i].entity) + 1;
    t->surfaces.count = 0;
    if (!ng_array_resize(&t->surfaces, entities) || !ng_array_resize(&t->places, entities))
        return ng_out_of_memory("ray tracing");
    *most = 1, *unplaced = false;
    for (uint32_t i = 0; i < snapshot->instance_count; i++) {
        uint32_t entity = ng_entity_index(snapshot->instances[i].entity);
        uint32_t surfaces = ++t->surfaces.items[entity];
        NG_REQUIRE(surfaces <= MOST_SURFACES, "ray tracing: an entity has more than %u surfaces",
                   MOST_SURFACES);
        while (*most < surfaces)
            *most *= 2;
        *unplaced |= !t->places.items[entity];
    }
    return NG_OK;
}

// An entity and its place, both counted from one; place 0: none.
struct placed {
    uint32_t entity, place;
};

// The first one after an entity.
static struct placed next_placed(const struct lf_tracer *t, uint32_t entity)
{
    for (uint32_t i = entity; i < t->places.count; i++)
        if (t->surfaces.items[i] && t->places.items[i])
            return (struct placed){i + 1, t->places.items[i]};
    return (struct placed){.entity = UINT32_MAX};
}

// As far between two places as the entity is between theirs; that of `high` where there is no room.
static uint32_t find_place(struct placed low, uint32_t entity, struct placed high)
{
    uint32_t ahead = entity - low.entity;
    if (!high.place)
        return low.place + (ahead < LARGEST_GAP ? ahead : LARGEST_GAP);
    uint64_t along = (uint64_t)(high.place - low.place) * ahead / (high.entity - low.entity);
    return low.place + (along ? (uint32_t)along : 1);
}

// Gives entities that have none a place among the others, and takes it from those that show nothing. False:
// there is no room.
static bool place_entities(struct lf_tracer *t)
{
    struct placed low = {0}, high = {0};
    for (uint32_t i = 0; i < t->places.count; i++) {
        uint32_t *place = &t->places.items[i], entity = i + 1;
        if (!t->surfaces.items[i]) {
            *place = 0;
            continue;
        }
        if (!*place) {
            if (high.entity <= entity)
                high = next_placed(t, entity);
            *place = find_place(low, entity, high);
            if (*place == high.place)
                return false;
        }
        low = (struct placed){entity, *place};
    }
    return true;
}

// The id of each instance's geometry, from the place of its entity and how many surfaces of it are listed
// after. Ids that no geometry has take time in every commit. So entities without surfaces have no place, and
// there are no more ids for an entity than some entity needs; where that changes, as with the first light on
// the entity of a mesh, all ids do, and everything is built anew.
static ng_result name_instances(struct lf_tracer *t, const struct ng_snapshot *snapshot)
{
    uint32_t most, ids = 0;
    bool unplaced;
    NG_TRY(count_surfaces(t, snapshot, &most, &unplaced));
    if (!ng_array_resize(&t->ids, snapshot->instance_count))
        return ng_out_of_memory("ray tracing");
    if (unplaced && !place_entities(t)) {
        memset(t->places.items, 0, t->places.count * sizeof *t->places.items);
        place_entities(t); // one after another there is room for all
    }
    for (uint32_t i = 0; i < snapshot->instance_count; i++) {
        uint32_t entity = ng_entity_index(snapshot->instances[i].entity);
        t->ids.items[i] =
            LF_TRACE_FIRST_ID + (t->places.items[entity] - 1) * most + --t->surfaces.items[entity];
        ids = t->ids.items[i] >= ids ? t->ids.items[i] + 1 : ids;
    }
    return ids <= t->by_id.count || ng_array_resize(&t->by_id, ids) ? NG_OK : ng_out_of_memory("ray tracing");
}

// The slot of an instance, if it is to stay; what can be shared of it may be another thing than before.
static struct lf_trace_slot *find(struct lf_tracer *t, const struct ng_snapshot *snapshot, uint32_t index,
                                  bool *changed)
{
    struct lf_trace_slot *s = t->by_id.items[t->ids.items[index]];
    if (!s || !is_slot_of(t, s, snapshot, index)) {
        *changed = true;
        return NULL;
    }
    if (s->version != snapshot->instances[index].version) {
        bool may_share = lf_may_share(t, snapshot, index);
        *changed |= s->may_share != may_share;
        s->may_share = may_share;
    }
    s->instance = index;
    s->shown = true;
    return s;
}

ng_result lf_slots_find(struct lf_tracer *t, const struct ng_snapshot *snapshot, bool *changed)
{
    NG_TRY(ng_copies_find(&t->copies, snapshot));
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
    ng_array_finish(&t->places);
    ng_copies_finish(&t->copies);
    t->stats.triangles = t->stats.shared = 0;
}

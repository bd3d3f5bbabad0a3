// One Embree scene of all instances, flattened into world space, and a second one that holds the emitters
// alone. A slot per instance remembers what it was built from, so that an update touches what differs.
//
// The scene has two levels: a structure per instance, and a small one over them. So what moves is refitted
// alone (README.md has the figures).
//
// The device has one thread: what a parallel build makes may depend on their number, and with it which of two
// surfaces in the same place is met.
#include "base/log.h"
#include "base/system.h"
#include "lightformer/trace/embree_internal.h"

#include <stdlib.h>
#include <string.h>

const struct ng_snapshot *lf_tracer_snapshot(const struct lf_tracer *tracer)
{
    return tracer->snapshot;
}

struct lf_tracer_stats lf_tracer_stats_of(const struct lf_tracer *tracer)
{
    return tracer->stats;
}

const struct lf_instance *lf_tracer_instance(const struct lf_tracer *tracer, uint32_t instance)
{
    return &tracer->slots[instance].seen;
}

const struct lf_srgb *lf_tracer_srgb(const struct lf_tracer *tracer)
{
    return &tracer->srgb;
}

// Embree tells of every failure here, one after another where memory ends: the first is logged. Whoever
// called finds a null or `failed`, and passes on silently.
static void report_device(void *user, enum RTCError code, const char *text)
{
    struct lf_tracer *t = user;
    if (t->failed)
        return;
    t->failed = true;
    if (code == RTC_ERROR_OUT_OF_MEMORY)
        (void)ng_out_of_memory("ray tracing");
    else
        ng_log_error("ray tracing: Embree reports error %d: %s", (int)code, text ? text : "no reason given");
}

static void free_scene(struct lf_tracer *t)
{
    if (t->scene)
        rtcReleaseScene(t->scene);
    if (t->emitters)
        rtcReleaseScene(t->emitters);
    for (uint32_t i = 0; i < t->slot_count; i++)
        if (t->slots[i].geometry)
            rtcReleaseGeometry(t->slots[i].geometry);
    free(t->slots);
    t->scene = t->emitters = NULL;
    t->slots = NULL;
    t->slot_count = 0;
    t->snapshot = NULL;
}

ng_result lf_tracer_create(struct lf_tracer **out)
{
    struct lf_tracer *t = calloc(1, sizeof *t);
    *out = t;
    if (!t)
        return ng_out_of_memory("ray tracing");
    t->device = rtcNewDevice("threads=1,user_threads=1");
    if (!t->device) {
        report_device(t, rtcGetDeviceError(NULL), "it cannot be started");
        lf_tracer_destroy(out);
        return NG_ERROR_MEMORY;
    }
    rtcSetDeviceErrorFunction(t->device, report_device, t);
    lf_srgb_make(&t->srgb);
    return NG_OK;
}

void lf_tracer_destroy(struct lf_tracer **tracer)
{
    struct lf_tracer *t = *tracer;
    *tracer = NULL;
    if (!t)
        return;
    free_scene(t);
    if (t->device)
        rtcReleaseDevice(t->device);
    free(t);
}

static enum lf_shape shape_of(const struct ng_snapshot *snapshot, const struct ng_snapshot_instance *instance)
{
    if (instance->light == NG_NONE)
        return LF_SHAPE_TRIANGLES;
    const struct ng_light_source *source = &snapshot->lights[instance->light].source;
    struct ng_light_surface surface = {.shape = NG_LIGHT_SHAPE_MESH};
    if (source->type->surface)
        source->type->surface(source, &surface);
    return surface.shape == NG_LIGHT_SHAPE_SPHERE ? LF_SHAPE_SPHERE
           : surface.shape == NG_LIGHT_SHAPE_DISK ? LF_SHAPE_DISK
                                                  : LF_SHAPE_TRIANGLES;
}

static void write_vertices(struct lf_slot *s, const struct ng_snapshot_mesh *mesh)
{
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        float *out = s->vertices + i * 3;
        lf_transform_point(s->matrix, mesh->positions + i * 3, out);
        for (int k = 0; k < 3; k++)
            out[k] = lf_within_reach(out[k]);
    }
}

// Reads what an instance is now; true if its place or form is another.
static bool read_instance(struct lf_slot *s, const struct ng_snapshot *snapshot)
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

// Triangles whose vertices are all in one place, as a scale of zero leaves them, have nothing to meet. Where
// two geometries had some in the same place, Embree would fail an assertion of its upper level.
static bool is_point(const float *vertices, const uint32_t index[3])
{
    const float *a = vertices + (size_t)index[0] * 3, *b = vertices + (size_t)index[1] * 3,
                *c = vertices + (size_t)index[2] * 3;
    bool same = true;
    for (int k = 0; k < 3 && same; k++)
        same = a[k] >= b[k] && a[k] <= b[k] && a[k] >= c[k] && a[k] <= c[k];
    return same;
}

static bool has_points(const struct lf_slot *s, const struct ng_snapshot_mesh *mesh)
{
    for (size_t i = 0; i + 2 < mesh->index_count; i += 3)
        if (is_point(s->vertices, mesh->indices + i))
            return true;
    return false;
}

// Embree builds without a triangle whose indices are no vertices. True where it is to leave out others than
// before, and so has to build anew.
static bool leave_out_points(struct lf_slot *s, const struct ng_snapshot_mesh *mesh)
{
    static const uint32_t none[3] = {UINT32_MAX, UINT32_MAX, UINT32_MAX};
    bool changed = false;
    for (size_t i = 0; i + 2 < mesh->index_count; i += 3) {
        const uint32_t *now = is_point(s->vertices, mesh->indices + i) ? none : mesh->indices + i;
        changed |= s->own_indices[i] != now[0];
        memcpy(s->own_indices + i, now, sizeof none);
    }
    return changed;
}

// The mesh's own indices, as long as they are all of triangles. `*changed` as above.
static ng_result set_indices(struct lf_slot *s, const struct ng_snapshot_mesh *mesh, bool *changed)
{
    const size_t count = mesh->index_count / 3, stride = 3 * sizeof(uint32_t);
    *changed = false;
    if (!s->own_indices && !has_points(s, mesh)) {
        if (s->indices != mesh->indices)
            rtcSetSharedGeometryBuffer(s->geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh->indices,
                                       0, stride, count);
        s->indices = mesh->indices;
        return NG_OK;
    }
    if (!s->own_indices) {
        s->own_indices =
            rtcSetNewGeometryBuffer(s->geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, stride, count);
        if (!s->own_indices)
            return NG_ERROR_MEMORY;
        memcpy(s->own_indices, mesh->indices, count * stride);
    }
    *changed = leave_out_points(s, mesh);
    return NG_OK;
}

static ng_result make_triangles(struct lf_tracer *t, struct lf_slot *s, const struct ng_snapshot_mesh *mesh)
{
    bool changed;
    s->geometry = rtcNewGeometry(t->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    s->vertices = rtcSetNewGeometryBuffer(s->geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                          3 * sizeof(float), mesh->vertex_count ? mesh->vertex_count : 1);
    if (!s->vertices)
        return NG_ERROR_MEMORY;
    write_vertices(s, mesh);
    t->stats.triangles += mesh->index_count / 3;
    return set_indices(s, mesh, &changed);
}

static ng_result move_triangles(struct lf_tracer *t, struct lf_slot *s, const struct ng_snapshot_mesh *mesh)
{
    bool changed;
    write_vertices(s, mesh);
    NG_TRY(set_indices(s, mesh, &changed));
    rtcSetGeometryBuildQuality(s->geometry, RTC_BUILD_QUALITY_REFIT);
    rtcUpdateGeometryBuffer(s->geometry, RTC_BUFFER_TYPE_VERTEX, 0);
    if (changed) // then Embree builds
        rtcUpdateGeometryBuffer(s->geometry, RTC_BUFFER_TYPE_INDEX, 0);
    t->stats.built += changed;
    return NG_OK;
}

static void commit_geometry(struct lf_slot *s)
{
    if (s->seen.shape == LF_SHAPE_TRIANGLES) {
        bool masked = s->seen.flags & NG_INSTANCE_MASKED;
        rtcSetGeometryIntersectFilterFunction(s->geometry, masked ? lf_filter_mask : NULL);
        rtcSetGeometryOccludedFilterFunction(s->geometry, masked ? lf_filter_mask : NULL);
    }
    rtcCommitGeometry(s->geometry);
}

static ng_result make_slot(struct lf_tracer *t, const struct ng_snapshot *snapshot, uint32_t index)
{
    struct lf_slot *s = &t->slots[index];
    const struct ng_snapshot_instance *instance = &snapshot->instances[index];
    const struct ng_snapshot_mesh *mesh = &snapshot->meshes[instance->mesh];
    *s = (struct lf_slot){.tracer = t,
                          .instance = index,
                          .seen.shape = shape_of(snapshot, instance),
                          .entity = instance->entity,
                          .mesh_key = mesh->key};
    lf_instance_read(snapshot, index, &s->seen);
    read_instance(s, snapshot);
    if (s->seen.shape == LF_SHAPE_TRIANGLES) {
        NG_TRY(make_triangles(t, s, mesh));
    } else {
        s->geometry = rtcNewGeometry(t->device, RTC_GEOMETRY_TYPE_USER);
        lf_shape_set(s->geometry);
    }
    rtcSetGeometryUserData(s->geometry, s);
    commit_geometry(s);
    rtcAttachGeometryByID(t->scene, s->geometry, index);
    if (instance->light != NG_NONE)
        rtcAttachGeometryByID(t->emitters, s->geometry, index);
    return NG_OK;
}

static ng_result build(struct lf_tracer *t, const struct ng_snapshot *snapshot)
{
    free_scene(t);
    t->stats.triangles = 0;
    t->slots = calloc(snapshot->instance_count ? snapshot->instance_count : 1, sizeof *t->slots);
    if (!t->slots)
        return ng_out_of_memory("ray tracing");
    t->slot_count = snapshot->instance_count;
    t->scene = rtcNewScene(t->device);
    t->emitters = rtcNewScene(t->device);
    if (!t->scene || !t->emitters)
        return NG_ERROR_MEMORY;
    // Of the scene, "low" chooses the structure of two levels; each geometry is built in its own quality.
    rtcSetSceneFlags(t->scene, RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION | RTC_SCENE_FLAG_DYNAMIC);
    rtcSetSceneBuildQuality(t->scene, RTC_BUILD_QUALITY_LOW);
    rtcSetSceneFlags(t->emitters, RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
    for (uint32_t i = 0; i < t->slot_count; i++)
        NG_TRY(make_slot(t, snapshot, i));
    t->stats.updated = t->stats.built = t->slot_count;
    return NG_OK;
}

// Whether the snapshot has the instances that the slots were made from, and the same ones are emitters.
static bool same_instances(const struct lf_tracer *t, const struct ng_snapshot *snapshot)
{
    if (!t->slots || t->slot_count != snapshot->instance_count)
        return false;
    for (uint32_t i = 0; i < t->slot_count; i++) {
        const struct ng_snapshot_instance *instance = &snapshot->instances[i];
        const struct lf_slot *s = &t->slots[i];
        if (!ng_entity_same(s->entity, instance->entity) ||
            s->mesh_key != snapshot->meshes[instance->mesh].key ||
            s->seen.shape != shape_of(snapshot, instance) ||
            (s->seen.light == NG_NONE) != (instance->light == NG_NONE))
            return false;
    }
    return true;
}

static ng_result follow(struct lf_tracer *t, const struct ng_snapshot *snapshot)
{
    for (uint32_t i = 0; i < t->slot_count; i++) {
        struct lf_slot *s = &t->slots[i];
        uint32_t before = s->seen.flags;
        lf_instance_read(snapshot, i, &s->seen); // the snapshot's arrays may be elsewhere
        if (s->version == snapshot->instances[i].version)
            continue;
        bool moved = read_instance(s, snapshot);
        if (!moved && ((before ^ s->seen.flags) & NG_INSTANCE_MASKED) == 0)
            continue; // it reflects in another way
        t->stats.updated++;
        if (s->seen.shape == LF_SHAPE_TRIANGLES)
            NG_TRY(move_triangles(t, s, &snapshot->meshes[snapshot->instances[i].mesh]));
        commit_geometry(s);
    }
    return NG_OK;
}

// So that most rays that look for emitters alone end before they begin.
static void find_boxes(struct lf_tracer *t, const struct ng_snapshot *snapshot)
{
    t->box_count = 0;
    t->others_shine = false;
    for (uint32_t i = 0; i < snapshot->instance_count; i++) {
        const struct ng_snapshot_instance *in = &snapshot->instances[i];
        if (in->light == NG_NONE)
            t->others_shine |= lf_max3(t->slots[i].seen.plain.emission) > 0;
        if (in->light == NG_NONE || ++t->box_count > LF_MAX_BOXES)
            continue;
        struct lf_box *box = &t->boxes[t->box_count - 1];
        for (int k = 0; k < 3; k++) {
            // With room for rounding, and for exact shapes around the triangles of the picture.
            float room = 0.1f * (in->bounds_max[k] - in->bounds_min[k]) + 1e-4f * snapshot->scene_radius;
            box->low[k] = in->bounds_min[k] - room;
            box->high[k] = in->bounds_max[k] + room;
        }
    }
}

static ng_result update(struct lf_tracer *t, const struct ng_snapshot *snapshot)
{
    bool same = same_instances(t, snapshot);
    NG_TRY(same ? follow(t, snapshot) : build(t, snapshot));
    t->snapshot = snapshot;
    find_boxes(t, snapshot);
    if (!same || t->stats.updated) {
        rtcCommitScene(t->scene);
        rtcCommitScene(t->emitters);
    }
    return t->failed ? NG_ERROR_MEMORY : NG_OK;
}

ng_result lf_tracer_update(struct lf_tracer *t, const struct ng_snapshot *snapshot)
{
    NG_REQUIRE(snapshot, "a tracer follows a snapshot");
    uint64_t begin = ng_clock_ns();
    t->stats.updated = t->stats.built = 0;
    t->failed = false;
    ng_result result = update(t, snapshot);
    if (result != NG_OK)
        free_scene(t);
    t->stats.instances = t->slot_count;
    t->stats.update_ms = (double)(ng_clock_ns() - begin) * 1e-6;
    return result;
}

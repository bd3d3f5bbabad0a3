// One Embree scene of all instances, flattened into world space where memory allows it (sharing.c), and a
// second one that holds the emitters alone. A slot per instance remembers what it was built from, so that an
// update touches what differs.
//
// The scene has two levels: a structure per instance, and a small one over them. So what moves is refitted
// alone (README.md has the figures).
//
// The device has one thread: what a parallel build makes may depend on their number, and with it which of two
// surfaces in the same place is met.
#include "base/cpu.h"
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

void lf_tracer_limit_memory(struct lf_tracer *tracer, uint64_t bytes)
{
    tracer->memory_limit = bytes;
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
        ng_log_error(
            "ray tracing: out of memory at %.1f GiB; show fewer or simpler meshes, or end other programs",
            (double)t->bytes / (1 << 30));
    else
        ng_log_error("ray tracing: Embree reports error %d: %s", (int)code, text ? text : "no reason given");
}

// Embree asks before it takes memory, and tells when it gives some back. What it may not have is an error.
static bool count_memory(void *user, ssize_t bytes, bool done)
{
    struct lf_tracer *t = user;
    if (bytes > 0 && !done &&
        (uint64_t)bytes > t->most_bytes - (t->bytes < t->most_bytes ? t->bytes : t->most_bytes))
        return false;
    t->bytes += (uint64_t)bytes;
    return true;
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
    lf_sharing_forget(t);
    free(t->slots);
    t->scene = t->emitters = NULL;
    t->slots = NULL;
    t->slot_count = 0;
    t->snapshot = NULL;
}

// Embree takes the best that the processor has, unless it is held.
static const char *device_config(void)
{
    if (!ng_cpu_allowed(NG_CPU_AVX2))
        return "threads=1,user_threads=1,isa=sse4.2";
    if (!ng_cpu_allowed(NG_CPU_AVX512))
        return "threads=1,user_threads=1,isa=avx2";
    return "threads=1,user_threads=1";
}

ng_result lf_tracer_create(struct lf_tracer **out)
{
    *out = NULL;
    NG_TRY(ng_cpu_check());
    struct lf_tracer *t = calloc(1, sizeof *t);
    *out = t;
    if (!t)
        return ng_out_of_memory("ray tracing");
    t->device = rtcNewDevice(device_config());
    if (!t->device) {
        report_device(t, rtcGetDeviceError(NULL), "it cannot be started");
        lf_tracer_destroy(out);
        return NG_ERROR_MEMORY;
    }
    rtcSetDeviceErrorFunction(t->device, report_device, t);
    rtcSetDeviceMemoryMonitorFunction(t->device, count_memory, t);
    t->most_bytes = UINT64_MAX;
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
    uint32_t mesh = snapshot->instances[s->instance].mesh;
    if (s->seen.shape != LF_SHAPE_TRIANGLES) {
        s->geometry = rtcNewGeometry(t->device, RTC_GEOMETRY_TYPE_USER);
        lf_shape_set(s->geometry, s);
        return NG_OK;
    }
    t->stats.triangles += snapshot->meshes[mesh].index_count / 3;
    if (t->shared && t->shared[mesh].scene && lf_may_share(snapshot, s->instance)) {
        t->stats.shared++;
        return lf_sharing_attach(t, &t->shared[mesh], s);
    }
    bool built;
    ng_result r = lf_triangles_make(t->device, &snapshot->meshes[mesh], &s->triangles);
    s->geometry = s->triangles.geometry;
    return r == NG_OK ? lf_triangles_move(&s->triangles, s->matrix, &snapshot->meshes[mesh], &built) : r;
}

static ng_result make_slot(struct lf_tracer *t, const struct ng_snapshot *snapshot, uint32_t index)
{
    struct lf_trace_slot *s = &t->slots[index];
    const struct ng_snapshot_instance *instance = &snapshot->instances[index];
    const struct ng_snapshot_mesh *mesh = &snapshot->meshes[instance->mesh];
    *s = (struct lf_trace_slot){.instance = index,
                                .seen.shape = shape_of(snapshot, instance),
                                .entity = instance->entity,
                                .mesh_key = mesh->key};
    lf_instance_read(snapshot, index, &s->seen);
    read_instance(s, snapshot);
    NG_TRY(make_geometry(t, snapshot, s));
    commit_geometry(s);
    rtcAttachGeometryByID(t->scene, s->geometry, index);
    if (instance->light != NG_NONE)
        rtcAttachGeometryByID(t->emitters, s->geometry, index);
    return NG_OK;
}

static ng_result build(struct lf_tracer *t, const struct ng_snapshot *snapshot)
{
    free_scene(t);
    t->stats.triangles = t->stats.shared = 0;
    NG_TRY(lf_sharing_choose(t, snapshot));
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
        const struct lf_trace_slot *s = &t->slots[i];
        if (!ng_entity_same(s->entity, instance->entity) ||
            s->mesh_key != snapshot->meshes[instance->mesh].key ||
            s->seen.shape != shape_of(snapshot, instance) ||
            (s->shared && s->version != instance->version && !lf_may_share(snapshot, i)) ||
            (s->seen.light == NG_NONE) != (instance->light == NG_NONE))
            return false;
    }
    return true;
}

static ng_result follow(struct lf_tracer *t, const struct ng_snapshot *snapshot)
{
    for (uint32_t i = 0; i < t->slot_count; i++) {
        struct lf_trace_slot *s = &t->slots[i];
        uint32_t before = s->seen.flags;
        lf_instance_read(snapshot, i, &s->seen); // the snapshot's arrays may be elsewhere
        if (s->version == snapshot->instances[i].version)
            continue;
        bool moved = read_instance(s, snapshot);
        if (!moved && ((before ^ s->seen.flags) & NG_INSTANCE_MASKED) == 0)
            continue; // it reflects in another way
        t->stats.updated++;
        bool built = false;
        if (s->triangles.geometry)
            NG_TRY(lf_triangles_move(&s->triangles, s->matrix, &snapshot->meshes[snapshot->instances[i].mesh],
                                     &built));
        t->stats.built += built;
        commit_geometry(s);
    }
    return NG_OK;
}

// Structures that are built now are built around meshes at rest; then these go where they are.
static void settle(struct lf_tracer *t, const struct ng_snapshot *snapshot)
{
    bool any = false;
    for (uint32_t i = 0; i < t->slot_count; i++)
        any |= t->slots[i].triangles.at_rest;
    if (!any)
        return;
    rtcCommitScene(t->scene);
    for (uint32_t i = 0; i < t->slot_count; i++) {
        struct lf_trace_slot *s = &t->slots[i];
        if (!s->triangles.at_rest)
            continue;
        lf_triangles_settle(&s->triangles, s->matrix, &snapshot->meshes[snapshot->instances[i].mesh]);
        commit_geometry(s);
    }
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
    settle(t, snapshot);
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
    t->stats.bytes = t->bytes;
    t->stats.update_ms = (double)(ng_clock_ns() - begin) * 1e-6;
    return result;
}

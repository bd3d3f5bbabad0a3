// One Embree scene of all instances, flattened into world space where memory allows it (sharing.c), and a
// second one that holds the emitters alone.
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
    return &tracer->shown.items[instance]->seen;
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
    lf_slots_forget(t);
    lf_sharing_forget(t);
    if (t->scene)
        rtcReleaseScene(t->scene);
    if (t->emitters)
        rtcReleaseScene(t->emitters);
    t->scene = t->emitters = NULL;
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

// ---- Scenes ----------------------------------------------------------------------------------------------

static void bound_nothing(const struct RTCBoundsFunctionArguments *a)
{
    *a->bounds_o = (struct RTCBounds){.lower_x = INFINITY, .upper_x = -INFINITY};
}

static void attach_nothing(RTCScene scene, RTCGeometry geometry, unsigned int id)
{
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, id);
    rtcReleaseGeometry(geometry);
}

// When the first geometry of a kind comes, or the last goes, Embree builds everything anew, and around where
// things are instead of around the mesh at rest. So there is always one of each kind.
static ng_result keep_kinds(struct lf_tracer *t, RTCScene scene)
{
    RTCGeometry triangle = rtcNewGeometry(t->device, RTC_GEOMETRY_TYPE_TRIANGLE),
                shape = rtcNewGeometry(t->device, RTC_GEOMETRY_TYPE_USER),
                copy = rtcNewGeometry(t->device, RTC_GEOMETRY_TYPE_INSTANCE);
    float *vertex =
        rtcSetNewGeometryBuffer(triangle, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), 1);
    uint32_t *index =
        rtcSetNewGeometryBuffer(triangle, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof *index, 1);
    RTCScene empty = rtcNewScene(t->device);
    if (!vertex || !index || !empty || !shape || !copy)
        return NG_ERROR_MEMORY;
    memset(vertex, 0, 3 * sizeof *vertex);
    memset(index, 0xff, 3 * sizeof *index); // no vertices
    rtcSetGeometryUserPrimitiveCount(shape, 1);
    rtcSetGeometryBoundsFunction(shape, (RTCBoundsFunction)bound_nothing, NULL);
    rtcCommitScene(empty);
    rtcSetGeometryInstancedScene(copy, empty);
    rtcReleaseScene(empty);
    attach_nothing(scene, triangle, 0);
    attach_nothing(scene, shape, 1);
    attach_nothing(scene, copy, 2);
    return NG_OK;
}

static ng_result make_scene(struct lf_tracer *t, RTCScene *out)
{
    *out = rtcNewScene(t->device);
    if (!*out)
        return NG_ERROR_MEMORY;
    // Of the scene, "low" chooses the structure of two levels; each geometry is built in its own quality.
    rtcSetSceneFlags(*out, RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION | RTC_SCENE_FLAG_DYNAMIC);
    rtcSetSceneBuildQuality(*out, RTC_BUILD_QUALITY_LOW);
    return keep_kinds(t, *out);
}

static void commit(struct lf_tracer *t)
{
    rtcCommitScene(t->scene);
    rtcCommitScene(t->emitters);
}

// So that most rays that look for emitters alone end before they begin.
static void find_boxes(struct lf_tracer *t, const struct ng_snapshot *snapshot)
{
    t->box_count = 0;
    t->others_shine = t->lamps = false;
    for (uint32_t i = 0; i < snapshot->instance_count; i++) {
        const struct ng_snapshot_instance *in = &snapshot->instances[i];
        t->lamps |= (in->flags & NG_INSTANCE_LAMP) != 0;
        if (in->light == NG_NONE)
            t->others_shine |= lf_max3(t->shown.items[i]->seen.plain.emission) > 0;
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

static ng_result follow(struct lf_tracer *t, const struct ng_snapshot *snapshot)
{
    bool changed = !t->scene;
    if (!t->scene) {
        NG_TRY(make_scene(t, &t->scene));
        NG_TRY(make_scene(t, &t->emitters));
    }
    NG_TRY(lf_slots_find(t, snapshot, &changed));
    if (changed) {
        NG_TRY(lf_sharing_choose(t, snapshot));
        lf_slots_drop_otherwise_shared(t, snapshot);
        lf_sharing_tidy(t);
    }
    NG_TRY(lf_slots_follow(t, snapshot));
    t->snapshot = snapshot;
    find_boxes(t, snapshot);
    if (!changed && !t->stats.updated)
        return NG_OK;
    commit(t);
    if (lf_slots_settle(t, snapshot))
        commit(t);
    return NG_OK;
}

ng_result lf_tracer_update(struct lf_tracer *t, const struct ng_snapshot *snapshot)
{
    NG_REQUIRE(snapshot, "a tracer follows a snapshot");
    uint64_t begin = ng_clock_ns();
    t->stats.updated = t->stats.built = 0;
    t->failed = false;
    ng_result result = follow(t, snapshot);
    if (result == NG_OK && t->failed)
        result = NG_ERROR_MEMORY;
    if (result != NG_OK)
        free_scene(t);
    t->stats.instances = (uint32_t)t->shown.count;
    t->stats.ids = (uint32_t)t->by_id.count;
    t->stats.bytes = t->bytes;
    t->stats.update_ms = (double)(ng_clock_ns() - begin) * 1e-6;
    return result;
}

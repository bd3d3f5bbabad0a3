// Meshes that instances share, where memory is too short for copies of them: each has a scene of its own, in
// its own space, which Embree's instances place in the tracer's.
//
// A flattened scene is traced faster, and has the positions that the rasterizer interpolates: so it is the
// rule, as long as it takes no more than a part of the memory that there is.
#include "base/log.h"
#include "base/system.h"
#include "lightformer/trace/embree_internal.h"

#include <inttypes.h>
#include <stdlib.h>

#define GIB                (1024.0 * 1024.0 * 1024.0)
#define BYTES_A_TRIANGLE   130 // of Embree's structures; their most while they are built
#define BYTES_AN_INSTANCE  1024
#define PART_FOR_FLATTENED 2 // a half

// An instance turns rays into its mesh's space. Beyond these the turned ray may be none (LF_TRACE_FARTHEST),
// or Embree's inverse of the matrix be far off.
#define LEAST_STRETCH 1e-5
#define MOST_STRETCH  1e5
#define LEAST_VOLUME  0.1 // of the matrix's columns, of unit length

static bool keeps_rays(const float m[12])
{
    double c[3][3], length[3];
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < 3; i++)
            c[k][i] = (double)m[i * 4 + k];
        length[k] = sqrt(c[k][0] * c[k][0] + c[k][1] * c[k][1] + c[k][2] * c[k][2]);
        if (!(length[k] >= LEAST_STRETCH && length[k] <= MOST_STRETCH))
            return false;
    }
    double volume = c[0][0] * (c[1][1] * c[2][2] - c[1][2] * c[2][1]) -
                    c[0][1] * (c[1][0] * c[2][2] - c[1][2] * c[2][0]) +
                    c[0][2] * (c[1][0] * c[2][1] - c[1][1] * c[2][0]);
    return fabs(volume) >= LEAST_VOLUME * length[0] * length[1] * length[2];
}

// Whether its size is more than the steps that numbers have where it is: Embree's upper level asserts that
// its parts are not all in one point.
static bool has_size(const struct ng_snapshot_instance *in)
{
    float size = 0, far = 0;
    for (int k = 0; k < 3; k++) {
        size = lf_max(size, in->bounds_max[k] - in->bounds_min[k]);
        far = lf_max(far, lf_max(fabsf(in->bounds_min[k]), fabsf(in->bounds_max[k])));
    }
    return far <= LF_TRACE_FARTHEST && size > 1e-5f * far;
}

bool lf_may_share(const struct lf_tracer *t, const struct ng_snapshot *snapshot, uint32_t index)
{
    const struct ng_snapshot_instance *in = &snapshot->instances[index];
    const struct ng_snapshot_mesh *mesh = &snapshot->meshes[in->mesh];
    return !t->copies.hidden.items[index] && in->light == NG_NONE && !mesh->dynamic &&
           !mesh->rest_positions && mesh->index_count >= 3 && keeps_rays(in->matrix) && has_size(in);
}

static uint64_t bytes_of(const struct ng_snapshot_mesh *mesh)
{
    return 3 * sizeof(float) * (uint64_t)mesh->vertex_count +
           (uint64_t)BYTES_A_TRIANGLE * (mesh->index_count / 3);
}

struct need {
    uint64_t flattened, shared, triangles;
};

// `uses`: of each mesh, by instances that may share it.
static struct need count_need(const struct lf_tracer *t, const struct ng_snapshot *snapshot, uint32_t *uses)
{
    struct need need = {0};
    for (uint32_t i = 0; i < snapshot->instance_count; i++) {
        const struct ng_snapshot_mesh *mesh = &snapshot->meshes[snapshot->instances[i].mesh];
        if (t->copies.hidden.items[i])
            continue;
        bool first = !lf_may_share(t, snapshot, i) || !uses[snapshot->instances[i].mesh]++;
        need.triangles += mesh->index_count / 3;
        need.flattened += BYTES_AN_INSTANCE + bytes_of(mesh);
        need.shared += BYTES_AN_INSTANCE + (first ? bytes_of(mesh) : 0);
    }
    return need;
}

static ng_result make_shared(struct lf_tracer *t, const struct ng_snapshot_mesh *mesh, struct lf_shared *out)
{
    out->scene = rtcNewScene(t->device);
    if (!out->scene)
        return NG_ERROR_MEMORY;
    rtcSetSceneFlags(out->scene, RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
    bool built;
    NG_TRY(lf_triangles_make(t->device, mesh, &out->triangles));
    NG_TRY(lf_triangles_move(&out->triangles, NULL, mesh, &built)); // static: it is at rest
    rtcCommitGeometry(out->triangles.geometry);
    rtcAttachGeometryByID(out->scene, out->triangles.geometry, 0);
    rtcCommitScene(out->scene);
    return NG_OK;
}

// Meshes that were shared before are found by the slots that still show them.
static void keep_shared(struct lf_tracer *t, const struct ng_snapshot *snapshot, const uint32_t *uses)
{
    for (uint32_t i = 0; i < snapshot->instance_count; i++) {
        const struct lf_trace_slot *s = t->shown.items[i];
        uint32_t mesh = snapshot->instances[i].mesh;
        if (s && s->shared && uses[mesh] > 1)
            t->by_mesh.items[mesh] = s->shared;
    }
}

static ng_result share(struct lf_tracer *t, const struct ng_snapshot *snapshot, const uint32_t *uses)
{
    keep_shared(t, snapshot, uses);
    for (uint32_t i = 0; i < snapshot->mesh_count; i++) {
        struct lf_shared **shared = &t->by_mesh.items[i];
        if (uses[i] <= 1)
            continue;
        if (!*shared) {
            *shared = calloc(1, sizeof **shared);
            if (!*shared || !ng_array_push(&t->shared, *shared)) {
                free(*shared);
                return ng_out_of_memory("ray tracing");
            }
        }
        (*shared)->used = true;
    }
    return NG_OK;
}

static ng_result choose(struct lf_tracer *t, const struct ng_snapshot *snapshot, uint32_t *uses)
{
    const struct need need = count_need(t, snapshot, uses);
    t->most_bytes = t->memory_limit ? t->memory_limit : ng_system_available_memory() + t->bytes;
    if (need.flattened <= t->most_bytes / PART_FOR_FLATTENED)
        return NG_OK;
    if (need.shared <= t->most_bytes)
        return share(t, snapshot, uses);
    ng_log_error(
        "ray tracing: %u meshes of %" PRIu64 " triangles need %.1f GiB of memory, and there are %.1f; show "
        "fewer or simpler ones, or end other programs",
        snapshot->instance_count, need.triangles, (double)need.shared / GIB, (double)t->most_bytes / GIB);
    return NG_ERROR_MEMORY;
}

ng_result lf_sharing_choose(struct lf_tracer *t, const struct ng_snapshot *snapshot)
{
    t->by_mesh.count = 0;
    for (size_t i = 0; i < t->shared.count; i++)
        t->shared.items[i]->used = false;
    uint32_t *uses = calloc(snapshot->mesh_count ? snapshot->mesh_count : 1, sizeof *uses);
    bool room = uses && ng_array_resize(&t->by_mesh, snapshot->mesh_count);
    ng_result r = room ? choose(t, snapshot, uses) : ng_out_of_memory("ray tracing");
    free(uses);
    return r;
}

static void free_shared(struct lf_shared *shared)
{
    if (shared->triangles.geometry)
        rtcReleaseGeometry(shared->triangles.geometry);
    if (shared->scene)
        rtcReleaseScene(shared->scene);
    free(shared);
}

void lf_sharing_tidy(struct lf_tracer *t)
{
    for (size_t i = t->shared.count; i-- > 0;) {
        if (t->shared.items[i]->used)
            continue;
        free_shared(t->shared.items[i]);
        ng_array_swap_remove(&t->shared, i);
    }
}

void lf_sharing_forget(struct lf_tracer *t)
{
    for (size_t i = 0; i < t->shared.count; i++)
        free_shared(t->shared.items[i]);
    ng_array_finish(&t->shared);
    ng_array_finish(&t->by_mesh);
}

void lf_sharing_place(struct lf_trace_slot *s)
{
    rtcSetGeometryTransform(s->geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, s->matrix);
    // Some instance's is enough: the filter asks the one that is met.
    if (s->seen.flags & NG_INSTANCE_MASKED && !s->shared->masked) {
        s->shared->masked = true;
        lf_triangles_mask(&s->shared->triangles, true);
        rtcCommitGeometry(s->shared->triangles.geometry);
        rtcCommitScene(s->shared->scene);
    }
}

ng_result lf_sharing_attach(struct lf_tracer *t, struct lf_shared *shared,
                            const struct ng_snapshot_mesh *mesh, struct lf_trace_slot *s)
{
    if (!shared->scene)
        NG_TRY(make_shared(t, mesh, shared));
    s->geometry = rtcNewGeometry(t->device, RTC_GEOMETRY_TYPE_INSTANCE);
    if (!s->geometry)
        return NG_ERROR_MEMORY;
    s->shared = shared;
    rtcSetGeometryInstancedScene(s->geometry, shared->scene);
    return NG_OK;
}

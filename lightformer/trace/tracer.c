// One Embree scene of all instances, flattened into world space, and a second one that holds the emitters
// alone. A slot per instance remembers what it was built from, so that an update touches what differs.
//
// The scene has two levels: a structure per instance, and a small one over them. So what moves is refitted
// alone (README.md has the figures).
//
// The device has one thread: what a parallel build makes may depend on their number, and with it which of two
// surfaces in the same place is met.
#include "lightformer/trace/tracer.h"

#include "base/array.h"
#include "base/log.h"
#include "base/system.h"
#include "lightformer/trace/tracer_internal.h"
#include "lightformer/trace/vec.h"

#include <embree3/rtcore.h>
#include <stdlib.h>
#include <string.h>

#define MAX_BOXES 8

// One instance. Stays where it is while Embree knows it.
struct slot {
    struct lf_tracer *tracer;
    RTCGeometry geometry;
    uint32_t instance;
    struct lf_instance seen; // by rays
    ng_entity entity;
    uint64_t mesh_key, mesh_revision, version;
    float matrix[12];
    float *vertices; // Embree's, world space
};

// Around an emitter.
struct box {
    float low[3], high[3];
};

struct lf_tracer {
    RTCDevice device;
    RTCScene scene, emitters;
    struct box boxes[MAX_BOXES];
    uint32_t box_count; // more than MAX_BOXES: not all are kept, and Embree decides
    bool others_shine;  // some surface has emission without being a light's
    struct slot *slots;
    uint32_t slot_count;
    const struct ng_snapshot *snapshot;
    struct lf_srgb srgb;
    struct lf_tracer_stats stats;
    bool failed; // Embree, since the last update began
};

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

// ---- meetings --------------------------------------------------------------------------------------------
// What a ray looks for; Embree hands the context to every callback.
struct query {
    struct RTCIntersectContext context;
    enum lf_ray_kind kind;
    uint32_t passes;   // a light whose emitter is not there; NG_NONE: none
    lf_trace_fn visit; // every meeting is visited, none ends the ray
    void *user;
};

// Facing side of a disk: -Z of its placement, as light/light.h says.
static void disk_axes(const struct slot *s, float x[3], float y[3], float normal[3])
{
    float z[3];
    for (int i = 0; i < 3; i++) {
        x[i] = s->matrix[i * 4];
        y[i] = s->matrix[i * 4 + 1];
        z[i] = s->matrix[i * 4 + 2];
    }
    lf_cross(x, y, normal);
    lf_normalize(normal);
    if (lf_dot(normal, z) > 0)
        lf_scale(normal, -1, normal);
}

static void slot_center(const struct slot *s, float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = s->matrix[i * 4 + 3];
}

static float sphere_radius(const struct slot *s)
{
    return s->matrix[0]; // ng_light_surface of spheres is uniform
}

// Unit normal of the front. Embree's normal of a triangle follows the order of its vertices.
static void find_normal(const struct slot *s, const struct RTCHit *h, struct lf_hit *hit)
{
    float x[3], y[3], sign = s->seen.flags & NG_INSTANCE_MIRRORED ? -1.0f : 1.0f;
    switch (s->seen.shape) {
    case LF_SHAPE_TRIANGLES:
        hit->normal[0] = sign * h->Ng_x;
        hit->normal[1] = sign * h->Ng_y;
        hit->normal[2] = sign * h->Ng_z;
        lf_normalize(hit->normal);
        break;
    case LF_SHAPE_DISK:
        disk_axes(s, x, y, hit->normal);
        break;
    case LF_SHAPE_SPHERE:
        slot_center(s, x);
        lf_mad(hit->position, x, -1, hit->normal);
        lf_normalize(hit->normal);
        lf_mad(x, hit->normal, sphere_radius(s), hit->position); // exactly on it
        break;
    }
}

// The whole hit from what Embree tells of it. Nothing of the triangle is read: that would wait for memory.
static void describe(const struct slot *s, const struct RTCRay *ray, const struct RTCHit *h,
                     struct lf_hit *out)
{
    const float origin[3] = {ray->org_x, ray->org_y, ray->org_z};
    const float direction[3] = {ray->dir_x, ray->dir_y, ray->dir_z};
    out->instance = s->instance;
    out->triangle = h->primID;
    out->barycentric[0] = h->u;
    out->barycentric[1] = h->v;
    out->distance = ray->tfar;
    lf_mad(origin, direction, ray->tfar, out->position);
    find_normal(s, h, out);
    out->front = lf_dot(out->normal, direction) < 0;
}

// Whether the query takes this meeting as its hit.
static bool accepts(const struct query *q, const struct slot *s, const struct RTCRay *ray,
                    const struct RTCHit *h)
{
    struct lf_hit hit;
    if (q->passes != NG_NONE && s->seen.light == q->passes)
        return false;
    if (!q->visit && (q->kind == LF_RAY_ALL || s->seen.flags & NG_INSTANCE_DOUBLE_SIDED))
        return true;
    describe(s, ray, h, &hit);
    if (q->visit)
        q->visit(q->user, &hit);
    return !q->visit && hit.front;
}

// Callbacks see a packet of N rays, in which each member of struct RTCRay (or RTCHit), all of four bytes and
// in the same order, has become N of them. Alone, a ray is a packet of one.
static void take_lane(void *one, size_t size, const void *packet, unsigned int n, unsigned int i)
{
    for (size_t k = 0; k < size / 4; k++)
        memcpy((char *)one + 4 * k, (const char *)packet + 4 * (k * n + i), 4);
}

static void put_lane(void *packet, const void *one, size_t size, unsigned int n, unsigned int i)
{
    for (size_t k = 0; k < size / 4; k++)
        memcpy((char *)packet + 4 * (k * n + i), (const char *)one + 4 * k, 4);
}

static struct RTCRay ray_of(const void *packet, unsigned int n, unsigned int i)
{
    struct RTCRay ray;
    take_lane(&ray, sizeof ray, packet, n, i);
    return ray;
}

static struct RTCHit hit_of(const void *packet, unsigned int n, unsigned int i)
{
    struct RTCHit hit;
    take_lane(&hit, sizeof hit, packet, n, i);
    return hit;
}

static void filter_query(const struct RTCFilterFunctionNArguments *a)
{
    for (unsigned int i = 0; i < a->N; i++) {
        if (!a->valid[i])
            continue;
        struct RTCRay ray = ray_of(a->ray, a->N, i);
        struct RTCHit hit = hit_of(a->hit, a->N, i);
        if (!accepts((const void *)a->context, a->geometryUserPtr, &ray, &hit))
            a->valid[i] = 0;
    }
}

static void filter_mask(const struct RTCFilterFunctionNArguments *a)
{
    const struct slot *s = a->geometryUserPtr;
    for (unsigned int i = 0; i < a->N; i++) {
        if (!a->valid[i])
            continue;
        struct RTCHit hit = hit_of(a->hit, a->N, i);
        const float barycentric[2] = {hit.u, hit.v};
        if (lf_surface_is_cut(s->tracer, s->instance, hit.primID, barycentric))
            a->valid[i] = 0;
    }
}

// ---- exact shapes ----------------------------------------------------------------------------------------
static void shape_bounds(const struct RTCBoundsFunctionArguments *a)
{
    const struct slot *s = a->geometryUserPtr;
    float low[3], high[3];
    for (int i = 0; i < 3; i++) {
        const float *m = s->matrix + i * 4;
        float reach = s->seen.shape == LF_SHAPE_SPHERE ? sphere_radius(s) : sqrtf(m[0] * m[0] + m[1] * m[1]);
        reach += 1e-5f * (reach + fabsf(m[3])); // rounding
        low[i] = m[3] - reach;
        high[i] = m[3] + reach;
    }
    *a->bounds_o = (struct RTCBounds){.lower_x = low[0],
                                      .lower_y = low[1],
                                      .lower_z = low[2],
                                      .upper_x = high[0],
                                      .upper_y = high[1],
                                      .upper_z = high[2]};
}

// Distances along the ray at which it meets the shape, ascending; how many.
static int meet_disk(const struct slot *s, const float origin[3], const float direction[3], float t[2])
{
    float x[3], y[3], n[3], center[3], to[3], p[3];
    disk_axes(s, x, y, n);
    slot_center(s, center);
    lf_mad(center, origin, -1, to);
    t[0] = lf_dot(to, n) / lf_dot(direction, n);
    if (!isfinite(t[0]))
        return 0;
    lf_mad(origin, direction, t[0], p);
    lf_mad(p, center, -1, p);
    // The axes need not be perpendicular.
    float xx = lf_dot(x, x), xy = lf_dot(x, y), yy = lf_dot(y, y), px = lf_dot(p, x), py = lf_dot(p, y);
    float determinant = xx * yy - xy * xy;
    float a = (px * yy - py * xy) / determinant, b = (py * xx - px * xy) / determinant;
    return a * a + b * b <= 1;
}

static int meet_sphere(const struct slot *s, const float origin[3], const float direction[3], float t[2])
{
    double b = 0, d = 0, r = (double)sphere_radius(s);
    for (int i = 0; i < 3; i++) {
        double o = (double)origin[i] - (double)s->matrix[i * 4 + 3];
        b += o * (double)direction[i];
    }
    for (int i = 0; i < 3; i++) { // the squared distance of the line, without cancellation
        double o = (double)origin[i] - (double)s->matrix[i * 4 + 3] - b * (double)direction[i];
        d += o * o;
    }
    if (!(d < r * r))
        return 0;
    double half = sqrt(r * r - d);
    t[0] = (float)(-b - half);
    t[1] = (float)(-b + half);
    return 2;
}

static int meet(const struct slot *s, const struct RTCRay *ray, float t[2])
{
    const float origin[3] = {ray->org_x, ray->org_y, ray->org_z};
    const float direction[3] = {ray->dir_x, ray->dir_y, ray->dir_z};
    return s->seen.shape == LF_SHAPE_DISK ? meet_disk(s, origin, direction, t)
                                          : meet_sphere(s, origin, direction, t);
}

// The nearest place that the query accepts; sets `ray->tfar` to it.
static bool meet_query(const void *context, unsigned int geometry, const struct slot *s, struct RTCRay *ray,
                       struct RTCHit *hit)
{
    float t[2] = {0}, far = ray->tfar;
    int count = meet(s, ray, t);
    for (int k = 0; k < count; k++) {
        if (!(t[k] > ray->tnear) || !(t[k] < far))
            continue;
        *hit = (struct RTCHit){.geomID = geometry, .primID = 0, .instID = {RTC_INVALID_GEOMETRY_ID}};
        ray->tfar = t[k];
        if (accepts(context, s, ray, hit))
            return true;
    }
    return false;
}

static void shape_intersect(const struct RTCIntersectFunctionNArguments *a)
{
    for (unsigned int i = 0; i < a->N; i++) {
        struct RTCRay ray = ray_of(a->rayhit, a->N, i);
        struct RTCHit hit;
        if (!a->valid[i] || !meet_query(a->context, a->geomID, a->geometryUserPtr, &ray, &hit))
            continue;
        put_lane(a->rayhit, &ray, sizeof ray, a->N, i);
        put_lane((char *)a->rayhit + sizeof ray * a->N, &hit, sizeof hit, a->N, i);
    }
}

static void shape_occluded(const struct RTCOccludedFunctionNArguments *a)
{
    for (unsigned int i = 0; i < a->N; i++) {
        struct RTCRay ray = ray_of(a->ray, a->N, i);
        struct RTCHit hit;
        if (!a->valid[i] || !meet_query(a->context, a->geomID, a->geometryUserPtr, &ray, &hit))
            continue;
        ray.tfar = -INFINITY;
        put_lane(a->ray, &ray, sizeof ray, a->N, i);
    }
}

// ---- building --------------------------------------------------------------------------------------------
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

static void write_vertices(struct slot *s, const struct ng_snapshot_mesh *mesh)
{
    for (size_t i = 0; i < mesh->vertex_count; i++)
        lf_transform_point(s->matrix, mesh->positions + i * 3, s->vertices + i * 3);
}

// Reads what an instance is now; true if its place or form is another.
static bool read_instance(struct slot *s, const struct ng_snapshot *snapshot)
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

static ng_result make_triangles(struct lf_tracer *t, struct slot *s, const struct ng_snapshot_mesh *mesh)
{
    s->geometry = rtcNewGeometry(t->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    s->vertices = rtcSetNewGeometryBuffer(s->geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                          3 * sizeof(float), mesh->vertex_count ? mesh->vertex_count : 1);
    uint32_t *indices = rtcSetNewGeometryBuffer(s->geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                3 * sizeof(uint32_t), mesh->index_count / 3);
    if (!s->vertices || (!indices && mesh->index_count))
        return NG_ERROR_MEMORY;
    write_vertices(s, mesh);
    if (mesh->index_count)
        memcpy(indices, mesh->indices, (size_t)(mesh->index_count / 3 * 3) * sizeof(uint32_t));
    t->stats.triangles += mesh->index_count / 3;
    return NG_OK;
}

static void make_shape(struct lf_tracer *t, struct slot *s)
{
    s->geometry = rtcNewGeometry(t->device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(s->geometry, 1);
    rtcSetGeometryBoundsFunction(s->geometry, (RTCBoundsFunction)shape_bounds, NULL);
    rtcSetGeometryIntersectFunction(s->geometry, shape_intersect);
    rtcSetGeometryOccludedFunction(s->geometry, shape_occluded);
}

static void commit_geometry(struct slot *s)
{
    if (s->seen.shape == LF_SHAPE_TRIANGLES) {
        bool masked = s->seen.flags & NG_INSTANCE_MASKED;
        rtcSetGeometryIntersectFilterFunction(s->geometry, masked ? filter_mask : NULL);
        rtcSetGeometryOccludedFilterFunction(s->geometry, masked ? filter_mask : NULL);
    }
    rtcCommitGeometry(s->geometry);
}

static ng_result make_slot(struct lf_tracer *t, const struct ng_snapshot *snapshot, uint32_t index)
{
    struct slot *s = &t->slots[index];
    const struct ng_snapshot_instance *instance = &snapshot->instances[index];
    const struct ng_snapshot_mesh *mesh = &snapshot->meshes[instance->mesh];
    *s = (struct slot){.tracer = t,
                       .instance = index,
                       .seen.shape = shape_of(snapshot, instance),
                       .entity = instance->entity,
                       .mesh_key = mesh->key};
    lf_instance_read(snapshot, index, &s->seen);
    read_instance(s, snapshot);
    if (s->seen.shape != LF_SHAPE_TRIANGLES)
        make_shape(t, s);
    else if (make_triangles(t, s, mesh) != NG_OK)
        return NG_ERROR_MEMORY;
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
        const struct slot *s = &t->slots[i];
        if (!ng_entity_same(s->entity, instance->entity) ||
            s->mesh_key != snapshot->meshes[instance->mesh].key ||
            s->seen.shape != shape_of(snapshot, instance) ||
            (s->seen.light == NG_NONE) != (instance->light == NG_NONE))
            return false;
    }
    return true;
}

static void follow(struct lf_tracer *t, const struct ng_snapshot *snapshot)
{
    for (uint32_t i = 0; i < t->slot_count; i++) {
        struct slot *s = &t->slots[i];
        uint32_t before = s->seen.flags;
        lf_instance_read(snapshot, i, &s->seen); // the snapshot's arrays may be elsewhere
        if (s->version == snapshot->instances[i].version)
            continue;
        bool moved = read_instance(s, snapshot);
        if (!moved && ((before ^ s->seen.flags) & NG_INSTANCE_MASKED) == 0)
            continue; // it reflects in another way
        t->stats.updated++;
        if (s->seen.shape == LF_SHAPE_TRIANGLES) {
            rtcSetGeometryBuildQuality(s->geometry, RTC_BUILD_QUALITY_REFIT);
            write_vertices(s, &snapshot->meshes[snapshot->instances[i].mesh]);
            rtcUpdateGeometryBuffer(s->geometry, RTC_BUFFER_TYPE_VERTEX, 0);
        }
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
        if (in->light == NG_NONE || ++t->box_count > MAX_BOXES)
            continue;
        struct box *box = &t->boxes[t->box_count - 1];
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
    if (same)
        follow(t, snapshot);
    else
        NG_TRY(build(t, snapshot));
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

// ---- rays ------------------------------------------------------------------------------------------------
// In place: what is written member by member and then copied as a whole waits for the stores.
static void aim(const struct lf_ray *ray, struct RTCRay *out)
{
    out->org_x = ray->origin[0];
    out->org_y = ray->origin[1];
    out->org_z = ray->origin[2];
    out->tnear = ray->near;
    out->dir_x = ray->direction[0];
    out->dir_y = ray->direction[1];
    out->dir_z = ray->direction[2];
    out->time = 0;
    out->tfar = ray->far;
    out->mask = UINT32_MAX;
    out->id = 0;
    out->flags = 0;
}

static void begin_query(enum lf_ray_kind kind, lf_trace_fn visit, void *user, struct query *out)
{
    rtcInitIntersectContext(&out->context);
    out->kind = kind;
    out->passes = NG_NONE;
    out->visit = visit;
    out->user = user;
    if (visit || kind == LF_RAY_CAMERA)
        out->context.filter = filter_query;
}

// Of LF_RAY_ALL. `light`: whose emitter is passed, or NG_NONE.
static void begin_passing(uint32_t light, struct query *out)
{
    begin_query(LF_RAY_ALL, NULL, NULL, out);
    out->passes = light;
    if (light != NG_NONE)
        out->context.filter = filter_query;
}

static bool intersect(RTCScene scene, const struct lf_ray *ray, struct query *q, struct RTCRayHit *out)
{
    aim(ray, &out->ray);
    out->hit.geomID = RTC_INVALID_GEOMETRY_ID;
    out->hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene, &q->context, out);
    return out->hit.geomID != RTC_INVALID_GEOMETRY_ID;
}

bool lf_trace_closest(const struct lf_tracer *t, const struct lf_ray *ray, enum lf_ray_kind kind,
                      struct lf_hit *out)
{
    struct query q;
    struct RTCRayHit rayhit;
    begin_query(kind, NULL, NULL, &q);
    if (!intersect(t->scene, ray, &q, &rayhit))
        return false;
    describe(&t->slots[rayhit.hit.geomID], &rayhit.ray, &rayhit.hit, out);
    return true;
}

bool lf_trace_shadowed(const struct lf_tracer *t, const struct lf_ray *ray, uint32_t light)
{
    struct query q;
    struct RTCRay r;
    begin_passing(light, &q);
    aim(ray, &r);
    rtcOccluded1(t->scene, &q.context, &r);
    return r.tfar < 0;
}

bool lf_trace_occluded(const struct lf_tracer *t, const struct lf_ray *ray)
{
    return lf_trace_shadowed(t, ray, NG_NONE);
}

// As Embree wants them; what is no ray is not valid.
static void aim_side_by_side(const struct lf_packet *p, struct query *q, int valid[LF_PACKET],
                             struct RTCRayHit16 *out)
{
    begin_passing(p->passes, q);
    q->context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    *out = (struct RTCRayHit16){0};
    for (int i = 0; i < LF_PACKET; i++) {
        valid[i] = p->far[i] > 0 ? -1 : 0;
        out->ray.mask[i] = UINT32_MAX;
        out->hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    }
    memcpy(&out->ray.org_x, p->origin[0], sizeof p->origin[0]);
    memcpy(&out->ray.org_y, p->origin[1], sizeof p->origin[1]);
    memcpy(&out->ray.org_z, p->origin[2], sizeof p->origin[2]);
    memcpy(&out->ray.dir_x, p->direction[0], sizeof p->direction[0]);
    memcpy(&out->ray.dir_y, p->direction[1], sizeof p->direction[1]);
    memcpy(&out->ray.dir_z, p->direction[2], sizeof p->direction[2]);
    memcpy(&out->ray.tfar, p->far, sizeof p->far);
}

void lf_trace_packet_occluded(const struct lf_tracer *t, struct lf_packet *p)
{
    struct query q;
    struct RTCRayHit16 r;
    _Alignas(64) int valid[LF_PACKET];
    aim_side_by_side(p, &q, valid, &r);
    rtcOccluded16(valid, t->scene, &q.context, &r.ray);
    for (int i = 0; i < LF_PACKET; i++)
        p->met[i] = valid[i] && r.ray.tfar[i] < 0;
}

void lf_trace_packet(const struct lf_tracer *t, struct lf_packet *p, struct lf_hit *hits)
{
    struct query q;
    struct RTCRayHit16 r;
    _Alignas(64) int valid[LF_PACKET];
    aim_side_by_side(p, &q, valid, &r);
    rtcIntersect16(valid, t->scene, &q.context, &r);
    for (unsigned int i = 0; i < LF_PACKET; i++) {
        p->met[i] = valid[i] && r.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
        p->far[i] = r.ray.tfar[i];
        if (p->met[i] && hits) {
            struct RTCRay ray = ray_of(&r.ray, LF_PACKET, i);
            struct RTCHit hit = hit_of(&r.hit, LF_PACKET, i);
            describe(&t->slots[hit.geomID], &ray, &hit, &hits[i]);
        }
    }
}

// Up to LF_PACKET rays; lanes without a ray are not valid.
static void aim_packet(const struct lf_ray *rays, uint32_t count, int valid[LF_PACKET], struct RTCRay16 *out)
{
    for (uint32_t i = 0; i < LF_PACKET; i++) {
        const struct lf_ray *ray = &rays[i < count ? i : 0];
        valid[i] = i < count ? -1 : 0;
        out->org_x[i] = ray->origin[0];
        out->org_y[i] = ray->origin[1];
        out->org_z[i] = ray->origin[2];
        out->tnear[i] = ray->near;
        out->dir_x[i] = ray->direction[0];
        out->dir_y[i] = ray->direction[1];
        out->dir_z[i] = ray->direction[2];
        out->time[i] = 0;
        out->tfar[i] = ray->far;
        out->mask[i] = UINT32_MAX;
        out->id[i] = 0;
        out->flags[i] = 0;
    }
}

void lf_trace_closest_many(const struct lf_tracer *t, const struct lf_ray *rays, uint32_t count, bool *met,
                           struct lf_hit *hits)
{
    struct query q;
    struct RTCRayHit16 r;
    _Alignas(64) int valid[LF_PACKET];
    begin_query(LF_RAY_ALL, NULL, NULL, &q);
    for (uint32_t begin = 0; begin < count; begin += LF_PACKET) {
        uint32_t lanes = count - begin < LF_PACKET ? count - begin : LF_PACKET;
        aim_packet(rays + begin, lanes, valid, &r.ray);
        for (uint32_t i = 0; i < LF_PACKET; i++)
            r.hit.geomID[i] = r.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect16(valid, t->scene, &q.context, &r);
        for (unsigned int i = 0; i < lanes; i++) {
            met[begin + i] = r.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
            if (!met[begin + i])
                continue;
            struct RTCRay ray = ray_of(&r.ray, LF_PACKET, i);
            struct RTCHit hit = hit_of(&r.hit, LF_PACKET, i);
            describe(&t->slots[hit.geomID], &ray, &hit, &hits[begin + i]);
        }
    }
}

void lf_trace_occluded_many(const struct lf_tracer *t, const struct lf_ray *rays, uint32_t count, bool *met)
{
    struct query q;
    struct RTCRay16 r;
    _Alignas(64) int valid[LF_PACKET];
    begin_query(LF_RAY_ALL, NULL, NULL, &q);
    for (uint32_t begin = 0; begin < count; begin += LF_PACKET) {
        uint32_t lanes = count - begin < LF_PACKET ? count - begin : LF_PACKET;
        aim_packet(rays + begin, lanes, valid, &r);
        rtcOccluded16(valid, t->scene, &q.context, &r);
        for (uint32_t i = 0; i < lanes; i++)
            met[begin + i] = r.tfar[i] < 0;
    }
}

static bool passes(const struct lf_ray *ray, const struct box *b)
{
    float near = ray->near, far = ray->far;
    for (int k = 0; k < 3; k++) {
        float inverse = 1 / ray->direction[k];
        float a = (b->low[k] - ray->origin[k]) * inverse, c = (b->high[k] - ray->origin[k]) * inverse;
        // In the plane of a face one of them is not a number; then either answer is right.
        near = lf_max(lf_min(a, c), near);
        far = lf_min(lf_max(a, c), far);
    }
    return near <= far;
}

static bool passes_emitters(const struct lf_tracer *t, const struct lf_ray *ray)
{
    bool near = t->box_count > MAX_BOXES;
    for (uint32_t i = 0; !near && i < t->box_count; i++)
        near = passes(ray, &t->boxes[i]);
    return near;
}

bool lf_trace_may_shine(const struct lf_tracer *t, const struct lf_ray *ray)
{
    return t->others_shine || passes_emitters(t, ray);
}

bool lf_trace_emitters(const struct lf_tracer *t, const struct lf_ray *ray, lf_trace_fn visit, void *user)
{
    if (!passes_emitters(t, ray))
        return false;
    struct query q;
    struct RTCRayHit rayhit;
    begin_query(LF_RAY_ALL, visit, user, &q);
    intersect(t->emitters, ray, &q, &rayhit);
    return true;
}

uint32_t lf_trace_bare(const struct lf_tracer *t, const struct lf_ray *rays, uint32_t count)
{
    uint32_t met = 0;
    for (uint32_t i = 0; i < count; i++) {
        struct query q;
        struct RTCRayHit rayhit;
        begin_query(LF_RAY_ALL, NULL, NULL, &q);
        met += intersect(t->scene, &rays[i], &q, &rayhit);
    }
    return met;
}

void lf_trace_origin(const struct lf_tracer *t, const float position[3], const float normal[3],
                     const float direction[3], float out[3])
{
    float off = lf_trace_offset(t->snapshot->scene_radius, position[0], position[1], position[2]);
    lf_mad(position, normal, copysignf(off, lf_dot(normal, direction)), out);
}

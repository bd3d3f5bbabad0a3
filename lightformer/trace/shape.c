// The surfaces of sphere and disk lights as exact spheres and ellipses, geometries of Embree's own kind
// "user".
#include "lightformer/trace/embree_internal.h"

// Facing side of a disk: -Z of its placement, as light/light.h says.
static void disk_axes(const struct lf_trace_slot *s, float x[3], float y[3], float normal[3])
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

static void slot_center(const struct lf_trace_slot *s, float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = s->matrix[i * 4 + 3];
}

static float sphere_radius(const struct lf_trace_slot *s)
{
    return s->matrix[0]; // ng_light_surface of spheres is uniform
}

void lf_shape_normal(const struct lf_trace_slot *s, float position[3], float normal[3])
{
    float x[3], y[3];
    if (s->seen.shape == LF_SHAPE_DISK) {
        disk_axes(s, x, y, normal);
        return;
    }
    slot_center(s, x);
    lf_mad(position, x, -1, normal);
    lf_normalize(normal);
    lf_mad(x, normal, sphere_radius(s), position); // exactly on it
}

static void shape_bounds(const struct RTCBoundsFunctionArguments *a)
{
    const struct lf_trace_slot *s = a->geometryUserPtr;
    float low[3], high[3];
    bool empty = true;
    for (int i = 0; i < 3; i++) {
        const float *m = s->matrix + i * 4;
        float reach = s->seen.shape == LF_SHAPE_SPHERE ? sphere_radius(s) : sqrtf(m[0] * m[0] + m[1] * m[1]);
        reach += 1e-5f * (reach + fabsf(m[3])); // rounding
        low[i] = lf_within_reach(m[3] - reach);
        high[i] = lf_within_reach(m[3] + reach);
        empty &= !(low[i] < high[i]);
    }
    if (empty) { // see is_point in triangles.c
        *a->bounds_o = (struct RTCBounds){.lower_x = INFINITY, .upper_x = -INFINITY};
        return;
    }
    *a->bounds_o = (struct RTCBounds){.lower_x = low[0],
                                      .lower_y = low[1],
                                      .lower_z = low[2],
                                      .upper_x = high[0],
                                      .upper_y = high[1],
                                      .upper_z = high[2]};
}

// Distances along the ray at which it meets the shape, ascending; how many.
static int meet_disk(const struct lf_trace_slot *s, const float origin[3], const float direction[3],
                     float t[2])
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

static int meet_sphere(const struct lf_trace_slot *s, const float origin[3], const float direction[3],
                       float t[2])
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

static int meet(const struct lf_trace_slot *s, const struct RTCRay *ray, float t[2])
{
    const float origin[3] = {ray->org_x, ray->org_y, ray->org_z};
    const float direction[3] = {ray->dir_x, ray->dir_y, ray->dir_z};
    return s->seen.shape == LF_SHAPE_DISK ? meet_disk(s, origin, direction, t)
                                          : meet_sphere(s, origin, direction, t);
}

// The nearest place that the query accepts; sets `ray->tfar` to it.
static bool meet_query(const void *context, unsigned int geometry, const struct lf_trace_slot *s,
                       struct RTCRay *ray, struct RTCHit *hit)
{
    float t[2] = {0}, far = ray->tfar;
    int count = meet(s, ray, t);
    for (int k = 0; k < count; k++) {
        if (!(t[k] > ray->tnear) || !(t[k] < far))
            continue;
        *hit = (struct RTCHit){.geomID = geometry, .primID = 0, .instID = {RTC_INVALID_GEOMETRY_ID}};
        ray->tfar = t[k];
        if (lf_accepts(context, s, ray, hit))
            return true;
    }
    return false;
}

static void shape_intersect(const struct RTCIntersectFunctionNArguments *a)
{
    for (unsigned int i = 0; i < a->N; i++) {
        struct RTCRay ray = lf_ray_of(a->rayhit, a->N, i);
        struct RTCHit hit;
        if (!a->valid[i] || !meet_query(a->context, a->geomID, a->geometryUserPtr, &ray, &hit))
            continue;
        lf_put_lane(a->rayhit, &ray, sizeof ray, a->N, i);
        lf_put_lane((char *)a->rayhit + sizeof ray * a->N, &hit, sizeof hit, a->N, i);
    }
}

static void shape_occluded(const struct RTCOccludedFunctionNArguments *a)
{
    for (unsigned int i = 0; i < a->N; i++) {
        struct RTCRay ray = lf_ray_of(a->ray, a->N, i);
        struct RTCHit hit;
        if (!a->valid[i] || !meet_query(a->context, a->geomID, a->geometryUserPtr, &ray, &hit))
            continue;
        ray.tfar = -INFINITY;
        lf_put_lane(a->ray, &ray, sizeof ray, a->N, i);
    }
}

void lf_shape_set(RTCGeometry geometry, struct lf_trace_slot *slot)
{
    rtcSetGeometryUserData(geometry, slot);
    rtcSetGeometryUserPrimitiveCount(geometry, 1);
    rtcSetGeometryBoundsFunction(geometry, (RTCBoundsFunction)shape_bounds, NULL);
    rtcSetGeometryIntersectFunction(geometry, shape_intersect);
    rtcSetGeometryOccludedFunction(geometry, shape_occluded);
}

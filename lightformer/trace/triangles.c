// Meshes as triangles of Embree: of an instance in world space, or of a mesh in its own.
#include "lightformer/trace/embree_internal.h"

#define MOST_TURNED 65536 // triangles

// A null matrix: as they are.
static void write_vertices(struct lf_triangles *t, const float matrix[12], const float *positions,
                           uint32_t count)
{
    for (size_t i = 0; i < count; i++) {
        float *out = t->vertices + i * 3;
        if (matrix)
            lf_transform_point(matrix, positions + i * 3, out);
        else
            memcpy(out, positions + i * 3, 3 * sizeof *out);
        for (int k = 0; k < 3; k++)
            out[k] = lf_within_reach(out[k]);
    }
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

static bool is_left_out(const struct lf_triangles *t, size_t i)
{
    return t->own_indices && t->own_indices[i] == UINT32_MAX;
}

static bool has_points(const struct lf_triangles *t, const struct ng_snapshot_mesh *mesh)
{
    for (size_t i = 0; i + 2 < mesh->index_count; i += 3)
        if (!is_left_out(t, i) && is_point(t->vertices, mesh->indices + i))
            return true;
    return false;
}

// Embree builds without a triangle whose indices are no vertices. True where it is to leave out others than
// before, and so has to build anew.
static bool leave_out_points(struct lf_triangles *t, const struct ng_snapshot_mesh *mesh)
{
    static const uint32_t none[3] = {UINT32_MAX, UINT32_MAX, UINT32_MAX};
    bool changed = false;
    for (size_t i = 0; i + 2 < mesh->index_count; i += 3) {
        const uint32_t *now = is_point(t->vertices, mesh->indices + i) ? none : mesh->indices + i;
        changed |= t->own_indices[i] != now[0];
        memcpy(t->own_indices + i, now, sizeof none);
    }
    return changed;
}

// The mesh's own indices, as long as they are all of triangles. `*changed` as above.
static ng_result set_indices(struct lf_triangles *t, const struct ng_snapshot_mesh *mesh, bool *changed)
{
    const size_t count = mesh->index_count / 3, stride = 3 * sizeof(uint32_t);
    *changed = false;
    if (!t->own_indices && !has_points(t, mesh)) {
        if (t->indices != mesh->indices)
            rtcSetSharedGeometryBuffer(t->geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh->indices,
                                       0, stride, count);
        t->indices = mesh->indices;
        return NG_OK;
    }
    if (!t->own_indices) {
        t->own_indices =
            rtcSetNewGeometryBuffer(t->geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, stride, count);
        if (!t->own_indices)
            return NG_ERROR_MEMORY;
        memcpy(t->own_indices, mesh->indices, count * stride);
    }
    *changed = leave_out_points(t, mesh);
    return NG_OK;
}

ng_result lf_triangles_make(RTCDevice device, const struct ng_snapshot_mesh *mesh, struct lf_triangles *out)
{
    out->geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetGeometryBuildQuality(out->geometry, RTC_BUILD_QUALITY_REFIT);
    out->vertices = rtcSetNewGeometryBuffer(out->geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                            3 * sizeof(float), mesh->vertex_count ? mesh->vertex_count : 1);
    return out->vertices ? NG_OK : NG_ERROR_MEMORY;
}

// What turns a mesh as its instance is: boxes fit best around what is turned already. Large ones are built so
// rarely that they stay as they are, and those that joints move have a pose instead.
static bool find_turn(const float matrix[12], const struct ng_snapshot_mesh *mesh, float turn[12])
{
    if (!matrix || mesh->dynamic || mesh->index_count / 3 > MOST_TURNED)
        return false;
    memcpy(turn, matrix, 12 * sizeof *turn);
    turn[3] = turn[7] = turn[11] = 0;
    return true;
}

static bool differ(const float a[12], const float b[12])
{
    bool other = false;
    for (int i = 0; i < 12; i++)
        other |= a[i] != b[i];
    return other;
}

// For a structure to be built around. Where that would leave points, they stay where they are.
static void lay_to_rest(struct lf_triangles *t, const float matrix[12], const struct ng_snapshot_mesh *mesh)
{
    const float *rest = mesh->rest_positions ? mesh->rest_positions : mesh->positions;
    bool turned = find_turn(matrix, mesh, t->turn);
    write_vertices(t, turned ? t->turn : NULL, rest, mesh->vertex_count);
    t->at_rest = !has_points(t, mesh);
    if (!t->at_rest)
        write_vertices(t, matrix, mesh->positions, mesh->vertex_count);
}

ng_result lf_triangles_move(struct lf_triangles *t, const float matrix[12],
                            const struct ng_snapshot_mesh *mesh, bool *built)
{
    bool first = !t->indices && !t->own_indices, changed;
    float turn[12];
    write_vertices(t, matrix, mesh->positions, mesh->vertex_count);
    NG_TRY(set_indices(t, mesh, &changed));
    changed |= find_turn(matrix, mesh, turn) && differ(turn, t->turn);
    if (changed && !first)
        rtcUpdateGeometryBuffer(t->geometry, RTC_BUFFER_TYPE_INDEX, 0);
    *built = changed || first;
    if (*built)
        lay_to_rest(t, matrix, mesh);
    rtcUpdateGeometryBuffer(t->geometry, RTC_BUFFER_TYPE_VERTEX, 0);
    return NG_OK;
}

void lf_triangles_settle(struct lf_triangles *t, const float matrix[12], const struct ng_snapshot_mesh *mesh)
{
    write_vertices(t, matrix, mesh->positions, mesh->vertex_count);
    rtcUpdateGeometryBuffer(t->geometry, RTC_BUFFER_TYPE_VERTEX, 0);
    t->at_rest = false;
}

void lf_triangles_mask(struct lf_triangles *t, bool masked)
{
    rtcSetGeometryIntersectFilterFunction(t->geometry, masked ? lf_filter_mask : NULL);
    rtcSetGeometryOccludedFilterFunction(t->geometry, masked ? lf_filter_mask : NULL);
}

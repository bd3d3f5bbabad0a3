// Faces into primitives: one for each material of a part, indexed, every vertex with a normal. Where the file
// has none they follow from its smoothing groups: flat outside of them, as the format has it.
#include "asset/obj_internal.h"
#include "base/hash.h"
#include "base/log.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_WORK 500000000u // comparisons while polygons are divided: seconds

static const float *position(const struct obj_model *m, int32_t v)
{
    return m->positions.items + (size_t)v * 3;
}

// ---- faces -----------------------------------------------------------------------------------------------
// Twice the area, times the normal (Newell's method).
static void area_of(const struct obj_model *m, const struct obj_face *f, double out[3])
{
    out[0] = out[1] = out[2] = 0;
    for (uint32_t i = 0; i < f->count; i++) {
        const float *a = position(m, m->corners.items[f->corner + i].v);
        const float *b = position(m, m->corners.items[f->corner + (i + 1) % f->count].v);
        for (int k = 0; k < 3; k++) {
            int u = (k + 1) % 3, w = (k + 2) % 3;
            out[k] += ((double)a[u] - (double)b[u]) * ((double)a[w] + (double)b[w]);
        }
    }
}

static bool is_flat_zero(const double area[3])
{
    return !(area[0] * area[0] + area[1] * area[1] + area[2] * area[2] > 0);
}

static bool has_normal(const struct obj_model *m, int32_t n)
{
    const float *v = m->normals.items + (size_t)n * 3;
    float length = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    return length > 1e-20f && isfinite(length);
}

static bool is_finite(const float *v, int count)
{
    for (int i = 0; i < count; i++)
        if (!isfinite(v[i]))
            return false;
    return true;
}

static ng_result check_corner(struct obj_model *m, struct obj_corner *c)
{
    if (c->t < -1 || (c->t >= 0 && (size_t)c->t >= m->uvs.count / 2)) {
        NG_TRY(ng_gltf_fault(m->faults, "the corner has none",
                             "a face names texture coordinates that are not among the %zu",
                             m->uvs.count / 2));
        c->t = -1;
    }
    if (c->n < -1 || (c->n >= 0 && (size_t)c->n >= m->normals.count / 3)) {
        NG_TRY(ng_gltf_fault(m->faults, "one is made", "a face names a normal that is not among the %zu",
                             m->normals.count / 3));
        c->n = -1;
    }
    if (c->n >= 0 && !has_normal(m, c->n))
        c->n = -1;
    if (c->t >= 0 && !is_finite(m->uvs.items + (size_t)c->t * 2, 2)) {
        NG_TRY(
            ng_gltf_fault(m->faults, "the corner has none", "a texture coordinate is not a finite number"));
        c->t = -1;
    }
    return NG_OK;
}

// Sets `*drawn` where a face has an area. What has none is not seen, and nothing is said about it.
static ng_result check_face(struct obj_model *m, const struct obj_face *f, bool *drawn)
{
    double area[3];
    *drawn = false;
    if (f->count < 3)
        return ng_gltf_fault(m->faults, "it is not drawn", "a face has %u corners", f->count);
    for (uint32_t i = 0; i < f->count; i++) {
        struct obj_corner *c = &m->corners.items[f->corner + i];
        if (c->v < 0 || (size_t)c->v >= m->positions.count / 3)
            return ng_gltf_fault(m->faults, "it is not drawn",
                                 "a face names a vertex that is not among the %zu", m->positions.count / 3);
        if (!is_finite(position(m, c->v), 3))
            return ng_gltf_fault(m->faults, "it is not drawn", "a vertex of a face is not a finite number");
        NG_TRY(check_corner(m, c));
    }
    area_of(m, f, area);
    *drawn = !is_flat_zero(area);
    return NG_OK;
}

static ng_result drop_faces(struct obj_model *m)
{
    size_t kept = 0, before = m->faults->list.count;
    for (size_t i = 0; i < m->faces.count; i++) {
        bool drawn;
        NG_TRY(check_face(m, &m->faces.items[i], &drawn));
        if (drawn)
            m->faces.items[kept++] = m->faces.items[i];
    }
    m->faces.count = kept;
    if (kept)
        return NG_OK;
    size_t reasons = m->faults->list.count;
    if (reasons > before)
        ng_log_error("%s; no face can be drawn", m->faults->list.items[before].text);
    else
        ng_log_error("%s: no face can be drawn: none has an area", m->faults->path);
    return NG_ERROR_FORMAT;
}

// ---- normals ---------------------------------------------------------------------------------------------
// Normals that were made: sums over the faces of a smoothing group around a vertex.
struct sums {
    struct sum {
        int32_t v;
        uint32_t group; // 0: the slot is free
        int32_t n;
    } * slots;
    size_t mask;
};

static bool add_normal(struct obj_model *m, int32_t *out)
{
    *out = (int32_t)(m->normals.count / 3);
    return ng_array_resize(&m->normals, m->normals.count + 3);
}

// The normal of a vertex in a group; -1 when out of memory.
static int32_t find_sum(struct obj_model *m, struct sums *s, int32_t v, uint32_t group)
{
    size_t i = (size_t)ng_hash_u64((uint64_t)group << 32 | (uint32_t)v) & s->mask;
    while (s->slots[i].group && (s->slots[i].v != v || s->slots[i].group != group))
        i = (i + 1) & s->mask;
    if (!s->slots[i].group) {
        int32_t n;
        if (!add_normal(m, &n))
            return -1;
        s->slots[i] = (struct sum){v, group, n};
    }
    return s->slots[i].n;
}

static bool make_face_normals(struct obj_model *m, const struct obj_face *f, struct sums *s)
{
    double area[3];
    int32_t flat = -1;
    area_of(m, f, area);
    double length = sqrt(area[0] * area[0] + area[1] * area[1] + area[2] * area[2]);
    for (uint32_t i = 0; i < f->count; i++) {
        struct obj_corner *c = &m->corners.items[f->corner + i];
        if (c->n >= 0)
            continue;
        bool first = f->smoothing || flat < 0;
        if (f->smoothing)
            c->n = find_sum(m, s, c->v, f->smoothing);
        else if (flat >= 0 || add_normal(m, &flat))
            c->n = flat;
        if (c->n < 0)
            return false;
        // Larger faces count for more. A face of a kilometre and one of a micron are both within a float.
        for (int k = 0; first && k < 3; k++)
            m->normals.items[(size_t)c->n * 3 + (size_t)k] +=
                (float)(f->smoothing ? area[k] : area[k] / length);
    }
    return true;
}

// Whether it still has a direction after opposite faces were added.
static void finish_normals(struct obj_model *m, size_t first)
{
    for (size_t i = first; i < m->normals.count; i += 3) {
        float *n = m->normals.items + i;
        double x = (double)n[0], y = (double)n[1], z = (double)n[2], length = sqrt(x * x + y * y + z * z);
        bool none = !(length > 0) || !isfinite(length);
        n[0] = none ? 0 : (float)(x / length);
        n[1] = none ? 1 : (float)(y / length);
        n[2] = none ? 0 : (float)(z / length);
    }
}

static ng_result make_normals(struct obj_model *m)
{
    size_t missing = 0, slots = 16, first = m->normals.count;
    for (size_t i = 0; i < m->faces.count; i++)
        missing += m->faces.items[i].smoothing ? m->faces.items[i].count : 0;
    while (slots < missing * 2)
        slots *= 2;
    struct sums sums = {calloc(slots, sizeof *sums.slots), slots - 1};
    bool enough = sums.slots;
    for (size_t i = 0; enough && i < m->faces.count; i++)
        enough = make_face_normals(m, &m->faces.items[i], &sums);
    free(sums.slots);
    finish_normals(m, first);
    return enough ? NG_OK : ng_out_of_memory(m->faults->path);
}

// ---- primitives ------------------------------------------------------------------------------------------
// The faces of one part and material.
struct run {
    const struct obj_face *faces;
    size_t count;
};

struct builder {
    struct obj_model *m;
    NG_ARRAY(uint32_t) slots; // hash table of vertices: index plus 1
    NG_ARRAY(struct obj_corner) vertices;
    NG_ARRAY(uint32_t) indices;
    NG_ARRAY(float) values;
    NG_ARRAY(uint32_t) polygon; // links and triangles
    NG_ARRAY(double) points;
    uint64_t work;
    bool failed, has_uvs;
};

static uint32_t find_vertex(struct builder *b, const struct obj_corner *c)
{
    size_t mask = b->slots.count - 1, i = (size_t)ng_hash_bytes(0, c, sizeof *c) & mask;
    for (; b->slots.items[i]; i = (i + 1) & mask)
        if (memcmp(&b->vertices.items[b->slots.items[i] - 1], c, sizeof *c) == 0)
            return b->slots.items[i] - 1;
    b->failed = b->failed || !ng_array_push(&b->vertices, *c);
    b->slots.items[i] = (uint32_t)b->vertices.count;
    return (uint32_t)b->vertices.count - 1;
}

// Along the axis in which the face is seen largest; counter-clockwise.
static void project(const struct builder *b, const struct obj_face *f, double (*out)[2])
{
    double area[3];
    area_of(b->m, f, area);
    int axis = fabs(area[1]) > fabs(area[0]) ? 1 : 0;
    axis = fabs(area[2]) > fabs(area[axis]) ? 2 : axis;
    int u = (axis + 1) % 3, w = (axis + 2) % 3;
    for (uint32_t i = 0; i < f->count; i++) {
        const float *p = position(b->m, b->m->corners.items[f->corner + i].v);
        out[i][0] = (double)p[area[axis] < 0 ? w : u];
        out[i][1] = (double)p[area[axis] < 0 ? u : w];
    }
}

static void add_face(struct builder *b, const struct obj_face *f)
{
    static const uint32_t triangle[3] = {0, 1, 2};
    const uint32_t *order = triangle;
    size_t n = f->count;
    if (n > 3) {
        b->failed = b->failed || !ng_array_resize(&b->polygon, n * 2 + (n - 2) * 3) ||
                    !ng_array_resize(&b->points, n * 2);
        if (b->failed)
            return;
        double(*points)[2] = (double(*)[2])b->points.items;
        project(b, f, points);
        ng_obj_triangles(
            &(struct obj_polygon){(const double(*)[2])points, f->count, b->polygon.items, &b->work},
            b->polygon.items + n * 2);
        order = b->polygon.items + n * 2;
    }
    for (size_t i = 0; i < (n - 2) * 3 && !b->failed; i++) {
        uint32_t vertex = find_vertex(b, &b->m->corners.items[f->corner + order[i]]);
        b->failed = b->failed || !ng_array_push(&b->indices, vertex);
    }
}

// Texture coordinates of OBJ begin at the bottom, glTF's at the top.
static void put_uv(const struct obj_model *m, const struct obj_map *map, int32_t t, float out[2])
{
    static const float none[2] = {0, 0};
    const float *uv = t >= 0 ? m->uvs.items + (size_t)t * 2 : none;
    out[0] = uv[0] * map->scale[0] + map->offset[0];
    out[1] = 1 - (uv[1] * map->scale[1] + map->offset[1]);
}

static float to_linear(float v)
{
    v = fminf(fmaxf(v, 0), 1);
    return v <= 0.04045f ? v / 12.92f : powf((v + 0.055f) / 1.055f, 2.4f);
}

// The attribute's values for all vertices.
static float *values(struct builder *b, unsigned width)
{
    b->failed = b->failed || !ng_array_resize(&b->values, b->vertices.count * width);
    return b->failed ? NULL : b->values.items;
}

static void write_positions(struct builder *b)
{
    float min[3] = {FLT_MAX, FLT_MAX, FLT_MAX}, max[3] = {-FLT_MAX, -FLT_MAX, -FLT_MAX}, *out = values(b, 3);
    char bounds[256];
    for (size_t i = 0; out && i < b->vertices.count * 3; i++) {
        out[i] = position(b->m, b->vertices.items[i / 3].v)[i % 3];
        min[i % 3] = fminf(min[i % 3], out[i]);
        max[i % 3] = fmaxf(max[i % 3], out[i]);
    }
    snprintf(bounds, sizeof bounds, ",\"min\":[%.9g,%.9g,%.9g],\"max\":[%.9g,%.9g,%.9g]", (double)min[0],
             (double)min[1], (double)min[2], (double)max[0], (double)max[1], (double)max[2]);
    if (out)
        ng_obj_item(&b->m->glb, OBJ_MESHES, "\"POSITION\":%u",
                    ng_obj_accessor(&b->m->glb, out, b->vertices.count, 3, GLTF_F32, bounds));
}

static void write_attributes(struct builder *b, const struct obj_map *map)
{
    struct obj_model *m = b->m;
    write_positions(b);
    float *out = values(b, 3);
    for (size_t i = 0; out && i < b->vertices.count * 3; i++)
        out[i] = m->normals.items[(size_t)b->vertices.items[i / 3].n * 3 + i % 3];
    if (out)
        ng_obj_item(&m->glb, OBJ_MESHES, ",\"NORMAL\":%u",
                    ng_obj_accessor(&m->glb, out, b->vertices.count, 3, GLTF_F32, ""));
    out = b->has_uvs ? values(b, 2) : NULL;
    for (size_t i = 0; out && i < b->vertices.count; i++)
        put_uv(m, map, b->vertices.items[i].t, out + i * 2);
    if (out)
        ng_obj_item(&m->glb, OBJ_MESHES, ",\"TEXCOORD_0\":%u",
                    ng_obj_accessor(&m->glb, out, b->vertices.count, 2, GLTF_F32, ""));
    out = m->colors.count ? values(b, 3) : NULL;
    for (size_t i = 0; out && i < b->vertices.count * 3; i++) {
        size_t at = (size_t)b->vertices.items[i / 3].v * 3 + i % 3;
        out[i] = at < m->colors.count ? to_linear(m->colors.items[at]) : 1;
    }
    if (out)
        ng_obj_item(&m->glb, OBJ_MESHES, ",\"COLOR_0\":%u",
                    ng_obj_accessor(&m->glb, out, b->vertices.count, 3, GLTF_F32, ""));
}

static bool prepare(struct builder *b, const struct run *run)
{
    size_t corners = 0, slots = 16;
    b->has_uvs = false;
    for (size_t i = 0; i < run->count; i++)
        for (uint32_t k = 0; k < run->faces[i].count; k++, corners++)
            b->has_uvs = b->has_uvs || b->m->corners.items[run->faces[i].corner + k].t >= 0;
    while (slots < corners * 2)
        slots *= 2;
    b->slots.count = 0;
    b->vertices.count = b->indices.count = 0;
    if (!ng_array_resize(&b->slots, slots))
        return false;
    memset(b->slots.items, 0, slots * sizeof *b->slots.items);
    return true;
}

static void write_primitive(struct builder *b, const struct run *run)
{
    static const struct obj_map plain = {.scale = {1, 1}};
    struct obj_model *m = b->m;
    b->failed = b->failed || !prepare(b, run);
    for (size_t i = 0; i < run->count && !b->failed; i++)
        add_face(b, &run->faces[i]);
    if (b->failed)
        return;
    uint32_t material = run->faces[0].material;
    const struct obj_material_use *use =
        material < m->materials.count && m->materials.items[material].gltf >= 0
            ? &m->materials.items[material]
            : NULL;
    ng_obj_item(&m->glb, OBJ_MESHES, "{\"attributes\":{");
    write_attributes(b, use ? &use->diffuse_map : &plain);
    ng_obj_item(&m->glb, OBJ_MESHES, "},\"indices\":%u",
                ng_obj_accessor(&m->glb, b->indices.items, b->indices.count, 1, GLTF_U32, ""));
    ng_obj_item(&m->glb, OBJ_MESHES, ",\"material\":%u}",
                use ? (uint32_t)use->gltf : ng_obj_plain_material(m));
}

static int compare_faces(const void *a, const void *b)
{
    const struct obj_face *f = a, *g = b;
    if (f->part != g->part)
        return f->part < g->part ? -1 : 1;
    if (f->material != g->material)
        return f->material < g->material ? -1 : 1;
    return f->corner < g->corner ? -1 : f->corner > g->corner;
}

static void write_part(struct builder *b, const struct run *part)
{
    struct obj_model *m = b->m;
    m->parts.items[part->faces[0].part].mesh = ng_obj_begin(&m->glb, OBJ_MESHES) + 1;
    ng_obj_item(&m->glb, OBJ_MESHES, "{\"primitives\":[");
    for (size_t i = 0, n; i < part->count && !b->failed; i += n) {
        for (n = 1; i + n < part->count && part->faces[i + n].material == part->faces[i].material;)
            n++;
        ng_obj_item(&m->glb, OBJ_MESHES, i ? "," : "");
        write_primitive(b, &(struct run){part->faces + i, n});
    }
    ng_obj_item(&m->glb, OBJ_MESHES, "]}");
}

ng_result ng_obj_write_meshes(struct obj_model *m)
{
    struct builder b = {.m = m, .work = MAX_WORK};
    NG_TRY(drop_faces(m));
    NG_TRY(make_normals(m));
    qsort(m->faces.items, m->faces.count, sizeof *m->faces.items, compare_faces);
    for (size_t i = 0, n; i < m->faces.count && !b.failed; i += n) {
        for (n = 1; i + n < m->faces.count && m->faces.items[i + n].part == m->faces.items[i].part;)
            n++;
        write_part(&b, &(struct run){m->faces.items + i, n});
    }
    ng_array_finish(&b.slots);
    ng_array_finish(&b.vertices);
    ng_array_finish(&b.indices);
    ng_array_finish(&b.values);
    ng_array_finish(&b.polygon);
    ng_array_finish(&b.points);
    if (b.failed)
        return ng_out_of_memory(m->faults->path);
    if (b.work == 0)
        return ng_gltf_fault(m->faults, "the rest is divided as if they were convex",
                             "its polygons have too many corners");
    return NG_OK;
}

// ---- fitting ---------------------------------------------------------------------------------------------
static void bounds_of(const struct obj_model *m, const float r[9], double min[3], double max[3])
{
    for (int k = 0; k < 3; k++)
        min[k] = DBL_MAX, max[k] = -DBL_MAX;
    for (size_t i = 0; i < m->faces.count; i++)
        for (uint32_t c = 0; c < m->faces.items[i].count; c++) {
            const float *p = position(m, m->corners.items[m->faces.items[i].corner + c].v);
            for (int k = 0; k < 3; k++) {
                double x = 0;
                for (int j = 0; j < 3; j++)
                    x += (double)r[k * 3 + j] * (double)p[j];
                min[k] = fmin(min[k], x);
                max[k] = fmax(max[k], x);
            }
        }
}

void ng_obj_write_fit(struct obj_model *m, const struct obj_text *children)
{
    const struct obj_fit *fit = m->source->fit;
    const float *r = fit->rotation;
    double min[3], max[3], scale[3], move[3];
    bounds_of(m, r, min, max);
    for (int k = 0; k < 3; k++) {
        double extent = max[k] - min[k];
        // What is flat has no scale of its own.
        scale[k] = extent > 0 && isfinite((double)fit->size[k] / extent) ? (double)fit->size[k] / extent : 1;
        move[k] = -scale[k] * (k == 1 ? min[k] : (min[k] + max[k]) / 2);
    }
    ng_obj_begin(&m->glb, OBJ_NODES);
    ng_obj_item(&m->glb, OBJ_NODES, "{\"name\":");
    ng_obj_item_string(&m->glb, OBJ_NODES, m->source->title ? m->source->title : "fit");
    ng_obj_item(&m->glb, OBJ_NODES,
                ",\"translation\":[%.9g,%.9g,%.9g],\"scale\":[%.9g,%.9g,%.9g],\"children\":[1]}", move[0],
                move[1], move[2], scale[0], scale[1], scale[2]);
    ng_obj_begin(&m->glb, OBJ_NODES);
    ng_obj_item(&m->glb, OBJ_NODES,
                "{\"name\":\"model\",\"matrix\":[%.9g,%.9g,%.9g,0,%.9g,%.9g,%.9g,0,%.9g,%.9g,%.9g,0,0,0,0,1],"
                "\"children\":[",
                (double)r[0], (double)r[3], (double)r[6], (double)r[1], (double)r[4], (double)r[7],
                (double)r[2], (double)r[5], (double)r[8]);
    ng_obj_append(&m->glb, OBJ_NODES, children);
    ng_obj_item(&m->glb, OBJ_NODES, "]}");
}

// Faces into primitives: one for each material of a part, indexed.
#include "asset/obj_internal.h"
#include "base/hash.h"
#include "base/log.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_WORK 100000000u // comparisons while polygons are divided: a second

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
    ng_obj_area(b->m, f, area);
    int axis = fabs(area[1]) > fabs(area[0]) ? 1 : 0;
    axis = fabs(area[2]) > fabs(area[axis]) ? 2 : axis;
    int u = (axis + 1) % 3, w = (axis + 2) % 3;
    for (uint32_t i = 0; i < f->count; i++) {
        const float *p = ng_obj_position(b->m, b->m->corners.items[f->corner + i].v);
        out[i][0] = (double)p[area[axis] < 0 ? w : u];
        out[i][1] = (double)p[area[axis] < 0 ? u : w];
    }
}

static void add_face(struct builder *b, const struct obj_face *f)
{
    static const uint32_t triangle[3] = {0, 1, 2};
    const uint32_t *order = triangle;
    size_t n = f->count, triangles = n > 3 ? n - 2 : 1;
    if (n > 3) {
        b->failed = b->failed || !ng_array_resize(&b->polygon, n * 2 + triangles * 3) ||
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
    for (size_t i = 0; i < triangles * 3 && !b->failed; i++) {
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
        out[i] = ng_obj_position(b->m, b->vertices.items[i / 3].v)[i % 3];
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
    NG_TRY(ng_obj_drop_faces(m));
    NG_TRY(ng_obj_make_normals(m));
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
            const float *p = ng_obj_position(m, m->corners.items[m->faces.items[i].corner + c].v);
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

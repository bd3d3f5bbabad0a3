// Faces that can be drawn, and a normal for each of their corners: where the file has none they follow from
// its smoothing groups, flat outside of them, as the format has it.
#include "asset/obj_internal.h"
#include "base/hash.h"
#include "base/log.h"

#include <math.h>
#include <stdlib.h>

const float *ng_obj_position(const struct obj_model *m, int32_t v)
{
    return m->positions.items + (size_t)v * 3;
}

// ---- faces -----------------------------------------------------------------------------------------------
void ng_obj_area(const struct obj_model *m, const struct obj_face *f, double out[3])
{
    out[0] = out[1] = out[2] = 0;
    for (uint32_t i = 0; i < f->count; i++) {
        const float *a = ng_obj_position(m, m->corners.items[f->corner + i].v);
        const float *b = ng_obj_position(m, m->corners.items[f->corner + (i + 1) % f->count].v);
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
        if (!is_finite(ng_obj_position(m, c->v), 3))
            return ng_gltf_fault(m->faults, "it is not drawn", "a vertex of a face is not a finite number");
        NG_TRY(check_corner(m, c));
    }
    ng_obj_area(m, f, area);
    *drawn = !is_flat_zero(area);
    return NG_OK;
}

ng_result ng_obj_drop_faces(struct obj_model *m)
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
    ng_obj_area(m, f, area);
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

ng_result ng_obj_make_normals(struct obj_model *m)
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

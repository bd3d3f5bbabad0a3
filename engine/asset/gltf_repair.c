// Numbers of a file that make no sense, put right where the rest can be kept: key frames, and what vertices
// have.
#include "asset/gltf_loader_internal.h"
#include "asset/gltf_unit.h"

#include <cglm/cglm.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---- key frames ------------------------------------------------------------------------------------------
static uint32_t key_width(const struct ng_channel *c)
{
    return c->width * (c->interpolation == NG_INTERPOLATION_CUBIC ? 3 : 1);
}

static void copy_key(struct ng_channel *c, uint32_t from, uint32_t to)
{
    size_t width = key_width(c);
    c->times[to] = c->times[from];
    memmove(c->values + to * width, c->values + from * width, width * sizeof(float));
}

// Whether a key's numbers are finite; a rotation is made to have length 1, if it has one.
static bool make_usable(struct ng_channel *c, uint32_t key)
{
    uint32_t width = key_width(c);
    float *v = c->values + (size_t)key * width;
    for (uint32_t i = 0; i < width; i++)
        if (!isfinite(v[i]))
            return false;
    if (!c->rotation)
        return isfinite(c->times[key]);
    v += c->interpolation == NG_INTERPOLATION_CUBIC ? 4 : 0;
    return ng_gltf_normalize_rotation(v) && isfinite(c->times[key]);
}

static ng_result drop_unusable(struct gltf_loader *l, const char *where, struct ng_channel *c)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < c->key_count; i++) {
        if (make_usable(c, i))
            copy_key(c, i, kept++);
        else
            NG_TRY(ng_gltf_fault(&l->faults, "the key is left out",
                                 "%s: key %u has what is no finite number, or a rotation of length 0", where,
                                 i));
    }
    c->key_count = kept;
    return NG_OK;
}

struct key_time {
    float time;
    uint32_t key;
};

static int compare_times(const void *a, const void *b)
{
    const struct key_time *x = a, *y = b;
    if (x->time != y->time)
        return x->time < y->time ? -1 : 1;
    return (x->key > y->key) - (x->key < y->key);
}

static ng_result sort_keys(struct gltf_loader *l, struct ng_channel *c)
{
    size_t width = key_width(c);
    struct key_time *order = malloc((c->key_count + (size_t)1) * sizeof *order);
    float *values = malloc((c->key_count * width + 1) * sizeof *values);
    for (uint32_t i = 0; order && values && i < c->key_count; i++)
        order[i] = (struct key_time){c->times[i], i};
    if (order && values)
        qsort(order, c->key_count, sizeof *order, compare_times);
    for (uint32_t i = 0; order && values && i < c->key_count; i++) {
        c->times[i] = order[i].time;
        memcpy(values + i * width, c->values + order[i].key * width, width * sizeof *values);
    }
    bool ok = order && values;
    free(order);
    if (ok) {
        free(c->values);
        c->values = values;
    } else {
        free(values);
    }
    return ok ? NG_OK : ng_out_of_memory(l->path);
}

// Of keys at one time the last counts from then on, the first until then; so a jump stays one.
static void part_equal_times(struct ng_channel *c)
{
    uint32_t kept = 0;
    for (uint32_t first = 0, last; first < c->key_count; first = last + 1) {
        for (last = first; last + 1 < c->key_count && c->times[last + 1] == c->times[first];)
            last++;
        float before = nextafterf(c->times[first], -INFINITY);
        if (last > first && before >= 0 && (kept == 0 || before > c->times[kept - 1])) {
            copy_key(c, first, kept);
            c->times[kept++] = before;
        }
        copy_key(c, last, kept++);
    }
    c->key_count = kept;
}

ng_result ng_gltf_repair_keys(struct gltf_loader *l, const char *where, struct ng_channel *c)
{
    NG_TRY(drop_unusable(l, where, c));
    if (c->key_count == 0)
        return ng_gltf_error(l, "%s: has no keys", where);
    uint32_t at = 1;
    while (at < c->key_count && c->times[at] > c->times[at - 1])
        at++;
    if (at < c->key_count) {
        NG_TRY(ng_gltf_fault(&l->faults, "they are put in order, and of equal ones the last counts",
                             "%s: times are not increasing at key %u", where, at));
        NG_TRY(sort_keys(l, c));
        part_equal_times(c);
    }
    if (c->times[0] < 0)
        NG_TRY(ng_gltf_fault(&l->faults, "it is played from 0", "%s: the first time %g is negative", where,
                             (double)c->times[0]));
    return NG_OK;
}

// ---- vertices --------------------------------------------------------------------------------------------
static bool is_finite(const float *v, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!isfinite(v[i]))
            return false;
    return true;
}

// Whether a triangle's vertices are there and have a place.
static ng_result check_triangle(struct gltf_loader *l, const char *where, const struct ng_geometry *g,
                                const uint32_t v[3], bool *good)
{
    *good = false;
    for (size_t k = 0; k < 3; k++)
        if (v[k] >= g->vertex_count)
            return ng_gltf_fault(&l->faults, "the triangle is left out",
                                 "%s: index %u is not below the %u vertices", where, v[k], g->vertex_count);
    for (size_t k = 0; k < 3; k++)
        if (!is_finite(g->positions + v[k] * (size_t)3, 3))
            return ng_gltf_fault(&l->faults, "its triangles are left out",
                                 "%s: the POSITION of vertex %u is not a finite number", where, v[k]);
    *good = true;
    return NG_OK;
}

static ng_result drop_triangles(struct gltf_loader *l, const char *where, struct ng_geometry *g)
{
    uint32_t kept = 0;
    for (size_t t = 0; t < g->index_count; t += 3) { // there is one, at least
        bool good;
        NG_TRY(check_triangle(l, where, g, g->indices + t, &good));
        if (good)
            memmove(g->indices + kept, g->indices + t, 3 * sizeof *g->indices);
        kept += good ? 3 : 0;
    }
    g->index_count = kept;
    return kept ? NG_OK : ng_gltf_follows(&l->faults);
}

// Vertices without a place stand where one is that is drawn, so that bounds are those of what is seen.
static void place_unused(struct ng_geometry *g)
{
    const float *somewhere = g->positions + g->indices[0] * (size_t)3;
    for (size_t i = 0; i < g->vertex_count; i++)
        if (!is_finite(g->positions + i * 3, 3))
            memcpy(g->positions + i * 3, somewhere, 3 * sizeof(float));
}

// Gives a vector length 1. `exact`: what has it nearly is the bits that were saved, and stays.
static bool normalize(float *v, bool exact)
{
    float length = glm_vec3_norm(v);
    if (!(length > 1e-20f) || !isfinite(length))
        return false;
    if (exact && fabsf(length - 1) < 1e-4f)
        return true;
    for (int i = 0; i < 3; i++)
        v[i] /= length;
    return true;
}

// The mean of the triangles around each marked vertex, by area.
static void compute_normals(struct ng_geometry *g, const bool *marked)
{
    for (size_t i = 0; i < g->vertex_count; i++)
        if (marked[i])
            memset(g->normals + i * 3, 0, 3 * sizeof(float));
    for (size_t t = 0; t < g->index_count; t += 3) {
        const uint32_t *v = g->indices + t;
        vec3 a, b, n;
        if (!marked[v[0]] && !marked[v[1]] && !marked[v[2]])
            continue;
        glm_vec3_sub(g->positions + v[1] * (size_t)3, g->positions + v[0] * (size_t)3, a);
        glm_vec3_sub(g->positions + v[2] * (size_t)3, g->positions + v[0] * (size_t)3, b);
        glm_vec3_cross(a, b, n);
        for (size_t k = 0; k < 3; k++)
            if (marked[v[k]])
                glm_vec3_add(g->normals + v[k] * (size_t)3, n, g->normals + v[k] * (size_t)3);
    }
    for (size_t i = 0; i < g->vertex_count; i++)
        if (marked[i] && !normalize(g->normals + i * 3, false))
            memcpy(g->normals + i * 3, (float[]){0, 1, 0}, 3 * sizeof(float));
}

static ng_result repair_normals(struct gltf_loader *l, const char *where, bool exact, struct ng_geometry *g)
{
    bool *marked = calloc(g->vertex_count, sizeof *marked), any = false;
    ng_result r = marked ? NG_OK : ng_out_of_memory(l->path);
    for (uint32_t i = 0; r == NG_OK && i < g->vertex_count; i++) {
        if (normalize(g->normals + i * (size_t)3, exact))
            continue;
        marked[i] = any = true;
        r = ng_gltf_fault(&l->faults, "it is computed", "%s: the NORMAL of vertex %u has no direction", where,
                          i);
    }
    if (any)
        compute_normals(g, marked);
    free(marked);
    return r;
}

// One without a direction gets one that is at right angles to the normal: its texture says nothing better.
static ng_result repair_tangents(struct gltf_loader *l, const char *where, bool exact, struct ng_geometry *g)
{
    for (uint32_t i = 0; i < g->vertex_count; i++) {
        float *t = g->tangents + i * (size_t)4;
        t[3] = t[3] < 0 ? -1.0f : 1.0f;
        if (normalize(t, exact))
            continue;
        vec3 normal = {0, 0, 1};
        if (g->normals)
            glm_vec3_copy(g->normals + i * (size_t)3, normal);
        glm_vec3_ortho(normal, t);
        if (!normalize(t, false))
            memcpy(t, (float[]){1, 0, 0}, 3 * sizeof(float));
        NG_TRY(ng_gltf_fault(&l->faults, "it is computed", "%s: the TANGENT of vertex %u has no direction",
                             where, i));
    }
    return NG_OK;
}

// `uvs` may be null.
static ng_result repair_uvs(struct gltf_loader *l, const char *where, uint32_t vertex_count, float *uvs)
{
    for (uint32_t i = 0; uvs && i < vertex_count; i++) {
        float *uv = uvs + i * (size_t)2;
        if (is_finite(uv, 2))
            continue;
        uv[0] = uv[1] = 0;
        NG_TRY(
            ng_gltf_fault(&l->faults, "it is 0, 0", "%s: the TEXCOORD of vertex %u is not finite", where, i));
    }
    return NG_OK;
}

ng_result ng_gltf_repair_geometry(struct gltf_loader *l, const char *where, bool exact, struct ng_geometry *g)
{
    NG_TRY(drop_triangles(l, where, g));
    place_unused(g);
    if (g->normals)
        NG_TRY(repair_normals(l, where, exact, g));
    if (g->tangents)
        NG_TRY(repair_tangents(l, where, exact, g));
    NG_TRY(repair_uvs(l, where, g->vertex_count, g->uvs));
    return repair_uvs(l, where, g->vertex_count, g->uvs1);
}

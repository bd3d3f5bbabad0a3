// Morph targets of a geometry without normals: its triangles get vertices of their own, and flat normals, for
// each target (glTF 2.0, 3.7.2.1).
#include "asset/geometry_internal.h"
#include "base/array.h"

#include <cglm/cglm.h>

#include <stdlib.h>
#include <string.h>

void ng_flat_normal(const float a[3], const float b[3], const float c[3], float out[3])
{
    vec3 ab, ac, n;
    glm_vec3_sub((float *)b, (float *)a, ab);
    glm_vec3_sub((float *)c, (float *)a, ac);
    glm_vec3_cross(ab, ac, n);
    // A degenerate triangle has no area and is never seen; its normal has only to be a unit vector.
    float length = glm_vec3_norm(n);
    if (length > 0 && isfinite(length))
        glm_vec3_scale(n, 1 / length, out);
    else
        glm_vec3_copy((vec3){0, 1, 0}, out);
}

struct split {
    uint32_t *delta_of; // [vertex_count]: 1 + a vertex's delta in the target; 0: it has none
    NG_ARRAY(uint32_t) vertices;
    NG_ARRAY(float) positions, normals;
};

// A triangle of which the target moves a corner: all three turn.
static bool split_triangle(const struct ng_geometry *g, uint32_t first, struct split *s)
{
    vec3 at[3], moved[3], delta[3], flat, turned;
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t vertex = g->indices[first + k], of = s->delta_of[vertex];
        memcpy(at[k], g->positions + vertex * (size_t)3, 12);
        memset(delta[k], 0, 12);
        if (of)
            memcpy(delta[k], g->delta_positions + (of - 1) * (size_t)3, 12);
        glm_vec3_add(at[k], delta[k], moved[k]);
    }
    ng_flat_normal(at[0], at[1], at[2], flat);
    ng_flat_normal(moved[0], moved[1], moved[2], turned);
    glm_vec3_sub(turned, flat, turned);
    if (!ng_array_reserve(&s->vertices, s->vertices.count + 3) ||
        !ng_array_reserve(&s->positions, s->positions.count + 9) ||
        !ng_array_reserve(&s->normals, s->normals.count + 9))
        return false;
    for (uint32_t k = 0; k < 3; k++) {
        s->vertices.items[s->vertices.count++] = first + k;
        memcpy(s->positions.items + s->positions.count, delta[k], 12);
        memcpy(s->normals.items + s->normals.count, turned, 12);
        s->positions.count += 3;
        s->normals.count += 3;
    }
    return true;
}

static bool split_target(const struct ng_geometry *g, uint32_t begin, uint32_t end, struct split *s)
{
    for (uint32_t i = begin; i < end; i++)
        s->delta_of[g->delta_vertices[i]] = i + 1;
    bool ok = true;
    for (uint32_t i = 0; ok && i < g->index_count; i += 3) {
        const uint32_t *tri = g->indices + i;
        if (s->delta_of[tri[0]] || s->delta_of[tri[1]] || s->delta_of[tri[2]])
            ok = split_triangle(g, i, s);
    }
    for (uint32_t i = begin; i < end; i++)
        s->delta_of[g->delta_vertices[i]] = 0;
    return ok;
}

bool ng_geometry_split_targets(struct ng_geometry *g)
{
    if (!g->target_count)
        return true;
    struct split s = {.delta_of = calloc((size_t)g->vertex_count + 1, sizeof *s.delta_of)};
    bool ok = s.delta_of;
    for (uint32_t t = 0, begin = 0; ok && t < g->target_count; t++) {
        uint32_t end = g->target_ends[t];
        ok = split_target(g, begin, end, &s) && s.vertices.count <= UINT32_MAX;
        begin = end;
        g->target_ends[t] = (uint32_t)s.vertices.count;
    }
    free(s.delta_of);
    free(g->delta_vertices);
    free(g->delta_positions);
    free(g->delta_normals);
    free(g->delta_tangents);
    g->delta_vertices = s.vertices.items;
    g->delta_positions = s.positions.items;
    g->delta_normals = s.normals.items;
    g->delta_tangents = NULL;
    g->delta_count = (uint32_t)s.vertices.count;
    return ok;
}

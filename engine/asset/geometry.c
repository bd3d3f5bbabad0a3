// Normals first (they may split vertices), then UVs, then tangents from both, then the bounds.
#include "asset/geometry.h"
#include "base/log.h"

#include <cglm/cglm.h>

#include <float.h>
#include <stdlib.h>
#include <string.h>

void ng_cage_free(struct ng_cage **cage)
{
    struct ng_cage *c = *cage;
    if (!c)
        return;
    free(c->positions);
    free(c->face_sizes);
    free(c->face_indices);
    free(c->face_uvs);
    free(c->crease_edges);
    free(c->crease_sharpness);
    free(c->corners);
    free(c->corner_sharpness);
    free(c->vertex_map);
    free(c);
    *cage = NULL;
}

void ng_geometry_finish(struct ng_geometry *g)
{
    free(g->positions);
    free(g->normals);
    free(g->tangents);
    free(g->uvs);
    free(g->joints);
    free(g->weights);
    free(g->indices);
    ng_cage_free(&g->cage);
    *g = (struct ng_geometry){0};
}

static size_t cage_size(const struct ng_cage *c)
{
    size_t size = c->vertex_count * (size_t)12 + c->face_count * (size_t)4 + c->index_count * (size_t)4;
    size += c->crease_count * (size_t)12 + c->corner_count * (size_t)8;
    size += c->face_uvs ? c->index_count * (size_t)8 : 0;
    return size + (c->vertex_map ? c->vertex_count * (size_t)4 : 0);
}

size_t ng_geometry_size(const struct ng_geometry *g)
{
    size_t vertex = 12u + (g->normals ? 12u : 0u) + (g->tangents ? 16u : 0u) + (g->uvs ? 8u : 0u);
    vertex += (g->joints ? 8u : 0u) + (g->weights ? 16u : 0u);
    return g->vertex_count * vertex + g->index_count * (size_t)4 + (g->cage ? cage_size(g->cage) : 0);
}

// One element per index instead of one per vertex.
static bool unshare(void *array, size_t size, const struct ng_geometry *g)
{
    unsigned char **items = array;
    if (!*items)
        return true;
    unsigned char *split = malloc((size_t)g->index_count * size + 1);
    if (!split)
        return false;
    for (size_t i = 0; i < g->index_count; i++)
        memcpy(split + i * size, *items + g->indices[i] * size, size);
    free(*items);
    *items = split;
    return true;
}

// Where each old vertex first went; a cage's vertex that maps to an unused one keeps vertex 0's.
static bool remap_cage(struct ng_geometry *g)
{
    if (!g->cage || !g->cage->vertex_map)
        return true;
    uint32_t *first = calloc((size_t)g->vertex_count + 1, sizeof *first);
    if (!first)
        return false;
    for (uint32_t i = g->index_count; i-- > 0;)
        first[g->indices[i]] = i;
    for (uint32_t i = 0; i < g->cage->vertex_count; i++)
        g->cage->vertex_map[i] = first[g->cage->vertex_map[i]];
    free(first);
    return true;
}

static bool split_vertices(struct ng_geometry *g)
{
    if (!unshare(&g->positions, 12, g) || !unshare(&g->tangents, 16, g) || !unshare(&g->uvs, 8, g) ||
        !unshare(&g->joints, 8, g) || !unshare(&g->weights, 16, g) || !remap_cage(g))
        return false;
    g->vertex_count = g->index_count;
    for (uint32_t i = 0; i < g->index_count; i++)
        g->indices[i] = i;
    return true;
}

static bool make_flat_normals(struct ng_geometry *g)
{
    free(g->tangents); // without normals the file's tangents mean nothing (glTF 2.0, 3.7.2.1)
    g->tangents = NULL;
    if (!split_vertices(g))
        return false;
    g->normals = malloc((size_t)g->vertex_count * 12 + 1);
    if (!g->normals)
        return false;
    for (size_t t = 0; t < g->index_count; t += 3) {
        float *p = g->positions + t * 3;
        vec3 a, b, n;
        glm_vec3_sub(p + 3, p, a);
        glm_vec3_sub(p + 6, p, b);
        glm_vec3_cross(a, b, n);
        // A degenerate triangle has no area and is never seen; its normal has only to be a unit vector.
        float length = glm_vec3_norm(n);
        if (length > 0 && isfinite(length))
            glm_vec3_scale(n, 1 / length, n);
        else
            glm_vec3_copy((vec3){0, 1, 0}, n);
        for (size_t k = 0; k < 3; k++)
            glm_vec3_copy(n, g->normals + (t + k) * 3);
    }
    return true;
}

// The directions in which u and v grow over a triangle; false where the UVs are degenerate.
static bool uv_directions(const struct ng_geometry *g, const uint32_t *tri, vec3 u_dir, vec3 v_dir)
{
    vec3 e1, e2;
    glm_vec3_sub(g->positions + tri[1] * (size_t)3, g->positions + tri[0] * (size_t)3, e1);
    glm_vec3_sub(g->positions + tri[2] * (size_t)3, g->positions + tri[0] * (size_t)3, e2);
    const float *t0 = g->uvs + tri[0] * (size_t)2, *t1 = g->uvs + tri[1] * (size_t)2,
                *t2 = g->uvs + tri[2] * (size_t)2;
    float du1 = t1[0] - t0[0], dv1 = t1[1] - t0[1], du2 = t2[0] - t0[0], dv2 = t2[1] - t0[1];
    float det = du1 * dv2 - du2 * dv1;
    if (!isfinite(det) || fabsf(det) < 1e-20f)
        return false;
    float sign = det > 0 ? 1.0f : -1.0f;
    for (int k = 0; k < 3; k++) {
        u_dir[k] = sign * (e1[k] * dv2 - e2[k] * dv1);
        v_dir[k] = sign * (e2[k] * du1 - e1[k] * du2);
    }
    glm_vec3_normalize(u_dir);
    glm_vec3_normalize(v_dir);
    return true;
}

static float corner_angle(const struct ng_geometry *g, const uint32_t *tri, uint32_t corner)
{
    vec3 a, b;
    float *p = g->positions + tri[corner] * (size_t)3;
    glm_vec3_sub(g->positions + tri[(corner + 1) % 3] * (size_t)3, p, a);
    glm_vec3_sub(g->positions + tri[(corner + 2) % 3] * (size_t)3, p, b);
    glm_vec3_normalize(a);
    glm_vec3_normalize(b);
    return acosf(glm_clamp(glm_vec3_dot(a, b), -1, 1));
}

// The bitangent points to the top of the texture, against v: green of a normal map is up (glTF 2.0, 3.9.3).
static void finish_tangent(vec3 n, vec3 u_sum, vec3 v_sum, float out[4])
{
    vec3 t, b;
    glm_vec3_copy(u_sum, t);
    glm_vec3_muladds(n, -glm_vec3_dot(n, t), t);
    float length = glm_vec3_norm(t);
    if (length > 1e-12f && isfinite(length))
        glm_vec3_scale(t, 1 / length, t);
    else
        glm_vec3_ortho(n, t), glm_vec3_normalize(t);
    glm_vec3_cross(n, t, b);
    glm_vec3_copy(t, out);
    out[3] = glm_vec3_dot(b, v_sum) > 0 ? -1.0f : 1.0f;
}

static bool make_tangents(struct ng_geometry *g)
{
    g->tangents = malloc((size_t)g->vertex_count * 16 + 1);
    float(*sums)[2][3] = calloc((size_t)g->vertex_count + 1, sizeof *sums);
    if (!g->tangents || !sums) {
        free(sums);
        return false;
    }
    for (size_t i = 0; i < g->index_count; i += 3) {
        const uint32_t *tri = g->indices + i;
        vec3 u_dir, v_dir;
        if (!uv_directions(g, tri, u_dir, v_dir))
            continue;
        for (uint32_t c = 0; c < 3; c++) {
            float angle = corner_angle(g, tri, c);
            glm_vec3_muladds(u_dir, angle, sums[tri[c]][0]);
            glm_vec3_muladds(v_dir, angle, sums[tri[c]][1]);
        }
    }
    for (size_t i = 0; i < g->vertex_count; i++)
        finish_tangent(g->normals + i * 3, sums[i][0], sums[i][1], g->tangents + i * 4);
    free(sums);
    return true;
}

static void set_bounds(struct ng_geometry *g)
{
    for (int k = 0; k < 3; k++) {
        g->bounds_min[k] = g->vertex_count ? FLT_MAX : 0;
        g->bounds_max[k] = g->vertex_count ? -FLT_MAX : 0;
    }
    for (size_t i = 0; i < g->vertex_count; i++) {
        glm_vec3_minv(g->bounds_min, g->positions + i * 3, g->bounds_min);
        glm_vec3_maxv(g->bounds_max, g->positions + i * 3, g->bounds_max);
    }
}

ng_result ng_geometry_complete(struct ng_geometry *g)
{
    bool ok = g->normals || make_flat_normals(g);
    if (ok && !g->uvs)
        ok = (g->uvs = calloc((size_t)g->vertex_count + 1, 8)) != NULL;
    ok = ok && (g->tangents || make_tangents(g));
    if (!ok) {
        ng_log_error("geometry: out of memory for %u vertices", g->vertex_count);
        return NG_ERROR_MEMORY;
    }
    set_bounds(g);
    return NG_OK;
}

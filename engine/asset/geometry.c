// Completion: normals first (they may split vertices), then UVs, then tangents from both, then the bounds.
#include "asset/geometry.h"
#include "asset/content_internal.h"
#include "asset/geometry_internal.h"
#include "base/hash.h"
#include "base/log.h"

#include <cglm/cglm.h>

#include <float.h>
#include <stdlib.h>
#include <string.h>

void ng_cage_finish(struct ng_cage *cage)
{
    union ng_content c = {.cage = *cage};
    ng_content_finish(NG_ASSET_CAGE, &c);
    *cage = (struct ng_cage){0};
}

void ng_geometry_finish(struct ng_geometry *g)
{
    union ng_content c = {.geometry = *g};
    ng_content_finish(NG_ASSET_GEOMETRY, &c);
    *g = (struct ng_geometry){0};
}

size_t ng_geometry_size(const struct ng_geometry *g)
{
    const union ng_content c = {.geometry = *g};
    return ng_content_size(NG_ASSET_GEOMETRY, &c);
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

// Where each old vertex first goes; a cage's vertex that maps to an unused one keeps vertex 0's.
bool ng_geometry_split_map(const struct ng_geometry *g, struct ng_cage *cage)
{
    if (g->normals || !cage->vertex_map)
        return true;
    uint32_t *first = calloc((size_t)g->vertex_count + 1, sizeof *first);
    if (!first)
        return false;
    for (uint32_t i = g->index_count; i-- > 0;)
        first[g->indices[i]] = i;
    for (uint32_t i = 0; i < cage->vertex_count; i++)
        cage->vertex_map[i] = first[cage->vertex_map[i]];
    free(first);
    return true;
}

static bool split_vertices(struct ng_geometry *g)
{
    if (!unshare(&g->positions, 12, g) || !unshare(&g->tangents, 16, g) || !unshare(&g->uvs, 8, g) ||
        !unshare(&g->uvs1, 8, g) || !unshare(&g->colors, 8, g) || !unshare(&g->joints, 8, g) ||
        !unshare(&g->weights, 16, g) || !unshare(&g->joints1, 8, g) || !unshare(&g->weights1, 16, g))
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
    if (!ng_geometry_split_targets(g) || !split_vertices(g))
        return false;
    g->normals = malloc((size_t)g->vertex_count * 12 + 1);
    if (!g->normals)
        return false;
    for (size_t t = 0; t < g->index_count; t += 3) {
        float *p = g->positions + t * 3, n[3];
        ng_flat_normal(p, p + 3, p + 6, n);
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
    const float *uvs = g->tangents_of_uvs1 && g->uvs1 ? g->uvs1 : g->uvs;
    const float *t0 = uvs + tri[0] * (size_t)2, *t1 = uvs + tri[1] * (size_t)2,
                *t2 = uvs + tri[2] * (size_t)2;
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

static float corner_angle(const float *positions, const uint32_t *tri, uint32_t corner)
{
    vec3 a, b;
    float *p = (float *)positions + tri[corner] * (size_t)3;
    glm_vec3_sub((float *)positions + tri[(corner + 1) % 3] * (size_t)3, p, a);
    glm_vec3_sub((float *)positions + tri[(corner + 2) % 3] * (size_t)3, p, b);
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

// [vertex_count][2][3]: the directions of u and of v.
static void add_uv_directions(const struct ng_geometry *g, float (*sums)[2][3])
{
    for (size_t i = 0; i < g->index_count; i += 3) {
        const uint32_t *tri = g->indices + i;
        vec3 u_dir, v_dir;
        if (!uv_directions(g, tri, u_dir, v_dir))
            continue;
        for (uint32_t c = 0; c < 3; c++) {
            float angle = corner_angle(g->positions, tri, c);
            glm_vec3_muladds(u_dir, angle, sums[tri[c]][0]);
            glm_vec3_muladds(v_dir, angle, sums[tri[c]][1]);
        }
    }
}

static bool make_tangents(struct ng_geometry *g)
{
    g->tangents = malloc((size_t)g->vertex_count * 16 + 1);
    float(*sums)[2][3] = calloc((size_t)g->vertex_count + 1, sizeof *sums);
    if (!g->tangents || !sums) {
        free(sums);
        return false;
    }
    add_uv_directions(g, sums);
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

// ---- points that move ------------------------------------------------------------------------------------
void ng_geometry_scratch_finish(struct ng_geometry_scratch *scratch)
{
    ng_array_finish(&scratch->words);
    ng_array_finish(&scratch->sums);
}

// Bit for bit: what is written again unchanged has not moved, NaN or not.
static bool same_bits(const void *a, const void *b, size_t size)
{
    return memcmp(a, b, size) == 0;
}

// What a pass over the triangles needs, by vertex.
struct follow {
    uint32_t *group;    // the first vertex that is the same smooth point: one place and one normal at rest
    uint32_t *moved;    // 1: a corner of a triangle around it, or around its group, moved
    uint32_t *table;    // of hashes: a vertex + 1, 0: free
    size_t slots;       // a power of two
    float (*now)[3];    // by group: the sum of the normals around it
    float (*rest)[3];   // the same at rest
    float (*uvs)[2][3]; // sums of add_uv_directions
};

static bool make_follow(const struct ng_geometry *g, struct ng_geometry_scratch *scratch, struct follow *f)
{
    size_t n = g->vertex_count;
    f->slots = 16;
    while (f->slots < n * 2)
        f->slots *= 2;
    if (!ng_array_resize(&scratch->words, n * 2 + f->slots) || !ng_array_resize(&scratch->sums, n * 12 + 1))
        return false;
    memset(scratch->words.items, 0, scratch->words.count * sizeof *scratch->words.items);
    memset(scratch->sums.items, 0, scratch->sums.count * sizeof *scratch->sums.items);
    f->group = scratch->words.items;
    f->moved = f->group + n;
    f->table = f->moved + n;
    f->now = (float(*)[3])scratch->sums.items;
    f->rest = f->now + n;
    f->uvs = (float(*)[2][3])(f->rest + n);
    return true;
}

static void find_groups(const struct ng_geometry *g, struct follow *f)
{
    for (uint32_t i = 0; i < g->vertex_count; i++) {
        const float *p = g->rest_positions + i * (size_t)3, *n = g->rest_normals + i * (size_t)3;
        size_t at = (size_t)ng_hash_bytes(ng_hash_bytes(0, p, 12), n, 12) & (f->slots - 1);
        for (; f->table[at]; at = (at + 1) & (f->slots - 1)) {
            size_t other = (f->table[at] - 1) * (size_t)3;
            if (same_bits(g->rest_positions + other, p, 12) && same_bits(g->rest_normals + other, n, 12))
                break;
        }
        if (!f->table[at])
            f->table[at] = i + 1;
        f->group[i] = f->table[at] - 1;
    }
}

static void add_normals(const float *positions, const uint32_t *tri, const uint32_t *group, float (*sums)[3])
{
    vec3 a, b, n;
    float *p = (float *)positions + tri[0] * (size_t)3;
    glm_vec3_sub((float *)positions + tri[1] * (size_t)3, p, a);
    glm_vec3_sub((float *)positions + tri[2] * (size_t)3, p, b);
    glm_vec3_cross(a, b, n);
    float length = glm_vec3_norm(n);
    if (!(length > 0) || !isfinite(length))
        return;
    for (uint32_t c = 0; c < 3; c++)
        glm_vec3_muladds(n, corner_angle(positions, tri, c) / length, sums[group[tri[c]]]);
}

static bool has_moved(const struct ng_geometry *g, uint32_t vertex)
{
    return !same_bits(g->positions + vertex * (size_t)3, g->rest_positions + vertex * (size_t)3, 12);
}

static void add_triangles(const struct ng_geometry *g, struct follow *f)
{
    for (size_t i = 0; i < g->index_count; i += 3) {
        const uint32_t *tri = g->indices + i;
        add_normals(g->positions, tri, f->group, f->now);
        add_normals(g->rest_positions, tri, f->group, f->rest);
        if (has_moved(g, tri[0]) || has_moved(g, tri[1]) || has_moved(g, tri[2]))
            for (uint32_t c = 0; c < 3; c++)
                f->moved[f->group[tri[c]]] = 1;
    }
}

// The normal at rest, turned as much as the mean of the triangles around it.
static void turn_normal(const struct ng_geometry *g, const struct follow *f, size_t vertex)
{
    vec3 now, rest, n;
    float *out = g->normals + vertex * 3;
    glm_vec3_normalize_to(f->now[f->group[vertex]], now);
    glm_vec3_normalize_to(f->rest[f->group[vertex]], rest);
    glm_vec3_sub(now, rest, n);
    glm_vec3_add(n, g->rest_normals + vertex * 3, n);
    float length = glm_vec3_norm(n);
    if (length > 1e-6f && isfinite(length))
        glm_vec3_scale(n, 1 / length, out);
    else // turned around; where there are no triangles with an area nothing is seen
        glm_vec3_copy(glm_vec3_norm2(now) > 0 ? now : g->rest_normals + vertex * 3, out);
}

ng_result ng_geometry_follow_points(struct ng_geometry *g, struct ng_geometry_scratch *scratch)
{
    struct follow f;
    if (!g->rest_positions)
        return NG_OK;
    if (!make_follow(g, scratch, &f))
        return ng_out_of_memory("a geometry");
    find_groups(g, &f);
    add_triangles(g, &f);
    add_uv_directions(g, f.uvs);
    memcpy(g->normals, g->rest_normals, g->vertex_count * (size_t)12);
    memcpy(g->tangents, g->rest_tangents, g->vertex_count * (size_t)16);
    for (size_t i = 0; i < g->vertex_count; i++) {
        if (!f.moved[f.group[i]])
            continue;
        turn_normal(g, &f, i);
        finish_tangent(g->normals + i * 3, f.uvs[i][0], f.uvs[i][1], g->tangents + i * 4);
    }
    set_bounds(g);
    return NG_OK;
}

// Triangles as a cage: vertices at equal positions are joined, so that seams of normals and UVs do not tear
// the surface; the UVs become face-varying. Positions at rest decide, so that points which are edited do not
// change the topology.
#include "asset/geometry.h"
#include "asset/refiner.h"
#include "base/hash.h"
#include "base/log.h"

#include <stdlib.h>
#include <string.h>

// -0 equals 0, so it must hash alike.
static uint64_t hash_position(const float *p)
{
    float v[3] = {p[0] + 0.0f, p[1] + 0.0f, p[2] + 0.0f};
    return ng_hash_bytes(0, v, sizeof v);
}

static bool same_position(const float *a, const float *b)
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

// joined[vertex] = number of its position; c->positions and c->vertex_map get one entry a position.
static bool join_vertices(const struct ng_geometry *g, struct ng_cage *c, uint32_t *joined)
{
    const float *rest = g->rest_positions ? g->rest_positions : g->positions;
    size_t slots = 16;
    while (slots < (size_t)g->vertex_count * 2)
        slots *= 2;
    uint32_t *table = calloc(slots, sizeof *table); // number of a position + 1, 0: free
    for (uint32_t i = 0; table && i < g->vertex_count; i++) {
        const float *p = rest + i * (size_t)3;
        size_t at = (size_t)hash_position(p) & (slots - 1);
        while (table[at] && !same_position(c->positions + (table[at] - 1) * (size_t)3, p))
            at = (at + 1) & (slots - 1);
        if (!table[at]) {
            c->vertex_map[c->vertex_count] = i;
            memcpy(c->positions + c->vertex_count * (size_t)3, p, 12);
            table[at] = ++c->vertex_count;
        }
        joined[i] = table[at] - 1;
    }
    free(table);
    return table != NULL;
}

// Triangles that joining has collapsed are left out.
static void copy_faces(const struct ng_geometry *g, const uint32_t *joined, struct ng_cage *c)
{
    for (uint32_t t = 0; t < g->index_count; t += 3) {
        uint32_t v[3];
        for (uint32_t k = 0; k < 3; k++)
            v[k] = joined[g->indices[t + k]];
        if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0])
            continue;
        c->face_sizes[c->face_count++] = 3;
        for (uint32_t k = 0; k < 3; k++, c->index_count++) {
            c->face_indices[c->index_count] = v[k];
            memcpy(c->face_uvs + c->index_count * (size_t)2, g->uvs + g->indices[t + k] * (size_t)2, 8);
        }
    }
}

static bool allocate(const struct ng_geometry *g, struct ng_cage *c)
{
    c->positions = malloc((size_t)g->vertex_count * 12 + 1);
    c->rest_positions = malloc((size_t)g->vertex_count * 12 + 1);
    c->vertex_map = calloc((size_t)g->vertex_count + 1, 4);
    c->face_sizes = malloc((size_t)g->index_count * 4 + 1);
    c->face_indices = malloc((size_t)g->index_count * 4 + 1);
    c->face_uvs = malloc((size_t)g->index_count * 8 + 1);
    return c->positions && c->rest_positions && c->vertex_map && c->face_sizes && c->face_indices &&
           c->face_uvs;
}

ng_result ng_cage_from_geometry(const struct ng_geometry *g, struct ng_cage *out)
{
    NG_REQUIRE(g->uvs, "the geometry must be complete (ng_geometry_complete)");
    uint32_t *joined = malloc((size_t)g->vertex_count * 4 + 1);
    *out = (struct ng_cage){0};
    bool ok = allocate(g, out) && joined && join_vertices(g, out, joined);
    if (ok) {
        copy_faces(g, joined, out);
        memcpy(out->rest_positions, out->positions, (size_t)out->vertex_count * 12);
        ng_cage_follow_geometry(out, g);
    } else {
        ng_log_error("out of memory for a cage of %u vertices", g->vertex_count);
        ng_cage_finish(out);
    }
    free(joined);
    return ok ? NG_OK : NG_ERROR_MEMORY;
}

void ng_cage_follow_geometry(struct ng_cage *cage, const struct ng_geometry *g)
{
    for (size_t i = 0; i < cage->vertex_count; i++)
        memcpy(cage->positions + i * 3, g->positions + cage->vertex_map[i] * (size_t)3, 12);
}

// NG_scene's "cage": the control mesh of a subdivision surface. README.md has the specification.
#include "asset/geometry.h"
#include "asset/gltf_loader_internal.h"
#include "asset/refiner.h"
#include "base/log.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static ng_result read(struct gltf_loader *l, const char *where, const struct gltf_value *cage,
                      const char *key, const struct gltf_want *want, void *out, uint32_t *count)
{
    int accessor;
    NG_TRY(ng_gltf_index_member(l, cage, where, key, -1, &accessor));
    return accessor < 0 ? NG_OK : ng_gltf_read(l, accessor, want, out, count);
}

static ng_result read_faces(struct gltf_loader *l, const char *where, const struct gltf_value *v,
                            struct ng_cage *c)
{
    const struct gltf_want sizes = {"cage.faceSizes", GLTF_UNSIGNED, 1u << 1, 0, true};
    NG_TRY(read(l, where, v, "faceSizes", &sizes, &c->face_sizes, &c->face_count));
    if (c->face_count == 0)
        return ng_gltf_error(l, "%s: cage: has no faceSizes", where);
    const struct gltf_want indices = {"cage.faceIndices", GLTF_UNSIGNED, 1u << 1, 0, true};
    NG_TRY(read(l, where, v, "faceIndices", &indices, &c->face_indices, &c->index_count));
    const struct gltf_want uvs = {"cage.faceUVs", GLTF_QUANTIZED, 1u << 2, c->index_count, false};
    return read(l, where, v, "faceUVs", &uvs, &c->face_uvs, NULL);
}

static ng_result check_count(const struct gltf_loader *l, const char *where, const char *key, uint32_t count,
                             uint32_t needed)
{
    if (count != needed)
        return ng_gltf_error(l, "%s: cage: %u values of %s where %u are needed", where, count, key, needed);
    return NG_OK;
}

static ng_result read_creases(struct gltf_loader *l, const char *where, const struct gltf_value *v,
                              struct ng_cage *c)
{
    const struct gltf_want indices = {"cage creases", GLTF_UNSIGNED, 1u << 1, 0, true};
    const struct gltf_want sharpness = {"cage sharpness", GLTF_FLOATS, 1u << 1, 0, false};
    uint32_t ends = 0, creases = 0, corners = 0;
    NG_TRY(read(l, where, v, "creaseEdges", &indices, &c->crease_edges, &ends));
    NG_TRY(read(l, where, v, "creaseSharpness", &sharpness, &c->crease_sharpness, &creases));
    NG_TRY(read(l, where, v, "corners", &indices, &c->corners, &c->corner_count));
    NG_TRY(read(l, where, v, "cornerSharpness", &sharpness, &c->corner_sharpness, &corners));
    if (ends % 2 != 0)
        return ng_gltf_error(l, "%s: cage: creaseEdges has an odd number of entries", where);
    c->crease_count = ends / 2;
    NG_TRY(check_count(l, where, "creaseSharpness", creases, c->crease_count));
    return check_count(l, where, "cornerSharpness", corners, c->corner_count);
}

static ng_result read_vertices(struct gltf_loader *l, const char *where, const struct gltf_value *v,
                               const struct ng_geometry *g, struct ng_cage *c)
{
    const struct gltf_want positions = {"cage.positions", GLTF_FLOATS, 1u << 3, 0, false};
    const struct gltf_want map = {"cage.vertexMap", GLTF_UNSIGNED, 1u << 1, 0, true};
    uint32_t mapped = 0;
    NG_TRY(read(l, where, v, "positions", &positions, &c->positions, &c->vertex_count));
    NG_TRY(read(l, where, v, "vertexMap", &map, &c->vertex_map, &mapped));
    for (uint32_t i = 0; i < mapped; i++)
        if (c->vertex_map[i] >= g->vertex_count)
            return ng_gltf_error(l, "%s: cage: vertexMap: %u at %u is not below %u", where, c->vertex_map[i],
                                 i, g->vertex_count);
    if (!c->vertex_map && (!c->positions || g->joints))
        return ng_gltf_error(l, "%s: cage: needs a vertexMap (%s)", where,
                             g->joints ? "the primitive is skinned" : "it has no positions");
    if (c->positions && c->vertex_map && mapped != c->vertex_count)
        return ng_gltf_error(l, "%s: cage: %u entries of vertexMap for %u positions", where, mapped,
                             c->vertex_count);
    if (c->positions) {
        ng_gltf_keep_within(l, where, "cage.positions", c->positions, (size_t)c->vertex_count * 3);
        return NG_OK;
    }
    NG_TRY(ng_gltf_budget(l, (uint64_t)mapped * 12, where));
    c->vertex_count = mapped;
    c->positions = malloc((size_t)mapped * 12 + 1);
    if (!c->positions)
        return ng_out_of_memory(l->path);
    for (size_t i = 0; i < mapped; i++)
        memcpy(c->positions + i * 3, g->positions + c->vertex_map[i] * (size_t)3, 12);
    return NG_OK;
}

static ng_result check_members(const struct gltf_loader *l, const char *where, const struct gltf_value *cage)
{
    static const char *const known[] = {"positions", "faceSizes",       "faceIndices",
                                        "faceUVs",   "creaseEdges",     "creaseSharpness",
                                        "corners",   "cornerSharpness", "vertexMap"};
    for (uint32_t i = 0; i < cage->count; i++) {
        bool found = false;
        for (size_t k = 0; k < NG_COUNT(known); k++)
            found = found || strcmp(cage->items[i].key, known[k]) == 0;
        if (!found)
            return ng_gltf_error(l, "%s: cage: unknown member \"%.64s\"", where, cage->items[i].key);
    }
    return NG_OK;
}

static ng_result check_cage(struct gltf_loader *l, const char *where, const struct ng_cage *c)
{
    struct ng_cage_report report;
    ng_result r = ng_cage_check(c, &report);
    if (r == NG_ERROR_FORMAT)
        return ng_gltf_error(l, "%s: cage: %s", where, report.why);
    if (report.divided_edges)
        ng_gltf_warn(l, &l->warned_cage,
                     "%s: cage: the surface is divided along %u edges of more than two faces, or of faces "
                     "that face opposite ways, as between vertices %u and %u",
                     where, report.divided_edges, report.first_edge[0], report.first_edge[1]);
    return r;
}

static ng_result read_cage(struct gltf_loader *l, const char *where, const struct gltf_value *cage,
                           const struct ng_geometry *g, struct ng_cage *c)
{
    if (cage->kind != GLTF_OBJECT)
        return ng_gltf_error(l, "%s: cage is not an object", where);
    NG_TRY(check_members(l, where, cage));
    NG_TRY(read_faces(l, where, cage, c));
    NG_TRY(read_creases(l, where, cage, c));
    NG_TRY(read_vertices(l, where, cage, g, c));
    return check_cage(l, where, c);
}

// A cage that is wrong costs the subdivision, not the scene.
ng_result ng_gltf_cage(struct gltf_loader *l, const char *where, const struct gltf_value *cage,
                       const struct ng_geometry *g, struct ng_cage *out)
{
    struct gltf_part part;
    ng_gltf_part_begin(&part, "it is drawn by its triangles");
    part.where = where;
    NG_TRY(ng_gltf_part_end(&l->faults, &part, read_cage(l, where, cage, g, out)));
    if (part.lost)
        ng_cage_finish(out);
    return NG_OK;
}

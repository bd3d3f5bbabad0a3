// Catmull-Clark subdivision of a cage into triangles, by OpenSubdiv's stencil tables.
//
// Everything that depends on topology alone (refined faces, UVs, the weights of the cage's vertices in each
// refined vertex) is worked out once, when the refiner is made. Refining is then a weighted sum per vertex,
// so that a cage that moves every frame (skinned, animated) is cheap. Positions and normals are those of the
// limit surface. Source: Pixar, OpenSubdiv 3.5, Far::LimitStencilTable.
#ifndef NG_ASSET_REFINER_H
#define NG_ASSET_REFINER_H

#include "base/extern_c.h"
#include "base/result.h"
#include "scene/component.h"

#include <stddef.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

struct ng_cage;
struct ng_geometry;
struct ng_jobs;
struct ng_refiner;

#define NG_REFINER_MAX_LEVEL 6

struct ng_refiner_params {
    const char *name;    // for messages, or null
    uint32_t level;      // 0 to NG_REFINER_MAX_LEVEL; 0: the cage's own faces, their vertices on the limit
    uint32_t boundary;   // enum ng_subdivision_boundary
    uint64_t max_memory; // bytes; 0: 1 GiB. A level that would need more is refused
};

// What does not change while the cage moves. Where face-varying UVs differ around a vertex, the vertex is
// there once for each of them.
struct ng_refiner_mesh {
    uint32_t vertex_count, index_count;
    const uint32_t *indices; // [index_count], counter-clockwise is the front
    const float *uvs;        // [vertex_count][2]; zeros if the cage has none
};

// What forbids to refine a cage, and where it is not one surface.
struct ng_cage_report {
    char why[NG_REASON_SIZE]; // empty: nothing forbids it
    uint32_t divided_edges;   // edges of more than two faces, or of two that run along it in one direction;
                              // the surface is divided there as at a boundary
    uint32_t first_edge[2];   // cage vertices of one of them
};

// NG_ERROR_FORMAT, not logged, with a reason: counts, indices or sharpness are wrong, a face has a vertex
// twice, or a face or vertex has more than 1,024 corners.
NG_NODISCARD ng_result ng_cage_check(const struct ng_cage *cage, struct ng_cage_report *out);

// The cage is read during the call only, and is checked as by ng_cage_check. NG_ERROR_FORMAT and
// NG_ERROR_UNSUPPORTED (a level over max_memory) are not logged but said in `why`, as the caller knows
// whether it has something else to show.
NG_NODISCARD ng_result ng_refiner_create(const struct ng_cage *cage, const struct ng_refiner_params *params,
                                         char why[NG_REASON_SIZE], struct ng_refiner **out);
void ng_refiner_destroy(struct ng_refiner **r);

struct ng_refiner_mesh ng_refiner_get_mesh(const struct ng_refiner *r);
size_t ng_refiner_memory(const struct ng_refiner *r); // bytes held

// One refinement of the cage's current vertices.
struct ng_refiner_vertices {
    const float *cage; // [cage vertex_count][3]
    float *positions;  // [vertex_count][3]
    float *normals;    // [vertex_count][3], unit
    float *tangents;   // [vertex_count][4], along u, orthogonal to the normal, w = handedness; or null
};

// Runs on the jobs (null: in place); allocates nothing; the result does not depend on the thread count.
// Different refiners, and one refiner with different outputs, may be used from different threads.
void ng_refiner_apply(const struct ng_refiner *r, struct ng_jobs *jobs, const struct ng_refiner_vertices *v);

// A cage for geometry that came without one: its triangles, with vertices joined that are (at rest) in one
// place. Of these the first, named by `vertex_map`, says where the cage's vertex is. It has positions at
// rest, too. The caller owns the arrays (malloc; ng_cage_finish in asset/geometry.h).
NG_NODISCARD ng_result ng_cage_from_geometry(const struct ng_geometry *g, struct ng_cage *out);
// Its vertices again, where points of the geometry have moved since.
void ng_cage_follow_geometry(struct ng_cage *cage, const struct ng_geometry *g);

NG_EXTERN_C_END

#endif

// Catmull-Clark subdivision of a cage into triangles, by OpenSubdiv's stencil tables.
//
// Everything that depends on topology alone (refined faces, UVs, the weights of the cage's vertices in each
// refined vertex) is worked out once, when the refiner is made. Refining is then a weighted sum per vertex,
// so that a cage that moves every frame (skinned, animated) is cheap. Positions and normals are those of the
// limit surface. Source: Pixar, OpenSubdiv 3.5, Far::LimitStencilTable.
#ifndef NG_ASSET_REFINER_H
#define NG_ASSET_REFINER_H

#include "base/result.h"

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

struct ng_cage;
struct ng_geometry;
struct ng_jobs;
struct ng_refiner;

#define NG_REFINER_MAX_LEVEL 6

struct ng_refiner_params {
    const char *name;    // for messages
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

// The cage is read during the call only; all its counts and indices are checked (NG_ERROR_FORMAT).
NG_NODISCARD ng_result ng_refiner_create(const struct ng_cage *cage, const struct ng_refiner_params *params,
                                         struct ng_refiner **out);
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

// A cage for geometry that came without one: its triangles, with vertices at equal positions joined.
// `*out` is from malloc, with all its arrays; ng_cage_free (asset/geometry.h) releases it.
NG_NODISCARD ng_result ng_cage_from_geometry(const struct ng_geometry *g, struct ng_cage **out);

#ifdef __cplusplus
}
#endif

#endif

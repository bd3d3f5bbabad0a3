// Making a geometry complete: what files leave out and what every user of a geometry relies on.
#ifndef NG_ASSET_GEOMETRY_H
#define NG_ASSET_GEOMETRY_H

#include "asset/assets.h"
#include "base/extern_c.h"

NG_EXTERN_C_BEGIN

// Fills in what is missing, in place: `positions` and `indices` are needed, the other arrays may be null.
// Missing normals are flat (glTF 2.0, 3.7.2.1), which gives each triangle vertices of its own (so joints,
// weights and UVs are copied along and vertex_count grows). Missing UVs become zeros. Missing tangents are
// the mean over a vertex's triangles of the directions in which u and v grow, weighted by the corner's angle
// and made orthogonal to the normal, as MikkTSpace but without its splitting of vertices: mirrored UVs must
// not share vertices. Their w makes the bitangent point against v, to the texture's top, where green points
// in a normal map (3.9.3). Always sets the bounds. A cage's vertex map follows where vertices were split.
NG_NODISCARD ng_result ng_geometry_complete(struct ng_geometry *g);

// Frees the arrays (and the cage) and zeroes the struct.
void ng_geometry_finish(struct ng_geometry *g);
// Frees a cage and its arrays; zeroes the pointer; null is fine.
void ng_cage_free(struct ng_cage **cage);
size_t ng_geometry_size(const struct ng_geometry *g); // bytes of all arrays

NG_EXTERN_C_END

#endif

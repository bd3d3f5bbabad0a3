// Making a geometry complete: what files leave out and what every user of a geometry relies on.
#ifndef NG_ASSET_GEOMETRY_H
#define NG_ASSET_GEOMETRY_H

#include "asset/assets.h"
#include "base/array.h"
#include "base/extern_c.h"

NG_EXTERN_C_BEGIN

// Fills in what is missing, in place: `positions` and `indices` are needed, the other arrays may be null.
// Missing normals are flat (glTF 2.0, 3.7.2.1), which gives each triangle vertices of its own (so joints,
// weights and UVs are copied along and vertex_count grows). Missing UVs become zeros. Missing tangents are
// the mean over a vertex's triangles of the directions in which u and v grow, weighted by the corner's angle
// and made orthogonal to the normal, as MikkTSpace but without its splitting of vertices: mirrored UVs must
// not share vertices. Their w makes the bitangent point against v, to the texture's top, where green points
// in a normal map (3.9.3). Always sets the bounds.
NG_NODISCARD ng_result ng_geometry_complete(struct ng_geometry *g);
// Before that: has a cage's vertex map follow where vertices will be split. False when out of memory.
bool ng_geometry_split_map(const struct ng_geometry *g, struct ng_cage *cage);

// Memory that is kept from one call to the next. Zero is empty.
struct ng_geometry_scratch {
    NG_ARRAY(uint32_t) words;
    NG_ARRAY(float) sums;
};
void ng_geometry_scratch_finish(struct ng_geometry_scratch *scratch);

// Points were moved: finds normals, tangents and bounds again, from those at rest and what moved around them.
// The result follows from the points now and at rest, not from the way between. Nothing changes on failure,
// out of memory.
NG_NODISCARD ng_result ng_geometry_follow_points(struct ng_geometry *g, struct ng_geometry_scratch *scratch);

// Frees the arrays and zeroes the struct.
void ng_geometry_finish(struct ng_geometry *g);
void ng_cage_finish(struct ng_cage *cage);
size_t ng_geometry_size(const struct ng_geometry *g); // bytes of all arrays

NG_EXTERN_C_END

#endif

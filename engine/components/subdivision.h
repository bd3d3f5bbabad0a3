// Makes a mesh a Catmull-Clark surface, refined to a level: of a cage or, without one, of the mesh's
// triangles.
#ifndef NG_COMPONENTS_SUBDIVISION_H
#define NG_COMPONENTS_SUBDIVISION_H

#include "scene/component.h"

enum ng_subdivision_boundary { NG_BOUNDARY_EDGE_ONLY, NG_BOUNDARY_EDGE_AND_CORNER };

struct ng_subdivision {
    uint32_t level;    // 0 to 6: each level quadruples the faces
    uint32_t boundary; // enum ng_subdivision_boundary
    ng_asset cage;     // NG_ASSET_CAGE (asset/assets.h); null: the triangles of the mesh's geometry
};

#endif

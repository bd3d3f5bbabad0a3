// Geometry with one material. A glTF mesh of several primitives becomes child entities, one a primitive.
#ifndef NG_COMPONENTS_MESH_H
#define NG_COMPONENTS_MESH_H

#include "scene/component.h"

struct ng_mesh {
    ng_asset geometry;  // struct ng_geometry
    ng_entity material; // an entity with a material component; none: the default material
    bool visible;
};

#endif

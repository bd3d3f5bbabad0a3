// Makes the mesh of its entity follow joints: linear blend skinning. The mesh's own placement is then ignored
// (glTF 2.0, 3.7.3.3).
#ifndef NG_COMPONENTS_SKIN_H
#define NG_COMPONENTS_SKIN_H

#include "scene/component.h"

struct ng_skin {
    ng_asset skin; // struct ng_skeleton: joint entities and inverse bind matrices
};

#endif

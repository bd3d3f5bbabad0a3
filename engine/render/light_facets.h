// The surface of an area light as facets that shine evenly, for its light in closed form on what is near.
//
// Knows no light type: shapes come from the type's own surface, radiances from what its hits say.
#ifndef NG_RENDER_LIGHT_FACETS_H
#define NG_RENDER_LIGHT_FACETS_H

#include "base/extern_c.h"
#include "light/light.h"
#include "shaders/shared/scene.h"

NG_EXTERN_C_BEGIN

#define NG_LIGHT_FACETS 512 // of one light

struct ng_light_facets {
    uint32_t kind;  // NG_FACETS_*
    uint32_t count; // 0: the light is no surface or dark, or there is too little room for it
    struct ng_facet_data facets[NG_LIGHT_FACETS];
};

// `most`: so many facets at most. Their power together is the light's.
void ng_light_facets_of(const struct ng_light_source *source, uint32_t most, struct ng_light_facets *out);

NG_EXTERN_C_END

#endif

// Makes the emissive mesh of its entity a light: radiance = the material's emissive * emissive_strength *
// texture, times color * scale. One-sided unless the material is double sided. Emission without this
// component is seen but lights nothing.
// On a material, it makes all meshes of that material, but for those that are lights themselves, one light
// together: what costs a light's shadows and views is spent once on many small emitters.
#ifndef NG_COMPONENTS_LIGHT_MESH_H
#define NG_COMPONENTS_LIGHT_MESH_H

#include "scene/component.h"

struct ng_light_mesh {
    bool on;
    float color[3]; // linear
    float scale;    // on the material's emission
};

#endif

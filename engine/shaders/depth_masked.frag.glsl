// Holes of an alpha mask let light through.
#include "shared/scene.h"

layout(set = 0, binding = 2, scalar) readonly buffer Materials { ng_material_data materials[]; };
layout(set = 1, binding = 0) uniform sampler2D base_color_map;

layout(location = 0) in vec2 in_uv;
layout(location = 1) flat in uint in_material;
#ifdef NG_FULL
layout(location = 2) in float in_alpha;
#endif

void main()
{
    ng_material_data m = materials[in_material];
    float alpha = m.alpha;
#ifdef NG_FULL
    alpha *= in_alpha;
#endif
    if (texture(base_color_map, in_uv).a * alpha < m.alpha_cutoff)
        discard;
}

// Holes of an alpha mask let light through, and what covers a part lets the rest through.
#include "shared/scene.h"

layout(set = 0, binding = 1, scalar) readonly buffer Instances { ng_instance_data instances[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Materials { ng_material_data materials[]; };
layout(set = 1, binding = 0) uniform sampler2D base_color_map;

layout(location = 0) in vec2 in_uv;
layout(location = 1) flat in uint in_instance;
#ifdef NG_FULL
layout(location = 2) in float in_alpha;
#endif

#include "cut.glsl"

void main()
{
    ng_instance_data instance = instances[in_instance];
    ng_material_data m = materials[instance.material];
    bool front = gl_FrontFacing != ((instance.flags & NG_INSTANCE_MIRRORED) != 0);
    float alpha = m.alpha;
#ifdef NG_FULL
    alpha *= in_alpha;
#endif
    if (is_cut(m, instance, front, texture(base_color_map, in_uv).a, textureQueryLod(base_color_map, in_uv).x, alpha))
        discard;
}

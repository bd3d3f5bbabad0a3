// A light's depth maps: every view is a layer of one image, so one pass draws them all.
#include "shared/scene.h"

layout(set = 0, binding = 0, scalar) readonly buffer Views { ng_light_view_data views[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Instances { ng_instance_data instances[]; };
layout(push_constant, scalar) uniform Push { uint layer; } push;

layout(location = 0) in vec3 in_position;
#ifdef NG_MASKED
layout(location = 1) in vec2 in_uv;
layout(location = 0) out vec2 out_uv;
layout(location = 1) flat out uint out_instance;
#endif
#ifdef NG_FULL
layout(location = 2) in vec2 in_uv1;
layout(location = 3) in vec4 in_color;
layout(location = 2) out float out_alpha;
#include "texture_uv.glsl"
#endif

void main()
{
    vec4 m[3] = instances[gl_InstanceIndex].matrix;
    vec4 p = vec4(in_position, 1);
    p = vec4(dot(m[0], p), dot(m[1], p), dot(m[2], p), 1);
    gl_Position = views[push.layer].view_projection * p;
    gl_Layer = int(push.layer);
#ifdef NG_MASKED
    out_uv = in_uv;
    out_instance = gl_InstanceIndex;
#endif
#ifdef NG_FULL
    out_uv = texture_uv(instances[gl_InstanceIndex].material, NG_SLOT_BASE_COLOR);
    out_alpha = in_color.a;
#endif
}

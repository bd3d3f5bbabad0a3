// The small maps of a reflective shadow map: surfaces as the light sees them, all views in one pass.
#include "surface.vert.glsl"

layout(set = 0, binding = 7, scalar) readonly buffer Views { ng_light_view_data views[]; };
layout(push_constant, scalar) uniform Push { uint layer; } push;

layout(location = 4) out vec3 out_position;
layout(location = 5) flat out uint out_layer;

void main()
{
    vec4 matrix[3] = instances[gl_InstanceIndex].matrix;
    vec3 position = transform_point(matrix, in_position);
    out_position = position;
    out_normal = transform_normal(matrix, in_normal);
    out_instance = gl_InstanceIndex;
#ifdef NG_TEXTURED
    write_surface(matrix);
#endif
    out_layer = push.layer;
    gl_Position = views[push.layer].view_projection * vec4(position, 1);
    gl_Layer = int(push.layer);
}

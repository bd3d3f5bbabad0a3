// Few varyings: on a software rasterizer each costs every triangle. The fragment stage finds the position from the
// depth. Where instances move (NG_MOVING) or have textures (NG_TEXTURED) their vertices also say where they were.
#include "surface.vert.glsl"

#ifdef NG_MOVING
layout(location = NG_PREVIOUS_LOCATION) in vec3 in_previous;
layout(location = 4) out vec3 out_previous;
#endif

void main()
{
    vec4 matrix[3] = instances[gl_InstanceIndex].matrix;
    vec3 position = transform_point(matrix, in_position);
    out_normal = transform_normal(matrix, in_normal);
    out_instance = gl_InstanceIndex;
#ifdef NG_MOVING
    out_previous = transform_point(instances[gl_InstanceIndex].previous_matrix, in_previous);
#endif
#ifdef NG_TEXTURED
    write_surface(matrix);
#endif
    gl_Position = view.view_projection * vec4(position, 1);
}

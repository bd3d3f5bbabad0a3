#include "surface.vert.glsl"

void main()
{
    vec4 matrix[3] = instances[gl_InstanceIndex].matrix;
    vec3 position = transform_point(matrix, in_position);
    out_position = position;
    out_previous = transform_point(instances[gl_InstanceIndex].previous_matrix, in_previous);
    out_normal = transform_normal(matrix, in_normal);
    out_instance = gl_InstanceIndex;
#ifdef NG_TEXTURED
    out_tangent = vec4(transform_point(matrix, in_tangent.xyz) - transform_point(matrix, vec3(0)), in_tangent.w);
    out_uv = in_uv;
#endif
    gl_Position = view.view_projection * vec4(position, 1);
}

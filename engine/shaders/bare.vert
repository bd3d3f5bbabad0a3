// Depth alone from the camera: the least that a pass over these triangles can cost. For benchmarks.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/scene.h"

layout(set = 0, binding = 0, scalar) uniform View { ng_view_data view; };
layout(set = 0, binding = 1, scalar) readonly buffer Instances { ng_instance_data instances[]; };

layout(location = 0) in vec3 in_position;

void main()
{
    vec4 m[3] = instances[gl_InstanceIndex].matrix;
    vec4 p = vec4(in_position, 1);
    gl_Position = view.view_projection * vec4(dot(m[0], p), dot(m[1], p), dot(m[2], p), 1);
}

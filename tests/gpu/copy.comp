#version 460

layout(local_size_x = 64) in;
layout(set = 0, binding = 0, std430) readonly buffer Source { uint source[]; };
layout(set = 0, binding = 1, std430) writeonly buffer Target { uint target[]; };
layout(push_constant) uniform Push { uint count, add; };

void main()
{
    uint i = gl_GlobalInvocationID.x;
    if (i < count)
        target[i] = source[i];
}

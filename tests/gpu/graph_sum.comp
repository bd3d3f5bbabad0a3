#version 460
// out[i] = in[i] + add
layout(local_size_x = 64) in;
layout(set = 0, binding = 0) readonly buffer In { uint source[]; };
layout(set = 0, binding = 1) buffer Out { uint target[]; };
layout(push_constant) uniform Push { uint add, count; };

void main()
{
    uint i = gl_GlobalInvocationID.x;
    if (i < count)
        target[i] = source[i] + add;
}

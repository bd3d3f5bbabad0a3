#version 460
// out = in * mul + add + index of the texel, as graph_step.frag and test_graph_gpu.c.
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform usampler2D source;
layout(set = 0, binding = 1, r32ui) uniform writeonly uimage2D target;
layout(push_constant) uniform Push { uint mul, add, width, height; };

void main()
{
    uvec2 p = gl_GlobalInvocationID.xy;
    if (p.x < width && p.y < height)
        imageStore(target, ivec2(p), uvec4(texelFetch(source, ivec2(p), 0).x * mul + add + p.y * width + p.x));
}

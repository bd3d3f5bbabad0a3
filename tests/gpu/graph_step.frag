#version 460
// out = in * mul + add + index of the texel, as graph_step.comp and test_graph_gpu.c.
layout(set = 0, binding = 0) uniform usampler2D source;
layout(push_constant) uniform Push { uint mul, add, width, height; };
layout(location = 0) out uint value;

void main()
{
    uvec2 p = uvec2(gl_FragCoord.xy);
    value = texelFetch(source, ivec2(p), 0).x * mul + add + p.y * width + p.x;
}

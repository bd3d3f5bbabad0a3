// A layer in cells: each texel is the mean of a square of the picture, cut off at its edges.
#version 460

layout(set = 0, binding = 0) uniform sampler2D map;
layout(push_constant) uniform Push { int cell; }; // pixels a side

layout(location = 0) in vec2 in_ndc;
layout(location = 0) out vec4 out_mean;

void main()
{
    const ivec2 from = ivec2(gl_FragCoord.xy) * cell, to = min(from + cell, textureSize(map, 0));
    vec4 sum = vec4(0);
    for (int y = from.y; y < to.y; y++)
        for (int x = from.x; x < to.x; x++)
            sum += texelFetch(map, ivec2(x, y), 0);
    const ivec2 size = to - from;
    out_mean = sum / float(size.x * size.y);
}

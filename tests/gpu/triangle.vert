#version 460
// A triangle that covers the upper left half of the screen.
layout(push_constant) uniform Push { float depth; };
layout(location = 0) out vec2 uv;

void main()
{
    uv = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1);
    gl_Position = vec4(uv * 2 - 1, depth, 1);
}

// Triangles of the user interface. Vertices and indices are read by address: nothing to bind but the font.
#version 460
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

struct Vertex {
    vec2 position; // pixels
    vec2 uv;
    uint color; // RGBA8, red in the low byte
};
layout(buffer_reference, scalar) readonly buffer Vertices {
    Vertex items[];
};
layout(buffer_reference, scalar) readonly buffer Indices {
    uint items[];
};
layout(push_constant, scalar) uniform Push {
    Vertices vertices;
    Indices indices;
    vec2 pixel; // size of a pixel in clip space
} push;

layout(location = 0) out vec2 uv;
layout(location = 1) out vec4 color;

void main()
{
    Vertex v = push.vertices.items[push.indices.items[gl_VertexIndex]];
    uv = v.uv;
    color = unpackUnorm4x8(v.color);
    gl_Position = vec4(v.position * push.pixel - 1.0, 0.0, 1.0);
}

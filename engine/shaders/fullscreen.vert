// One triangle that covers the picture; `out_ndc` runs from -1 to 1, y down.
#version 460

layout(location = 0) out vec2 out_ndc;

void main()
{
    out_ndc = vec2((gl_VertexIndex << 1) & 2, gl_VertexIndex & 2) * 2 - 1;
    gl_Position = vec4(out_ndc, 0, 1); // reverse-Z: the far plane
}

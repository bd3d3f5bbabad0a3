#version 460
layout(location = 0) flat in vec4 passed;
layout(location = 0) out vec4 color;

void main()
{
    color = passed;
}

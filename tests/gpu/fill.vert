#version 460
// A vertex buffer, for the pipeline that uses one.
layout(location = 0) in vec3 position;
layout(location = 1) in vec4 value;
layout(location = 0) flat out vec4 passed;

void main()
{
    passed = value;
    gl_Position = vec4(position, 1);
}

#version 330 core
// Zeros, where a compute shader stores them faster than a rasterizer clears.

layout(location = 0) out vec4 o_value;

void main()
{
    o_value = vec4(0.0);
}

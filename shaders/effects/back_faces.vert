#version 330 core
// Places a vertex; which triangles are back faces is the rasterizer's to decide.
#include "lib/instance.glsl"

uniform mat4 u_clip_from_view;

void main()
{
    gl_Position = u_clip_from_view * vec4(instance_position_vs(), 1.0);
}

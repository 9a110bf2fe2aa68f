#version 330 core
// Triangles of the user interface: colour times texture, straight alpha, sRGB as given.

uniform sampler2D t_atlas;

in vec2 v_uv;
in vec4 v_color;

layout(location = 0) out vec4 o_color;

void main()
{
    o_color = v_color * texture(t_atlas, v_uv);
}

#version 330 core
// A picture as it is, stretched over the target.

uniform sampler2D t_image;

in vec2 v_uv;

layout(location = 0) out vec4 o_color;

void main()
{
    o_color = vec4(texture(t_image, v_uv).rgb, 1.0);
}

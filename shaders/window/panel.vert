#version 330 core
// Triangles of the user interface: positions in window coordinates, y down.

uniform vec2 u_window_size;

in vec2 a_position_px;
in vec2 a_uv;
in vec4 a_color;

out vec2 v_uv;
out vec4 v_color;

void main()
{
    v_uv = a_uv;
    v_color = a_color;
    vec2 ndc = 2.0 * a_position_px / u_window_size - 1.0;
    gl_Position = vec4(ndc.x, -ndc.y, 0.0, 1.0);
}

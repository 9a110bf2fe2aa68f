#version 330 core
// Puts the depths of fronts and backs side by side, so that a march reads both at once.

uniform sampler2D t_z_vs;
uniform sampler2D t_z_back_vs;

layout(location = 0) out vec2 o_z_layers;

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    o_z_layers = vec2(texelFetch(t_z_vs, texel, 0).x, texelFetch(t_z_back_vs, texel, 0).x);
}

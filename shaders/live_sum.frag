#version 330 core
// Adds one frame to a sum by blending. A frame counts for the samples it is the mean of.

uniform sampler2D t_image;
uniform float u_weight;

layout(location = 0) out vec4 o_sum;

void main()
{
    o_sum = u_weight * texelFetch(t_image, ivec2(gl_FragCoord.xy), 0);
}

#version 330 core
// Adds one frame to a sum by blending. A frame counts for the samples it is the mean of.
// IS_ENCODED: the frame holds sRGB codes, which are summed as the light they stand for.
#include "lib/color.glsl"

uniform sampler2D t_image;
uniform float u_weight;

layout(location = 0) out vec4 o_sum;

void main()
{
    vec4 image = texelFetch(t_image, ivec2(gl_FragCoord.xy), 0);
#if IS_ENCODED == 1
    image.rgb = srgb_decode(image.rgb);
#endif
    o_sum = u_weight * image;
}

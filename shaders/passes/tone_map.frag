#version 330 core
// Scene-linear radiance to sRGB. Defines: see lib/displayed.glsl.
#include "lib/displayed.glsl"

uniform sampler2D t_beauty;

layout(location = 0) out vec4 o_display;

void main()
{
    o_display = displayed(texelFetch(t_beauty, ivec2(gl_FragCoord.xy), 0));
}

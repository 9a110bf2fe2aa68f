#version 330 core
// The radiance that every visible surface sends on. Defines: see lib/senders.glsl.
#include "lib/senders.glsl"

layout(location = 0) out vec4 o_sender_radiance;

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    bool is_surface = texelFetch(t_albedo, texel, 0).a > 0.0;
    o_sender_radiance = is_surface ? vec4(summed_sender(texel), 1.0) : vec4(0.0);
}

#version 330 core
// What one irradiance contributes to the picture: albedo / pi * irradiance.
//
// IS_GREY: the irradiance has one channel (see lib/light_channels.glsl).
#include "lib/constants.glsl"
#include "lib/light_channels.glsl"

uniform sampler2D t_albedo;
uniform sampler2D t_irradiance;

layout(location = 0) out vec4 o_radiance;

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    vec4 albedo = texelFetch(t_albedo, texel, 0);
    LIGHT irradiance = light_in(texelFetch(t_irradiance, texel, 0));
    o_radiance = vec4(albedo.rgb * INV_PI * irradiance, albedo.a);
}

#version 330 core
// What one irradiance contributes to the picture: albedo / pi * irradiance.
#include "lib/constants.glsl"

uniform sampler2D t_albedo;
uniform sampler2D t_irradiance;

layout(location = 0) out vec4 o_radiance;

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    vec4 albedo = texelFetch(t_albedo, texel, 0);
    vec3 irradiance = texelFetch(t_irradiance, texel, 0).rgb;
    o_radiance = vec4(albedo.rgb * INV_PI * irradiance, albedo.a);
}

#version 330 core
// What every visible surface sends on: L = L_e + (albedo / pi) times what arrives.
// Emission counts only where no light delivers it already.
//
// Defines: see lib/terms.glsl.
#include "lib/constants.glsl"
#include "lib/terms.glsl"

uniform sampler2D t_albedo;

layout(location = 0) out vec4 o_sender_radiance;

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    vec4 albedo = texelFetch(t_albedo, texel, 0);
    vec3 reflected = albedo.rgb * summed_irradiance(texel) * INV_PI;
    vec3 radiance = summed_radiance(texel, true) + reflected;
    o_sender_radiance = albedo.a > 0.0 ? vec4(radiance, 1.0) : vec4(0.0);
}

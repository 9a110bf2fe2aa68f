#version 330 core
// What every visible surface sends on: L_e and what it reflects of what arrives.
// Emission counts only where no light delivers it already.
//
// Defines: see lib/terms.glsl, and GLOSSY in lib/brdf.glsl.
#include "lib/brdf.glsl"
#include "lib/terms.glsl"

layout(location = 0) out vec4 o_sender_radiance;

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    vec3 reflected = sent_radiance(brdf_at(texel), summed_irradiance(texel));
    vec3 radiance = summed_radiance(texel, true) + reflected;
    bool is_surface = texelFetch(t_albedo, texel, 0).a > 0.0;
    o_sender_radiance = is_surface ? vec4(radiance, 1.0) : vec4(0.0);
}

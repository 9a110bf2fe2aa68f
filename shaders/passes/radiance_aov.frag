#version 330 core
// What some terms contribute to the picture, as radiance.
//
// Defines: see lib/terms.glsl, and GLOSSY in lib/brdf.glsl.
#include "lib/reflected.glsl"
#include "lib/terms.glsl"

layout(location = 0) out vec4 o_radiance;

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    vec3 radiance = summed_radiance(texel, false);
    float coverage = texelFetch(t_albedo, texel, 0).a;
    radiance += reflected_towards_camera(texel, summed_irradiance(texel));
    o_radiance = vec4(radiance, coverage);
}

// What every visible surface sends on: L_e and what it reflects of what arrives.
// Emission counts only where no light delivers it already.
//
// Defines: see lib/terms.glsl, and GLOSSY in lib/brdf.glsl.
#include "lib/brdf.glsl"
#include "lib/terms.glsl"

vec3 summed_sender(ivec2 texel)
{
    vec3 reflected = sent_radiance(brdf_at(texel), summed_irradiance(texel));
    return summed_radiance(texel, true) + reflected;
}

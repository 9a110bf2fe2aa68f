#version 330 core
// What every visible surface sends on: L = L_e + (albedo / pi) (E_direct + E_directional).
// Emission counts only where no light delivers it already (emission.a = 1).
//
// Defines: HAS_DIRECT, HAS_DIRECTIONAL: whether those irradiances exist; HAS_EMISSION.
#include "lib/constants.glsl"

uniform sampler2D t_albedo;
#if HAS_EMISSION
uniform sampler2D t_emission;
#endif
#if HAS_DIRECT
uniform sampler2D t_direct_irradiance;
#endif
#if HAS_DIRECTIONAL
uniform sampler2D t_directional_irradiance;
#endif

layout(location = 0) out vec4 o_sender_radiance;

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    vec3 irradiance = vec3(0.0);
#if HAS_DIRECT
    irradiance += texelFetch(t_direct_irradiance, texel, 0).rgb;
#endif
#if HAS_DIRECTIONAL
    irradiance += texelFetch(t_directional_irradiance, texel, 0).rgb;
#endif
    vec4 albedo = texelFetch(t_albedo, texel, 0);
    vec3 emitted = vec3(0.0);
#if HAS_EMISSION
    vec4 emission = texelFetch(t_emission, texel, 0);
    // A select, not a product: emission of a lamp that is left out may be anything.
    emitted = emission.a > 0.5 ? emission.rgb : vec3(0.0);
#endif
    vec3 radiance = emitted + albedo.rgb * irradiance * INV_PI;
    o_sender_radiance = albedo.a > 0.0 ? vec4(radiance, 1.0) : vec4(0.0);
}

#version 330 core
// The picture: emission + albedo / pi * irradiance, before a sky.
//
// HAS_DIRECT, HAS_DIRECTIONAL, HAS_BOUNCE: which irradiances there are; HAS_EMISSION.
// COMBINE, what the visibility of an ambient-occlusion method multiplies:
//   0 there is none
//   1 ambient: the unoccluded irradiance of the environment
//   2 multiply: that and the direct light
//   3 report: (visibility + 0.4) x direct, the INF584 report's empirical mix for SSAO
//   4 report, ray-traced: direct + visibility / 2 (a grey, whatever the albedo)
#include "lib/constants.glsl"
#include "lib/gbuffer.glsl"
#include "lib/environment.glsl"

uniform sampler2D t_albedo;
#if HAS_EMISSION
uniform sampler2D t_emission;
#endif
#if HAS_DIRECT
uniform sampler2D t_direct;
#endif
#if HAS_DIRECTIONAL
uniform sampler2D t_directional;
#endif
#if HAS_BOUNCE
uniform sampler2D t_bounce;
#endif
#if COMBINE > 0
uniform sampler2D t_visibility;
#endif

layout(location = 0) out vec4 o_beauty;

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    if (gbuffer_z_vs(texel) <= 0.0) {
        vec3 ray_ws = direction_ws_of(normalize(view_ray_at(uv_of_texel(texel))));
        o_beauty = vec4(environment_radiance(ray_ws), 0.0);
        return;
    }

    vec3 irradiance = vec3(0.0);
    vec3 added_radiance = vec3(0.0);
#if HAS_EMISSION
    added_radiance = texelFetch(t_emission, texel, 0).rgb;
#endif
#if HAS_DIRECT
    irradiance += texelFetch(t_direct, texel, 0).rgb;
#endif
#if COMBINE > 0
    float visibility = texelFetch(t_visibility, texel, 0).x;
#endif
#if COMBINE == 1 || COMBINE == 2
    vec3 ambient = environment_irradiance(direction_ws_of(gbuffer_shading_normal_vs(texel)));
#endif
#if COMBINE == 1
    irradiance += ambient * visibility;
#elif COMBINE == 2
    irradiance = (irradiance + ambient) * visibility;
#elif COMBINE == 3
    irradiance *= visibility + 0.4;
#elif COMBINE == 4
    added_radiance += 0.5 * visibility;
#endif
#if HAS_DIRECTIONAL
    irradiance += texelFetch(t_directional, texel, 0).rgb;
#endif
#if HAS_BOUNCE
    irradiance += texelFetch(t_bounce, texel, 0).rgb;
#endif
    vec3 albedo = texelFetch(t_albedo, texel, 0).rgb;
    o_beauty = vec4(added_radiance + albedo * INV_PI * irradiance, 1.0);
}

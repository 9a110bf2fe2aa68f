#version 330 core
// The picture: radiance and reflected irradiance, before a sky.
//
// Defines: see lib/terms.glsl for what is added;
// COMBINE, what the visibility of an ambient-occlusion method multiplies:
//   0 there is none
//   1 ambient: the unoccluded irradiance of the environment
//   2 multiply: that and the direct light
//   3 report: (visibility + 0.4) x direct, the INF584 report's empirical mix for SSAO
//   4 report, ray-traced: direct + visibility / 2 (a grey, whatever the albedo)
// GLOSSY: see lib/brdf.glsl;
// <last_stage>: light that is filtered on the way, see last_stages/;
// IS_SHOWN 1: written as a display shows it; then see lib/displayed.glsl.
#include "lib/gbuffer.glsl"
#include "lib/reflected.glsl"
#include "lib/environment.glsl"
#include "lib/terms.glsl"
#include "lib/displayed.glsl"
#include <last_stage>

#if COMBINE > 0
uniform sampler2D t_visibility;
#endif

layout(location = 0) out vec4 o_picture;

vec4 beauty_at(ivec2 texel)
{
    float z = gbuffer_z_vs(texel);
    if (z <= 0.0) {
        vec3 ray_ws = direction_ws_of(normalize(view_ray_at(uv_of_texel(texel))));
        return vec4(environment_radiance(ray_ws), 0.0);
    }

    vec3 irradiance = summed_irradiance(texel) + light_filtered_here(texel, z);
    vec3 radiance = summed_radiance(texel, false);
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
    radiance += 0.5 * visibility;
#endif
    return vec4(radiance + reflected_towards_camera(texel, irradiance), 1.0);
}

void main()
{
    o_picture = beauty_at(ivec2(gl_FragCoord.xy));
#if IS_SHOWN
    o_picture = displayed(o_picture);
#endif
}

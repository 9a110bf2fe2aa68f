#version 330 core
// The radiance of glossy reflections: the mean radiance of each lobe, without its noise, times
// what the surface reflects of it.
#define GLOSSY 1
#include "lib/brdf.glsl"
#include "lib/gbuffer.glsl"

uniform sampler2D t_reflections_raw;
uniform sampler2D t_reflections_filtered;

layout(location = 0) out vec4 o_radiance;  // alpha 0: senders do not pass it on

// Widths of lobes whose reflection is as sharp as the picture, and of those which are blurred
// more than by the filter.
const float SHARP_ALPHA = 0.01;
const float BLURRED_ALPHA = 0.06;

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    o_radiance = vec4(0.0);
    Brdf brdf = brdf_at(texel);
    if (gbuffer_z_vs(texel) > 0.0 && is_glossy(brdf)) {
        float blur = smoothstep(SHARP_ALPHA, BLURRED_ALPHA, alpha_of(brdf.roughness));
        vec3 raw = texelFetch(t_reflections_raw, texel, 0).rgb;
        vec3 filtered = texelFetch(t_reflections_filtered, texel, 0).rgb;
        vec3 w_out = toward_camera(gbuffer_position_vs(texel));
        float cos_out = cosine_out(gbuffer_shading_normal_vs(texel), w_out);
        o_radiance.rgb = mix(raw, filtered, blur) * layer_reflectance(brdf, cos_out);
    }
}

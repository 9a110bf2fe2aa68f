#version 330 core
// The radiance of glossy reflections: the mean radiance of each lobe, without its noise, times
// what the surface reflects of it.
#define GLOSSY 1
#include "lib/brdf.glsl"
#include "lib/gbuffer.glsl"

uniform sampler2D t_reflections_raw;
uniform sampler2D t_reflections_filtered;

layout(location = 0) out vec4 o_radiance;  // alpha 0: senders do not pass it on

// A lobe as wide as this, in pixels, is as wrong by its noise as by the filter's blur.
const float EVEN_WIDTH_PX = 2.45;
// From the one to the other, filtering begins and is complete however large pixels are: in wide
// lobes few directions find the image of a lamp.
const float SHARP_ALPHA = 0.01;
const float BLURRED_ALPHA = 0.06;

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    o_radiance = vec4(0.0);
    Brdf brdf = brdf_at(texel);
    float z = gbuffer_z_vs(texel);
    if (z > 0.0 && is_glossy(brdf)) {
        float alpha = alpha_of(brdf.roughness);
        float width = alpha * z / (EVEN_WIDTH_PX * pixel_height_at(z));
        float blur = max(width * width / (width * width + 1.0),
                         smoothstep(SHARP_ALPHA, BLURRED_ALPHA, alpha));
        vec3 raw = texelFetch(t_reflections_raw, texel, 0).rgb;
        vec3 filtered = texelFetch(t_reflections_filtered, texel, 0).rgb;
        vec3 w_out = toward_camera(gbuffer_position_vs(texel));
        float cos_out = cosine_out(gbuffer_shading_normal_vs(texel), w_out);
        o_radiance.rgb = mix(raw, filtered, blur) * layer_reflectance(brdf, cos_out);
    }
}

#version 330 core
// The radiance of glossy reflections: the mean radiance of each lobe, without its noise, times
// what the surface reflects of it.
//
// CURVE_WIDTH: where mirrored directions turn fast, images in wide lobes are not filtered either: the
// less the smaller it is; 0: they are.
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

#if CURVE_WIDTH > 0
// How far the normal turns from one pixel to the next: the smaller of two steps, so that edges do
// not count, along the axis along which it turns more.
float turn_at(ivec2 texel)
{
    vec3 n = gbuffer_shading_normal_vs(texel);
    ivec2 last = textureSize(t_z_vs, 0) - 1;
    vec2 turns = vec2(2.0);
    for (int i = 0; i < 4; ++i) {
        ivec2 step = i < 2 ? ivec2(2 * i - 1, 0) : ivec2(0, 2 * i - 5);
        vec3 m = gbuffer_shading_normal_vs(clamp(texel + step, ivec2(0), last));
        turns[i >> 1] = min(turns[i >> 1], length(m - n));
    }
    return max(turns.x, turns.y);
}
#endif

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
#if CURVE_WIDTH > 0
        float curved = float(CURVE_WIDTH) * alpha / max(EVEN_WIDTH_PX * turn_at(texel), 1e-6);
        blur *= curved * curved / (curved * curved + 1.0);
#endif
        vec3 raw = texelFetch(t_reflections_raw, texel, 0).rgb;
        vec3 filtered = texelFetch(t_reflections_filtered, texel, 0).rgb;
        vec3 w_out = toward_camera(gbuffer_position_vs(texel));
        float cos_out = cosine_out(gbuffer_shading_normal_vs(texel), w_out);
        o_radiance.rgb = mix(raw, filtered, blur) * layer_reflectance(brdf, cos_out);
    }
}

#version 330 core
// Adds one frame to a sum. A frame counts for the samples it is the mean of.
//
// A texel without a number, or with one that no light brings, counts as the mean of the
// frames before it; what came before a first sound one counts as that one. One fault would
// otherwise stay in the sum for as long as nothing moves.
//
// IS_ENCODED: the frame holds sRGB codes, which are summed as the light they stand for.
// The sum is shown stretched, so its texture blends: here, exactly one texel is asked for.
#undef texelFetch
#include "lib/color.glsl"
#include "lib/finite.glsl"

uniform sampler2D t_image;
uniform sampler2D t_sum;
uniform float u_weight;   // samples in t_image
uniform float u_count;    // samples in t_sum; if none, whatever is in it does not matter
uniform float u_bound;    // larger values are faults, whatever their sign

layout(location = 0) out vec4 o_sum;

bool is_sound(vec4 value, float count)
{
    return is_finite(value) && all(lessThanEqual(abs(value), vec4(u_bound * count)));
}

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    vec4 image = texelFetch(t_image, texel, 0);
    vec4 sum = texelFetch(t_sum, texel, 0);
#if IS_ENCODED == 1
    image.rgb = srgb_decode(image.rgb);
#endif
    if (u_count == 0.0 || !is_sound(sum, u_count)) {
        o_sum = (u_count + u_weight) * image;
    } else if (!is_sound(image, 1.0)) {
        o_sum = sum + u_weight / u_count * sum;
    } else {
        o_sum = sum + u_weight * image;
    }
}

#version 330 core
// How far the means of two halves of the samples are apart, summed over blocks of pixels.
//
// BLOCK_SIZE: pixels along the side of a block. CHANNEL_COUNT: channels that count, 1 to 4.
#include "lib/finite.glsl"

uniform sampler2D t_sum_a;
uniform sampler2D t_sum_b;
uniform sampler2D t_z_vs;
uniform vec2 u_inverse_counts;  // 1 / samples of each half

// x: largest difference, y: sum of (difference / x)^2, so that no square overflows or
// vanishes; z: sum of the mean over channels, w: pixels. Of what shows a surface and is
// a number in all channels.
layout(location = 0) out vec4 o_block;

vec4 mean_of(sampler2D sums, ivec2 texel, float inverse_count)
{
    bvec4 counts = greaterThan(ivec4(CHANNEL_COUNT), ivec4(0, 1, 2, 3));
    return mix(vec4(0.0), texelFetch(sums, texel, 0) * inverse_count, counts);
}

void main()
{
    ivec2 first = ivec2(gl_FragCoord.xy) * BLOCK_SIZE;
    ivec2 end = min(first + BLOCK_SIZE, textureSize(t_z_vs, 0));
    o_block = vec4(0.0);
    for (int y = first.y; y < end.y; ++y) {
        for (int x = first.x; x < end.x; ++x) {
            ivec2 texel = ivec2(x, y);
            vec4 a = mean_of(t_sum_a, texel, u_inverse_counts.x);
            vec4 b = mean_of(t_sum_b, texel, u_inverse_counts.y);
            if (texelFetch(t_z_vs, texel, 0).x > 0.0 && is_finite(a) && is_finite(b)) {
                vec4 apart = abs(a - b);
                float largest = max(max(apart.x, apart.y), max(apart.z, apart.w));
                // What was summed so far, in units of the new largest.
                float scale = max(o_block.x, largest);
                // Not by division where that is 1: a GPU's x / x may miss it by one rounding,
                // the same one for every pixel.
                float old = o_block.x < scale ? o_block.x / scale : 1.0;
                vec4 ratio = scale > 0.0 ? apart / scale : vec4(0.0);
                o_block.xy = vec2(scale, o_block.y * old * old + dot(ratio, ratio));
                vec4 mean = 0.5 * a + 0.5 * b;
                o_block.zw += vec2(dot(mean, vec4(1.0 / float(CHANNEL_COUNT))), 1.0);
            }
        }
    }
}

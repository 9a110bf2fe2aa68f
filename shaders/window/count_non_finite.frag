#version 330 core
// How many texels of each BLOCK x BLOCK block of an image hold a NaN or an infinity.
#include "lib/finite.glsl"

uniform sampler2D t_image;

layout(location = 0) out float o_count;

void main()
{
    ivec2 first = ivec2(gl_FragCoord.xy) * BLOCK;
    ivec2 end = min(first + BLOCK, textureSize(t_image, 0));
    float count = 0.0;
    for (int y = first.y; y < end.y; ++y) {
        for (int x = first.x; x < end.x; ++x) {
            vec4 c = texelFetch(t_image, ivec2(x, y), 0);
            count += is_finite(c) ? 0.0 : 1.0;
        }
    }
    o_count = count;
}

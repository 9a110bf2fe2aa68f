#version 330 core
// How many texels of each BLOCK x BLOCK block of an image hold a NaN or an infinity.

uniform sampler2D t_image;

layout(location = 0) out float o_count;

// No comparison with NaN holds, so that anything but a plain number fails both.
bool is_finite(float x)
{
    return x >= -3.402823e38 && x <= 3.402823e38;
}

void main()
{
    ivec2 first = ivec2(gl_FragCoord.xy) * BLOCK;
    ivec2 end = min(first + BLOCK, textureSize(t_image, 0));
    float count = 0.0;
    for (int y = first.y; y < end.y; ++y) {
        for (int x = first.x; x < end.x; ++x) {
            vec4 c = texelFetch(t_image, ivec2(x, y), 0);
            bool fine = is_finite(c.r) && is_finite(c.g) && is_finite(c.b) && is_finite(c.a);
            count += fine ? 0.0 : 1.0;
        }
    }
    o_count = count;
}

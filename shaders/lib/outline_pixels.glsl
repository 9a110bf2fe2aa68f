// Pixels around which little of their surface shows: on things a pixel or two wide and at corners.
// A filter finds few others there to average with, and what the last frame saw lies farther away.
#include "lib/gbuffer.glsl"

// Of the eight pixels around. Along a straight outline five show the same surface, at a corner three,
// on a line two.
const int FEWEST_ALIKE = 3;

// `stride`: texels from one pixel to the next.
bool is_outline(ivec2 texel, int stride)
{
    float z = gbuffer_z_vs(texel);
    vec4 codes = texelFetch(t_normals_vs, texel, 0);
    // Heights above the tangent plane, in footprints of a pixel.
    float footprint = pixel_height_at(z) * float(stride);
    vec3 rate = plane_rate(uv_of_texel(texel), oct_decode(codes.zw)) / footprint;
    float offset = plane_height(rate, vec2(0.0), z);
    ivec2 last = ivec2(u_frame_size_px) - 1;
    int alike = -1;  // the pixel itself
    for (int i = 0; i < 9; ++i) {
        ivec2 other = clamp(texel + stride * (ivec2(i % 3, i / 3) - 1), ivec2(0), last);
        float other_z = gbuffer_z_vs(other);
        float height = plane_height(rate, vec2(other - texel), other_z) - offset;
        vec2 turn = 2.0 * (texelFetch(t_normals_vs, other, 0).xy - codes.xy);
        bool is_alike = other_z > 0.0 && abs(height) < 1.0
                     && dot(turn, turn) < NORMAL_TOLERANCE * NORMAL_TOLERANCE;
        alike += is_alike ? 1 : 0;
    }
    return alike < FEWEST_ALIKE;
}

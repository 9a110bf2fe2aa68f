#version 330 core
// How bright pixels are while the camera moves, by their rays and those of pixels about, in this frame
// and those before, and how well that is known.
#include "lib/gbuffer.glsl"

// r: what a pixel's rays have gathered, all colours together; g: 0 if it has none, -1 at contacts, 1 else.
uniform sampler2D t_own_light;
uniform int u_receiver_stride;  // pixels from one that light is gathered at to the next
uniform sampler2D t_past;       // as effects/moving_numbers.frag writes it
uniform float u_most_frames;    // averaged at most

layout(location = 0) out vec2 o_guide;    // light, and its variance
layout(location = 1) out vec4 o_surface;  // as t_past_surfaces of lib/past_surfaces.glsl, g: frames averaged

// Distance from a pixel's plane at which another counts a quarter, in footprints of it.
const float OFF_PLANE = 2.0;

// Mean of the light of a pixel and the four next to it, of the same surface, and its variance.
// With the corners, too, nothing is told apart better.
vec2 light_about(ivec2 texel, vec2 own, float z)
{
    vec4 codes = texelFetch(t_normals_vs, texel, 0);
    float tolerance = OFF_PLANE * float(u_receiver_stride) * pixel_height_at(z);
    vec3 rate = plane_rate(uv_of_texel(texel), oct_decode(codes.zw)) / tolerance;
    float offset = plane_height(rate, vec2(0.0), z);
    ivec2 last = textureSize(t_own_light, 0) - 1;
    // Relative to the pixel's own, so that squares of what is alike leave something.
    vec2 sums = vec2(0.0);
    vec2 weights = vec2(1.0);
    for (int i = 0; i < 4; ++i) {
        ivec2 step_px = u_receiver_stride * (2 * (i & 1) - 1) * (i < 2 ? ivec2(1, 0) : ivec2(0, 1));
        ivec2 other = clamp(texel + step_px, ivec2(0), last);
        vec2 light = texelFetch(t_own_light, other, 0).rg;
        float off = plane_height(rate, vec2(step_px), gbuffer_z_vs(other)) - offset;
        vec2 turn = 2.0 * (texelFetch(t_normals_vs, other, 0).xy - codes.xy);
        float agree = max(1.0 - dot(turn, turn) / (NORMAL_TOLERANCE * NORMAL_TOLERANCE), 0.0);
        bool counts = other == texel + step_px && light.g == own.g;
        float weight = counts ? agree / ((1.0 + off * off) * (1.0 + off * off)) : 0.0;
        float apart = light.r - own.r;
        sums += weight * apart * vec2(1.0, apart);
        weights += weight * vec2(1.0, weight);
    }
    vec2 mean = sums / weights.x;
    float part = weights.y / (weights.x * weights.x);
    float variance = part * max(mean.y - mean.x * mean.x, 0.0) / max(1.0 - part, 1e-6);
    // One pixel alone might be any.
    return vec2(own.r + mean.x, weights.x > 1.0 ? variance : own.r * own.r);
}

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    float z = gbuffer_z_vs(texel);
    o_guide = vec2(0.0);
    o_surface = vec4(z, 0.0, texelFetch(t_normals_vs, texel, 0).xy);
    vec2 own = texelFetch(t_own_light, texel, 0).rg;
    if (own.g == 0.0)
        return;
    vec2 light = light_about(texel, own, z);
    vec3 past = texelFetch(t_past, texel, 0).xyz;
    float frames = min(past.z, u_most_frames - 1.0) + 1.0;
    float share = 1.0 / frames;
    float kept = 1.0 - share;
    o_guide = vec2(mix(past.x, light.x, share), kept * kept * past.y + share * share * light.y);
    o_surface.g = frames;
}

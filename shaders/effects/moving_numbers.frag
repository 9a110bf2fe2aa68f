#version 330 core
// How many per-pixel rays each pixel traces while the camera moves, and what the last frame knew of it.
//
// Defines: HAS_PAST 0: there is nothing before this frame.
#include "lib/shaded_pixels.glsl"
#include "lib/outline_pixels.glsl"
#include "lib/past_surfaces.glsl"

uniform int u_receiver_stride;  // pixels from one that light is gathered at to the next
uniform int u_many_rays;        // of pixels that a neighbour in front may shade
uniform int u_outline_rays;     // of pixels around which little of their surface shows
uniform int u_lost_rays;        // at most, of pixels whose surface the last frame shows little of
uniform int u_few_rays;         // of all others

#if HAS_PAST
uniform sampler2D t_past_guide;  // as effects/moving_guide.frag writes it
#endif

layout(location = 0) out int o_number;  // negative: a neighbour may shade it; 0: none
// Light that rays had found there, its variance, and for how many frames that counts; 0: none.
layout(location = 1) out vec4 o_past;

#if HAS_PAST
// How much of the surface at `texel` the last frame shows, of the four texels around, and what it knew.
float known_share(ivec2 texel, out vec4 past)
{
    Place place = place_of(texel, gbuffer_z_vs(texel));
    float share = 0.0;
    float known = 0.0;
    past = vec4(0.0);
    for (int i = 0; i < 4; ++i) {
        ivec2 step_px = ivec2(i & 1, i >> 1);
        ivec2 tap = place.base + step_px;
        vec4 surface = past_surface(tap);
        float weight = tap_weight(place, step_px) * same_surface(place, step_px, surface);
        share += weight;
        weight = surface.g > 0.0 ? weight : 0.0;
        past.xyz += weight > 0.0 ? weight * vec3(texelFetch(t_past_guide, tap, 0).rg, surface.g) : vec3(0.0);
        known += weight;
    }
    past.xy /= max(known, 1e-30);
    past = place.is_seen ? past : vec4(0.0);
    return place.is_seen ? share : 0.0;
}
#endif

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    o_number = 0;
    o_past = vec4(0.0);
    if (gbuffer_z_vs(texel) <= 0.0 || texel % u_receiver_stride != ivec2(0))
        return;
    bool is_edge = may_be_shaded(texel);
    int ray_count = is_edge ? u_many_rays : u_few_rays;
    if (ray_count < u_outline_rays && is_outline(texel, u_receiver_stride))
        ray_count = u_outline_rays;
#if HAS_PAST
    // The average stands for as many frames fewer (passes/temporal.frag).
    float lost_rays = min(float(u_few_rays) / max(known_share(texel, o_past), 1e-3), float(u_lost_rays));
    ray_count = max(ray_count, int(lost_rays + 0.5));
#endif
    o_number = is_edge ? -ray_count : ray_count;
}

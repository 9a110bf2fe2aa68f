#version 330 core
// How many per-pixel rays each pixel traces while the camera moves.
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

layout(location = 0) out int o_number;  // negative: a neighbour may shade it; 0: none

#if HAS_PAST
// How much of the surface at `texel` the last frame shows, of the four texels around.
float known_share(ivec2 texel)
{
    Place place = place_of(texel, gbuffer_z_vs(texel));
    float share = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 step_px = ivec2(i & 1, i >> 1);
        share += same_surface(place, step_px, past_surface(place.base + step_px))
               * tap_weight(place, step_px);
    }
    return place.is_seen ? share : 0.0;
}
#endif

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    o_number = 0;
    if (gbuffer_z_vs(texel) <= 0.0 || texel % u_receiver_stride != ivec2(0))
        return;
    bool is_edge = may_be_shaded(texel);
    int ray_count = is_edge ? u_many_rays : u_few_rays;
    if (ray_count < u_outline_rays && is_outline(texel, u_receiver_stride))
        ray_count = u_outline_rays;
#if HAS_PAST
    // The average stands for as many frames fewer (passes/temporal.frag).
    float lost_rays = min(float(u_few_rays) / max(known_share(texel), 1e-3), float(u_lost_rays));
    ray_count = max(ray_count, int(lost_rays + 0.5));
#endif
    o_number = is_edge ? -ray_count : ray_count;
}

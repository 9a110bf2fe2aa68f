#version 330 core
// One bounce: irradiance from the surfaces that block the receiver's directions,
//   E(P) = integral of (1 - V_R(w)) L(Q(w)) cos(theta) dw,
// with the same directions that effects/directional.frag uses, so that V and 1 - V share out
// the hemisphere and a white furnace comes out exact.
//
// Defines: DIRECTION_COUNT, STEP_COUNT, HAS_BACK_LAYER; ADDS 1: to another irradiance;
// KEPT_TEXTURE_COUNT (see screen_space/kept_directions.glsl): another pass has marched already;
// GATHERED 1: light that per-pixel rays have gathered takes the march's place;
// SUMS_SENDERS 1: terms are added up at each sender (see lib/senders.glsl), not looked up.
#define GATHERS_SENDERS 1
uniform float u_hidden_senders;  // march: share of the radiance sent from a hidden side
uniform float u_distance_clamp;  // rgs09, relative to R

#include "screen_space/estimator.glsl"
#include "lib/finite.glsl"
#include "lib/senders.glsl"
#define TAKES_DIRECTIONS 1
#include "screen_space/kept_directions.glsl"

#if !SUMS_SENDERS
uniform sampler2D t_sender_radiance;
#endif
#if GATHERED
uniform sampler2D t_gathered_near;  // as rays/shared_rays.glsl says
#endif
#if ADDS
uniform sampler2D t_added;
#endif
uniform float u_strength;
uniform float u_sender_bound;    // W sr^-1 m^-2, may be infinite

layout(location = 0) out vec4 o_bounce;  // irradiance, then z for the filter: negative where a neighbour in front may shade

// Radiance that leaves the surface at `texel`, kept within the scene's own light. Scaling
// by the largest component keeps the hue; what is no number, or negative, is no light.
vec3 bounded_radiance(ivec2 texel)
{
#if SUMS_SENDERS
    vec3 radiance = summed_sender(texel);
#else
    vec3 radiance = texelFetch(t_sender_radiance, texel, 0).rgb;
#endif
    float largest = max(radiance.r, max(radiance.g, radiance.b));
    float factor = largest > u_sender_bound ? u_sender_bound / largest : 1.0;
    bool is_light = is_finite(radiance) && all(greaterThanEqual(radiance, vec3(0.0)));
    return is_light && largest > 0.0 ? radiance * factor : vec3(0.0);
}

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    Receiver r = receiver_at(pixel, DIRECTION_COUNT);
    vec3 irradiance = vec3(0.0);
    float z = r.z_vs;
#if GATHERED
    vec4 found = texelFetch(t_gathered_near, receiver_texel(pixel), 0);
    irradiance = PI * found.rgb;
    z = found.a < 0.0 ? -z : z;
#else
    if (r.z_vs > 0.0 && !is_radius_under_a_pixel(r.z_vs)) {
        Tangent t = tangent_at(r.position_vs, r.geometric_vs);
#if FINDS_SECTORS
        irradiance = estimator_gathered(r, t);
#else
#if KEPT_TEXTURE_COUNT > 0
        take_directions(pixel);
#endif
        // Tested at its end: in software other loops cost two rounds more than they run.
        int i = 0;
        do {
            Direction d = direction_of(r, i);
#if KEPT_TEXTURE_COUNT > 0
            Blocker b = next_kept_blocker();
#else
            Blocker b = blocker_of(t, d);
#endif
            if (is_blocked(b)) {
                vec3 radiance = bounded_radiance(b.texel);
                irradiance += estimator_sent(r, t, d, radiance, b.texel);
            }
        } while (++i < DIRECTION_COUNT);
#endif
    }
#endif
    irradiance *= u_strength;
#if ADDS
    irradiance += texelFetch(t_added, pixel, 0).rgb;
#endif
    o_bounce = vec4(irradiance, z);
}

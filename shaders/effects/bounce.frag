#version 330 core
// One bounce: irradiance from the surfaces that block the receiver's directions,
//   E(P) = integral of (1 - V_R(w)) L(Q(w)) cos(theta) dw,
// with the same directions that effects/directional.frag uses, so that V and 1 - V share out
// the hemisphere and a white furnace comes out exact.
//
// Defines: ESTIMATOR 0 march, 1 rgs09; DIRECTION_COUNT, STEP_COUNT, HAS_BACK_LAYER;
// KEPT_TEXTURE_COUNT (see lib/kept_directions.glsl): another pass has marched already.
#include "lib/estimator.glsl"
#include "lib/finite.glsl"
#define TAKES_DIRECTIONS 1
#include "lib/kept_directions.glsl"

uniform sampler2D t_sender_radiance;
uniform float u_strength;
uniform float u_hidden_senders;  // march: share of the radiance sent from a hidden side
uniform float u_sender_bound;    // W sr^-1 m^-2, may be infinite
uniform float u_distance_clamp;  // rgs09, relative to R

layout(location = 0) out vec4 o_bounce;  // irradiance, then z for the filter

// Radiance that leaves the surface at `texel`, kept within the scene's own light. Scaling
// by the largest component keeps the hue; what is no number, or negative, is no light.
vec3 bounded_radiance(ivec2 texel)
{
    vec3 radiance = texelFetch(t_sender_radiance, texel, 0).rgb;
    float largest = max(radiance.r, max(radiance.g, radiance.b));
    float factor = largest > u_sender_bound ? u_sender_bound / largest : 1.0;
    bool is_light = is_finite(radiance) && all(greaterThanEqual(radiance, vec3(0.0)));
    return is_light && largest > 0.0 ? radiance * factor : vec3(0.0);
}

#if ESTIMATOR == ESTIMATOR_RGS09
// Section 3.2 of the paper: (1 - V) A_s cos(theta_s) cos(theta_r) / d^2 with the sender's
// area A_s = pi r_max^2 / N: the base disk of the hemisphere, shared out evenly.
//
// Departure: the paper clamps d to 1 in world units, which makes the bounce scale as R^2
// where R < 1; here d is clamped relative to R.
vec3 sent(Receiver r, Tangent t, vec3 radiance, ivec2 texel)
{
    vec3 to_sender = gbuffer_position_vs(texel) - r.position_vs;
    float d2 = dot(to_sender, to_sender);
    // is_above has ruled out d = 0: Q lies off the tangent plane of P.
    vec3 w = to_sender * inversesqrt(d2);
    float cos_r = max(dot(r.normal_vs, w), 0.0);
    // The sender's normal against the direction back to the receiver: positive where the
    // lit side faces it. Senders that turn away contribute nothing.
    float cos_s = max(dot(gbuffer_shading_normal_vs(texel), -w), 0.0);
    float reach = finite_radius(t);
    float d_min = u_distance_clamp * reach;
    float area_over_d2 = PI * reach * reach / (float(DIRECTION_COUNT) * max(d2, d_min * d_min));
    return radiance * (area_over_d2 * cos_s * cos_r);
}
#else
// Each blocked direction stands for the solid angle it was drawn with, pi / N of the
// cosine-weighted hemisphere: no area, no distance, no singularity, no scale.
vec3 sent(Receiver r, vec3 radiance, ivec2 texel, float share)
{
    vec3 to_receiver = r.position_vs - gbuffer_position_vs(texel);
    // What is seen of a surface is its front. If that turns away from the receiver, the
    // ray met a side of the solid that the camera does not see. All that is known of what
    // this side sends is that the other side of the same thing is near.
    bool faces = dot(gbuffer_geometric_normal_vs(texel), to_receiver) > 0.0;
    return radiance * (PI * share * (faces ? 1.0 : u_hidden_senders));
}
#endif

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    Receiver r = receiver_at(pixel, DIRECTION_COUNT);
    vec3 irradiance = vec3(0.0);
    if (r.z_vs > 0.0 && !is_radius_under_a_pixel(r.z_vs)) {
        Tangent t = tangent_at(r.position_vs, r.geometric_vs);
#if KEPT_TEXTURE_COUNT > 0
        take_directions(pixel);
#endif
        for (int i = 0; i < DIRECTION_COUNT; ++i) {
            Direction d = direction_of(r, i);
#if KEPT_TEXTURE_COUNT > 0
            Blocker b = kept_blocker(i);
#else
            Blocker b = blocker_of(t, d);
#endif
            if (is_blocked(b)) {
                vec3 radiance = bounded_radiance(b.texel);
#if ESTIMATOR == ESTIMATOR_RGS09
                irradiance += sent(r, t, radiance, b.texel);
#else
                irradiance += sent(r, radiance, b.texel, d.share);
#endif
            }
        }
    }
    o_bounce = vec4(irradiance * u_strength, r.z_vs);
}

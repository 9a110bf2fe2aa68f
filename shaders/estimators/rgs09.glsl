// Ritschel, Grosch and Seidel 2009, "Approximating Dynamic Global Illumination in Image
// Space", as written: uniform directions with one point each, senders by their area.
#include "screen_space/point_samples.glsl"
#include "lib/sampling.glsl"

#define FINDS_BLOCKERS 1
#define FINDS_SECTORS 0

// Uniform directions, each with solid angle 2 pi / N.
vec3 estimator_direction(vec2 u)
{
    return uniform_hemisphere(u);
}

float estimator_share(vec3 local)
{
    return local.z * 2.0 / float(DIRECTION_COUNT);
}

Blocker estimator_blocker(Tangent t, Direction d, int steps, int refinements)
{
    return point_blocker(t, d.w_vs, point_reach(t, d.w_vs) * d.jitter, false);
}

#if GATHERS_SENDERS
// Section 3.2 of the paper: (1 - V) A_s cos(theta_s) cos(theta_r) / d^2 with the sender's
// area A_s = pi r_max^2 / N: the base disk of the hemisphere, shared out evenly.
//
// Departure: the paper clamps d to 1 in world units, which makes the bounce scale as R^2
// where R < 1; here d is clamped relative to R.
vec3 estimator_sent(Receiver r, Tangent t, Direction d, vec3 radiance, ivec2 texel)
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
#endif

// Several depth reads along each direction: see screen_space/march.glsl.
#include "screen_space/march.glsl"
#include "lib/sampling.glsl"

#define FINDS_BLOCKERS 1
#define FINDS_SECTORS 0
#define FINDS_IN_STEPS 1

vec3 estimator_direction(vec2 u)
{
    return cosine_hemisphere(u);
}

float estimator_share(vec3 local)
{
    return 1.0 / float(DIRECTION_COUNT);
}

Steps estimator_steps(Tangent t, Direction d, int steps)
{
    return steps_along(t, d.w_vs, u_radius, d.jitter, steps);
}

#if GATHERS_SENDERS
// Each blocked direction stands for the solid angle it was drawn with, pi / N of the
// cosine-weighted hemisphere: no area, no distance, no singularity, no scale.
vec3 estimator_sent(Receiver r, Tangent t, Direction d, vec3 radiance, ivec2 texel)
{
    return radiance * (PI * d.share * share_sent(r.position_vs, texel));
}
#endif

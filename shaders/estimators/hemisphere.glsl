// Points of the normal's half-ball, one for each direction: visibility as most viewers
// estimate it.
#include "screen_space/point_samples.glsl"
#include "lib/sampling.glsl"

#define FINDS_BLOCKERS 1

vec3 estimator_direction(vec2 u)
{
    return cosine_hemisphere(u);
}

float estimator_share(vec3 local)
{
    return 1.0 / float(DIRECTION_COUNT);
}

// Distances R sqrt(u) instead of the paper's R u: a point near the receiver misses what
// stands farther out. From R / 20 to R / 2 away from a wall, u loses 18 to 73 % of its
// occlusion, sqrt(u) 6 to 56 % (closed forms A1, A4).
Blocker estimator_blocker(Tangent t, Direction d, int steps, int refinements)
{
    return point_blocker(t, d.w_vs, point_reach(t, d.w_vs) * sqrt(d.jitter), true);
}

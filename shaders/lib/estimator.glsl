// One interface to the estimators: directions, their weight, and what blocks them.
// The integral over the hemisphere of f(w) cos(theta) dw is estimated by
// pi * sum_i share_i f(w_i).
//
// IS_OPEN: 1 if it is known beforehand that nothing in view blocks any direction within R.
#include "lib/receiver.glsl"
#include "lib/march.glsl"
#include "lib/rgs09.glsl"

#define ESTIMATOR_MARCH 0
#define ESTIMATOR_RGS09 1
#define ESTIMATOR_HEMISPHERE 2

struct Direction {
    vec3 w_vs;       // unit length, above the tangent plane
    float share;     // of the cosine-weighted hemisphere: cos(theta) / (pi density count)
    float jitter;    // in [0, 1), for the distance
};

Direction direction_of(Receiver r, int i)
{
    vec3 u = sample_point(r, i);
#if ESTIMATOR == ESTIMATOR_RGS09
    // The paper: uniform directions, each with solid angle 2 pi / N.
    vec3 local = uniform_hemisphere(u.xy);
    float share = local.z * 2.0 / float(DIRECTION_COUNT);
#else
    vec3 local = cosine_hemisphere(u.xy);
    float share = 1.0 / float(DIRECTION_COUNT);
#endif
    vec3 w = r.vs_from_tangent * local;
    // The facets of a smooth shape tilt away from its shading normals. A direction below
    // the facet is mirrored above it, as the ray-traced references do: no weight is lost,
    // and a convex shape stays open.
    w -= 2.0 * min(dot(w, r.geometric_vs), 0.0) * r.geometric_vs;
    return Direction(w, share, u.z);
}

// Distances above FAR_REACH times z have no place in the picture; R may be infinite.
float finite_radius(Tangent t)
{
    return min(u_radius, FAR_REACH * -t.position_vs.z);
}

// Over how far single points are spread: R, or what of the ray is in the frame where R
// is without end. (Where it is not, points may well fall outside, as in the paper.)
float point_reach(Tangent t, vec3 w)
{
    float radius = finite_radius(t);
    return radius < u_radius ? distance_in_frame(t.position_vs, w) : radius;
}

// What blocks the direction within R.
Blocker blocker_of(Tangent t, Direction d)
{
#if IS_OPEN
    return NO_BLOCKER;
#elif ESTIMATOR == ESTIMATOR_MARCH
    return march(t, d.w_vs, u_radius, d.jitter, STEP_COUNT, REFINE_COUNT);
#elif ESTIMATOR == ESTIMATOR_RGS09
    return point_blocker(t, d.w_vs, point_reach(t, d.w_vs) * d.jitter, false);
#else
    // Distances R sqrt(u) instead of the paper's R u: a point near the receiver misses what
    // stands farther out. From R / 20 to R / 2 away from a wall, u loses 18 to 73 % of its
    // occlusion, sqrt(u) 6 to 56 % (closed forms A1, A4).
    return point_blocker(t, d.w_vs, point_reach(t, d.w_vs) * sqrt(d.jitter), true);
#endif
}

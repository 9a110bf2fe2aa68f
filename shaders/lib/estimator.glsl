// One interface to the estimators: directions, their weight, and what blocks them.
// The integral over the hemisphere of f(w) cos(theta) dw is estimated by
// pi * sum_i share_i f(w_i).
//
// The pass chooses one of shaders/estimators/ (`#include <estimator>`). It defines
//   FINDS_BLOCKERS: 1, or 0 if all it tells is visibility. If 1,
//     vec3 estimator_direction(vec2 u): unit vector about +z for u in [0, 1)^2
//     float estimator_share(vec3 local): of the cosine-weighted hemisphere
//     Blocker estimator_blocker(Tangent t, Direction d, int steps, int refinements)
//     vec3 estimator_sent(Receiver r, Tangent t, Direction d, vec3 radiance, ivec2 texel):
//       irradiance from a blocker, if GATHERS_SENDERS, which the including file defines;
//   if 0,
//     float estimator_visibility(Receiver r, ivec2 centre).
//
// IS_OPEN: 1 if it is known beforehand that nothing in view blocks any direction within R.
#include "lib/receiver.glsl"
#include "lib/march.glsl"

struct Direction {
    vec3 w_vs;       // unit length, above the tangent plane
    float share;     // of the cosine-weighted hemisphere: cos(theta) / (pi density count)
    float jitter;    // in [0, 1), for the distance
};

#include <estimator>

#if FINDS_BLOCKERS
Direction direction_of(Receiver r, int i)
{
    vec3 u = sample_point(r, i);
    vec3 local = estimator_direction(u.xy);
    vec3 w = r.vs_from_tangent * local;
    // The facets of a smooth shape tilt away from its shading normals. A direction below
    // the facet is mirrored above it, as the ray-traced references do: no weight is lost,
    // and a convex shape stays open.
    w -= 2.0 * min(dot(w, r.geometric_vs), 0.0) * r.geometric_vs;
    return Direction(w, estimator_share(local), u.z);
}

// What blocks the direction within R.
Blocker blocker_of(Tangent t, Direction d)
{
#if IS_OPEN
    return NO_BLOCKER;
#else
    return estimator_blocker(t, d, STEP_COUNT, REFINE_COUNT);
#endif
}
#endif

// One interface to the estimators: directions, their weight, and what blocks them.
// The integral over the hemisphere of f(w) cos(theta) dw is estimated by
// pi * sum_i share_i f(w_i).
//
// The pass chooses one of shaders/estimators/ (`#include <estimator>`). It defines
//   FINDS_BLOCKERS: 1, or 0 if all it tells is visibility. If 1,
//     vec3 estimator_direction(vec2 u): unit vector about +z for u in [0, 1)^2
//     float estimator_share(vec3 local): of the cosine-weighted hemisphere
//     Blocker estimator_blocker(Tangent t, Direction d, int steps, int refinements), or with
//       FINDS_IN_STEPS, the same in two parts, of which `refined` is the second:
//     Steps estimator_steps(Tangent t, Direction d, int steps)
//     vec3 estimator_sent(Receiver r, Tangent t, Direction d, vec3 radiance, ivec2 texel):
//       irradiance from a blocker, if GATHERS_SENDERS, which the including file defines;
//   if 0,
//     float estimator_visibility(Receiver r, ivec2 centre).
//   FINDS_SECTORS: 1 if it tells which of 32 directions of each slice are blocked, which is
//   enough to gather light. (Estimators of mere visibility need not define it.) If 1,
//     Sectors estimator_sectors(Receiver r, vec3 view, int i): slice i of DIRECTION_COUNT
//     float estimator_sector_share(Receiver r, vec3 view): of a direction of weight 1
//     uint estimator_hidden(Sectors s, Tangent t, vec3 view, float jitter, inout vec3 sent)
//     vec3 estimator_gathered(Receiver r, Tangent t): irradiance, if GATHERS_SENDERS.
//
// IS_OPEN: 1 if it is known beforehand that nothing in view blocks any direction within R.
#include "screen_space/receiver.glsl"
#include "screen_space/march.glsl"

struct Direction {
    vec3 w_vs;       // unit length, above the tangent plane
    float share;     // of the cosine-weighted hemisphere: cos(theta) / (pi density count)
    float jitter;    // in [0, 1), for the distance
};

#if GATHERS_SENDERS
// Radiance that leaves the surface at `texel`: the including file's.
vec3 bounded_radiance(ivec2 texel);

// Which share of that a blocker sends to the receiver.
float share_sent(vec3 position_vs, ivec2 texel)
{
    vec3 to_receiver = position_vs - gbuffer_position_vs(texel);
    // What is seen of a surface is its front. If that turns away from the receiver, the
    // ray met a side of the solid that the camera does not see. All that is known of what
    // this side sends is that the other side of the same thing is near.
    return gbuffer_faces(texel, to_receiver) ? 1.0 : u_hidden_senders;
}
#endif

#include <estimator>
#ifndef FINDS_IN_STEPS
#define FINDS_IN_STEPS 0
#endif
#ifndef MOST_TOGETHER
#define MOST_TOGETHER 1
#endif

// So many directions are followed side by side, of which each does part after part what the
// others do. In software one goes on while another waits for what it looked up.
const int TOGETHER = DIRECTION_COUNT % MOST_TOGETHER == 0 ? MOST_TOGETHER
                   : MOST_TOGETHER > 1 && DIRECTION_COUNT % 2 == 0 ? 2 : 1;

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

#if FINDS_IN_STEPS && !IS_OPEN
Blocker estimator_blocker(Tangent t, Direction d, int steps, int refinements)
{
    return refined(t, estimator_steps(t, d, steps), refinements);
}
#endif

// What blocks the direction within R.
Blocker blocker_of(Tangent t, Direction d)
{
#if IS_OPEN
    return NO_BLOCKER;
#else
    return estimator_blocker(t, d, STEP_COUNT, REFINE_COUNT);
#endif
}

// What blocks directions i, i + 1, ... of the receiver within R.
void blockers_of(Receiver r, Tangent t, int i, out Direction d[TOGETHER], out Blocker b[TOGETHER])
{
    for (int k = 0; k < TOGETHER; ++k)
        d[k] = direction_of(r, i + k);
#if FINDS_IN_STEPS && !IS_OPEN
    Steps steps[TOGETHER];
    for (int k = 0; k < TOGETHER; ++k)
        steps[k] = estimator_steps(t, d[k], STEP_COUNT);
    for (int k = 0; k < TOGETHER; ++k)
        b[k] = refined(t, steps[k], REFINE_COUNT);
#else
    for (int k = 0; k < TOGETHER; ++k)
        b[k] = blocker_of(t, d[k]);
#endif
}
#endif

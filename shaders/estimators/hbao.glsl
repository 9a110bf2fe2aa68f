// Bavoil, Sainz and Dimitrov 2008, "Image-Space Horizon-Based Ambient Occlusion" (HBAO): in
// each direction of the picture, what lies between the tangent plane and the highest thing
// seen is blocked. Every solid angle counts alike, so that even converged this is not the
// cosine-weighted visibility that is asked for.
//
// Departures. Elevations are told from the plane square to the pixel's own view vector, not
// from the picture's. Only what stands above the tangent plane raises a horizon, in place of
// an angle that a horizon must exceed. What is within R counts wholly, what is not does not
// count, where the paper lets it fade by 1 - (d / R)^2: visibility is defined by R. (RMSE
// over five scenes at two radii, 32 directions of 8 steps: .095, with the fading .099.)
#include "screen_space/slices.glsl"

#define FINDS_BLOCKERS 0

// Blocked share of the half-plane above one direction of the picture.
float blocked_along(Tangent t, vec3 view, vec3 along, float jitter)
{
    float tangent = -sin(slice_along(along, view, t.normal_vs).normal_angle);
    return highest_elevation(t, view, along, jitter, tangent) - tangent;
}

float estimator_visibility(Receiver r, ivec2 centre)
{
    Tangent t = tangent_at(r.position_vs, r.geometric_vs);
    vec3 view = toward_camera(r.position_vs);
    float blocked = 0.0;
    int i = 0;
    do {
        vec3 along = slice_direction(view, 2.0 * PI * slice_turn(r, i));
        blocked += blocked_along(t, view, along, sample_point(r, i).y);
    } while (++i < DIRECTION_COUNT);
    return max(1.0 - blocked / float(DIRECTION_COUNT), 0.0);
}

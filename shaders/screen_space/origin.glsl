// Where rays begin, and how soon they leave the frame.
#include "lib/space.glsl"

uniform float u_near_vs;           // distance of the near plane

// Rays end this many pixels inside the frame's border, so that rounding cannot
// carry a step outside; what lies outside is open anyway.
const float BORDER_PX = 0.25;
// Stands for an infinite reach: beyond it the rest of a ray covers 1e-4 of the frame.
const float FAR_REACH = 1.0e4;
// Distances to borders count as at least this: 1 / 0 is no bound.
const float LEAST_GAP = 1.0e-30;

// What all rays from a point have in common. Kept, because a division takes as long as ten
// products, and compilers do not take it out of a loop.
struct Origin {
    vec3 position_vs;
    vec2 start_px;
    float nearness;
    vec4 slopes;         // see frame_gaps
    vec4 inverse_gaps;
    float inverse_depth; // beyond the near plane
    float inverse_reach; // the least that is told apart from none
    vec2 px_scale;       // see picture_place
    vec2 centre_px;      // where the camera's axis is seen
};

Origin origin_at(vec3 p_vs)
{
    vec4 slopes = frame_slopes(BORDER_PX);
    float from_eye = nearness(-p_vs.z);
    vec2 scale = px_scale();
    vec2 centre = (0.5 - 0.5 * u_jitter_ndc) * u_frame_size_px;
    return Origin(p_vs, picture_place(p_vs, from_eye) * scale + centre, from_eye, slopes,
                  1.0 / max(frame_gaps(slopes, p_vs), LEAST_GAP),
                  1.0 / max(-p_vs.z - u_near_vs, LEAST_GAP), 1.0 / (FAR_REACH * -p_vs.z),
                  scale, centre);
}

// Distance along the unit vector w at which a ray leaves the frame or passes the near plane,
// at most `reach`. Beyond that, nothing is known, and unknown means open.
float distance_in_frame(Origin o, vec3 w, float reach)
{
    // The gap to each border is linear along the ray, so it closes at gap / -rate if it shrinks:
    // the first to do so has the largest inverse. The sign is w's: that of a product compilers give
    // to the inverse, and divide anew for each direction.
    vec4 closes = frame_gap_rates(o.slopes, -w) * o.inverse_gaps;
    float borders = max(max(closes.x, closes.y), max(closes.z, closes.w));
    float first = max(max(borders, w.z * o.inverse_depth), o.inverse_reach);
    return min(reach, 1.0 / first);
}

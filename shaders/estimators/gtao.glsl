// Jimenez, Wu, Pesce and Jarabo 2016, "Practical Real-Time Strategies for Accurate Indirect
// Occlusion" (GTAO): of each slice all is blocked that lies below the highest thing seen on
// either side, weighted by the cosine in closed form.
//
// Departures. Whatever is farther than R does not count, where the paper lets its effect
// fade: visibility is defined by R. What is blocked is taken from 1, so that an open
// hemisphere is exactly open also with few slices. Slices are spread evenly about the view
// vector of the pixel, not about that of the picture's middle. A horizon is raised only by what
// stands above the tangent plane. The paper's heuristic for thin things, which lowers the
// horizon again behind them, is left out, as in XeGTAO's defaults.
#include "screen_space/slices.glsl"

#define FINDS_BLOCKERS 0

// What one side hides of a slice; `gamma` counts towards this side.
float hidden_below_horizon(Tangent t, vec3 view, vec3 along, float gamma, float jitter)
{
    // Of the angle between view vector and horizon.
    float cosine = highest_elevation(t, view, along, jitter, NO_ELEVATION);
    if (cosine == NO_ELEVATION)
        return 0.0;
    float end = clamp(gamma + 0.5 * PI, 0.0, PI);
    float horizon = angle_of(sqrt(max(1.0 - cosine * cosine, 0.0)), cosine);
    return max(arc_integral(end, gamma) - arc_integral(min(horizon, end), gamma), 0.0);
}

float estimator_visibility(Receiver r, ivec2 centre)
{
    Tangent t = tangent_at(r.position_vs, r.geometric_vs);
    vec3 view = toward_camera(r.position_vs);
    float blocked = 0.0;
    int i = 0;
    do {
        vec3 u = sample_point(r, i);
        vec3 along = slice_direction(view, PI * slice_turn(r, i));
        Slice slice = slice_along(along, view, r.normal_vs);
        blocked += slice.normal_length
            * (hidden_below_horizon(t, view, along, slice.normal_angle, u.y)
               + hidden_below_horizon(t, view, -along, -slice.normal_angle, u.z));
    } while (++i < DIRECTION_COUNT);
    return max(1.0 - blocked / float(DIRECTION_COUNT), 0.0);
}

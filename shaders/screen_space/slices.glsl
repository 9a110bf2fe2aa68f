// Slices of the hemisphere: planes through the view vector, which the camera sees as lines.
//
// A slice is looked along both ways. Directions in it are told by their angle from the view
// vector v, counted towards `along`. Of the cosine-weighted hemisphere about n, the part
// that lies in the slices about an azimuth dphi is, with n' the projection of n into the
// slice and gamma its angle,
//   1 / pi * |n'| * integral of cos(theta - gamma) |sin theta| dtheta dphi
// (Jimenez, Wu, Pesce and Jarabo 2016).
#include "lib/angle.glsl"
#include "screen_space/march.glsl"
#include "screen_space/receiver.glsl"

struct Slice {
    vec3 along_vs;       // unit length, orthogonal to the view vector
    float normal_angle;  // gamma
    float normal_length; // |n'|
};

Slice slice_along(vec3 along_vs, vec3 view, vec3 normal_vs)
{
    vec2 projected = vec2(dot(normal_vs, along_vs), dot(normal_vs, view));
    float angle = angle_of(abs(projected.x), projected.y);
    return Slice(along_vs, projected.x < 0.0 ? -angle : angle, length(projected));
}

// Turn `i` of DIRECTION_COUNT about the view vector, in [0, 1): evenly spread at each pixel, and
// the sixteen pixels of a block, each with a set of its own, share out what lies between.
float slice_turn(Receiver r, int i)
{
    uint set = r.first_point / uint(DIRECTION_COUNT);
    float shift = float((u_pattern_offset.x + (set << 28)) >> 8) * (1.0 / 16777216.0);
    return (float(i) + shift) / float(DIRECTION_COUNT);
}

// The direction `turn` about the view vector.
vec3 slice_direction(vec3 view, float turn)
{
    mat3 axes = frame_from_z(view);
    return axes[0] * cos(turn) + axes[1] * sin(turn);
}

// How far along a slice the sphere of radius R about the receiver is seen.
float silhouette_reach(vec3 position_vs)
{
    float distance = length(position_vs);
    return min(silhouette_radius(distance, u_radius), FAR_REACH * distance);
}

// The way from a receiver along one side of a slice, in the picture. It starts a pixel away,
// as in the code of XeGTAO: what is nearer is the receiver's own texel.
struct Walk {
    Segment segment;
    float first;     // fraction of the segment
};

Walk walk_along(Origin o, vec3 along_vs)
{
    Segment g = segment_of(o, along_vs, silhouette_reach(o.position_vs));
    return Walk(g, min(inversesqrt(max(dot(g.across_px, g.across_px), 1.0)), 1.0));
}

// Number of a step, from 0 to 1, to fraction of the segment.
float walk_fraction(Walk k, float x)
{
    return mix(k.first, 1.0, march_fraction(x));
}

vec2 walk_px(Walk k, float fraction)
{
    return k.segment.start_px + fraction * k.segment.across_px;
}

// The integral of cos(t - gamma) sin(t) for t from 0 to theta.
float arc_integral(float theta, float gamma)
{
    return 0.25 * (cos(gamma) - cos(2.0 * theta - gamma) + 2.0 * theta * sin(gamma));
}

const float NO_ELEVATION = -2.0;

// Sine of the elevation of the surface at `texel` above the plane square to the view vector,
// if that surface can block: within R and above the tangent plane.
float elevation_sine(Tangent t, vec3 view, ivec2 texel)
{
    float z = gbuffer_z_vs(texel);
    vec3 to_q = position_vs_at(uv_of_texel(texel), z) - t.position_vs;
    float distance = length(to_q);
    bool blocks = z > 0.0 && distance <= u_radius && is_above(t, vec2(texel) + 0.5, z);
    return blocks ? dot(to_q, view) / distance : NO_ELEVATION;
}

// The largest `elevation_sine` that STEP_COUNT steps find on one side of a slice, at least `lowest`.
float highest_elevation(Tangent t, vec3 view, vec3 along, float jitter, float lowest)
{
    Walk walk = walk_along(t.origin, along);
    float stride = 1.0 / float(STEP_COUNT);
    float highest = lowest;
    int i = 0;
    do {
        float x = (float(i) + jitter) * stride;
        ivec2 texel = ivec2(walk_px(walk, walk_fraction(walk, x)));
        highest = max(highest, elevation_sine(t, view, texel));
    } while (++i < STEP_COUNT);
    return highest;
}

// The sample test of Ritschel, Grosch and Seidel 2009, "Approximating Dynamic Global
// Illumination in Image Space": one point per direction, at a random distance.
#include "screen_space/march.glsl"
#include "screen_space/occlusion.glsl"

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
    return radius < u_radius ? distance_in_frame(t.origin, w, FLOAT_MAX) : radius;
}

// The surface that hides the point `distance` along w from the receiver. Section 3: the
// point is back-projected into the picture and counts as occluded iff moving it onto the
// surface found there brings it towards the viewer.
//
// Departures from the paper: the texel is snapped to its centre and must lie above the
// tangent plane (see occlusion.glsl; as printed, the test shadows every tilted plane);
// points outside the frame and background are open, where the paper says nothing.
// `has_back` adds the end of the solid, which the paper's first-depth test lacks.
Blocker point_blocker(Tangent t, vec3 w, float distance, bool has_back)
{
    vec3 s_vs = t.position_vs + distance * w;
    float z_s = -s_vs.z;
    bool in_front = z_s > u_near_vs;
    vec2 uv = uv_of_position_vs(vec3(s_vs.xy, -max(z_s, u_near_vs)));
    ivec2 texel = texel_of_uv(uv);
    ivec2 last = ivec2(u_frame_size_px) - 1;
    bool in_frame = in_front && all(greaterThanEqual(uv, vec2(0.0))) && all(lessThan(uv, vec2(1.0)));
    texel = clamp(texel, ivec2(0), last);
    vec2 solid = solid_at(texel);
    bool blocked = in_frame && solid.x > 0.0 && z_s > solid.x && is_above(t, vec2(texel) + 0.5, solid.x)
        && (!has_back || z_s < solid_end(t, solid));
    if (blocked)
        return Blocker(texel, distance);
    return NO_BLOCKER;
}

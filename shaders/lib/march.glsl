// Looking for the first surface along a ray, in several steps across the picture.
//
// The step at fraction s of a projected segment lies at pixel p(s) = p0 + s (p1 - p0),
// and its nearness is linear in s too; that of a pinhole camera is the inverse depth:
// 1 / z(s) = 1 / z0 + s (1 / z1 - 1 / z0). So `z(s) > z_Q` is tested as z_Q / z(s) < 1,
// without a division per step.
//
// A step stands for the stretch of the ray around it: it counts as inside a solid also if
// the ray is in front of the solid, or behind it, but would not be a part of a stride
// earlier or later. Tested as points, few steps jump over whatever is thin. Slack at the
// back costs nothing on a wall, whose depths are without end; slack at the front darkens
// corners, where rays run close along a wall that they do not meet. RMSE of visibility
// over six scenes at R from .3 to 4, and the excess of a corner's occlusion of .43:
//   front, back slack in strides   0, 0          0, 1          1/4, 1        1/2, 1
//   4 steps                        .085, 0       .068, 0       .058, .036    .053, .068
//   8 steps                        .066, 0       .056, 0       .052, .021    .050, .032
#include "lib/occlusion.glsl"

uniform float u_step_growth;  // 0: steps of equal length, 1: lengths grow linearly
uniform float u_front_slack;  // strides
uniform float u_back_slack;   // strides

// Rays end this many pixels inside the frame's border, so that rounding cannot
// carry a step outside; what lies outside is open anyway.
const float BORDER_PX = 0.25;

// Distance along the unit vector w at which a ray from p_vs leaves the frame or passes
// the near plane. Beyond that, nothing is known, and unknown means open.
float distance_in_frame(vec3 p_vs, vec3 w)
{
    // In frame: |place.xy| <= e place.z. Each bound is linear along the ray:
    // gap + t * rate >= 0, so the ray leaves at gap / -rate if the gap shrinks.
    float z = -p_vs.z;
    float rate_z = -w.z;
    vec2 e = 1.0 - 2.0 * BORDER_PX / u_frame_size_px;
    vec3 place = frame_place(p_vs);
    vec3 change = frame_place_rate(w);
    vec4 gap = vec4(e * place.z - place.xy, e * place.z + place.xy);
    vec4 rate = vec4(e * change.z - change.xy, e * change.z + change.xy);
    float far = FAR_REACH * z;
    // Where the gap does not shrink the quotient is not used, whatever it is.
    vec4 leave = mix(vec4(far), gap / -rate, lessThan(rate, vec4(0.0)));
    float near = rate_z < 0.0 ? (z - u_near_vs) / -rate_z : far;
    return max(min(min(min(leave.x, leave.y), min(leave.z, leave.w)), min(near, far)), 0.0);
}

// Step number (0..1) to fraction of the segment: x for growth 0, x^2 for growth 1.
float march_fraction(float x)
{
    return x * mix(1.0, x, u_step_growth);
}

vec2 px_of_position_vs(vec3 p_vs)
{
    return uv_of_position_vs(p_vs) * u_frame_size_px;
}

// A ray, projected.
struct Segment {
    vec2 start_px;
    vec2 across_px;
    float nearness_0;
    float nearness_across;
    float length_vs;    // in space, clipped to the frame
};

Segment segment_of(vec3 p_vs, vec3 w, float reach)
{
    float clipped = min(reach, distance_in_frame(p_vs, w));
    vec3 end_vs = p_vs + clipped * w;
    vec2 start_px = px_of_position_vs(p_vs);
    float nearness_0 = nearness(-p_vs.z);
    return Segment(start_px, px_of_position_vs(end_vs) - start_px,
                   nearness_0, nearness(-end_vs.z) - nearness_0, clipped);
}

ivec2 texel_on(Segment g, float x)
{
    return ivec2(g.start_px + march_fraction(x) * g.across_px);
}

// Does the surface at `texel` block the ray around x? `slack`: to where in front of x, and
// behind it, the ray counts; see slack_of.
bool blocks_at(Tangent t, Segment g, ivec2 texel, float x, vec2 slack)
{
    vec2 solid = solid_at(texel);
    // Nearness goes one way along the ray, so that its bounds are at the ends.
    vec2 end = clamp(x + slack, 0.0, 1.0);
    float farthest = g.nearness_0 + march_fraction(end.x) * g.nearness_across;
    float nearest = g.nearness_0 + march_fraction(end.y) * g.nearness_across;
    // Asked for first and put together then: behind `&&` each call would be a branch.
    bool is_before = is_nearer(solid.x, farthest);
    bool is_behind = is_farther(solid_end(t, solid), nearest);
    bool rises = is_above(t, texel, solid.x);
    return solid.x > 0.0 && is_before && is_behind && rises;
}

// From x towards what is farthest from the camera, and towards what is nearest.
vec2 slack_of(Segment g, float stride)
{
    vec2 slack = vec2(u_front_slack, -u_back_slack) * stride;
    return g.nearness_across < 0.0 ? slack : -slack;
}

// The first surface that blocks the ray from the receiver along the unit vector w within
// `reach`. `jitter` in [0, 1) moves each step within its stratum, except for the last,
// which stands at the very end: a solid that begins anywhere before it and reaches that
// far is always found, so `count` decides how thin a thing may be and still be seen, not
// how much of a wall is lost (closed form A4 with survival 1, whatever `count` is).
//
// `refine_count` bisections between the step that was blocked and the one before bring
// the blocker found nearer to where the ray enters the solid. They do not change whether
// the ray is blocked, only which texel stands for the sender of a bounce.
Blocker march(Tangent t, vec3 w, float reach, float jitter, int count, int refine_count)
{
#if IS_OPEN
    return NO_BLOCKER;
#endif
    Segment g = segment_of(t.position_vs, w, reach);
    float stride = 1.0 / float(max(count - 1, 1));
    vec2 slack = slack_of(g, stride);
    float found = -1.0;
    ivec2 texel = ivec2(-1);
    // From the end, so that what is found first along the ray is what is found last, and nothing
    // breaks off: in software that costs more than the steps that it saves.
    int i = count;
    do {
        --i;
        float x = i < count - 1 ? (float(i) + jitter) * stride : 1.0;
        ivec2 place = texel_on(g, x);
        bool blocks = blocks_at(t, g, place, x, slack);
        found = blocks ? x : found;
        texel = blocks ? place : texel;
    } while (i > 0);
    if (found < 0.0)
        return NO_BLOCKER;
    for (int k = 0; k < refine_count; ++k) {
        stride *= 0.5;
        slack *= 0.5;
        float x = max(found - stride, 0.0);
        ivec2 nearer = texel_on(g, x);
        bool blocks = blocks_at(t, g, nearer, x, slack);
        found = blocks ? x : found;
        texel = blocks ? nearer : texel;
    }
    float s = march_fraction(found);
    return Blocker(texel, length_before(g.length_vs, s, g.nearness_0, g.nearness_across));
}

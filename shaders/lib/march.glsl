// Looking for the first surface along a ray, in several steps across the picture.
//
// The step at fraction s of a projected segment lies at pixel p(s) = p0 + s (p1 - p0),
// and its inverse depth is linear in s too: 1 / z(s) = 1 / z0 + s (1 / z1 - 1 / z0).
// So `z(s) > z_Q` is tested as z_Q / z(s) < 1, without a division per step.
//
// A step stands for the stretch of the ray around it: the surface at its texel blocks if
// the solid behind that surface, from z_Q to its back, overlaps the depths of the stretch.
// Tested as points instead, a few steps jump over whatever is thin: with 4 of them, over
// six scenes at R from .3 to 4, the error of visibility (RMSE) is .085 for points and .057
// for stretches of one stride; with 8, .066 and .051; stretches of 2 strides do no better.
#include "lib/occlusion.glsl"

uniform float u_step_growth;  // 0: steps of equal length, 1: lengths grow linearly
uniform float u_step_span;    // length of the stretch that a step stands for, in strides

// Rays end this many pixels inside the frame's border, so that rounding cannot
// carry a step outside; what lies outside is open anyway.
const float BORDER_PX = 0.25;

// Distance along the unit vector w at which a ray from p_vs leaves the frame or passes
// the near plane. Beyond that, nothing is known, and unknown means open.
float distance_in_frame(vec3 p_vs, vec3 w)
{
    // In frame: |x / tan - jitter z| <= e z with z = -p.z. Each bound is linear along the
    // ray: gap + t * rate >= 0, so the ray leaves at gap / -rate if the gap shrinks.
    float z = -p_vs.z;
    float rate_z = -w.z;
    vec2 e = 1.0 - 2.0 * BORDER_PX / u_frame_size_px;
    vec2 c = p_vs.xy / u_tan_half_fov - u_jitter_ndc * z;
    vec2 rate_c = w.xy / u_tan_half_fov - u_jitter_ndc * rate_z;
    vec4 gap = vec4(e * z - c, e * z + c);
    vec4 rate = vec4(e * rate_z - rate_c, e * rate_z + rate_c);
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

// The first surface that blocks the ray from the receiver along the unit vector w within
// `reach`. `jitter` in [0, 1) moves each step within its stratum, except for the last,
// which stands at the very end: a solid that begins anywhere before it and reaches that
// far is always found, so `count` decides how thin a thing may be and still be seen, not
// how much of a wall is lost (closed form A4 with survival 1, whatever `count` is).
Blocker march(Tangent t, vec3 w, float reach, float jitter, int count)
{
    float clipped = min(reach, distance_in_frame(t.position_vs, w));
    vec3 end_vs = t.position_vs + clipped * w;
    vec2 start_px = px_of_position_vs(t.position_vs);
    vec2 across_px = px_of_position_vs(end_vs) - start_px;
    float inv_z0 = -1.0 / t.position_vs.z;
    float inv_z1 = -1.0 / end_vs.z;
    float inv_z_across = inv_z1 - inv_z0;
    float stride = 1.0 / float(max(count - 1, 1));
    float half_span = 0.5 * u_step_span * stride;
    for (int i = 0; i < count; ++i) {
        float x = i < count - 1 ? (float(i) + jitter) * stride : 1.0;
        float s = march_fraction(x);
        ivec2 texel = ivec2(start_px + s * across_px);
        float z = gbuffer_z_vs(texel);
        float inv_z_from = inv_z0 + march_fraction(max(x - half_span, 0.0)) * inv_z_across;
        float inv_z_to = inv_z0 + march_fraction(min(x + half_span, 1.0)) * inv_z_across;
        if (z > 0.0 && z * min(inv_z_from, inv_z_to) < 1.0 && is_above(t, texel, z)
            && solid_end(t, texel, z) * max(inv_z_from, inv_z_to) > 1.0)
            // Perspective: the share s of the projected segment is this share of it in space.
            return Blocker(texel, clipped * s * inv_z1 / (inv_z0 + s * inv_z_across));
    }
    return NO_BLOCKER;
}

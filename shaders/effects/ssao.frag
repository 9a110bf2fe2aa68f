#version 330 core
// Ambient visibility: (1 / pi) * integral of V_R(w) cos(theta) dw, 1 = open.
//
// Defines: ESTIMATOR 0 march, 1 rgs09, 2 hemisphere, 3 zbuffer; DIRECTION_COUNT,
// STEP_COUNT (depth reads along each direction), HAS_BACK_LAYER, IS_OPEN (see
// lib/estimator.glsl); KEPT_TEXTURE_COUNT (see lib/kept_directions.glsl).
#include "lib/estimator.glsl"
#define TAKES_DIRECTIONS 0
#include "lib/kept_directions.glsl"

#define ESTIMATOR_ZBUFFER 3

uniform float u_box_px;  // zbuffer: half the width of the box, pixels

layout(location = 0) out vec2 o_visibility;  // x: visibility, y: z for the filter

#if ESTIMATOR == ESTIMATOR_ZBUFFER
// The image-space variant of the method's first report: random texels of a square around
// the pixel, blocked where they are nearer to the camera. It knows no radius in scene
// units, no hemisphere and no tangent plane: tilted planes darken themselves and the
// result changes with the resolution. Kept for comparison. Departure: the report's bias
// of 0.01 scene units is taken relative to z, so that at least scale does not matter.
const float ZBUFFER_BIAS = 0.01;

float visibility_of(Receiver r, ivec2 centre)
{
    int open_count = 0;
    for (int i = 0; i < DIRECTION_COUNT; ++i) {
        vec2 offset = (sample_point(r, i).xy * 2.0 - 1.0) * u_box_px;
        ivec2 texel = centre + ivec2(floor(offset + 0.5));
        ivec2 inside = clamp(texel, ivec2(0), ivec2(u_frame_size_px) - 1);
        float z = gbuffer_z_vs(inside);
        bool blocked = texel == inside && z > 0.0 && z < r.z_vs * (1.0 - ZBUFFER_BIAS);
        open_count += blocked ? 0 : 1;
    }
    return float(open_count) / float(DIRECTION_COUNT);
}
#else
float visibility_of(Receiver r, ivec2 centre)
{
    // What is blocked is taken from 1, so that an open hemisphere gives exactly 1 also for
    // directions whose shares add up to 1 only on average (rgs09).
    float blocked = 0.0;
    Tangent t = tangent_at(r.position_vs, r.geometric_vs);
    for (int i = 0; i < DIRECTION_COUNT; ++i) {
        Direction d = direction_of(r, i);
        Blocker b = blocker_of(t, d);
        blocked += is_blocked(b) ? d.share : 0.0;
#if KEPT_TEXTURE_COUNT > 0
        keep_direction(i, b);
#endif
    }
    return max(1.0 - blocked, 0.0);
}
#endif

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    Receiver r = receiver_at(pixel, DIRECTION_COUNT);
    float visibility = 1.0;
#if KEPT_TEXTURE_COUNT > 0
    keep_nothing();
#endif
    if (r.z_vs > 0.0 && !is_radius_under_a_pixel(r.z_vs))
        visibility = visibility_of(r, receiver_texel(pixel));
    o_visibility = vec2(visibility, r.z_vs);
#if KEPT_TEXTURE_COUNT > 0
    write_kept_directions();
#endif
}

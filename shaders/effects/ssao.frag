#version 330 core
// Ambient visibility: (1 / pi) * integral of V_R(w) cos(theta) dw, 1 = open.
//
// Defines: DIRECTION_COUNT, STEP_COUNT (depth reads along each direction), HAS_BACK_LAYER,
// IS_OPEN (see screen_space/estimator.glsl); KEPT_TEXTURE_COUNT (see screen_space/kept_directions.glsl).
#define GATHERS_SENDERS 0
uniform float u_box_px;  // zbuffer: half the width of the box, pixels

#include "screen_space/estimator.glsl"
#define TAKES_DIRECTIONS 0
#include "screen_space/kept_directions.glsl"

layout(location = 0) out vec2 o_visibility;  // x: visibility, y: z for the filter

float visibility_of(Receiver r, ivec2 centre)
{
#if FINDS_BLOCKERS
    // What is blocked is taken from 1, so that an open hemisphere gives exactly 1 also for
    // directions whose shares add up to 1 only on average (rgs09).
    float blocked = 0.0;
    Tangent t = tangent_at(r.position_vs, r.geometric_vs);
    int i = 0;
    do {
        Direction d[TOGETHER];
        Blocker b[TOGETHER];
        blockers_of(r, t, i, d, b);
        for (int k = 0; k < TOGETHER; ++k) {
            blocked += is_blocked(b[k]) ? d[k].share : 0.0;
#if KEPT_TEXTURE_COUNT > 0
            keep_direction(b[k]);
#endif
        }
    } while ((i += TOGETHER) < DIRECTION_COUNT);
    return max(1.0 - blocked, 0.0);
#else
    return estimator_visibility(r, centre);
#endif
}

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

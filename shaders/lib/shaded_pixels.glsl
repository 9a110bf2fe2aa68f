// Pixels that a neighbour in front may shade: one that lies within R above their tangent plane, and
// what it shows turns away. What its hidden side sends neither the depth buffer nor what is found
// beside tells.
#include "lib/gbuffer.glsl"

uniform float u_radius;

// In footprints of a pixel: more than rounding, less than what a thin lamp hangs below a ceiling.
const float LEAST_HEIGHT = 0.05;

bool shades(ivec2 other, vec3 p_vs, vec3 n_vs, float least)
{
    vec3 d = gbuffer_position_vs(other) - p_vs;
    return gbuffer_z_vs(other) > 0.0 && dot(d, n_vs) > least && length(d) < u_radius
        && dot(d, gbuffer_geometric_normal_vs(other)) > least;
}

bool may_be_shaded(ivec2 texel)
{
    vec3 p_vs = gbuffer_position_vs(texel);
    vec3 n_vs = gbuffer_geometric_normal_vs(texel);
    float least = LEAST_HEIGHT * pixel_height_at(-p_vs.z);
    ivec2 last = ivec2(u_frame_size_px) - 1;
    bool found = false;
    for (int i = 0; i < 9; ++i) {
        ivec2 other = clamp(texel + ivec2(i % 3, i / 3) - 1, ivec2(0), last);
        found = found || shades(other, p_vs, n_vs, least);
    }
    return found;
}

#version 330 core
// Which pixels neither the depth buffer nor probes can tell enough about.
// A neighbour in front may shade them: it lies within R above their tangent plane, and what it
// shows turns away. What its hidden side sends the depth buffer does not tell, and probes beside
// the edge are not shaded by it. Or they lie beside a wall where a tile reaches much farther
// along their surface than R: its probes stand too far from the wall to tell what comes from it.
#include "lib/gbuffer.glsl"

uniform float u_radius;

layout(location = 0) out float o_is_edge;

// In footprints of a pixel: more than rounding, less than what a thin lamp hangs below a ceiling.
const float LEAST_HEIGHT = 0.05;

// Where a tile of 8 pixels reaches farther than this many R. In 1 three times as many pixels of
// cornell_meso have rays, for no less error; 4 leaves those of a corridor out.
const float LEAST_REACH = 2.5;
// Beside a wall: it shows in one of these pixels.
const ivec2 AWAY[8] = ivec2[8](ivec2(2, 0), ivec2(-2, 0), ivec2(0, 2), ivec2(0, -2),
                               ivec2(5, 0), ivec2(-5, 0), ivec2(0, 5), ivec2(0, -5));

bool shades(ivec2 other, vec3 p_vs, vec3 n_vs, float least)
{
    vec3 d = gbuffer_position_vs(other) - p_vs;
    return gbuffer_z_vs(other) > 0.0 && dot(d, n_vs) > least && length(d) < u_radius
        && dot(d, gbuffer_geometric_normal_vs(other)) > least;
}

bool faces(ivec2 other, vec3 p_vs, vec3 n_vs, float least)
{
    vec3 d = gbuffer_position_vs(other) - p_vs;
    return gbuffer_z_vs(other) > 0.0 && dot(d, n_vs) > least
        && dot(d, gbuffer_geometric_normal_vs(other)) < -least;
}

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    bool is_edge = false;
    float z = gbuffer_z_vs(texel);
    if (z > 0.0) {
        vec3 p_vs = gbuffer_position_vs(texel);
        vec3 n_vs = gbuffer_geometric_normal_vs(texel);
        float least = LEAST_HEIGHT * pixel_height_at(z);
        ivec2 last = ivec2(u_frame_size_px) - 1;
        for (int i = 0; i < 9; ++i) {
            ivec2 other = clamp(texel + ivec2(i % 3, i / 3) - 1, ivec2(0), last);
            is_edge = is_edge || shades(other, p_vs, n_vs, least);
        }
        // Of a pixel, along the surface.
        float along = pixel_height_at(z) / max(dot(toward_camera(p_vs), n_vs), 1e-6);
        bool is_coarse = 8.0 * along > LEAST_REACH * u_radius;
        for (int i = 0; i < 8 && is_coarse && !is_edge; ++i)
            is_edge = faces(clamp(texel + AWAY[i], ivec2(0), last), p_vs, n_vs, least);
    }
    o_is_edge = is_edge ? 1.0 : 0.0;
}

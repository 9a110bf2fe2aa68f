#version 330 core
// How many rays of its own a pixel has: none, the usual number, or more where a neighbour in
// front may shade it: one that lies within R above its tangent plane, and what it shows turns
// away. What its hidden side sends neither the depth buffer nor what is found beside tells.
#include "lib/gbuffer.glsl"

uniform float u_radius;
uniform int u_receiver_stride;  // pixels from one that light is gathered at to the next

layout(location = 0) out float o_class;

// As ssdo_gl/effects/own_rays.py reads them.
const float NONE = 0.0;
const float USUAL = 0.5;
const float EDGE = 1.0;
// In footprints of a pixel: more than rounding, less than what a thin lamp hangs below a ceiling.
const float LEAST_HEIGHT = 0.05;

bool shades(ivec2 other, vec3 p_vs, vec3 n_vs, float least)
{
    vec3 d = gbuffer_position_vs(other) - p_vs;
    return gbuffer_z_vs(other) > 0.0 && dot(d, n_vs) > least && length(d) < u_radius
        && dot(d, gbuffer_geometric_normal_vs(other)) > least;
}

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    float z = gbuffer_z_vs(texel);
    o_class = NONE;
    if (z > 0.0 && texel % u_receiver_stride == ivec2(0)) {
        vec3 p_vs = gbuffer_position_vs(texel);
        vec3 n_vs = gbuffer_geometric_normal_vs(texel);
        float least = LEAST_HEIGHT * pixel_height_at(z);
        ivec2 last = ivec2(u_frame_size_px) - 1;
        bool is_edge = false;
        for (int i = 0; i < 9; ++i) {
            ivec2 other = clamp(texel + ivec2(i % 3, i / 3) - 1, ivec2(0), last);
            is_edge = is_edge || shades(other, p_vs, n_vs, least);
        }
        o_class = is_edge ? EDGE : USUAL;
    }
}

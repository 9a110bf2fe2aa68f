#version 330 core
// Guided sampling: how often per-pixel rays follow each direction of the probes.
//
// Defines: PROBE_SIDE (see lib/far_probes.glsl).
#include "lib/probe_cells.glsl"

uniform sampler2D t_far_radiance;
uniform float u_sky;  // mean radiance of the environment

// Relative density, mean radiance; share of the sky that is open.
layout(location = 0) out vec4 o_guide;

// What a cell counts beside its neighbours.
const float OWN_WEIGHT = 4.0;

float light_at(ivec2 texel)
{
    vec4 far = texelFetch(t_far_radiance, texel, 0);
    return dot(far.rgb, vec3(1.0 / 3.0)) + (1.0 - far.a) * u_sky;
}

// The root of the mean square: what is seen a few pixels away, or beside a cell's middle, differs,
// and rays that come upon light which was thought improbable are bright dots.
void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    ProbeCell c = probe_cell(texel);
    o_guide = vec4(0.0);
    if (c.point.w == 0.0)
        return;
    vec3 n_vs = oct_unproject(probe_square(c.point.w));
    float own = light_at(texel);
    vec3 sums = OWN_WEIGHT * vec3(1.0, own, own * own);
    for (int i = 0; i < 34; ++i) {
        bool turns = i < 9;
        ivec2 step = turns ? ivec2(i % 3, i / 3) - 1 : ivec2((i - 9) % 5, (i - 9) / 5) - 2;
        ivec2 other = cell_beside(c, n_vs, step, turns);
        float light = other.x >= 0 ? light_at(other) : 0.0;
        sums += other.x >= 0 ? vec3(1.0, light, light * light) : vec3(0.0);
    }
    float open = 1.0 - texelFetch(t_far_radiance, texel, 0).a;
    o_guide = vec4(sqrt(sums.z / sums.x), sums.y / sums.x, open, 0.0);
}

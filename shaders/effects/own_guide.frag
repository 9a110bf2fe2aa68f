#version 330 core
// Guided sampling: how often per-pixel rays follow each direction of the probes.
//
// Defines: PROBE_SIDE (see lib/far_probes.glsl).
#include "lib/probe_cells.glsl"

uniform sampler2D t_far_radiance;
uniform float u_sky;  // mean radiance of the environment

// Relative density, mean radiance; share of the sky that is open, there and in the mean.
layout(location = 0) out vec4 o_guide;

// What a cell counts beside its neighbours.
const float OWN_WEIGHT = 4.0;

// Radiance, its square and the share of the sky that is open; 1.
vec4 light_at(ivec2 texel)
{
    vec4 far = texelFetch(t_far_radiance, texel, 0);
    float light = dot(far.rgb, vec3(1.0 / 3.0)) + (1.0 - far.a) * u_sky;
    return vec4(light, light * light, 1.0 - far.a, 1.0);
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
    vec4 own = light_at(texel);
    vec4 sums = OWN_WEIGHT * own;
    for (int i = 0; i < 34; ++i) {
        bool turns = i < 9;
        ivec2 step = turns ? ivec2(i % 3, i / 3) - 1 : ivec2((i - 9) % 5, (i - 9) / 5) - 2;
        ivec2 other = cell_beside(c, n_vs, step, turns);
        sums += other.x >= 0 ? light_at(other) : vec4(0.0);
    }
    sums /= sums.w;
    o_guide = vec4(sqrt(sums.y), sums.x, own.z, sums.z);
}

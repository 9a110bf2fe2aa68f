#version 330 core
// Guided sampling: how often per-pixel rays follow each direction of the probes.
//
// Defines: PROBE_SIDE (see lib/far_probes.glsl); ENVIRONMENT_KIND (see lib/environment.glsl).
#include "lib/environment.glsl"
#include "lib/probe_cells.glsl"

uniform sampler2D t_far_radiance;
uniform float u_sky;  // mean radiance of the environment

// Relative density, mean radiance; share of the sky that is open, there and in the mean.
layout(location = 0) out vec4 o_guide;

// What a cell counts beside its neighbours.
const float OWN_WEIGHT = 4.0;

// Points of the sky that are asked along each edge of two cells.
const int SKY_POINTS = 5;

// Radiance of the sky in and beside a cell, the root of its mean square; in all directions the mean,
// where no image has its light in a few.
float sky_at(ProbeCell c, vec3 n_vs)
{
#if ENVIRONMENT_KIND == 3
    mat3 frame = u_world_from_view * frame_from_z(n_vs);
    float squares = 0.0;
    for (int i = 0; i < SKY_POINTS * SKY_POINTS; ++i) {
        vec2 step = vec2(i % SKY_POINTS, i / SKY_POINTS) * (2.0 / float(SKY_POINTS - 1)) - 0.5;
        vec2 place = clamp((vec2(c.cell) + step) / float(PROBE_SIDE), 0.0, 1.0);
        float light = dot(environment_radiance(frame * probe_direction(place)), vec3(1.0 / 3.0));
        squares += light * light;
    }
    return sqrt(squares / float(SKY_POINTS * SKY_POINTS));
#else
    return u_sky;
#endif
}

// Radiance, the square of what rays follow, and the share of the sky that is open; 1.
vec4 light_at(ivec2 texel, float sky)
{
    vec4 far = texelFetch(t_far_radiance, texel, 0);
    float sent = dot(far.rgb, vec3(1.0 / 3.0));
    float open = 1.0 - far.a;
    float followed = sent + open * sky;
    return vec4(sent + open * u_sky, followed * followed, open, 1.0);
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
    float sky = sky_at(c, n_vs);
    vec4 own = light_at(texel, sky);
    vec4 sums = OWN_WEIGHT * own;
    for (int i = 0; i < 34; ++i) {
        bool turns = i < 9;
        ivec2 step = turns ? ivec2(i % 3, i / 3) - 1 : ivec2((i - 9) % 5, (i - 9) / 5) - 2;
        ivec2 other = cell_beside(c, n_vs, step, turns);
        sums += other.x >= 0 ? light_at(other, sky) : vec4(0.0);
    }
    sums /= sums.w;
    o_guide = vec4(sqrt(sums.y), sums.x, own.z, sums.z);
}

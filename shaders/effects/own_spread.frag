#version 330 core
// Averages the rare light of per-pixel rays over tiles around, for each of a tile's two probes; a:
// the variance of one ray's light over its squared mean.
//
// Defines: PROBE_TILE, PROBE_SIDE (see lib/far_probes.glsl).
#include "rays/guide.glsl"

uniform sampler2D t_rare_first;   // as effects/own_rare.frag writes them
uniform sampler2D t_rare_second;
uniform sampler2D t_light_first;
uniform sampler2D t_light_second;

layout(location = 0) out vec4 o_first;
layout(location = 1) out vec4 o_second;

// Tiles to either side.
const int REACH = 2;

vec4 spread(vec4 receiver, ivec2 tile)
{
    if (receiver.w == 0.0)
        return vec4(0.0);
    vec3 n_vs = oct_unproject(probe_square(receiver.w));
    float inv_extent = 1.0 / (float(PROBE_TILE) * pixel_height_at(-receiver.z));
    ivec2 low = max(tile - REACH, ivec2(0));
    ivec2 high = min(tile + REACH, textureSize(t_far_first_probes, 0) - 1);
    vec4 sum = vec4(0.0);
    vec2 light = vec2(0.0);
    for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) {
            ivec2 other = ivec2(x, y);
            vec4 point = texelFetch(t_far_first_probes, other, 0);
            float weight = on_surface(point, receiver.xyz, n_vs, inv_extent);
            sum += weight * texelFetch(t_rare_first, other, 0);
            light += weight * texelFetch(t_light_first, other, 0).rg;
            point = texelFetch(t_far_second_probes, other, 0);
            weight = on_surface(point, receiver.xyz, n_vs, inv_extent);
            sum += weight * texelFetch(t_rare_second, other, 0);
            light += weight * texelFetch(t_light_second, other, 0).rg;
        }
    }
    float mean = max(sum.a, 1e-6);
    return vec4(sum.rgb / mean, mean * light.y / max(light.x * light.x, 1e-30));
}

void main()
{
    ivec2 tile = ivec2(gl_FragCoord.xy);
    o_first = spread(texelFetch(t_far_first_probes, tile, 0), tile);
    o_second = spread(texelFetch(t_far_second_probes, tile, 0), tile);
}

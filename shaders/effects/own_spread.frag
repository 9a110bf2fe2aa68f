#version 330 core
// Averages the rare light of per-pixel rays over tiles around, for each probe; a: the variance of one
// ray's light over its squared mean.
//
// Defines: PROBE_TILE, PROBE_SIDE (see lib/far_probes.glsl).
#include "rays/guide.glsl"

uniform sampler2D t_rare;   // as effects/own_rare.frag writes them
uniform sampler2D t_light;

layout(location = 0) out vec4 o_about;

// Tiles to either side.
const int REACH = 2;

void main()
{
    ivec2 probe = ivec2(gl_FragCoord.xy);
    vec4 receiver = texelFetch(t_far_probe_points, probe, 0);
    o_about = vec4(0.0);
    if (receiver.w == 0.0)
        return;
    vec3 n_vs = oct_unproject(probe_square(receiver.w));
    float inv_extent = 1.0 / (float(PROBE_TILE) * pixel_height_at(-receiver.z));
    ivec2 tiles = probe_tiles();
    ivec2 tile = ivec2(probe.x, probe.y % tiles.y);
    ivec2 low = max(tile - REACH, ivec2(0));
    ivec2 high = min(tile + REACH, tiles - 1);
    vec4 sum = vec4(0.0);
    vec2 light = vec2(0.0);
    for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) {
            for (int second = 0; second < 2; ++second) {
                ivec2 other = ivec2(x, y + second * tiles.y);
                vec4 point = texelFetch(t_far_probe_points, other, 0);
                float weight = on_surface(point, receiver.xyz, n_vs, inv_extent);
                sum += weight * texelFetch(t_rare, other, 0);
                light += weight * texelFetch(t_light, other, 0).rg;
            }
        }
    }
    float mean = max(sum.a, 1e-6);
    o_about = vec4(sum.rgb / mean, mean * light.y / max(light.x * light.x, 1e-30));
}

#version 330 core
// Sums the rare light of per-pixel rays by tile and surface; a: of how many pixels. And what tells
// how uneven their light is.
//
// Defines: PROBE_TILE: see lib/far_probes.glsl.
uniform isampler2D t_own_places;  // as lib/own_rays.glsl says
uniform sampler2D t_own_rare;    // as effects/own_rays.frag writes them
uniform sampler2D t_own_light;

layout(location = 0) out vec4 o_first;
layout(location = 1) out vec4 o_second;
layout(location = 2) out vec2 o_first_light;
layout(location = 3) out vec2 o_second_light;

void main()
{
    ivec2 low = ivec2(gl_FragCoord.xy) * PROBE_TILE;
    ivec2 high = min(low + PROBE_TILE, textureSize(t_own_places, 0));
    int columns = textureSize(t_own_rare, 0).x;
    o_first = vec4(0.0);
    o_second = vec4(0.0);
    o_first_light = vec2(0.0);
    o_second_light = vec2(0.0);
    for (int y = low.y; y < high.y; ++y) {
        for (int x = low.x; x < high.x; ++x) {
            int number = abs(texelFetch(t_own_places, ivec2(x, y), 0).x) - 1;
            if (number < 0)
                continue;
            ivec2 place = ivec2(number % columns, number / columns);
            vec4 rare = texelFetch(t_own_rare, place, 0);
            vec2 light = texelFetch(t_own_light, place, 0).rg;
            o_first_light += rare.a == 1.0 ? light : vec2(0.0);
            o_second_light += rare.a == 2.0 ? light : vec2(0.0);
            o_first += rare.a == 1.0 ? vec4(rare.rgb, 1.0) : vec4(0.0);
            o_second += rare.a == 2.0 ? vec4(rare.rgb, 1.0) : vec4(0.0);
        }
    }
}

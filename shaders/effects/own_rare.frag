#version 330 core
// Sums by probe, of the pixels of its tile that lie on its surface, their rare light, a: how many they
// are, and what tells how uneven their light is.
//
// Defines: PROBE_TILE: see lib/far_probes.glsl.
uniform isampler2D t_own_places;  // as rays/shared_rays.glsl says
uniform sampler2D t_own_rare;    // as effects/own_rays.frag writes them
uniform sampler2D t_own_light;
uniform int u_tile_rows;         // from a tile's first probe up to its second

layout(location = 0) out vec4 o_rare;
layout(location = 1) out vec2 o_light;

void main()
{
    ivec2 tile = ivec2(gl_FragCoord.xy);
    float owner = tile.y < u_tile_rows ? 1.0 : 2.0;
    ivec2 low = ivec2(tile.x, tile.y % u_tile_rows) * PROBE_TILE;
    ivec2 high = min(low + PROBE_TILE, textureSize(t_own_places, 0));
    int columns = textureSize(t_own_rare, 0).x;
    o_rare = vec4(0.0);
    o_light = vec2(0.0);
    for (int y = low.y; y < high.y; ++y) {
        for (int x = low.x; x < high.x; ++x) {
            int number = abs(texelFetch(t_own_places, ivec2(x, y), 0).x) - 1;
            if (number < 0)
                continue;
            ivec2 place = ivec2(number % columns, number / columns);
            vec4 rare = texelFetch(t_own_rare, place, 0);
            bool counts = rare.a == owner;
            o_rare += counts ? vec4(rare.rgb, 1.0) : vec4(0.0);
            o_light += counts ? texelFetch(t_own_light, place, 0).rg : vec2(0.0);
        }
    }
}

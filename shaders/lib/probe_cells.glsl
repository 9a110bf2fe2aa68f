// Which probe and direction a texel of the image of radiance stands for, and who stands beside.
//
// Defines: PROBE_SIDE (see lib/far_probes.glsl).
#include "lib/far_probes.glsl"

// Normals whose cosine is less than this have other directions in the same cell.
const float SAME_DIRECTIONS = 0.9;

// Position and code of the first or second probe of a tile.
vec4 probe_at(ivec2 tile, bool is_second)
{
    return is_second ? texelFetch(t_far_second_probes, tile, 0)
                     : texelFetch(t_far_first_probes, tile, 0);
}

struct ProbeCell {
    ivec2 probe;
    ivec2 tile;
    ivec2 cell;
    vec4 point;  // position and code of the probe; w = 0: there is none
};

ProbeCell probe_cell(ivec2 texel)
{
    ivec2 tiles = textureSize(t_far_first_probes, 0);
    ivec2 quarter = texel / probe_quarter_size(tiles);
    ivec2 place = texel - quarter * probe_quarter_size(tiles);
    ProbeCell c;
    c.probe = 2 * (place / PROBE_SIDE) + quarter;
    c.cell = place % PROBE_SIDE;
    bool is_second = c.probe.y >= second_probe_rows(tiles);
    c.tile = c.probe - ivec2(0, is_second ? second_probe_rows(tiles) : 0);
    c.point = all(lessThan(c.tile, tiles)) ? probe_at(c.tile, is_second) : vec4(0.0);
    return c;
}

// The probe of a tile that has the same directions, or -1.
ivec2 probe_like(ivec2 tile, ivec2 tiles, vec3 n_vs)
{
    for (int i = 0; i < 2; ++i) {
        float code = probe_at(tile, i == 1).w;
        if (code != 0.0 && dot(oct_unproject(probe_square(code)), n_vs) > SAME_DIRECTIONS)
            return tile + ivec2(0, i * second_probe_rows(tiles));
    }
    return ivec2(-1);
}

// The texel of a neighbour of the cell: one of the directions about it, or the same one at a tile
// about; -1: there is none.
ivec2 cell_beside(ProbeCell c, vec3 n_vs, ivec2 step, bool turns)
{
    ivec2 tiles = textureSize(t_far_first_probes, 0);
    ivec2 other = (turns ? c.cell : c.tile) + step;
    ivec2 size = turns ? ivec2(PROBE_SIDE) : tiles;
    bool exists = all(greaterThanEqual(other, ivec2(0))) && all(lessThan(other, size));
    ivec2 probe = exists && !turns ? probe_like(other, tiles, n_vs) : c.probe;
    return exists && probe.x >= 0 ? probe_texel(probe, tiles) + (turns ? other : c.cell) : ivec2(-1);
}

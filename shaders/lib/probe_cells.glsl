// Which probe and direction a texel of the image of radiance stands for, and who stands beside.
//
// Defines: PROBE_SIDE (see lib/far_probes.glsl).
#include "lib/far_probes.glsl"

// Normals whose cosine is less than this have other directions in the same cell.
const float SAME_DIRECTIONS = 0.9;

struct ProbeCell {
    ivec2 probe;
    ivec2 cell;
    vec4 point;  // position and code of the probe; w = 0: there is none
};

ProbeCell probe_cell(ivec2 texel)
{
    ProbeCell c;
    c.probe = texel / PROBE_SIDE;
    c.cell = texel % PROBE_SIDE;
    c.point = texelFetch(t_far_probe_points, c.probe, 0);
    return c;
}

// The probe of a tile that has the same directions, or -1.
ivec2 probe_like(ivec2 tile, vec3 n_vs)
{
    for (int i = 0; i < 2; ++i) {
        float code = probe_point(tile, i).w;
        if (code != 0.0 && dot(oct_unproject(probe_square(code)), n_vs) > SAME_DIRECTIONS)
            return tile + ivec2(0, i * probe_tiles().y);
    }
    return ivec2(-1);
}

// The texel of a neighbour of the cell: one of the directions about it, or the same one at a tile
// about; -1: there is none.
ivec2 cell_beside(ProbeCell c, vec3 n_vs, ivec2 step, bool turns)
{
    ivec2 tiles = probe_tiles();
    ivec2 tile = ivec2(c.probe.x, c.probe.y % tiles.y);
    ivec2 other = (turns ? c.cell : tile) + step;
    ivec2 size = turns ? ivec2(PROBE_SIDE) : tiles;
    bool exists = all(greaterThanEqual(other, ivec2(0))) && all(lessThan(other, size));
    ivec2 probe = exists && !turns ? probe_like(other, n_vs) : c.probe;
    return exists && probe.x >= 0 ? probe_texel(probe) + (turns ? other : c.cell) : ivec2(-1);
}

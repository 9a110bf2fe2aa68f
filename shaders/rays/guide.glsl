// Guided sampling by the radiance of the nearest probe and those around: three quarters by
// that in the probe's cells, the others uniformly over the cosine-weighted hemisphere (a defensive
// mixture: Owen, Zhou 2000), so that none counts more than four times.
//
// Defines: PROBE_TILE, PROBE_SIDE (see lib/far_probes.glsl).
#include "lib/gbuffer.glsl"
#include "lib/far_probes.glsl"

// r: relative density, g: mean radiance, b: share of open sky, a: the mean of that
uniform sampler2D t_own_guide;
uniform float u_sky;  // mean radiance of the environment

const float GUIDED = 0.75;
// Probes whose normals have a smaller cosine tell nothing: their cells are other directions.
const float LEAST_AGREEMENT = 0.8;
const float GUIDE_CELL = 1.0 / float(PROBE_SIDE * PROBE_SIDE);

struct Guide {
    ivec2 first;    // texel of the probe's first cell
    float scale;    // from the density of a cell to its share of the guided directions; 0: none are
    float open;     // share of the sky that the probe sees
    float sent;     // mean radiance of surfaces that probes about have found; negative: none is known
    float seen;     // mean share of the sky that they see
    float rows[PROBE_SIDE];  // shares of the directions
};

// A direction in the frame of the normal, and what to multiply with what arrives along it.
struct Guided {
    vec3 w;
    float weight;
};

// How much a probe lies on the surface at p_vs, in units of 1 / inv_extent; 0: it tells nothing.
float on_surface(vec4 point, vec3 p_vs, vec3 n_vs, float inv_extent)
{
    float height = dot(point.xyz - p_vs, n_vs) * inv_extent;
    float facing = point.w != 0.0 ? dot(oct_unproject(probe_square(point.w)), n_vs) : 0.0;
    return facing > LEAST_AGREEMENT ? facing / (1.0 + height * height) : 0.0;
}

const float NO_PROBE = 0.0;
// Neither: that which lies on the pixel's plane stands beyond a partition, where there is less light.
const float IN_MORE_LIGHT = 3.0;

// Which probe of the pixel's tile lies on its surface: 1 the first, 2 the second, or NO_PROBE.
float probe_of_tile(ivec2 texel, vec3 p_vs, vec3 n_vs)
{
    ivec2 tile = texel / PROBE_TILE;
    float inv_extent = 1.0 / (float(PROBE_TILE) * pixel_height_at(-p_vs.z));
    float first = on_surface(probe_point(tile, 0), p_vs, n_vs, inv_extent);
    float second = on_surface(probe_point(tile, 1), p_vs, n_vs, inv_extent);
    return max(first, second) == 0.0 ? NO_PROBE : first >= second ? 1.0 : 2.0;
}

// The probe of the four tiles around the pixel that lies most on the same surface, or -1.
ivec2 probe_beside(ivec2 texel, vec3 p_vs, vec3 n_vs)
{
    ivec2 found = ivec2(-1);
    float best = 0.0;
    float inv_extent = 1.0 / (float(PROBE_TILE) * pixel_height_at(-p_vs.z));
    ivec2 low = (2 * texel + 1 - PROBE_TILE) / (2 * PROBE_TILE);
    ivec2 tiles = probe_tiles();
    for (int i = 0; i < 8; ++i) {
        ivec2 tile = min(low + ivec2(i & 1, i >> 1 & 1), tiles - 1);
        vec4 point = probe_point(tile, i >> 2);
        vec2 apart = vec2(tile * PROBE_TILE - texel) / float(PROBE_TILE) + 0.5;
        float fit = on_surface(point, p_vs, n_vs, inv_extent) / (1.0 + 0.1 * dot(apart, apart));
        if (fit > best) {
            best = fit;
            found = tile + ivec2(0, (i >> 2) * tiles.y);
        }
    }
    return found;
}

Guide guide_at(ivec2 texel, vec3 p_vs, vec3 n_vs)
{
    ivec2 probe = probe_beside(texel, p_vs, n_vs);
    Guide g;
    g.first = probe_texel(max(probe, ivec2(0)));
    g.open = 0.0;
    g.seen = 0.0;
    float sum = 0.0;
    float mean = 0.0;
    for (int y = 0; y < PROBE_SIDE; ++y) {
        g.rows[y] = 0.0;
        for (int x = 0; x < PROBE_SIDE; ++x) {
            vec4 cell = texelFetch(t_own_guide, g.first + ivec2(x, y), 0);
            g.rows[y] += cell.x;
            mean += cell.y;
            g.open += GUIDE_CELL * cell.z;
            g.seen += GUIDE_CELL * cell.w;
        }
        sum += g.rows[y];
    }
    bool is_known = probe.x >= 0 && sum > 0.0;
    g.open = is_known ? g.open : 0.0;
    g.scale = is_known ? GUIDED / sum : 0.0;
    g.sent = is_known ? max(GUIDE_CELL * mean - g.seen * u_sky, 0.0) : -1.0;
    float even = (is_known ? 1.0 - GUIDED : 1.0) / float(PROBE_SIDE);
    for (int y = 0; y < PROBE_SIDE; ++y)
        g.rows[y] = even + g.scale * g.rows[y];
    return g;
}

// By a point of the unit square, which is warped so that nearby points stay together.
Guided guided_direction(Guide g, vec2 u)
{
    ivec2 cell = ivec2(0);
    // The last ones take what rounding leaves.
    while (cell.y < PROBE_SIDE - 1 && u.y >= g.rows[cell.y])
        u.y -= g.rows[cell.y++];
    float row = g.rows[cell.y];
    u.x *= row;
    float even = (g.scale > 0.0 ? 1.0 - GUIDED : 1.0) * GUIDE_CELL;
    float share = even + g.scale * texelFetch(t_own_guide, g.first + cell, 0).x;
    while (cell.x < PROBE_SIDE - 1 && u.x >= share) {
        u.x -= share;
        ++cell.x;
        share = even + g.scale * texelFetch(t_own_guide, g.first + cell, 0).x;
    }
    vec2 within = clamp(u / vec2(share, row), 0.0, 1.0 - FLOAT_EPSILON);
    return Guided(probe_direction((vec2(cell) + within) / float(PROBE_SIDE)), GUIDE_CELL / share);
}

// How many times as often as spread by the cosine the direction w, in the frame of the normal, is drawn.
float guided_share(Guide g, vec3 w)
{
    ivec2 cell = ivec2(probe_place(w) * float(PROBE_SIDE));
    float even = g.scale > 0.0 ? 1.0 - GUIDED : 1.0;
    return even + g.scale / GUIDE_CELL * texelFetch(t_own_guide, g.first + cell, 0).x;
}

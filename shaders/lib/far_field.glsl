// Looks up what arrives at a receiver from beyond R: in the probes of the tiles around it.
//
// HAS_FAR_FIELD: 0 leaves it out; PROBE_TILE, PROBE_SIDE: see lib/far_probes.glsl.
#include "lib/far_probes.glsl"

// The probes that may speak for a receiver: of four tiles the first ones, then the second.
struct FarProbes {
    ivec2 tile;        // lower left of the four
    int tile_rows;     // second probes lie so many rows higher
    vec4 first;        // weights, added up
    vec4 second;
};

#if HAS_FAR_FIELD
// Sums over rays: rgb; a: how many of them have met a surface, not the sky.
uniform sampler2D t_far_radiance;
uniform vec4 u_inv_ray_counts;  // of each quarter; 0 where nothing is known yet

// Never 0: where no probe lies on the receiver's surface, the likeliest is better than none.
const float LEAST_WEIGHT = 1e-4;

float probe_weight(Receiver r, ivec2 probe, float inv_extent)
{
    vec4 point = texelFetch(t_far_probe_points, probe, 0);
    vec3 normal = texelFetch(t_far_probe_normals, probe, 0).xyz;
    float height = dot(point.xyz - r.position_vs, r.geometric_vs) * inv_extent;
    float plane = 1.0 / (1.0 + height * height);
    float agree = max(dot(normal, r.normal_vs), 0.0);
    agree *= agree;
    agree *= agree;
    bool is_known = u_inv_ray_counts[(probe.x & 1) + 2 * (probe.y & 1)] > 0.0;
    return (is_known ? point.w : 0.0) * max(plane * plane * agree * agree, LEAST_WEIGHT);
}

FarProbes far_probes_at(Receiver r, ivec2 texel)
{
    ivec2 frame = ivec2(u_frame_size_px);
    ivec2 tiles = (frame + PROBE_TILE - 1) / PROBE_TILE;
    // The pixels of a block look up to a tile apart: more probes, whose noise the filter
    // averages. relMSE of a cellar under a grating .0203, .0164, .0170 for 0, 1, 2 tiles, of an
    // attic with a window .0045, .0041, .0066.
    uint set = set_of_pixel(texel / u_receiver_stride);
    vec2 jitter = (vec2(set & 3u, set >> 2) - 1.5) * 0.25;
    // Where a quarter of the probes is known they stand twice as far apart.
    vec4 known = u_inv_ray_counts;
    jitter *= min(min(known.x, known.y), min(known.z, known.w)) > 0.0 ? 1.0 : 2.0;
    vec2 place = (vec2(texel) + 0.5) / float(PROBE_TILE) - 0.5 + jitter;
    // Inside, so that of the four tiles each is in another quarter.
    vec2 low = clamp(floor(place), vec2(0.0), vec2(max(tiles - 2, ivec2(0))));
    vec2 f = clamp(place - low, 0.0, 1.0);
    vec4 bilinear = vec4((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y);
    float inv_extent = 4.0 / (float(PROBE_TILE) * pixel_height_at(r.z_vs));
    FarProbes probes = FarProbes(ivec2(low), tiles.y, vec4(0.0), vec4(0.0));
    float sum = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 tile = clamp(probes.tile + ivec2(i & 1, i >> 1), ivec2(0), tiles - 1);
        sum += (bilinear[i] + 1e-3) * probe_weight(r, tile, inv_extent);
        probes.first[i] = sum;
    }
    for (int i = 0; i < 4; ++i) {
        ivec2 tile = clamp(probes.tile + ivec2(i & 1, i >> 1), ivec2(0), tiles - 1);
        tile.y += tiles.y;
        sum += (bilinear[i] + 1e-3) * probe_weight(r, tile, inv_extent);
        probes.second[i] = sum;
    }
    return probes;
}

// Radiance of surfaces along w_vs, a: the share of it that is no sky, by one of the probes,
// drawn by weight with u in [0, 1).
vec4 far_radiance(FarProbes probes, vec3 w_vs, float u)
{
    float chosen = u * probes.second.w;
    bool is_second = chosen >= probes.first.w;
    vec4 sums = is_second ? probes.second : probes.first;
    bvec3 past = greaterThanEqual(vec3(chosen), sums.xyz);
    int corner = int(past.x) + int(past.y) + int(past.z);
    ivec2 tiles = (ivec2(u_frame_size_px) + PROBE_TILE - 1) / PROBE_TILE;
    ivec2 probe = clamp(probes.tile + ivec2(corner & 1, corner >> 1), ivec2(0), tiles - 1);
    probe.y += is_second ? tiles.y : 0;
    vec3 normal = texelFetch(t_far_probe_normals, probe, 0).xyz;
    vec2 place = probe_place(w_vs * frame_from_z(normal));
    ivec2 cell = ivec2(place * float(PROBE_SIDE));
    float scale = u_inv_ray_counts[(probe.x & 1) + 2 * (probe.y & 1)];
    return scale * texelFetch(t_far_radiance, probe_texel(probe, ivec2(tiles.x, 2 * tiles.y)) + cell, 0);
}
#else
FarProbes far_probes_at(Receiver r, ivec2 texel)
{
    return FarProbes(texel, 0, vec4(0.0), vec4(0.0));
}
#endif

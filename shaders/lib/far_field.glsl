// Looks up radiance from beyond R at a receiver, in the probes of the tiles around it.
//
// HAS_FAR_FIELD: 0 leaves it out; PROBE_TILE, PROBE_SIDE: see lib/far_probes.glsl.
#include "lib/far_probes.glsl"

// A probe that speaks for a receiver: where its radiance begins, and its frame.
struct FarProbe {
    ivec2 texel;
    mat3 frame;
};

// Each for every fourth direction.
struct FarProbes {
    FarProbe a;
    FarProbe b;
    FarProbe c;
    FarProbe d;
};

#if HAS_FAR_FIELD
uniform sampler2D t_far_radiance;  // a: 1 where a surface sends it, 0 where the sky is

// Never 0: where no probe lies on the receiver's surface, the likeliest is better than none.
const float LEAST_WEIGHT = 1e-4;

// Four of the probes looked at so far, drawn by weight.
struct Drawn {
    vec4 columns;
    vec4 rows;
    vec4 codes;
    float sum;     // of weights
    vec4 u;        // in [0, 1), for those to come
};

void consider(inout Drawn drawn, Receiver r, vec4 point, ivec2 probe, float share, float inv_extent)
{
    float height = dot(point.xyz - r.position_vs, r.geometric_vs) * inv_extent;
    float plane = 1.0 / (1.0 + height * height);
    vec3 normal = oct_unfold(probe_square(point.w));
    float facing = max(dot(normal, r.normal_vs), 0.0);
    float agree = facing * facing / dot(normal, normal);
    agree *= agree;
    float weight = share * max(plane * plane * agree * agree, LEAST_WEIGHT);
    weight = point.w != 0.0 ? weight : 0.0;
    drawn.sum += weight;
    float part = weight > 0.0 ? weight / drawn.sum : 0.0;
    bvec4 is_taken = lessThan(drawn.u, vec4(part));
    drawn.u = mix((drawn.u - part) / (1.0 - part), drawn.u / part, is_taken);
    drawn.columns = mix(drawn.columns, vec4(probe.x), is_taken);
    drawn.rows = mix(drawn.rows, vec4(probe.y), is_taken);
    drawn.codes = mix(drawn.codes, vec4(point.w), is_taken);
}

FarProbe far_probe(Drawn drawn, int i)
{
    ivec2 probe = ivec2(drawn.columns[i], drawn.rows[i]);
    return FarProbe(probe_texel(probe), frame_from_z(oct_unproject(probe_square(drawn.codes[i]))));
}

// Four of the probes of the four tiles around the receiver, or any where nobody reads them.
FarProbes far_probes_at(Receiver r, ivec2 texel, bool are_read)
{
    ivec2 frame = ivec2(u_frame_size_px);
    ivec2 last = (frame + PROBE_TILE - 1) / PROBE_TILE - 1;
    // The pixels of a block look up to a tile apart: more probes, whose noise the filter
    // averages. relMSE of a cellar under a grating .0203, .0164, .0170 for 0, 1, 2 tiles, of an
    // attic with a window .0045, .0041, .0066.
    uint set = set_of_pixel(texel / u_receiver_stride);
    vec2 jitter = (vec2(set & 3u, set >> 2) - 1.5) * 0.25;
    vec2 place = (vec2(texel) + 0.5) / float(PROBE_TILE) - 0.5 + jitter;
    ivec2 low = ivec2(clamp(floor(place), vec2(0.0), vec2(max(last - 1, ivec2(0)))));
    vec2 f = clamp(place - vec2(low), 0.0, 1.0);
    float inv_extent = 4.0 / (float(PROBE_TILE) * pixel_height_at(r.z_vs));
    float u = sample_point(r, 0).z;
    Drawn drawn = Drawn(vec4(low.x), vec4(low.y), vec4(probe_code(vec3(0.0, 0.0, 1.0))), 0.0,
                        fract(u + vec4(0.0, 0.618034, 0.236068, 0.854102)));
    // Loops that are tested at their end: in software those alone skip what is left.
    bool has_second = false;
    int i = 0;
    do {
        ivec2 corner = ivec2(i & 1, i >> 1);
        vec2 near = mix(1.0 - f, f, vec2(corner));
        ivec2 tile = min(low + corner, last);
        vec4 point = probe_point(tile, 0);
        has_second = has_second || point.w < 0.0;
        consider(drawn, r, point, tile, near.x * near.y + 1e-3, inv_extent);
    } while (are_read && ++i < 4);
    do {
        ivec2 corner = ivec2(i & 1, i >> 1 & 1);
        vec2 near = mix(1.0 - f, f, vec2(corner));
        ivec2 tile = min(low + corner, last);
        ivec2 probe = tile + ivec2(0, probe_tiles().y);
        consider(drawn, r, probe_point(tile, 1), probe, near.x * near.y + 1e-3, inv_extent);
    } while (++i < (are_read && has_second ? 8 : 4));
    return FarProbes(far_probe(drawn, 0), far_probe(drawn, 1), far_probe(drawn, 2), far_probe(drawn, 3));
}

// Radiance of surfaces along w_vs, the direction number i, a: the share of it that is no sky.
vec4 far_radiance(FarProbes probes, vec3 w_vs, int i)
{
    FarProbe probe = probes.a;
    if ((i & 3) == 1)
        probe = probes.b;
    if ((i & 3) == 2)
        probe = probes.c;
    if ((i & 3) == 3)
        probe = probes.d;
    ivec2 cell = ivec2(probe_place(w_vs * probe.frame) * float(PROBE_SIDE));
    return texelFetch(t_far_radiance, probe.texel + cell, 0);
}
#else
FarProbes far_probes_at(Receiver r, ivec2 texel, bool are_read)
{
    FarProbe probe = FarProbe(texel, mat3(0.0));
    return FarProbes(probe, probe, probe, probe);
}
#endif

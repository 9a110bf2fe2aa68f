#version 330 core
// The far field at probes: what arrives along each direction from beyond R.
//
// Defines: PROBE_SIDE (see lib/far_probes.glsl); NEAR_HITS: rays tell of surfaces
// within R: 0 never, 1 where the depth buffer does not show them, 2 always; REFINES: 0 one ray
// for each direction, 1 further ones where these differ; as in rays/surface_data.glsl.
#include "rays/surface_cache.glsl"
#include "lib/random.glsl"
#include "lib/far_probes.glsl"

uniform float u_radius_ns;
uniform sampler2D t_cached_irradiance;
#if REFINES
uniform sampler2D t_far_first;    // of one ray for each direction
uniform float u_sky;              // mean radiance of the environment
uniform float u_rays_per_deviation;
uniform int u_most_rays;
#endif

layout(location = 0) out vec4 o_radiance;  // a: 1 where a surface sends it, 0 where the sky is

// Whether the depth buffer shows the surface point, so that it can tell what it blocks.
bool is_seen(vec3 p_ns, float slack_px)
{
    vec3 p_vs = ((p_ns - u_eye_ns) / u_ns_per_unit) * u_ns_from_vs;
    if (p_vs.z >= 0.0)
        return false;
    vec2 uv = uv_of_position_vs(p_vs);
    ivec2 texel = texel_of_uv(uv);
    if (any(lessThan(uv, vec2(0.0))) || any(greaterThanEqual(uv, vec2(1.0))))
        return false;
    float z = gbuffer_z_vs(texel);
    return z == 0.0 || -p_vs.z < z + slack_px * pixel_height_at(z);
}

vec4 traced(vec3 start, vec3 w)
{
    float from = NEAR_HITS > 0 ? 0.0 : u_radius_ns;
    BvhHit hit;
    for (int turn = 0; turn < 2; ++turn) {
        hit = bvh_nearest(start + from * w, w, RAY_FAR);
        bool again = NEAR_HITS == 1 && turn == 0 && hit.record >= 0 && hit.t < u_radius_ns
                  && is_seen(start + hit.t * w, 2.0)
                  && is_seen(start + u_radius_ns * w, 0.0);
        if (!again)
            break;
        from = u_radius_ns;
    }
    if (hit.record < 0)
        return vec4(0.0);
    Surface met = surface_at_hit(hit, start + from * w, w);
    bool is_lamp = (met.flags & LIGHT_BODY_FLAG) != 0u;
    return vec4(cached_reflection(hit, met, w) + (is_lamp ? vec3(0.0) : met.emission), 1.0);
}

// Position and code of the first or second probe of a tile.
vec4 probe_at(ivec2 tile, bool is_second)
{
    return is_second ? texelFetch(t_far_second_probes, tile, 0)
                     : texelFetch(t_far_first_probes, tile, 0);
}

#if REFINES
// Normals whose cosine is less than this have other directions in the same cell.
const float SAME_DIRECTIONS = 0.9;

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

// How many rays a direction is worth: in proportion to the deviation of its neighbours, four
// directions about and the same one of sixteen tiles about, over the light that arrives. Not of
// its own ray: to trace on where that has met light, and not where it has missed it, darkens.
int rays_worth(ivec2 tile, ivec2 probe, ivec2 cell, ivec2 tiles, vec3 p_vs, vec3 n_vs)
{
    vec3 sums = vec3(0.0);
    for (int i = 0; i < 20; ++i) {
        bool turns = i < 4;
        ivec2 along = (i & 1) == 0 ? ivec2(1, 0) : ivec2(0, 1);
        // Of eight places around, those nearby and those twice as far away.
        int place = i & 7;
        place += place < 4 ? 0 : 1;
        ivec2 around = (i < 12 ? 1 : 2) * (ivec2(place % 3, place / 3) - 1);
        ivec2 other = turns ? cell + (i < 2 ? along : -along) : tile + around;
        ivec2 size = turns ? ivec2(PROBE_SIDE) : tiles;
        bool counts = all(greaterThanEqual(other, ivec2(0))) && all(lessThan(other, size));
        ivec2 of = counts && !turns ? probe_like(other, tiles, n_vs) : probe;
        if (counts && of.x >= 0) {
            vec4 far = texelFetch(t_far_first, probe_texel(of, tiles) + (turns ? other : cell), 0);
            float x = dot(far.rgb, vec3(1.0 / 3.0)) + (1.0 - far.a) * u_sky;
            sums += vec3(1.0, x, x * x);
        }
    }
    sums.yz /= max(sums.x, 1.0);
    float deviation = sqrt(max(sums.z - sums.y * sums.y, 0.0));
    ivec2 pixel = texel_of_uv(uv_of_position_vs(p_vs));
    float arriving = dot(texelFetch(t_cached_irradiance, pixel, 0).rgb, vec3(INV_PI / 3.0));
    float worth = u_rays_per_deviation * deviation / max(arriving, 1e-30);
    return int(clamp(worth, 1.0, float(u_most_rays)));
}
#endif

void main()
{
    ivec2 place_px = ivec2(gl_FragCoord.xy);
    ivec2 tiles = textureSize(t_far_first_probes, 0);
    ivec2 quarter_size = probe_quarter_size(tiles);
    ivec2 quarter = place_px / quarter_size;
    place_px -= quarter * quarter_size;
    ivec2 probe = 2 * (place_px / PROBE_SIDE) + quarter;
    ivec2 cell = place_px % PROBE_SIDE;
    bool is_second = probe.y >= second_probe_rows(tiles);
    ivec2 tile = probe - ivec2(0, is_second ? second_probe_rows(tiles) : 0);
    vec4 point = vec4(0.0);
    if (all(lessThan(tile, tiles)))
        point = probe_at(tile, is_second);
    vec4 sum = vec4(0.0);
    int count = 1;
    if (point.w != 0.0) {
        vec3 n_vs = oct_unproject(probe_square(point.w));
#if REFINES
        sum = texelFetch(t_far_first, ivec2(gl_FragCoord.xy), 0);
        count = rays_worth(tile, probe, cell, tiles, point.xyz, n_vs);
#endif
        vec3 n = u_ns_from_vs * n_vs;
        mat3 frame = frame_from_z(n_vs);
        uint seed = pixel_seed(probe * PROBE_SIDE + cell);
        vec3 to_point = u_ns_from_vs * (point.xyz * u_ns_per_unit);
        vec3 p = u_eye_ns + to_point;
        vec3 start = ray_start(p, n, viewing_direction(to_point, u_ns_from_vs * AHEAD_VS),
                               GBUFFER_ERROR * length(to_point) + RAY_OFFSET);
        for (int i = REFINES; i < count; ++i) {
            vec2 u = random_2d(uint(i), seed, 0u, false);
            vec2 place = (vec2(cell) + u) / float(PROBE_SIDE);
            sum += traced(start, u_ns_from_vs * (frame * probe_direction(place)));
        }
    }
    o_radiance = sum / float(count);
}

#version 330 core
// The far field at probes: what arrives along each direction from beyond R.
//
// Defines: PROBE_SIDE (see lib/far_probes.glsl); NEAR_HITS: rays tell of surfaces
// within R: 0 never, 1 where the depth buffer does not show them, 2 always; as in
// rays/surface_data.glsl and lib/environment.glsl.
#include "rays/surface_cache.glsl"
#include "lib/random.glsl"
#include "lib/far_probes.glsl"

uniform float u_radius_ns;

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

void main()
{
    ivec2 place_px = ivec2(gl_FragCoord.xy);
    ivec2 probes = textureSize(t_far_probe_points, 0);
    ivec2 quarter_size = probe_quarter_size(probes);
    ivec2 quarter = place_px / quarter_size;
    place_px -= quarter * quarter_size;
    ivec2 probe = 2 * (place_px / PROBE_SIDE) + quarter;
    ivec2 cell = place_px % PROBE_SIDE;
    vec4 point = vec4(0.0);
    if (all(lessThan(probe, probes)))
        point = texelFetch(t_far_probe_points, probe, 0);
    vec3 radiance = vec3(0.0);
    float surface = 0.0;
    if (point.w > 0.0) {
        vec3 n_vs = texelFetch(t_far_probe_normals, probe, 0).xyz;
        vec3 n = u_ns_from_vs * n_vs;
        uint seed = pixel_seed(probe * PROBE_SIDE + cell);
        vec2 u = random_2d(0u, seed, 0u, false);
        vec2 place = (vec2(cell) + u) / float(PROBE_SIDE);
        vec3 w = u_ns_from_vs * (frame_from_z(n_vs) * probe_direction(place));
        vec3 to_point = u_ns_from_vs * (point.xyz * u_ns_per_unit);
        vec3 p = u_eye_ns + to_point;
        vec3 start = ray_start(p, n, viewing_direction(to_point, u_ns_from_vs * AHEAD_VS),
                               GBUFFER_ERROR * length(to_point) + RAY_OFFSET);
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
        if (hit.record >= 0) {
            Surface met = surface_at_hit(hit, start + from * w, w);
            bool is_lamp = (met.flags & LIGHT_BODY_FLAG) != 0u;
            radiance = cached_reflection(hit, met, w) + (is_lamp ? vec3(0.0) : met.emission);
        }
        surface = hit.record >= 0 ? 1.0 : 0.0;
    }
    o_radiance = vec4(radiance, surface);
}

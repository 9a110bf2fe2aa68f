#version 330 core
// The far field at probes: incident radiance from beyond R, by direction.
//
// Of surfaces within R rays tell where the depth buffer does not show them.
//
// Defines: PROBE_SIDE (see lib/far_probes.glsl); as in rays/surface_data.glsl.
#include "rays/surface_cache.glsl"
#include "lib/random.glsl"
#include "lib/probe_cells.glsl"

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

vec4 traced(vec3 start, vec3 w)
{
    float from = 0.0;
    BvhHit hit;
    for (int turn = 0; turn < 2; ++turn) {
        hit = bvh_nearest(start + from * w, w, RAY_FAR);
        bool again = turn == 0 && hit.record >= 0 && hit.t < u_radius_ns
                  && is_seen(start + hit.t * w, 2.0)
                  && is_seen(start + u_radius_ns * w, 0.0);
        if (!again)
            break;
        from = u_radius_ns;
    }
    if (hit.record < 0)
        return vec4(0.0);
    Surface met = surface_at_hit(hit, start + from * w, w);
    bool is_lamp = counts_as_direct(met.flags, met.mean_emission);
    return vec4(cached_reflection(hit, met, w) + (is_lamp ? vec3(0.0) : met.emission), 1.0);
}

void main()
{
    ProbeCell c = probe_cell(ivec2(gl_FragCoord.xy));
    o_radiance = vec4(0.0);
    if (c.point.w == 0.0)
        return;
    vec3 n_vs = oct_unproject(probe_square(c.point.w));
    vec2 u = random_2d(0u, pixel_seed(c.probe * PROBE_SIDE + c.cell), 0u, false);
    vec3 w_vs = frame_from_z(n_vs) * probe_direction((vec2(c.cell) + u) / float(PROBE_SIDE));
    o_radiance = traced(ray_start_vs(c.point.xyz, n_vs), u_ns_from_vs * w_vs);
}

#version 330 core
// The far field at probes: what arrives along each direction from beyond R.
//
// Defines: PROBE_TILE, PROBE_SIDE (see lib/far_probes.glsl); NEAR_HITS: rays tell of surfaces
// within R: 0 never, 1 where the depth buffer does not show them, 2 always; as in
// rays/surface_data.glsl and lib/environment.glsl.
#include "rays/emitters.glsl"
#include "lib/random.glsl"
#include "lib/far_probes.glsl"

uniform float u_radius_ns;

layout(location = 0) out vec4 o_radiance;

const uint DIMENSION_DIRECTION = 0u;
const uint DIMENSION_SKY = 1u;
const uint DIMENSION_LIGHTS = 2u;

// What arrives at a surface from lights and sky, one sample of each.
vec3 sampled_irradiance(RaySurface surface, uint index, uint seed)
{
    vec3 irradiance = vec3(0.0);
    for (int g = 0; g <= u_emitter_group_count; ++g) {
        bool is_sky = g == u_emitter_group_count;
        EmitterGroup group = emitter_group(max(min(g, u_emitter_group_count - 1), 0));
        uint dimension = DIMENSION_LIGHTS + 2u * uint(g);
        vec2 u = random_2d(index, seed, is_sky ? DIMENSION_SKY : dimension, false);
        LightSample light = NO_LIGHT;
        vec3 arriving = vec3(0.0);
        float reach = -1.0;
        if (is_sky) {
            light.w = ray_direction(surface, frame_from_z(surface.normal), u);
            arriving = PI * environment_radiance(light.w);
            reach = is_dark(arriving) ? -1.0 : RAY_FAR;
        } else if (group.is_direct) {
            vec2 choice = random_2d(index, seed, dimension + 1u, false);
            light = sample_group(group, choice, u, surface.start);
            arriving = unblocked_irradiance(surface, light);
            reach = needed_reach(group, light, arriving, RAY_FAR);
        }
        irradiance += light_is_blocked(surface, light.w, reach) ? vec3(0.0) : arriving;
    }
    return irradiance;
}

// Whether the depth buffer shows the surface point, so that it can tell what it blocks.
bool is_seen(vec3 p_ns, float slack)
{
    vec3 p_vs = ((p_ns - u_eye_ns) / u_ns_per_unit) * u_ns_from_vs;
    if (p_vs.z >= 0.0)
        return false;
    vec2 uv = uv_of_position_vs(p_vs);
    ivec2 texel = texel_of_uv(uv);
    if (any(lessThan(uv, vec2(0.0))) || any(greaterThanEqual(uv, vec2(1.0))))
        return false;
    float z = gbuffer_z_vs(texel);
    return z == 0.0 || -p_vs.z < z * (1.0 + slack);
}

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    ivec2 probe = texel / PROBE_SIDE;
    vec4 point = texelFetch(t_far_probe_points, probe, 0);
    vec3 radiance = vec3(0.0);
    if (point.w > 0.0) {
        vec3 n = u_ns_from_vs * texelFetch(t_far_probe_normals, probe, 0).xyz;
        uint seed = pixel_seed(texel);
        vec2 u = random_2d(u_first_sample, seed, DIMENSION_DIRECTION, false);
        vec2 place = (vec2(texel - probe * PROBE_SIDE) + u) / float(PROBE_SIDE);
        vec3 w = frame_from_z(n) * probe_direction(place);
        vec3 to_point = u_ns_from_vs * (point.xyz * u_ns_per_unit);
        float distance = length(to_point);
        vec3 p = u_eye_ns + to_point;
        vec3 start = ray_start(p, n, to_point / max(distance, 1e-30),
                               GBUFFER_ERROR * distance + RAY_OFFSET);
        float from = NEAR_HITS > 0 ? 0.0 : u_radius_ns;
        // Twice what a pixel covers.
        float slack = 4.0 * u_tan_half_fov.y / u_frame_size_px.y;
        BvhHit hit;
        for (int turn = 0; turn < 2; ++turn) {
            hit = bvh_nearest(start + from * w, w, RAY_FAR);
            bool again = NEAR_HITS == 1 && turn == 0 && hit.record >= 0 && hit.t < u_radius_ns
                      && is_seen(start + hit.t * w, slack)
                      && is_seen(start + u_radius_ns * w, 0.0);
            if (!again)
                break;
            from = u_radius_ns;
        }
        if (hit.record >= 0) {
            Surface met = surface_at_hit(hit, start + from * w, w);
            bool is_lamp = (met.flags & LIGHT_BODY_FLAG) != 0u;
            radiance = diffuse_radiance(met.brdf, sampled_irradiance(met.at, u_first_sample, seed));
            radiance += is_lamp ? vec3(0.0) : met.emission;
        } else {
            radiance = environment_radiance(w);
        }
    }
    o_radiance = vec4(radiance, 1.0);
}

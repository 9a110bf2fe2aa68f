// Radiance along per-pixel rays, and the points of a sequence that they are drawn from.
//
// Needs rays/surface_cache.glsl, lib/gbuffer.glsl, lib/environment.glsl and lib/random.glsl.
#include "lib/z_curve.glsl"

uniform float u_radius_ns;

// Sums over rays.
struct Arriving {
    vec3 far;
    vec3 near;
    float open_sky;
    float blocked_sky;
};

// Where the rays of the surface point `p_vs` start, normalised.
vec3 own_rays_start(vec3 p_vs, vec3 geometric_vs)
{
    vec3 to_point = u_ns_from_vs * (p_vs * u_ns_per_unit);
    return ray_start(u_eye_ns + to_point, u_ns_from_vs * geometric_vs,
                     viewing_direction(to_point, u_ns_from_vs * AHEAD_VS),
                     GBUFFER_ERROR * length(to_point) + RAY_OFFSET);
}

// Along w_vs, or mirrored to above the facet of a smooth shape, as SSDO does.
void add_ray(inout Arriving sums, vec3 start, vec3 w_vs, vec3 geometric_vs, float weight)
{
    w_vs -= 2.0 * min(dot(w_vs, geometric_vs), 0.0) * geometric_vs;
    vec3 w = u_ns_from_vs * w_vs;
    float sky = weight * dot(environment_radiance(direction_ws_of(w_vs)), vec3(1.0));
    BvhHit hit = bvh_nearest(start, w, RAY_FAR);
    if (hit.record < 0) {
        sums.open_sky += sky;
        return;
    }
    sums.blocked_sky += sky;
    Surface met = surface_at_hit(hit, start, w);
    bool is_lamp = counts_as_direct(met.flags, met.mean_emission);
    vec3 sent = cached_reflection(hit, met, w) + (is_lamp ? vec3(0.0) : met.emission);
    bool is_near = hit.t < u_radius_ns;
    sums.near += is_near ? weight * sent : vec3(0.0);
    sums.far += is_near ? vec3(0.0) : weight * sent;
}

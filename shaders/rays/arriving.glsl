// Radiance along per-pixel rays, and the points of a sequence that they are drawn from.
//
// Needs rays/surface_cache.glsl, lib/gbuffer.glsl, lib/environment.glsl and lib/random.glsl.
// BRIGHT_PIECES: 0 or 1: rays are aimed at bright pieces, too.
#include "lib/z_curve.glsl"
#include "rays/bright_pieces.glsl"

uniform float u_radius_ns;

// Sums over rays.
struct Arriving {
    vec3 far;
    vec3 near;
    float open_sky;
    float blocked_sky;
};

// Along w_vs, or mirrored to above the facet of a smooth shape, as SSDO does; `at` is where ray_start_vs
// and the shading normal say. With bright pieces it is one of `ray_count`, drawn 1 / `weight` times as
// often as by the cosine, and of what other rays are aimed at it brings its part alone.
void add_ray(inout Arriving sums, LitPoint at, vec3 w_vs, vec3 geometric_vs, float weight, int ray_count)
{
    w_vs -= 2.0 * min(dot(w_vs, geometric_vs), 0.0) * geometric_vs;
    vec3 w = u_ns_from_vs * w_vs;
    float sky = weight * dot(environment_radiance(direction_ws_of(w_vs)), vec3(1.0));
    BvhHit hit = bvh_nearest(at.p, w, RAY_FAR);
    if (hit.record < 0) {
        sums.open_sky += sky;
        return;
    }
    sums.blocked_sky += sky;
    Surface met = surface_at_hit(hit, at.p, w);
    bool is_lamp = counts_as_direct(met.flags, met.mean_emission);
    ivec2 surfel = surfel_met(hit, met, w);
    vec3 sent = reflection_of(cached_light(surfel), surfel, met);
#if BRIGHT_PIECES
    float found = float(ray_count) * max(dot(w, at.normal), 0.0) * INV_PI / max(weight, 1e-30);
    sent *= share_of_found(at, w, surfel, found);
#endif
    sent += is_lamp ? vec3(0.0) : met.emission;
    bool is_near = hit.t < u_radius_ns;
    sums.near += is_near ? weight * sent : vec3(0.0);
    sums.far += is_near ? vec3(0.0) : weight * sent;
}

#if BRIGHT_PIECES
// What a ray aimed at a bright piece brings, towards which others go with that density over solid angle,
// all together.
void add_aimed_ray(inout Arriving sums, LitPoint at, AimedRay ray, vec3 geometric, float found)
{
    float cosine = dot(ray.w, at.normal);
    if (!(ray.density > 0.0 && cosine > 0.0 && dot(ray.w, geometric) > 0.0))
        return;
    BvhHit hit = bvh_nearest(at.p, ray.w, RAY_FAR);
    if (hit.record < 0)
        return;
    Surface met = surface_at_hit(hit, at.p, ray.w);
    ivec2 surfel = surfel_met(hit, met, ray.w);
    if (surfel != ray.surfel)
        return;
    float weight = cosine * INV_PI * ray.weight * share_of_aimed(ray, found);
    vec3 sent = weight * reflection_of(cached_light(surfel), surfel, met);
    bool is_near = hit.t < u_radius_ns;
    sums.near += is_near ? sent : vec3(0.0);
    sums.far += is_near ? vec3(0.0) : sent;
}
#endif

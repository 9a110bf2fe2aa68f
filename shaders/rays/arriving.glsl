// Radiance along per-pixel rays, and the points of a sequence that they are drawn from.
//
// Needs rays/surface_cache.glsl, lib/gbuffer.glsl, lib/environment.glsl and lib/random.glsl.
uniform float u_radius_ns;

// Sums over rays.
struct Arriving {
    vec3 far;
    vec3 near;
    float open_sky;
    float blocked_sky;
};

// Leaves room for another bit after each of the lower sixteen.
uint spread_bits(uint x)
{
    x = (x | x << 8) & 0x00ff00ffu;
    x = (x | x << 4) & 0x0f0f0f0fu;
    x = (x | x << 2) & 0x33333333u;
    return (x | x << 1) & 0x55555555u;
}

// Pixels take their points from one sequence in the order of their Z-curve, so that those of every
// block are spread evenly, which the filter averages (Ahmed, Wonka 2020). Without the order
// relMSE is .0033 for .0018 in an attic, .0129 for .0098 in a cellar (four rays, not guided).
uint first_point(ivec2 texel, int ray_count)
{
    return (spread_bits(uint(texel.x)) | spread_bits(uint(texel.y)) << 1) * uint(ray_count);
}

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
    bool is_lamp = (met.flags & LIGHT_BODY_FLAG) != 0u;
    vec3 sent = cached_reflection(hit, met, w) + (is_lamp ? vec3(0.0) : met.emission);
    bool is_near = hit.t < u_radius_ns;
    sums.near += is_near ? weight * sent : vec3(0.0);
    sums.far += is_near ? vec3(0.0) : weight * sent;
}

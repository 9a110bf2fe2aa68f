// What the picture does not show, by a ray: what it meets, in the light of the surface cache.
#include "rays/surface_cache.glsl"

bool meets_beyond_screen(vec3 p_vs, vec3 geometric_vs, vec3 w_vs, out vec3 radiance)
{
    vec3 to_point = u_ns_from_vs * (p_vs * u_ns_per_unit);
    vec3 n = u_ns_from_vs * geometric_vs;
    vec3 w = u_ns_from_vs * w_vs;
    vec3 viewing = viewing_direction(to_point, u_ns_from_vs * AHEAD_VS);
    vec3 start = ray_start(u_eye_ns + to_point, n, viewing,
                           GBUFFER_ERROR * length(to_point) + RAY_OFFSET);
    BvhHit hit = bvh_nearest(start, w, RAY_FAR);
    radiance = vec3(0.0);
    if (hit.record < 0)
        return false;
    Surface met = surface_at_hit(hit, start, w);
    // Lamps are reflected as lights.
    bool is_lamp = (met.flags & LIGHT_BODY_FLAG) != 0u;
    radiance = cached_reflection(hit, met, w) + (is_lamp ? vec3(0.0) : met.emission);
    return true;
}

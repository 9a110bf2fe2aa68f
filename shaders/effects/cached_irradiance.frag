#version 330 core
// What the surface cache holds for the surfaces in view: a short ray finds them again.
// Defines: as in rays/surface_data.glsl.
#include "rays/surface_cache.glsl"

layout(location = 0) out vec4 o_irradiance;

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    vec3 irradiance = vec3(0.0);
    float z = gbuffer_z_vs(texel);
    if (z > 0.0) {
        vec3 to_surface = u_ns_from_vs * (gbuffer_position_vs(texel) * u_ns_per_unit);
        float distance = length(to_surface);
        vec3 w = viewing_direction(to_surface, u_ns_from_vs * AHEAD_VS);
        // Twice what rays allow for to leave a surface: here they may meet any near it.
        float reach = 2.0 * (GBUFFER_ERROR * distance + RAY_OFFSET);
        vec3 start = u_eye_ns + to_surface - w * reach;
        BvhHit hit = bvh_nearest(start, w, 2.0 * reach);
        if (hit.record >= 0)
            irradiance = cached_light(surfel_met(hit, surface_at_hit(hit, start, w), w)).rgb;
    }
    o_irradiance = vec4(irradiance, 1.0);
}

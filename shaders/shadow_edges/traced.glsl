// Where texels of a shadow map disagree: what a ray to a light without a size finds.
#include "rays/ray.glsl"

vec2 shadow_edge(Light light, ivec2 pixel, bool is_edge, vec2 visibility)
{
    if (is_edge) {
        RaySurface surface = ray_surface_at(pixel);
#if LIGHT_FORM == FORM_PARALLEL
        vec3 w = u_ns_from_vs * light.place_vs;
        float reach = RAY_FAR;
#else
        vec3 to_light = u_eye_ns + u_ns_from_vs * (light.place_vs * u_ns_per_unit) - surface.start;
        float size = max(length(to_light), 1e-15);
        vec3 w = to_light / size;
        float reach = reach_toward_light(size);
#endif
        visibility = vec2(light_is_blocked(surface, w, reach) ? 0.0 : 1.0);
    }
    return visibility;
}

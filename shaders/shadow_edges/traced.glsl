// Where texels of a shadow map disagree: what a ray to parallel light finds.
#include "rays/ray.glsl"

vec2 shadow_edge(Light light, ivec2 pixel, bool is_edge, vec2 visibility)
{
    if (is_edge) {
        vec3 w = u_ns_from_vs * light.place_vs;
        visibility = vec2(light_is_blocked(ray_surface_at(pixel), w, RAY_FAR) ? 0.0 : 1.0);
    }
    return visibility;
}

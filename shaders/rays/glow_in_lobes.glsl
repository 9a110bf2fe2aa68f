// What lobes reflect of glowing bodies: by shadow rays to points of them, and by rays of the lobe
// that meet them. Both count, weighted against each other by the balance heuristic (Veach 1997):
// rays of a narrow lobe find its image, points chosen from a tree find small bodies in a wide one.
//
// SAMPLE_COUNT: rays of the lobe. GLOW_IS_DIRECT 0: there are none.
#include "rays/glow_that_is_met.glsl"
#include "lib/z_curve.glsl"

#if GLOW_IS_DIRECT
uniform int u_glow_rays;

LitPoint lit_point_of_lobe(vec3 p, ivec2 texel)
{
    vec3 normal = u_ns_from_vs * gbuffer_shading_normal_vs(texel);
    vec3 w_out = u_ns_from_vs * toward_camera(gbuffer_position_vs(texel));
    vec3 mirrored = 2.0 * cosine_out(normal, w_out) * normal - w_out;
    return LitPoint(p, normal, w_out, normalize(mirrored), alpha_of(brdf_at(texel).roughness));
}

// Mean radiance that the lobe of a pixel takes in from points of glowing bodies. `is_met`: rays of
// the lobe meet them, too.
vec3 glow_in_lobe(ivec2 texel, Brdf brdf, bool is_met)
{
    RaySurface surface = ray_surface_at(texel);
    LitPoint r = lit_point_of_lobe(surface.start, texel);
    vec3 whole = layer_reflectance(brdf, cosine_out(r.normal, r.w_out));
    uint first = first_point(texel, u_glow_rays);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < u_glow_rays; ++i) {
        vec2 choice = random_2d(first + uint(i), u_stream, 2u, false);
        vec2 u = random_2d(first + uint(i), u_stream, 3u, false);
        LightSample light = sample_tree(r, choice, u);
        float found = gloss_density(brdf, r.normal, r.w_out, light.w) * float(SAMPLE_COUNT);
        float chosen = light.density * float(u_glow_rays);
        float share = is_met ? chosen / max(chosen + found, 1e-30) : 1.0;
        vec3 response = gloss_times_cosine(brdf, r.normal, r.w_out, light.w) * share;
        vec3 reflected = unblocked_light(surface, light, response);
        float reach = is_dark(reflected) ? -1.0 : reach_toward_light(light.distance);
        sum += light_is_blocked(surface, light.w, reach) ? vec3(0.0) : reflected;
    }
    return sum / max(whole, vec3(1e-4)) / float(max(u_glow_rays, 1));
}
#else
vec3 glow_in_lobe(ivec2 texel, Brdf brdf, bool is_met)
{
    return vec3(0.0);
}
#endif

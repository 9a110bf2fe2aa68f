// What lobes reflect of glowing bodies: by shadow rays to points of them, and by rays of the lobe
// that meet them. Both count, weighted against each other by the balance heuristic (Veach 1997):
// rays of a narrow lobe find its image, points chosen from a tree find small bodies in a wide one.
//
// SAMPLE_COUNT: rays of the lobe. GLOW_IS_DIRECT 0: there are none.
#include "rays/emitter_tree.glsl"
#include "lib/z_curve.glsl"

#if GLOW_IS_DIRECT
// Of each slot, which emitter of the tree it is, or the first of its cells; -1: none; and how many
// cells it has along an edge.
uniform isampler2D t_glow_places;
uniform int u_glow_rays;

LitPoint lit_point_of_lobe(vec3 p, ivec2 texel)
{
    vec3 normal = u_ns_from_vs * gbuffer_shading_normal_vs(texel);
    vec3 w_out = u_ns_from_vs * toward_camera(gbuffer_position_vs(texel));
    vec3 mirrored = 2.0 * cosine_out(normal, w_out) * normal - w_out;
    return LitPoint(p, normal, w_out, normalize(mirrored), alpha_of(brdf_at(texel).roughness));
}

// Which of a parallelogram's cells the point p lies in, of which `e` is the first.
ivec2 cell_at(Emitter e, vec3 p, int per_side)
{
    vec3 normal = cross(e.edge_u.xyz, e.edge_v.xyz);
    vec3 d = (p - e.place) / max(dot(normal, normal), 1e-30);
    vec2 place = vec2(dot(cross(d, e.edge_v.xyz), normal), dot(cross(e.edge_u.xyz, d), normal));
    return clamp(ivec2(place), ivec2(0), ivec2(per_side - 1));
}

// Density over solid angle, all rays together, with which points of what a ray of length t has
// met are chosen; -1 where it is not of the tree.
float glow_density(LitPoint r, BvhHit hit, Surface met)
{
    int slot = int(bvh_texel(hit.record, 3).x) * 2 + (hit.is_second ? 1 : 0);
    ivec2 place = texelFetch(t_glow_places, row_address(slot), 0).xy;
    if (place.x < 0) {
        return -1.0;
    }
    ivec4 which = texelFetch(t_glow_order, row_address(place.x), 0);
    if (place.y > 1) {
        ivec2 cell = cell_at(emitter_at(which.y), met.at.position, place.y);
        which = texelFetch(t_glow_order, row_address(place.x + cell.y * place.y + cell.x), 0);
    }
    float area = emitter_texel(which.y, 2).w;
    float per_angle = hit.t * hit.t / max(area * met.area_cosine, 1e-20);
    return float(u_glow_rays) * chance_of_leaf(r, which.z) * per_angle;
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

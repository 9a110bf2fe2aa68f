// How likely points of glowing bodies that a ray has met would have been drawn from the tree.
#include "rays/emitter_tree.glsl"

// Of each slot, which emitter of the tree it is, or the first of its cells; -1: none; and how many
// cells it has along an edge.
uniform isampler2D t_glow_places;

const float ANY_AREA = 1e30;

// Which of a parallelogram's cells the point p lies in, of which `e` is the first.
ivec2 cell_at(Emitter e, vec3 p, int per_side)
{
    vec3 normal = cross(e.edge_u.xyz, e.edge_v.xyz);
    vec3 d = (p - e.place) / max(dot(normal, normal), 1e-30);
    vec2 place = vec2(dot(cross(d, e.edge_v.xyz), normal), dot(cross(e.edge_u.xyz, d), normal));
    return clamp(ivec2(place), ivec2(0), ivec2(per_side - 1));
}

// Which emitter of the tree a ray has met, or the first of its cells, and their number along an edge;
// below 0: none.
ivec2 glow_place(BvhHit hit)
{
    int slot = int(bvh_texel(hit.record, 3).x) * 2 + (hit.is_second ? 1 : 0);
    return texelFetch(t_glow_places, row_address(slot), 0).xy;
}

// Density over solid angle with which points of what a ray has met are chosen; -1 where it is not
// of the tree, or larger.
float glow_density(LitPoint r, BvhHit hit, Surface met, float most_area)
{
    ivec2 place = glow_place(hit);
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
    return area > most_area ? -1.0 : chance_of_leaf(r, which.z) * per_angle;
}

float glow_density(LitPoint r, BvhHit hit, Surface met)
{
    return glow_density(r, hit, met, ANY_AREA);
}

float spread_density(RaySurface at, vec3 w)
{
    return INV_PI * max(dot(w, at.normal), 0.0);
}

// What a ray spread by the cosine meets of glowing bodies closer than `reach`, and how far off. Of a
// point that a body touches, or nearly so, a few of its triangles send most, and points drawn from all
// of them bring the more the fewer of these are drawn: 16 of them brought more than a body can send
// that fills the hemisphere. Rays find such a body; both count, by the balance heuristic (Veach 1997).
// Emitters of a larger area are left to points.
vec3 glow_nearby(RaySurface at, vec3 w, float reach, float most_area, out float distance)
{
    BvhHit hit = bvh_nearest(at.start, w, reach);
    distance = hit.t;
    if (hit.record < 0)
        return vec3(0.0);
    Surface met = surface_at_hit(hit, at.start, w);
    if (!(met.mean_emission > 0.0) || met_light_is_blocked(at.start, w, hit.t))
        return vec3(0.0);
    float chosen = glow_density(lit_point(at.start, at.normal), hit, met, most_area);
    float found = spread_density(at, w);
    return chosen < 0.0 ? vec3(0.0) : PI * found / max(found + chosen, 1e-30) * met.emission;
}

// Of a point drawn from the tree with that density and so far off, what is not left to such rays.
float share_of_drawn(RaySurface at, LightSample light, float reach)
{
    float found = light.distance < reach ? spread_density(at, light.w) : 0.0;
    return light.density > 0.0 ? light.density / (light.density + found) : 1.0;
}

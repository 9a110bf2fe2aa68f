// Rays aimed at bright pieces of the surface cache: where they go, and what part of the light there they
// bring, where others come upon the same by chance (the balance heuristic: Veach, Guibas 1995).
//
// Pieces are parallelograms in a table of emitters of their own, t_ray_emitters, with a tree of their own:
// ssdo_gl/passes/surfels/bright_tables.py. A ray counts where it meets the surfel that it was aimed at.
#include "rays/emitter_tree.glsl"

uniform isampler2D t_bright_faces;  // of each surfel: the first parallelogram, and how many it has
uniform int u_aimed_rays;           // of each pixel

struct AimedRay {
    vec3 w;
    float weight;   // 1 / the density that it was drawn with, over solid angle
    float density;  // by area, which weighs it against others; 0: there is none
    ivec2 surfel;
};

AimedRay aimed_ray(LitPoint at, uint index, uint dimension)
{
    vec2 choice = random_2d(index, u_stream, dimension, false);
    vec2 u = random_2d(index, u_stream, dimension + 1u, false);
    float probability;
    int entry = draw_from_tree(at, choice, probability);
    if (entry < 0)
        return AimedRay(at.normal, 0.0, 0.0, ivec2(0));
    LightSample light = sample_surface_emitter(emitter_at(entry), entry, u, at.p);
    ivec2 surfel = surfel_texel(texelFetch(t_glow_order, row_address(entry), 0).g);
    // Its radiance is 1, and 0 on its back.
    float weight = light.radiance.r / max(probability, 1e-30);
    return AimedRay(light.w, weight, weight > 0.0 ? light.density * probability : 0.0, surfel);
}

// The density by area with which directions are drawn that meet the parallelogram where w does.
float density_of_face(LitPoint at, vec3 w, int face)
{
    Emitter e = emitter_at(face);
    vec3 normal = cross(e.edge_u.xyz, e.edge_v.xyz);
    float square = max(dot(normal, normal), 1e-30);
    float facing = -dot(w, normal);
    float along = dot(at.p - e.place, normal) / max(facing, 1e-30);
    vec3 d = at.p + along * w - e.place;
    vec2 place = vec2(dot(cross(d, e.edge_v.xyz), normal), dot(cross(e.edge_u.xyz, d), normal)) / square;
    bool is_within = all(greaterThanEqual(place, vec2(0.0))) && all(lessThanEqual(place, vec2(1.0)));
    if (!(is_within && facing > 0.0 && along > 0.0))
        return 0.0;
    float cosine = facing * inversesqrt(square);
    int leaf = texelFetch(t_glow_order, row_address(face), 0).b;
    return chance_of_leaf(at, leaf) * along * along / max(e.edge_v.w * cosine, 1e-30);
}

// Of the light of a surfel that a ray has met by chance, its part, and that of an aimed one; `found` is the
// density of all rays that go there by chance. From outside a box a ray comes in through one face.
float share_of_found(LitPoint at, vec3 w, ivec2 surfel, float found)
{
    ivec2 faces = texelFetch(t_bright_faces, surfel, 0).xy;
    float aimed = 0.0;
    for (int i = 0; i < faces.y; ++i) {
        aimed += density_of_face(at, w, faces.x + i);
    }
    return aimed > 0.0 ? found / (found + float(u_aimed_rays) * aimed) : 1.0;
}

float share_of_aimed(AimedRay ray, float found)
{
    float aimed = float(u_aimed_rays) * ray.density;
    return aimed / (aimed + found);
}

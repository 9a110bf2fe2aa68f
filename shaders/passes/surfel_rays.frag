#version 330 core
// What the rays of every surfel meet: the surfel there and its albedo, gloss included, once
// for all light.
//
// A tile of the image for each ray, a texel of it for each surfel: neighbours look the same
// way. Words as in rays/surfel_hits.glsl. Defines as in rays/surface_data.glsl and
// lib/environment.glsl; SURFEL_RAYS_PER_SIDE: rays of a surfel, by the root.
#include "rays/surfel_points.glsl"
#include "rays/surfel_hits.glsl"

#if LOBES
layout(location = 0) out uvec4 o_hit;
#else
layout(location = 0) out uvec2 o_hit;
#endif

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    ivec2 tile_size = ivec2(1 << SURFEL_ROW_SHIFT, u_surfel_rows);
    ivec2 tile = pixel / tile_size;
    ivec2 surfel = pixel - tile * tile_size;
    int ray = tile.y * SURFEL_RAYS_PER_SIDE + tile.x;
    int ray_count = SURFEL_RAYS_PER_SIDE * SURFEL_RAYS_PER_SIDE;
    RaySurface at = surfel_point(surfel, ray * SURFEL_POINTS / ray_count);
    vec3 w = surfel_direction(at, ray, pixel_seed(surfel));
    BvhHit hit = bvh_nearest(at.start, w, RAY_FAR);
    SurfelHit found = SurfelHit(NO_SURFEL, vec3(0.0), 0.0);
#if LOBES
    LayerHit layer = LayerHit(vec3(0.0, 0.0, 1.0), 1.0, vec2(0.0));
#endif
    if (hit.record >= 0) {
        Surface met = surface_at_hit(hit, at.start, w);
        found.surfel = uint(surfel_at_hit(hit, met.at.position, w));
        found.albedo = reflectance_of_facet(met);
#if GLOSSY
        found.slope = dot(facet_slope(met), vec3(1.0 / 3.0));
#endif
#if LOBES
        layer = LayerHit(met.at.normal, met.brdf.roughness, layer_of(met.brdf));
#endif
    }
#if LOBES
    o_hit = uvec4(packed_hit(found), packed_layer(layer));
#else
    o_hit = packed_hit(found);
#endif
}

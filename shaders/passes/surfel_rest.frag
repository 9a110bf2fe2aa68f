#version 330 core
// The mean direction of what surfels receive of each other, times the sum of its colours, and that.
// Defines as in passes/surfel_rays.frag.
#include "rays/surfel_points.glsl"
#include "rays/surfel_hits.glsl"

uniform usampler2D t_surfel_hits;

layout(location = 0) out vec4 o_rest;

void main()
{
    ivec2 surfel = ivec2(gl_FragCoord.xy);
    ivec2 tile_size = ivec2(1 << SURFEL_ROW_SHIFT, u_surfel_rows);
    uint seed = pixel_seed(surfel);
    const int ray_count = SURFEL_RAYS_PER_SIDE * SURFEL_RAYS_PER_SIDE;
    vec4 sum = vec4(0.0);
    for (int ray = 0; ray < ray_count; ++ray) {
        ivec2 tile = ivec2(ray % SURFEL_RAYS_PER_SIDE, ray / SURFEL_RAYS_PER_SIDE);
        SurfelHit met = unpacked_hit(texelFetch(t_surfel_hits, tile * tile_size + surfel, 0).xy);
        if (met.surfel == NO_SURFEL)
            continue;
        RaySurface at = surfel_point(surfel, ray * SURFEL_POINTS / ray_count);
        vec3 light = texelFetch(t_surface_cache, surfel_texel(int(met.surfel)), 0).rgb;
        sum += vec4(surfel_direction(at, ray, seed), 1.0) * dot(met.albedo, light);
    }
    o_rest = sum / float(ray_count);
}

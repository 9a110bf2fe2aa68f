#version 330 core
// Direct light of surfels, and what gloss sends them of all light more or less than if it was
// diffuse, which is what bounces count. Defines as in passes/surfel_rays.frag.
#include "rays/surfel_points.glsl"
#include "rays/surfel_hits.glsl"

uniform usampler2D t_surfel_hits;
uniform sampler2D t_surfel_direct;

layout(location = 0) out vec4 o_irradiance;

void main()
{
    ivec2 surfel = ivec2(gl_FragCoord.xy);
    ivec2 tile_size = ivec2(1 << SURFEL_ROW_SHIFT, u_surfel_rows);
    uint seed = pixel_seed(surfel);
    const int ray_count = SURFEL_RAYS_PER_SIDE * SURFEL_RAYS_PER_SIDE;
    vec3 sum = vec3(0.0);
#if LOBES
    for (int ray = 0; ray < ray_count; ++ray) {
        ivec2 tile = ivec2(ray % SURFEL_RAYS_PER_SIDE, ray / SURFEL_RAYS_PER_SIDE);
        uvec4 words = texelFetch(t_surfel_hits, tile * tile_size + surfel, 0);
        LayerHit hit = unpacked_layer(words.zw);
        if (!has_layer(hit.layer))
            continue;
        SurfelHit met = unpacked_hit(words.xy);
        RaySurface at = surfel_point(surfel, ray * SURFEL_POINTS / ray_count);
        vec3 w = surfel_direction(at, ray, seed);
        ivec2 other = surfel_texel(int(met.surfel));
        vec4 light = texelFetch(t_surface_cache, other, 0);
        vec3 share = met.albedo;
        share += is_all_layer(hit.layer) ? vec3(0.0) : vec3(met.slope * light.a);
        sum += PI * sent_by_directions(other, light, hit.normal, -w, hit.roughness, share, hit.layer)
             - share * light.rgb;
    }
#endif
    vec4 direct = texelFetch(t_surfel_direct, surfel, 0);
    o_irradiance = vec4(direct.rgb + sum / float(ray_count), direct.a);
}

#version 330 core
// Irradiance of surfels by the sky, through the directions in which their rays met nothing:
// a tile of the image for each row of rays, whose sum it is. Defines as in
// passes/surfel_rays.frag. A map is drawn from with the lights, too: both ways share its light.
#include "rays/surfel_points.glsl"
#include "rays/surfel_hits.glsl"
#include "rays/quarter_sums.glsl"

uniform usampler2D t_surfel_hits;

layout(location = 0) out vec4 o_irradiance;

void main()
{
    ivec2 surfel = ivec2(gl_FragCoord.xy);
    int row = surfel.y / u_surfel_rows;
    surfel.y -= row * u_surfel_rows;
    ivec2 tile_size = ivec2(1 << SURFEL_ROW_SHIFT, u_surfel_rows);
    vec4 sum = vec4(0.0);
#if LOBES
    QuarterSums quarters = EMPTY_QUARTERS;
#endif
    uint seed = pixel_seed(surfel);
    int ray_count = SURFEL_RAYS_PER_SIDE * SURFEL_RAYS_PER_SIDE;
    for (int column = 0; column < SURFEL_RAYS_PER_SIDE; ++column) {
        ivec2 texel = ivec2(column, row) * tile_size + surfel;
        if (unpacked_hit(texelFetch(t_surfel_hits, texel, 0).xy).surfel == NO_SURFEL) {
            int ray = row * SURFEL_RAYS_PER_SIDE + column;
            RaySurface at = surfel_point(surfel, ray * SURFEL_POINTS / ray_count);
            vec3 w = surfel_direction(at, ray, seed);
            vec3 arriving = environment_radiance(w) * share_of_own_rays(at, w, map_density(w));
            sum += light_of_surfel(at, w, arriving);
#if LOBES
            add_to_quarter(quarters, at.normal, w, arriving);
#endif
        }
    }
    o_irradiance = sum * (PI / float(ray_count));
#if LOBES
    write_quarters(quarters, PI / float(ray_count));
#endif
}

#version 330 core
// Irradiance of surfels by the sky, through the directions in which their rays met nothing.
// Defines as in passes/surfel_rays.frag. A map is drawn from with the lights instead.
#include "rays/surfel_points.glsl"

uniform usampler2D t_surfel_hits;

layout(location = 0) out vec4 o_irradiance;

void main()
{
    ivec2 surfel = ivec2(gl_FragCoord.xy);
    ivec2 tile_size = ivec2(1 << SURFEL_ROW_SHIFT, u_surfel_rows);
    vec3 sum = vec3(0.0);
    uint seed = pixel_seed(surfel);
    int ray_count = SURFEL_RAYS_PER_SIDE * SURFEL_RAYS_PER_SIDE;
    int rays_per_point = max(ray_count / SURFEL_POINTS, 1);
    for (int ray = 0; ray < ray_count; ++ray) {
        ivec2 tile = ivec2(ray % SURFEL_RAYS_PER_SIDE, ray / SURFEL_RAYS_PER_SIDE);
        if ((texelFetch(t_surfel_hits, tile * tile_size + surfel, 0).x & 0xffffu) == 0xffffu) {
            RaySurface at = surfel_point(surfel, ray / rays_per_point);
            sum += environment_radiance(surfel_direction(at, ray, seed));
        }
    }
    o_irradiance = vec4(sum * (PI / float(ray_count)), 1.0);
}

#version 330 core
// Irradiance of surfels by the sky, through the directions in which their rays met nothing:
// a tile of the image for each row of rays, whose sum it is. Defines as in
// passes/surfel_rays.frag. A map is drawn from with the lights, too: both ways share its light. OPENINGS:
// see rays/openings.glsl: rays aimed at them share what these bring (the balance heuristic).
#include "rays/surfel_points.glsl"
#include "rays/openings.glsl"
#include "rays/surfel_hits.glsl"
#include "rays/quarter_sums.glsl"

uniform usampler2D t_surfel_hits;

layout(location = 0) out vec4 o_irradiance;

#if OPENINGS
// Aimed at openings, with each row of rays.
const int AIMED_RAYS = 4;

// Of the light along w, what rays bring that are not aimed, `ray_count` of all rows.
float share_of_spread_rays(RaySurface at, vec3 w, int ray_count)
{
    float spread = float(ray_count) * INV_PI * max(dot(w, at.normal), 0.0);
    float sum = weight_of_openings(at.start, at.normal);
    float aimed = float(AIMED_RAYS * SURFEL_RAYS_PER_SIDE) * density_of_openings(at.start, at.normal, w, sum);
    return spread / max(spread + aimed, 1e-30);
}

// What one brings in place of one that is spread by the cosine.
vec3 arriving_by_opening(RaySurface at, vec3 w, int ray_count)
{
    float cosine = dot(w, at.normal);
    if (!(cosine > 0.0) || bvh_is_blocked(at.start, w, RAY_FAR))
        return vec3(0.0);
    // The density cancels: aimed / (spread + aimed) / aimed.
    float share = share_of_spread_rays(at, w, ray_count);
    return environment_radiance(w) * share_of_own_rays(at, w, map_density(w)) * share;
}
#endif

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
#if OPENINGS
            arriving *= share_of_spread_rays(at, w, ray_count);
#endif
            sum += light_of_surfel(at, w, arriving);
#if LOBES
            add_to_quarter(quarters, at.normal, w, arriving);
#endif
        }
    }
#if OPENINGS
    for (int i = 0; i < AIMED_RAYS; ++i) {
        int ray = row * AIMED_RAYS + i;
        RaySurface at = surfel_point(surfel, ray % SURFEL_POINTS);
        float choice = random_2d(uint(ray), seed, 1u, false).x;
        vec2 u = random_2d(uint(ray), seed, 2u, false);
        float weights = weight_of_openings(at.start, at.normal);
        vec3 w = towards_opening(at.start, at.normal, choice, u, weights);
        vec3 arriving = arriving_by_opening(at, w, ray_count);
        sum += light_of_surfel(at, w, arriving);
#if LOBES
        add_to_quarter(quarters, at.normal, w, arriving);
#endif
    }
#endif
    o_irradiance = sum * (PI / float(ray_count));
#if LOBES
    write_quarters(quarters, PI / float(ray_count));
#endif
}

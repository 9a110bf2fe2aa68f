#version 330 core
// Irradiance of surfels straight from the scene's lights, glowing meshes and environment map,
// by shadow rays from all their points. Emission that rays meet by chance is thus counted
// nowhere else, but for a map's: see passes/surfel_sky.frag. Defines as in rays/surface_data.glsl and lib/environment.glsl;
// PART_COUNT: parts in which the rays are traced, each in a tile of the image.
#include "rays/surfel_points.glsl"

uniform int u_samples;          // of each group, or in all where they are drawn
uniform bool u_draws_groups;    // too many to go through

layout(location = 0) out vec4 o_irradiance;

const uint DIMENSION_GROUP = 1u;
const uint DIMENSION_LIGHT = 2u;  // two for each group

void main()
{
    ivec2 surfel = ivec2(gl_FragCoord.xy);
    int part = surfel.y / u_surfel_rows;
    surfel.y -= part * u_surfel_rows;
    uint seed = pixel_seed(surfel);
    int ray_count = u_samples * (u_draws_groups ? 1 : u_emitter_group_count);
    int points_per_sample = max(SURFEL_POINTS / max(u_samples, 1), 1);
    vec4 sum = vec4(0.0);
    for (int ray = part; ray < ray_count; ray += PART_COUNT) {
        int g = ray / u_samples;
        int i = ray - g * u_samples;
        // Groups of few samples start from different points.
        RaySurface at = surfel_point(surfel, (i * points_per_sample + g) % SURFEL_POINTS);
        uint dimension = DIMENSION_LIGHT + 2u * uint(g);
        vec2 choice = random_2d(uint(i), seed, dimension, false);
        vec2 u = random_2d(uint(i), seed, dimension + 1u, true);
        EmitterGroup group;
        if (u_draws_groups) {
            float chance = random_2d(uint(i), seed, DIMENSION_GROUP, false).x;
            group = draw_emitter_group(chance);
        } else {
            group = emitter_group(g);
            group.probability = 1.0;
        }
        LightSample light = sample_group(group, choice, u, at.start);
        vec3 arriving = unblocked_irradiance(at, light) / max(group.probability, 1e-30);
        float reach = needed_reach(group, light, arriving, RAY_FAR);
#if ENVIRONMENT_KIND == 3
        bool is_map = emitter_at(group.first).kind == EMITTER_MAP;
        arriving *= is_map ? 1.0 - share_of_own_rays(at, light.w, light.density) : 1.0;
#endif
        sum += light_is_blocked(at, light.w, reach) ? vec4(0.0) : light_of_surfel(at, light.w, arriving);
    }
    o_irradiance = sum / float(max(u_samples, 1));
}

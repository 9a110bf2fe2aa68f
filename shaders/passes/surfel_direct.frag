#version 330 core
// Irradiance of surfels straight from the scene's lights, glowing meshes and environment map,
// by shadow rays from all their points. Emission that rays meet by chance is thus counted
// nowhere else. Defines as in rays/surface_data.glsl and lib/environment.glsl.
#include "rays/surfel_points.glsl"

uniform sampler2D t_surfel_sky;
uniform int u_samples;          // of each group, or in all where they are drawn
uniform bool u_draws_groups;    // too many to go through

layout(location = 0) out vec4 o_irradiance;

const uint DIMENSION_GROUP = 1u;
const uint DIMENSION_LIGHT = 2u;  // two for each group

void main()
{
    ivec2 surfel = ivec2(gl_FragCoord.xy);
    vec3 irradiance = texelFetch(t_surfel_sky, surfel, 0).rgb;
    uint seed = pixel_seed(surfel);
    int turns = u_draws_groups ? 1 : u_emitter_group_count;
    int points_per_sample = max(SURFEL_POINTS / max(u_samples, 1), 1);
    vec3 sum = vec3(0.0);
    for (int g = 0; g < turns; ++g) {
        for (int i = 0; i < u_samples; ++i) {
            // Groups of few samples start from different points.
            RaySurface at = surfel_point(surfel, (i * points_per_sample + g) % SURFEL_POINTS);
            uint dimension = DIMENSION_LIGHT + 2u * uint(g);
            vec2 choice = random_2d(uint(i), seed, dimension, false);
            EmitterGroup group;
            if (u_draws_groups) {
                float chance = random_2d(uint(i), seed, DIMENSION_GROUP, false).x;
                group = draw_emitter_group(chance);
            } else {
                group = emitter_group(g);
                group.probability = 1.0;
            }
            LightSample light = sample_group(group, choice, random_2d(uint(i), seed, dimension + 1u, true), at.start);
            vec3 arriving = unblocked_irradiance(at, light) / max(group.probability, 1e-30);
            float reach = needed_reach(group, light, arriving, RAY_FAR);
            sum += light_is_blocked(at, light.w, reach) ? vec3(0.0) : arriving;
        }
    }
    o_irradiance = vec4(irradiance + sum / float(max(u_samples, 1)), 1.0);
}

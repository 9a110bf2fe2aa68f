#version 330 core
// Irradiance from the scene's lights with shadows by rays: for each sample one point of
// each light, E = mean of L cos(theta) cos(theta') / (d^2 density) V. Lights that an
// emissive mesh stands behind are that mesh here, triangle by triangle.
//
// Where surfaces are glossy, a ray of the lobe looks for those meshes, too; the power
// heuristic weights what both can find. LOBES_MEET_LIGHTS: there are such meshes.
//
// Adds this draw's samples to the sum; defines as in rays/surface_data.glsl.
#include "rays/emitters.glsl"
#include "lights/gloss_along.glsl"
#include "lib/random.glsl"

layout(location = 0) out vec4 o_sum;
#if GLOSSY
layout(location = 1) out vec4 o_gloss;  // radiance; alpha 0: senders do not pass it on
#endif

// The power heuristic (Veach 1997), which leaves the better way of finding a light its low noise.
float power(float mine, float other)
{
    float ratio = other / max(mine, 1e-30);
    return 1.0 / (1.0 + ratio * ratio);
}

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 irradiance = vec3(0.0);
    vec3 gloss = vec3(0.0);
    if (gbuffer_z_vs(pixel) > 0.0) {
        RaySurface surface = ray_surface_at(pixel);
#if GLOSSY
        Brdf brdf = brdf_at(pixel);
        float groups = float(asked_group_count());
#endif
        uint seed = pixel_seed(pixel);
        for (int g = 0; g < asked_group_count(); ++g) {
            uint own = seed + uint(g) * 0x9e3779b9u;
            int i = 0;
            do {
                uint index = u_first_sample + uint(i);
                vec2 choice = random_2d(index, own, 1u, false);
                float weight;
                EmitterGroup group = asked_group(g, choice.x, weight);
                bool is_traced = group.is_direct && group.shadow != EMITTER_SSDO;
                vec2 u = random_2d(index, own, 0u, true);
                LightSample light = sample_group(group, choice, u, surface.start);
                vec3 arriving = is_traced ? weight * unblocked_irradiance(surface, light) : vec3(0.0);
                float reach = needed_reach(group, light, arriving, RAY_FAR);
#if GLOSSY && LOBES_MEET_LIGHTS
                BrdfSample facet = gloss_sample(brdf, surface.normal, surface.w_out,
                                                random_2d(index, own, 2u, false));
                // With the first light, because one loop for both rays takes less time.
                bool goes = g == 0 && dot(facet.w_in, surface.geometric) > 0.0 && !is_dark(facet.weight);
                LightRay ray = light_ray(surface, light.w, reach);
                bool is_blocked;
                BvhHit hit = bvh_blocked_and_nearest(
                    bvh_ray_to_light(ray.start, ray.w, SIDES_TO_LIGHT), ray.t_max,
                    surface.start, facet.w_in, goes ? RAY_FAR : -1.0, is_blocked);
                if (hit.record >= 0) {
                    Surface met = surface_at_hit(hit, surface.start, facet.w_in);
                    float found = power(facet.density, groups * drawn_density(met, hit.t));
                    bool counts = is_direct_body(met.flags)
                        && !met_light_is_blocked(surface.start, facet.w_in, hit.t);
                    gloss += counts ? found * facet.weight * met.emission : vec3(0.0);
                }
#else
                bool is_blocked = light_is_blocked(surface, light.w, reach);
#endif
                arriving = is_blocked ? vec3(0.0) : arriving;
#if GLOSSY
                LightGloss reflected = gloss_along(
                    brdf, surface.normal, surface.w_out, light.w, arriving,
                    facets_between(brdf, surface.normal, surface.w_out, light.w));
                arriving = reflected.irradiance;
#if LOBES_MEET_LIGHTS
                bool can_be_met = group.shadow == EMITTER_SHADOWED && dot(light.w, surface.geometric) > 0.0;
#if RAY_SINGLE_SIDED
                can_be_met = can_be_met && !is_dark(arriving)
                    && !bvh_meets_any(bvh_ray_to_light(ray.start, ray.w, ALL_SIDES), ray.t_max);
#endif
                float other = gloss_density(brdf, surface.normal, surface.w_out, light.w);
                float drawn = groups * group.probability * light.density;
                reflected.radiance *= can_be_met && drawn > 0.0 ? power(drawn, other) : 1.0;
#endif
                gloss += reflected.radiance;
#endif
                irradiance += arriving;
            } while (++i < u_sample_count);
        }
    }
    o_sum = vec4(irradiance, 0.0);
#if GLOSSY
    o_gloss = vec4(gloss, 0.0);
#endif
}

#version 330 core
// Irradiance from the scene's lights with shadows by rays: for each sample one point of
// each light, E = mean of L cos(theta) cos(theta') / (d^2 density) V. Lights that an
// emissive mesh stands behind are that mesh here, triangle by triangle.
//
// Adds this draw's samples to the sum; defines as in rays/surface_data.glsl.
#include "rays/emitters.glsl"
#include "lights/gloss_along.glsl"
#include "lib/random.glsl"

layout(location = 0) out vec4 o_sum;
#if GLOSSY
layout(location = 1) out vec4 o_gloss;  // radiance; alpha 0: senders do not pass it on
#endif

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 irradiance = vec3(0.0);
    vec3 gloss = vec3(0.0);
    if (gbuffer_z_vs(pixel) > 0.0) {
        RaySurface surface = ray_surface_at(pixel);
#if GLOSSY
        Brdf brdf = brdf_at(pixel);
#endif
        uint seed = pixel_seed(pixel);
        for (int g = 0; g < asked_group_count(); ++g) {
            uint own = seed + uint(g) * 0x9e3779b9u;
            for (int i = 0; i < u_sample_count; ++i) {
                uint index = u_first_sample + uint(i);
                vec2 choice = random_2d(index, own, 1u, false);
                float weight;
                EmitterGroup group = asked_group(g, choice.x, weight);
                if (group.is_direct && group.shadow != EMITTER_SSDO) {
                    vec2 u = random_2d(index, own, 0u, true);
                    LightSample light = sample_group(group, choice, u, surface.start);
                    vec3 arriving = weight * unblocked_irradiance(surface, light);
                    float reach = needed_reach(group, light, arriving, RAY_FAR);
                    arriving = light_is_blocked(surface, light.w, reach) ? vec3(0.0) : arriving;
#if GLOSSY
                    LightGloss reflected = gloss_along(
                        brdf, surface.normal, surface.w_out, light.w, arriving,
                        facets_between(brdf, surface.normal, surface.w_out, light.w));
                    arriving = reflected.irradiance;
                    gloss += reflected.radiance;
#endif
                    irradiance += arriving;
                }
            }
        }
    }
    o_sum = vec4(irradiance, 0.0);
#if GLOSSY
    o_gloss = vec4(gloss, 0.0);
#endif
}

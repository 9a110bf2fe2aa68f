#version 330 core
// The near field by rays: the integrals that SSDO approximates, with V_R from the true
// surfaces instead of the depth buffer.
//   directional E = integral of L_in(w) V_R(w) cos
//   bounce      E = integral of (1 - V_R(w)) L_out1(sender) cos
//   L_out1 = emission that no light delivers + reflected E_direct + E_directional
//   gloss       L = integral of gloss(w_out, w) cos (L_in(w) or L_out1(sender)) dw, whatever R
// L_in = environment and the lights marked ssdo, whose light arrives unless something
// within R stands before them. Shadows of `direct` light at the sender have no limit.
//
// Adds this draw's samples to the sums; defines as in rays/surface_data.glsl and
// lib/environment.glsl.
#include "rays/emitters.glsl"
#include "lib/random.glsl"

uniform float u_radius_ns;

layout(location = 0) out vec4 o_directional;  // rgb irradiance, a visibility
layout(location = 1) out vec4 o_bounce;       // rgb irradiance

#if GLOSSY
layout(location = 2) out vec4 o_gloss;    // rgb radiance; alpha 0: senders do not pass it on

const uint DIMENSION_GLOSS = 0x10000u;    // beyond those of any number of lights
#endif
const uint DIMENSION_FIRST = 0u;
const uint DIMENSION_SENDER_SKY = 1u;
const uint DIMENSION_LIGHTS = 2u;  // two for each light and place

// Irradiance of the lights marked ssdo at `surface`, one sample of each that is asked.
vec3 ssdo_irradiance(RaySurface surface, uint index, uint seed)
{
    vec3 irradiance = vec3(0.0);
    for (int g = 0; g < asked_group_count(); ++g) {
        uint dimension = DIMENSION_LIGHTS + 4u * uint(g);
        vec2 choice = random_2d(index, seed, dimension + 1u, false);
        float weight;
        EmitterGroup group = asked_group(g, choice.x, weight);
        if (group.is_direct && group.shadow == EMITTER_SSDO) {
            vec2 u = random_2d(index, seed, dimension, false);
            LightSample light = sample_group(group, choice, u, surface.start);
            vec3 arriving = weight * unblocked_irradiance(surface, light);
            float reach = needed_reach(group, light, arriving, u_radius_ns);
            irradiance += light_is_blocked(surface, light.w, reach) ? vec3(0.0) : arriving;
        }
    }
    return irradiance;
}

// E_direct + E_directional at a sender: one ray to each light that is asked and one to the sky.
vec3 sender_irradiance(RaySurface surface, uint index, uint seed)
{
    vec3 irradiance = vec3(0.0);
    // The turn after the last light is the sky's: one loop, because every call of the
    // traversal is another copy of it in the program.
    int g = 0;
    do {
        bool is_sky = g == asked_group_count();
        uint dimension = DIMENSION_LIGHTS + 4u * uint(g) + 2u;
        vec2 u = random_2d(index, seed, is_sky ? DIMENSION_SENDER_SKY : dimension, false);
        vec2 choice = random_2d(index, seed, dimension + 1u, false);
        float weight;
        EmitterGroup group = asked_group(max(min(g, asked_group_count() - 1), 0), choice.x, weight);
        LightSample light = NO_LIGHT;
        vec3 arriving = vec3(0.0);
        float reach = -1.0;
        if (is_sky) {
            light.w = ray_direction(surface, frame_from_z(surface.normal), u);
            arriving = PI * environment_radiance(light.w);
            reach = is_dark(arriving) ? -1.0 : u_radius_ns;
        } else if (group.is_direct) {
            light = sample_group(group, choice, u, surface.start);
            arriving = weight * unblocked_irradiance(surface, light);
            float longest = group.shadow == EMITTER_SSDO ? u_radius_ns : RAY_FAR;
            reach = needed_reach(group, light, arriving, longest);
        }
        irradiance += light_is_blocked(surface, light.w, reach) ? vec3(0.0) : arriving;
    } while (++g <= asked_group_count());
    return irradiance;
}

#if GLOSSY
const int LOBE_COUNT = 2;
#else
const int LOBE_COUNT = 1;
#endif

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 directional = vec4(0.0, 0.0, 0.0, float(u_sample_count));
    vec3 bounce = vec3(0.0);
    vec3 gloss = vec3(0.0);
    if (gbuffer_z_vs(pixel) > 0.0) {
        RaySurface receiver = ray_surface_at(pixel);
        mat3 frame = frame_from_z(receiver.normal);
        uint seed = pixel_seed(pixel);
#if GLOSSY
        Brdf brdf = brdf_at(pixel);
#endif
        // One loop, because every call of the traversal is another copy of it.
        int i = 0;
        do {
            uint index = u_first_sample + uint(i / LOBE_COUNT);
            bool is_gloss = i % LOBE_COUNT == 1;
            vec3 w = ray_direction(receiver, frame, random_2d(index, seed, DIMENSION_FIRST, true));
            vec3 weight = vec3(PI);
            float reach = u_radius_ns;
#if GLOSSY
            if (is_gloss) {
                vec2 u = random_2d(index, seed, DIMENSION_GLOSS, false);
                BrdfSample facet = gloss_sample(brdf, receiver.normal, receiver.w_out, u);
                bool is_above = dot(facet.w_in, receiver.geometric) > 0.0;
                w = facet.w_in;
                weight = is_above ? facet.weight : vec3(0.0);
                reach = is_dark(weight) ? -1.0 : RAY_FAR;
            }
#endif
            BvhHit hit = bvh_nearest(receiver.start, w, reach);
            vec3 sent = vec3(0.0);
            if (hit.record >= 0) {
                Surface sender = surface_at_hit(hit, receiver.start, w);
                bool is_lamp = (sender.flags & LIGHT_BODY_FLAG) != 0u;
                vec3 reflected = sent_radiance(sender.brdf, sender_irradiance(sender.at, index, seed));
                sent = weight * ((is_lamp ? vec3(0.0) : sender.emission) + reflected);
            }
            vec3 sky = hit.record >= 0 ? vec3(0.0) : weight * environment_radiance(w);
            if (is_gloss) {
                gloss += sent + sky;
            } else {
                bounce += sent;
                directional.rgb += sky + ssdo_irradiance(receiver, index, seed);
                directional.a -= hit.record >= 0 ? 1.0 : 0.0;
            }
        } while (++i < LOBE_COUNT * u_sample_count);
    }
    o_directional = directional;
    o_bounce = vec4(bounce, 0.0);
#if GLOSSY
    o_gloss = vec4(gloss, 0.0);
#endif
}

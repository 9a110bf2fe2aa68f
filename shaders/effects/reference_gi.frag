#version 330 core
// The full solution: an unbiased path tracer over the surfaces that the camera sees.
//
// At each vertex of a path, one sample of the light (next-event estimation) and one
// scattered ray; where both can find the same light, the balance heuristic (Veach 1997)
// weights them. Kept naive on purpose: the reference that everything else is measured
// against. A pixel whose path has ended starts the next one at once, because pixels run
// in lockstep and would wait for the longest path of each round.
//
// Adds this draw's paths to the sum; defines as in rays/surface_data.glsl and
// lib/environment.glsl; HAS_EMITTERS: 0 if there is nothing to draw light from.
#include "rays/emitters.glsl"
#include "lib/random.glsl"

uniform sampler2D t_emission;
uniform int u_max_bounces;       // indirect bounces; with roulette, far beyond any path
uniform int u_roulette_start;    // bounces before a path may end by chance

layout(location = 0) out vec4 o_sum;  // rgb radiance, a coverage

// Paths never survive more surely than this, or white rooms would hold them for ever.
const float MAX_SURVIVAL = 0.95;
const uint DIMENSIONS_PER_VERTEX = 4u;

float balance(float mine, float other)
{
    return mine / max(mine + other, 1e-30);
}

// Probability density with which the light sampling of a vertex would have drawn a point
// of the map in direction w.
float sky_density(vec3 w)
{
#if ENVIRONMENT_KIND == 3
    // The map is the last group.
    return map_density(w) * emitter_group(u_emitter_group_count - 1).probability;
#else
    return 0.0;
#endif
}

// One sample of the light that reaches a vertex straight from an emitter.
struct DirectSample {
    LightRay ray;    // a negative length: none is needed
    float sides;     // that it meets
    vec3 reflected;  // unless something blocks the ray
    vec3 all;        // where scattered rays do not find it
};

DirectSample sampled_light(RaySurface at, Brdf brdf, uint index, uint seed, uint dimension,
                           bool is_first)
{
    vec2 choice = random_2d(index, seed, dimension, false);
    // The first shadow rays of neighbouring pixels stay together.
    vec2 u = random_2d(index, seed, dimension + 1u, is_first);
    EmitterGroup group = draw_emitter_group(choice.x);
    LightSample light = sample_group(group, choice, u, at.start);
    // Scattered rays go nowhere below the geometric horizon.
    bool can_be_hit = light.density > 0.0 && group.shadow != EMITTER_UNSHADOWED
        && dot(light.w, at.geometric) > 0.0;
    float scattered = brdf_density(brdf, at.normal, at.w_out, light.w);
    float weight = can_be_hit ? balance(light.density * group.probability, scattered) : 1.0;
    vec3 response = brdf_times_cosine(brdf, at.normal, at.w_out, light.w);
    vec3 all = unblocked_light(at, light, response) / max(group.probability, 1e-30);
    all = is_dark(all) ? vec3(0.0) : all;
    float reach = needed_reach(group, light, all, RAY_FAR);
    bool is_sky = emitter_at(group.first).kind == EMITTER_MAP;
    float sides = is_sky ? SIDES_TO_SKY : can_be_hit ? ALL_SIDES : SIDES_TO_LIGHT;
    vec3 reflected = all * weight;
    return DirectSample(light_ray(at, light.w, reach), sides, reflected, is_sky ? reflected : all);
}

vec3 traced_radiance(RaySurface first, Brdf first_brdf, uint seed)
{
    vec3 sum = vec3(0.0);
    RaySurface at = first;
    Brdf brdf = first_brdf;
    vec3 weight = vec3(1.0);   // of what leaves the vertex
    float survival = 1.0;      // chance with which the path has come to it
    int path = 0;
    int bounce = 0;
    bool goes_on = u_sample_count > 0 && !is_dark(brdf_reflectance(first_brdf));
    if (goes_on) do {
        uint index = u_first_sample + uint(path);
        uint dimension = DIMENSIONS_PER_VERTEX * uint(bounce);
        LightRay none = LightRay(at.start, vec3(0.0, 0.0, 1.0), -1.0);
        DirectSample direct = DirectSample(none, SIDES_TO_LIGHT, vec3(0.0), vec3(0.0));
#if HAS_EMITTERS
        direct = sampled_light(at, brdf, index, seed, dimension, bounce == 0);
#endif
        vec2 u = random_2d(index, seed, dimension + 2u, bounce == 0);
        BrdfSample scattered = brdf_sample(brdf, at.normal, at.w_out, u);
        vec3 w = scattered.w_in;
#if GLOSSY
        // Facets of what stands for a smooth surface do not hide each other.
        w -= at.is_smooth ? min(2.0 * dot(w, at.geometric), 0.0) * at.geometric : vec3(0.0);
#endif
        vec3 onward = weight * scattered.weight / survival;   // of what arrives along w
        bool is_above = dot(w, at.geometric) > 0.0;
        bool is_blocked;
        BvhHit hit = bvh_blocked_and_nearest(
            bvh_ray_to_light(direct.ray.start, direct.ray.w, direct.sides), direct.ray.t_max,
            at.start, w, is_above ? RAY_FAR : -1.0, is_blocked);
        bool is_hit = hit.record >= 0;
        sum += weight * light_past_sheets(direct.ray, is_blocked, direct.reflected, direct.all) / survival;
        if (is_above && !is_hit) {
            sum += onward * environment_radiance(w) * balance(scattered.density, sky_density(w));
        }
        if (is_hit) {
            Surface met = surface_at_hit(hit, at.start, w);
            float drawn = drawn_density(met, hit.t);
            bool counts = !is_dark(met.emission) && !is_unshadowed_body(met.flags)
                && !met_light_is_blocked(at.start, w, hit.t);
            sum += counts ? onward * met.emission * balance(scattered.density, drawn) : vec3(0.0);
            at = met.at;
            brdf = met.brdf;
        }
        ++bounce;
        weight = onward;
        vec3 worth = weight * brdf_reflectance(brdf);
        float largest = max(worth.r, max(worth.g, worth.b));
        survival = bounce > u_roulette_start ? min(largest, MAX_SURVIVAL) : 1.0;
        float chance = random_2d(index, seed, dimension + 3u, false).x;
        bool ends = !is_hit || bounce > u_max_bounces || !(largest > 0.0) || chance >= survival;
        if (ends) {
            at = first;
            brdf = first_brdf;
            weight = vec3(1.0);
            survival = 1.0;
            bounce = 0;
            ++path;
        }
        goes_on = path < u_sample_count;
    } while (goes_on);
    return sum;
}

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float count = float(u_sample_count);
    if (gbuffer_z_vs(pixel) > 0.0) {
        RaySurface first = ray_surface_at(pixel);
        vec3 emission = texelFetch(t_emission, pixel, 0).rgb;
        vec3 sum = traced_radiance(first, brdf_at(pixel), pixel_seed(pixel));
        o_sum = vec4(sum + emission * count, count);
    } else {
        vec3 ray_ws = u_ns_from_vs * normalize(view_ray_at(uv_of_texel(pixel)));
        o_sum = vec4(environment_radiance(ray_ws) * count, 0.0);
    }
}

#version 330 core
// The full solution: an unbiased path tracer over the surfaces that the camera sees.
//
// At each vertex of a path, one sample of the light (next-event estimation) and one
// scattered ray; where both can find the same light, the balance heuristic (Veach 1997)
// weights them. Kept naive on purpose: the truth that everything else is measured
// against. A pixel whose path has ended starts the next one at once, because pixels run
// in lockstep and would wait for the longest path of each round.
//
// Adds this draw's paths to the sum; defines as in rays/surface_data.glsl and
// lib/environment.glsl; HAS_EMITTERS: 0 if there is nothing to draw light from.
#include "rays/emitters.glsl"
#include "lib/random.glsl"

uniform sampler2D t_albedo;
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
    vec3 w;
    float reach;     // length of the shadow ray; negative: none is needed
    vec3 arriving;   // times cos / pi, unless something blocks the ray
};

DirectSample sampled_light(RaySurface at, uint index, uint seed, uint dimension, bool is_first)
{
    vec2 choice = random_2d(index, seed, dimension, false);
    // The first shadow rays of neighbouring pixels stay together.
    vec2 u = random_2d(index, seed, dimension + 1u, is_first);
    EmitterGroup group = draw_emitter_group(choice.x);
    LightSample light = sample_group(group, choice, u, at.start);
    bool can_be_hit = light.density > 0.0 && group.shadow != EMITTER_UNSHADOWED;
    float scattered = max(dot(light.w, at.normal), 0.0) * INV_PI;
    float weight = can_be_hit ? balance(light.density * group.probability, scattered) : 1.0;
    vec3 arriving = unblocked_irradiance(at, light) * (INV_PI * weight / max(group.probability, 1e-30));
    arriving = is_dark(arriving) ? vec3(0.0) : arriving;
    return DirectSample(light.w, needed_reach(group, light, arriving, RAY_FAR), arriving);
}

vec3 traced_radiance(RaySurface first, vec3 first_albedo, uint seed)
{
    vec3 sum = vec3(0.0);
    RaySurface at = first;
    vec3 weight = first_albedo;   // of what arrives at the vertex, its albedo included
    int path = 0;
    int bounce = 0;
    bool goes_on = u_sample_count > 0 && !is_dark(first_albedo);
    while (goes_on) {
        uint index = u_first_sample + uint(path);
        uint dimension = DIMENSIONS_PER_VERTEX * uint(bounce);
        DirectSample direct = DirectSample(vec3(0.0, 0.0, 1.0), -1.0, vec3(0.0));
#if HAS_EMITTERS
        direct = sampled_light(at, index, seed, dimension, bounce == 0);
#endif
        vec2 u = random_2d(index, seed, dimension + 2u, bounce == 0);
        vec3 w = frame_from_z(at.normal) * cosine_hemisphere(u);
        float scattered = dot(w, at.normal) * INV_PI;
        bool is_above = dot(w, at.geometric) > 0.0;
        bool is_blocked;
        BvhHit hit = bvh_blocked_and_nearest(
            at.start, direct.w, direct.reach, w, is_above ? RAY_FAR : -1.0, is_blocked);
        bool is_hit = hit.record >= 0;
        sum += is_blocked ? vec3(0.0) : weight * direct.arriving;
        if (is_above && !is_hit) {
            sum += weight * environment_radiance(w) * balance(scattered, sky_density(w));
        }
        if (is_hit) {
            Surface met = surface_at_hit(hit, at.start, w);
            float per_angle = hit.t * hit.t / max(met.area_cosine, 1e-20);
            float drawn = u_emitter_density * met.mean_emission * per_angle;
            bool counts = (met.flags & UNSHADOWED_BODY_FLAG) == 0u;
            sum += counts ? weight * met.emission * balance(scattered, drawn) : vec3(0.0);
            weight *= met.albedo;
            at = met.at;
        }
        ++bounce;
        float largest = max(weight.r, max(weight.g, weight.b));
        float survival = bounce > u_roulette_start ? min(largest, MAX_SURVIVAL) : 1.0;
        float chance = random_2d(index, seed, dimension + 3u, false).x;
        bool ends = !is_hit || bounce > u_max_bounces || !(largest > 0.0) || chance >= survival;
        weight = ends ? first_albedo : weight / max(survival, 1e-30);
        if (ends) {
            at = first;
            bounce = 0;
            ++path;
        }
        goes_on = path < u_sample_count;
    }
    return sum;
}

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float count = float(u_sample_count);
    if (gbuffer_z_vs(pixel) > 0.0) {
        RaySurface first = ray_surface_at(pixel);
        vec3 albedo = texelFetch(t_albedo, pixel, 0).rgb;
        vec3 emission = texelFetch(t_emission, pixel, 0).rgb;
        vec3 sum = traced_radiance(first, albedo, pixel_seed(pixel));
        o_sum = vec4(sum + emission * count, count);
    } else {
        vec3 ray_ws = u_ns_from_vs * normalize(view_ray_at(uv_of_texel(pixel)));
        o_sum = vec4(environment_radiance(ray_ws) * count, 0.0);
    }
}

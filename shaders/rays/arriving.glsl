// Radiance along per-pixel rays, and the points of a sequence that they are drawn from.
//
// Needs rays/surface_cache.glsl, lib/gbuffer.glsl, lib/environment.glsl and lib/random.glsl.
// BRIGHT_PIECES: 0 or 1: rays are aimed at bright pieces, too. OPENINGS: how many there are through which
// a room sees the sky; rays are aimed at them.
#include "lib/z_curve.glsl"
#include "rays/bright_pieces.glsl"
#include "rays/openings.glsl"
// Rays are aimed at the sky.
#define SKY_RAYS (ENVIRONMENT_KIND == 3 || OPENINGS)

uniform float u_radius_ns;
uniform int u_sky_rays;  // of each pixel, aimed at openings or at what is bright in an image of the sky

// Sums over rays.
struct Arriving {
    vec3 far;
    vec3 near;
    float open_sky;
    float blocked_sky;
    float all_sky;  // one ray's, if nothing blocked any; all colours together
};

Arriving nothing_yet(vec3 n_vs)
{
    float sky = dot(environment_irradiance(direction_ws_of(n_vs)), vec3(INV_PI));
    return Arriving(vec3(0.0), vec3(0.0), 0.0, 0.0, sky);
}

#if SKY_RAYS
struct SkyRay {
    vec3 w;
    float sky;  // what it brings if nothing blocks it, alone and all colours together; 0: there is none
};
#endif

#if OPENINGS
// Of the light of the sky along w the part that rays bring which are aimed at it, where others go there with
// that density over solid angle, all together (the balance heuristic: Veach, Guibas 1995).
float share_of_sky_rays(LitPoint at, vec3 w, float found, float all_sky)
{
    float aimed = float(u_sky_rays) * density_of_openings(at.p, at.normal, w, weight_of_openings(at.p, at.normal));
    return aimed / max(aimed + found, 1e-30);
}

SkyRay sky_ray(LitPoint at, uint index)
{
    float sum = weight_of_openings(at.p, at.normal);
    float choice = random_2d(index, u_stream, 3u, false).x;
    vec3 w = towards_opening(at.p, at.normal, choice, random_2d(index, u_stream, 4u, false), sum);
    float sent = INV_PI * max(dot(w, at.normal), 0.0) * dot(environment_radiance(w), vec3(1.0));
    return SkyRay(w, sent / max(density_of_openings(at.p, at.normal, w, sum), 1e-30));
}
#elif ENVIRONMENT_KIND == 3
// Directions of which a ray aimed at the sky takes one.
const int SKY_CHOICES = 4;

// As with openings.
float share_of_sky_rays(LitPoint at, vec3 w, float found, float all_sky)
{
    float cosine = max(dot(w, at.normal), 0.0);
    float aimed = float(u_sky_rays) * INV_PI * cosine * dot(environment_radiance(w), vec3(1.0));
    return aimed / max(aimed + found * all_sky, 1e-30);
}

// Drawn by what the sky sends along it times the cosine: of some directions drawn by what it sends one
// by the rest (resampling: Talbot, Cline, Egbert 2005).
SkyRay sky_ray(LitPoint at, uint index)
{
    vec2 choice = random_2d(index, u_stream, 3u, false);
    vec2 u = random_2d(index, u_stream, 4u, false);
    SkyRay ray = SkyRay(at.normal, 0.0);
    float sum = 0.0;
    for (int i = 0; i < SKY_CHOICES; ++i) {
        LightSample light = sample_map(vec2((choice.x + float(i)) / float(SKY_CHOICES), choice.y), u);
        float sky = INV_PI * max(dot(light.w, at.normal), 0.0) * dot(light.radiance, vec3(1.0));
        sum += sky;
        float part = sky / max(sum, 1e-30);
        bool takes = u.x < part;
        ray.w = takes ? light.w : ray.w;
        u.x = clamp(takes ? u.x / part : (u.x - part) / (1.0 - part), 0.0, 1.0 - FLOAT_EPSILON);
    }
    ray.sky = sum / float(SKY_CHOICES);
    return ray;
}
#endif

#if SKY_RAYS
// As one of u_sky_rays beside `ray_count` others, which go along it with the density `found`.
void add_sky_ray(inout Arriving sums, LitPoint at, SkyRay ray, vec3 geometric, float found, int ray_count)
{
    if (!(ray.sky > 0.0 && dot(ray.w, geometric) > 0.0))
        return;
    float share = share_of_sky_rays(at, ray.w, found, sums.all_sky);
    float sky = ray.sky * share * float(ray_count) / float(u_sky_rays);
    bool is_blocked = bvh_is_blocked(at.p, ray.w, RAY_FAR);
    sums.open_sky += is_blocked ? 0.0 : sky;
    sums.blocked_sky += is_blocked ? sky : 0.0;
}
#endif

// Along w_vs, or mirrored to above the facet of a smooth shape, as SSDO does; `at` is where ray_start_vs
// and the shading normal say. With bright pieces it is one of `ray_count`, drawn 1 / `weight` times as
// often as by the cosine, and of what other rays are aimed at it brings its part alone.
void add_ray(inout Arriving sums, LitPoint at, vec3 w_vs, vec3 geometric_vs, float weight, int ray_count)
{
    w_vs -= 2.0 * min(dot(w_vs, geometric_vs), 0.0) * geometric_vs;
    vec3 w = u_ns_from_vs * w_vs;
    float sky = weight * dot(environment_radiance(direction_ws_of(w_vs)), vec3(1.0));
#if SKY_RAYS || BRIGHT_PIECES
    float cosine = max(dot(w, at.normal), 0.0);
    float found = float(ray_count) * cosine * INV_PI / max(weight, 1e-30);
#endif
#if SKY_RAYS
    sky *= 1.0 - share_of_sky_rays(at, w, found, sums.all_sky);
#endif
    BvhHit hit = bvh_nearest(at.p, w, RAY_FAR);
    if (hit.record < 0) {
        sums.open_sky += sky;
        return;
    }
    sums.blocked_sky += sky;
    Surface met = surface_at_hit(hit, at.p, w);
    bool is_lamp = counts_as_direct(met.flags, met.mean_emission);
    ivec2 surfel = surfel_met(hit, met, w);
    vec3 sent = reflection_of(cached_light(surfel), surfel, met);
#if BRIGHT_PIECES
    sent *= share_of_found(at, w, surfel, found);
#endif
    sent += is_lamp ? vec3(0.0) : met.emission;
    bool is_near = hit.t < u_radius_ns;
    sums.near += is_near ? weight * sent : vec3(0.0);
    sums.far += is_near ? vec3(0.0) : weight * sent;
}

#if BRIGHT_PIECES
// What a ray aimed at a bright piece brings, towards which others go with that density over solid angle,
// all together.
void add_aimed_ray(inout Arriving sums, LitPoint at, AimedRay ray, vec3 geometric, float found)
{
    float cosine = dot(ray.w, at.normal);
    if (!(ray.density > 0.0 && cosine > 0.0 && dot(ray.w, geometric) > 0.0))
        return;
    BvhHit hit = bvh_nearest(at.p, ray.w, RAY_FAR);
    if (hit.record < 0)
        return;
    Surface met = surface_at_hit(hit, at.p, ray.w);
    ivec2 surfel = surfel_met(hit, met, ray.w);
    if (surfel != ray.surfel)
        return;
    float weight = cosine * INV_PI * ray.weight * share_of_aimed(ray, found);
    vec3 sent = weight * reflection_of(cached_light(surfel), surfel, met);
    bool is_near = hit.t < u_radius_ns;
    sums.near += is_near ? sent : vec3(0.0);
    sums.far += is_near ? vec3(0.0) : sent;
}
#endif

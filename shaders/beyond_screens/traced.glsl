// What lobes meet, by rays, in the light of the surface cache; what they meet reflects on where
// it is a mirror, or nearly so.
//
// MIRROR_BOUNCES: how often; 0: what glossy surfaces reflect counts as diffuse. Others as in
// rays/surface_data.glsl.
#include "rays/emitters.glsl"
#include "rays/surface_cache.glsl"
#include "lib/random.glsl"
#include "rays/glow_in_lobes.glsl"

uniform float u_mirror_roughness;  // of surfaces that reflect on

const bool TRACES_SMOOTH = true;

// Highlights of lights that no ray can meet are no narrower: directions would miss them, or find
// them far too bright.
const float LEAST_HIGHLIGHT = 0.01;
// Radiance of such a highlight, relative to the light that the cache has there.
const float BRIGHTEST = 16.0;
// A mirror that is seen in a rougher one is at least that share as rough: by chance few rays come upon a
// lamp in it, which are specks; and lamps are drawn by its lobe (after Kaplanyan, Dachsbacher 2013).
const float LEAST_ROUGHNESS = 0.7;
const uint DIMENSIONS_PER_MIRROR = 3u;
// Light that differs by more has an edge there: it is not noise.
const float MOST_NOISE = 0.6;

// Where a path from mirror to mirror has come to.
struct MirrorPath {
    vec3 start;
    vec3 w;
    vec3 weight;  // of what arrives along w
    float alpha;  // width of the lobe that w stands for
    float density;  // over solid angle, of drawing w from the last mirror's lobe
    float roughness;  // of what it meets, at least
};

// A ray to a light, and what the last mirror reflects of it unless the ray is blocked.
struct MirroredLight {
    LightRay ray;
    float sides;     // that it meets
    vec3 reflected;
    vec3 all;        // where rays of the lobe do not meet it
};

const LightRay NO_RAY = LightRay(vec3(0.0), vec3(0.0, 0.0, 1.0), -1.0);
const MirroredLight NO_MIRRORED = MirroredLight(NO_RAY, SIDES_TO_LIGHT, vec3(0.0), vec3(0.0));

float balance(float mine, float other)
{
    return mine / max(mine + other, 1e-30);
}

// Of one light, drawn by chance. One that rays of the lobe may meet, too, is weighed against them
// by the balance heuristic (Veach 1997); a map of the sky is theirs.
MirroredLight mirrored_light(Surface met, vec3 irradiance, uint index, uint seed, uint dimension)
{
    vec2 choice = random_2d(index, seed, dimension, false);
    vec2 u = random_2d(index, seed, dimension + 1u, false);
    EmitterGroup group = draw_emitter_group(choice.x);
    LightSample light = sample_group(group, choice, u, met.at.start);
    bool is_met = light.density > 0.0 && group.shadow != EMITTER_UNSHADOWED;
    Emitter e = emitter_at(group.first);
    Brdf brdf = met.brdf;
    float weight = 1.0;
    if (is_met) {
        float scattered = gloss_density(brdf, met.at.normal, met.at.w_out, light.w);
        weight = balance(light.density * group.probability, scattered);
    } else {
        // The lobe widens by how large the light seems to the facets, as if it was a disk.
        float solid_angle = largest_of(light.radiance) / max(largest_of(e.power.rgb), 1e-30);
        float size_2 = e.kind < EMITTER_MAP ? solid_angle * INV_PI : e.edge_v.x * e.edge_v.x;
        float alpha = max(alpha_of(brdf.roughness), LEAST_HIGHLIGHT);
        brdf.roughness = min(sqrt(sqrt(alpha * alpha + 0.25 * size_2)), 1.0);
    }
    vec3 response = gloss_times_cosine(brdf, met.at.normal, met.at.w_out, light.w);
    response *= e.kind == EMITTER_MAP ? 0.0 : 1.0 / max(group.probability, 1e-30);
    vec3 all = unblocked_light(met.at, light, response);
    // Chance draws one of many lights as if it was all of them: bright, but no speck.
    float brightest = BRIGHTEST * largest_of(irradiance);
    float bound = min(brightest / max(largest_of(all), 1e-30), 1.0);
    float reach = needed_reach(group, light, all, RAY_FAR);
    return MirroredLight(light_ray(met.at, light.w, reach), is_met ? ALL_SIDES : SIDES_TO_LIGHT,
                         all * (is_met ? weight : bound), all * bound);
}

// What the `surfel` receives that the path number `index` of the pixel met along `w`, or one beside it,
// which it then stands for: each has the noise of its own rays, and a mirror would show them one by
// one. Four paths take those around, the same four in all pixels and frames, so that nothing flickers.
vec4 light_around(BvhHit hit, Surface met, vec3 w, uint index, inout ivec2 surfel)
{
    vec4 light = cached_light(surfel);
#if SAMPLE_COUNT >= 4
    vec2 aside = vec2(ivec2(index >> 1u, index) & 1) - 0.5;
    aside += 0.5 * vec2(-aside.y, aside.x);
    ivec2 other = surfel_texel(surfel_beside_hit(hit, met.at.position, w, aside));
    vec4 there = cached_light(other);
    float most = largest_of(max(there.rgb, light.rgb));
    if (largest_of(abs(there.rgb - light.rgb)) < MOST_NOISE * most) {
        surfel = other;
        light = there;
    }
#endif
    return light;
}

// What a surface emits that a ray along `path` met, and no light delivers already: lamps are
// reflected as lights.
vec3 emitted(Surface met, BvhHit hit, MirrorPath path, bool is_first)
{
    bool is_lamp = (met.flags & LIGHT_BODY_FLAG) != 0u;
    if (is_dark(met.emission) || met_light_is_blocked(path.start, path.w, hit.t))
        return vec3(0.0);
#if GLOW_IS_DIRECT && SUMS_PANELS
    if (is_first && glow_place(hit).x >= 0)
        return vec3(0.0);
#elif GLOW_IS_DIRECT
    if (is_first && met.mean_emission > 0.0) {
        ivec2 texel = receiver_texel(ivec2(gl_FragCoord.xy));
        float chosen = glow_density(lit_point_of_lobe(path.start, texel), hit, met);
        if (chosen >= 0.0)
            return balance(path.density * float(SAMPLE_COUNT), chosen * float(u_glow_rays)) * met.emission;
    }
#endif
    float share = is_first ? 1.0 : balance(path.density, drawn_density(met, hit.t));
    return is_lamp && (is_first || is_unshadowed_body(met.flags)) ? vec3(0.0) : share * met.emission;
}

void reflect_on(inout MirrorPath path, Surface met, vec2 u)
{
    BrdfSample facet = gloss_sample(met.brdf, met.at.normal, met.at.w_out, u);
    vec3 w = facet.w_in;
    // Facets of what stands for a smooth surface do not hide each other.
    w -= min(2.0 * dot(w, met.at.geometric), 0.0) * met.at.geometric;
    float alpha = alpha_of(met.brdf.roughness) * inversesqrt(float(SAMPLE_COUNT));
    path = MirrorPath(met.at.start, w, path.weight * facet.weight, alpha, facet.density,
                      LEAST_ROUGHNESS * met.brdf.roughness);
}

// Radiance along `w_vs`, drawn with that density from a lobe of that roughness, by the path number
// `index` of the pixel; false where only the sky is.
bool meets_by_ray(vec3 p_vs, vec3 geometric_vs, vec3 w_vs, float density, float roughness,
                  uint index, out vec3 radiance)
{
    vec3 start = ray_start_vs(p_vs, geometric_vs);
    MirrorPath path = MirrorPath(start, u_ns_from_vs * w_vs, vec3(1.0), 0.0, density,
                                 LEAST_ROUGHNESS * roughness);
    uint seed = pixel_seed(ivec2(gl_FragCoord.xy));
    MirroredLight light = NO_MIRRORED;
    radiance = vec3(0.0);
    int bounce = 0;
    bool goes_on;
    do {
        bool is_blocked;
        BvhHit hit = bvh_blocked_and_nearest(
            bvh_ray_to_light(light.ray.start, light.ray.w, light.sides), light.ray.t_max,
            path.start, path.w, RAY_FAR, is_blocked);
        radiance += light_past_sheets(light.ray, is_blocked, light.reflected, light.all);
        light = NO_MIRRORED;
        if (hit.record < 0) {
            radiance += bounce > 0 ? path.weight * lobe_radiance(path.w, path.alpha) : vec3(0.0);
            return bounce > 0;
        }
        Surface met = surface_at_hit(hit, path.start, path.w);
        radiance += path.weight * emitted(met, hit, path, bounce == 0);
        goes_on = bounce < MIRROR_BOUNCES && is_glossy(met.brdf)
               && met.brdf.roughness <= u_mirror_roughness;
        ivec2 surfel = surfel_met(hit, met, path.w);
        vec4 cached = light_around(hit, met, path.w, index, surfel);
        if (goes_on) {
            met.brdf.roughness = min(max(met.brdf.roughness, path.roughness), u_mirror_roughness);
            vec3 n = met.at.normal;
            uint dimension = DIMENSIONS_PER_MIRROR * uint(bounce);
            radiance += path.weight * diffuse_radiance_towards(met.brdf, n, met.at.w_out, cached.rgb);
            light = mirrored_light(met, cached.rgb, index, seed, dimension);
            light.reflected *= path.weight;
            light.all *= path.weight;
            reflect_on(path, met, random_2d(index, seed, dimension + 2u, false));
            ++bounce;
        } else {
            radiance += path.weight * reflection_of(cached, surfel, met);
        }
    } while (goes_on);
    return true;
}

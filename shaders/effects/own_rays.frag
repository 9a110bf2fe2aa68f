#version 330 core
// Per-pixel rays: the light that a pixel's rays gather, a texel for each such pixel. What is far more
// than probes have found, by rays that came upon light which the guide thought improbable, is told
// apart (after Zirr, Hanika, Dachsbacher 2018).
//
// Defines: ENVIRONMENT_KIND (see lib/environment.glsl); PROBE_TILE, PROBE_SIDE (see
// lib/far_probes.glsl); BRIGHT_PIECES, OPENINGS (see rays/arriving.glsl); as in rays/surface_data.glsl.
#include "rays/surface_cache.glsl"
#include "lib/environment.glsl"
#include "lib/random.glsl"
#include "lib/pixel_centre.glsl"
#include "rays/arriving.glsl"
#include "rays/guide.glsl"

uniform sampler2D t_own_pixels;  // column and row of the pixel in the frame; -1: none
uniform int u_many_rays;         // of the first u_many_count pixels
uniform int u_few_rays;          // of all others
uniform int u_many_count;

// As rays/shared_rays.glsl says, a texel for each such pixel; o_near.a is never negative.
layout(location = 0) out vec4 o_far;
layout(location = 1) out vec4 o_near;
// Radiance that counts for pixels far about, a: whose of the tile's probes is the pixel's surface,
// or IN_MORE_LIGHT.
layout(location = 2) out vec4 o_rare;
// Of one ray, all colours together, within R and beyond, less what is rare: mean and variance. b: the
// share of the sky's light that rays aimed at openings have brought, which o_far leaves out.
layout(location = 3) out vec4 o_light;
#if BRIGHT_PIECES
// Beyond R, by rays aimed at bright pieces: less noisy than o_far.
layout(location = 4) out vec4 o_aimed;
#endif

// Times what probes have found, above which it is rare. Of 2 and 4.5 neither is better.
const float RARE = 3.0;
// As many of a pixel's rays, each counted by its part, do not come upon light by chance: it is the
// pixel's own, and probes on the same plane stand beyond a partition.
const float SURE_RAYS = 3.0;

// The share of the sky's light that arrives: as much as was found open, or all but what was found
// blocked. That is exact where all is open, and falls below 0 where little is. An image may have most
// of its light in one place, which few pixels' rays come upon: these bring that of the others, too.
float open_share(Arriving sums, float open, int ray_count)
{
    float all = sums.all_sky * float(ray_count);
    float mostly_open = open * open * open * open;
    float arrived = mix(sums.open_sky, all - sums.blocked_sky, mostly_open);
    float share = all > 0.0 ? arrived / all : 0.0;
#if ENVIRONMENT_KIND == 3
    return share;
#else
    return clamp(share, 0.0, 1.0);
#endif
}

#if BRIGHT_PIECES
Arriving aimed_light(LitPoint at, vec3 geometric, mat3 frame, Guide guide, ivec2 texel, int ray_count)
{
    mat3 own_from_ns = transpose(u_ns_from_vs * frame);
    uint first = first_point(texel, u_aimed_rays);
    Arriving sums = Arriving(vec3(0.0), vec3(0.0), 0.0, 0.0, 0.0);
    for (int i = 0; i < u_aimed_rays; ++i) {
        AimedRay ray = aimed_ray(at, first + uint(i), 1u);
        vec3 w = own_from_ns * ray.w;
        float found = float(ray_count) * max(w.z, 0.0) * INV_PI * guided_share(guide, w);
        add_aimed_ray(sums, at, ray, geometric, found);
    }
    sums.far /= float(u_aimed_rays);
    sums.near /= float(u_aimed_rays);
    return sums;
}
#endif

void main()
{
    ivec2 place = ivec2(gl_FragCoord.xy);
    ivec2 texel = ivec2(texelFetch(t_own_pixels, place, 0).xy);
    o_far = vec4(0.0);
    o_near = vec4(0.0);
    o_rare = vec4(0.0);
    o_light = vec4(0.0);
#if BRIGHT_PIECES
    o_aimed = vec4(0.0);
#endif
    if (texel.x < 0)
        return;
    int number = place.y * textureSize(t_own_pixels, 0).x + place.x;
    int ray_count = number < u_many_count ? u_many_rays : u_few_rays;
    vec3 p_vs = gbuffer_position_vs(texel);
    vec3 geometric_vs = gbuffer_geometric_normal_vs(texel);
    vec3 n_vs = gbuffer_shading_normal_vs(texel);
    mat3 frame = frame_from_z(n_vs);
    LitPoint at = lit_point(ray_start_vs(p_vs, geometric_vs), u_ns_from_vs * n_vs);
    Guide guide = guide_at(texel, p_vs, n_vs);
    uint first = first_point(texel, ray_count);
    Arriving sums = nothing_yet(n_vs);
    float brought = 0.0;
    float squares = 0.0;
    vec2 all = vec2(0.0);  // light of all rays, and its squares
    for (int i = 0; i < ray_count; ++i) {
        Guided d = guided_direction(guide, random_2d(first + uint(i), u_stream, 0u, false));
        add_ray(sums, at, frame * d.w, geometric_vs, d.weight, ray_count);
        float by_ray = dot(sums.far, vec3(1.0)) + sums.open_sky - brought;
        brought += by_ray;
        squares += by_ray * by_ray;
        float of_ray = dot(sums.far + sums.near, vec3(1.0)) + sums.open_sky - all.x;
        all += of_ray * vec2(1.0, of_ray);
    }
    float by_chance = sums.open_sky;
#if SKY_RAYS
    mat3 own_from_ns = transpose(u_ns_from_vs * frame);
    uint first_sky = first_point(texel, u_sky_rays);
    for (int j = 0; j < u_sky_rays; ++j) {
        SkyRay ray = sky_ray(at, first_sky + uint(j));
        vec3 w = own_from_ns * ray.w;
        float found = float(ray_count) * max(w.z, 0.0) * INV_PI * guided_share(guide, w);
        add_sky_ray(sums, at, ray, u_ns_from_vs * geometric_vs, found, ray_count);
    }
#endif
    float bringing = brought * brought / max(squares, 1e-30);
    vec3 far = sums.far / float(ray_count);
    float share = open_share(sums, guide.open, ray_count);
    // What rays aimed at openings have brought is never rare, and less noisy.
    float aimed_share = 0.0;
#if OPENINGS
    sums.open_sky -= by_chance;
    aimed_share = min(open_share(sums, 0.0, ray_count), share);
    share -= aimed_share;
#endif
    o_near = vec4(sums.near / float(ray_count), centre_z_vs(texel, p_vs, geometric_vs));
    // What probes have missed few rays come upon, and bring much: dots, were it the pixel's alone.
    vec3 sky = INV_PI * environment_irradiance(direction_ws_of(n_vs));
    float known = guide.sent + guide.seen * dot(sky, vec3(1.0 / 3.0));
    float found = dot(far + share * sky, vec3(1.0 / 3.0));
    float owner = guide.sent < 0.0 ? NO_PROBE : probe_of_tile(texel, p_vs, n_vs);
    float kept = owner != NO_PROBE && found > RARE * known ? RARE * known / found : 1.0;
    bool is_own = kept < 1.0 && bringing > SURE_RAYS;
    kept = is_own ? 1.0 : kept;
    owner = is_own ? IN_MORE_LIGHT : owner;
    float n = float(ray_count);
    // One ray alone might be any.
    float variance = ray_count > 1 ? max(all.y - all.x * all.x / n, 0.0) / (n - 1.0) : all.y;
    o_light = vec4(kept * all.x / n, kept * kept * variance, aimed_share, 0.0);
    o_far = kept * vec4(far, share);
    o_rare = vec4((1.0 - kept) * (far + share * sky), owner);
#if BRIGHT_PIECES
    Arriving aimed = aimed_light(at, u_ns_from_vs * geometric_vs, frame, guide, texel, ray_count);
    o_aimed = vec4(aimed.far, 0.0);
    o_near.rgb += aimed.near;
#endif
}

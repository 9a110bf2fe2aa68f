#version 330 core
// All that arrives at pixels, by rays of their own: a texel for each such pixel.
//
// Defines: ENVIRONMENT_KIND (see lib/environment.glsl); PROBE_TILE, PROBE_SIDE (see
// lib/far_probes.glsl); as in rays/surface_data.glsl.
#include "rays/surface_cache.glsl"
#include "lib/environment.glsl"
#include "lib/random.glsl"
#include "lib/pixel_centre.glsl"
#include "rays/guide.glsl"

uniform sampler2D t_own_pixels;  // column and row of the pixel in the frame; -1: none
uniform float u_radius_ns;
uniform int u_many_rays;         // of the first u_many_count pixels
uniform int u_few_rays;          // of all others
uniform int u_many_count;

// As lib/own_rays.glsl says.
layout(location = 0) out vec4 o_far;
layout(location = 1) out vec4 o_near;

// Sums over rays.
struct Arriving {
    vec3 far;
    vec3 near;
    float open_sky;
    float blocked_sky;
};

// Leaves room for another bit after each of the lower sixteen.
uint spread_bits(uint x)
{
    x = (x | x << 8) & 0x00ff00ffu;
    x = (x | x << 4) & 0x0f0f0f0fu;
    x = (x | x << 2) & 0x33333333u;
    return (x | x << 1) & 0x55555555u;
}

// Pixels take their points from one sequence in the order of their Z-curve, so that those of every
// block are spread evenly, which the filter averages (Ahmed, Wonka 2020). Without the order
// relMSE is .0033 for .0018 in an attic, .0129 for .0098 in a cellar (four rays, not guided).
uint first_point(ivec2 texel, int ray_count)
{
    return (spread_bits(uint(texel.x)) | spread_bits(uint(texel.y)) << 1) * uint(ray_count);
}

void add_ray(inout Arriving sums, vec3 start, vec3 w_vs, float weight)
{
    vec3 w = u_ns_from_vs * w_vs;
    float sky = weight * dot(environment_radiance(direction_ws_of(w_vs)), vec3(1.0));
    BvhHit hit = bvh_nearest(start, w, RAY_FAR);
    if (hit.record < 0) {
        sums.open_sky += sky;
        return;
    }
    sums.blocked_sky += sky;
    Surface met = surface_at_hit(hit, start, w);
    bool is_lamp = (met.flags & LIGHT_BODY_FLAG) != 0u;
    vec3 sent = cached_reflection(hit, met, w) + (is_lamp ? vec3(0.0) : met.emission);
    bool is_near = hit.t < u_radius_ns;
    sums.near += is_near ? weight * sent : vec3(0.0);
    sums.far += is_near ? vec3(0.0) : weight * sent;
}

// The share of the sky's light that arrives: as much as was found open, or all but what was found
// blocked. That is exact where all is open, and falls below 0 where little is.
float open_share(Arriving sums, float open, vec3 n_vs, int ray_count)
{
    float all = dot(environment_irradiance(direction_ws_of(n_vs)), vec3(INV_PI)) * float(ray_count);
    float mostly_open = open * open * open * open;
    float arrived = mix(sums.open_sky, all - sums.blocked_sky, mostly_open);
    return all > 0.0 ? clamp(arrived / all, 0.0, 1.0) : 0.0;
}

void main()
{
    ivec2 place = ivec2(gl_FragCoord.xy);
    ivec2 texel = ivec2(texelFetch(t_own_pixels, place, 0).xy);
    o_far = vec4(0.0);
    o_near = vec4(0.0);
    if (texel.x < 0)
        return;
    int number = place.y * textureSize(t_own_pixels, 0).x + place.x;
    int ray_count = number < u_many_count ? u_many_rays : u_few_rays;
    vec3 p_vs = gbuffer_position_vs(texel);
    vec3 geometric_vs = gbuffer_geometric_normal_vs(texel);
    vec3 n_vs = gbuffer_shading_normal_vs(texel);
    mat3 frame = frame_from_z(n_vs);
    vec3 to_point = u_ns_from_vs * (p_vs * u_ns_per_unit);
    vec3 start = ray_start(u_eye_ns + to_point, u_ns_from_vs * geometric_vs,
                           viewing_direction(to_point, u_ns_from_vs * AHEAD_VS),
                           GBUFFER_ERROR * length(to_point) + RAY_OFFSET);
    Guide guide = guide_at(texel, p_vs, n_vs);
    uint first = first_point(texel, ray_count);
    Arriving sums = Arriving(vec3(0.0), vec3(0.0), 0.0, 0.0);
    for (int i = 0; i < ray_count; ++i) {
        Guided d = guided_direction(guide, random_2d(first + uint(i), u_stream, 0u, false));
        vec3 w_vs = frame * d.w;
        // As SSDO does, below the facet of a smooth shape.
        w_vs -= 2.0 * min(dot(w_vs, geometric_vs), 0.0) * geometric_vs;
        add_ray(sums, start, w_vs, d.weight);
    }
    o_far = vec4(sums.far / float(ray_count), open_share(sums, guide.open, n_vs, ray_count));
    o_near = vec4(sums.near / float(ray_count), centre_z_vs(texel, p_vs, geometric_vs));
}

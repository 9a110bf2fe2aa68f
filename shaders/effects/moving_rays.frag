#version 330 core
// Per-pixel rays while the camera moves: all light that a pixel receives, by a few rays.
//
// Defines: SHARES_RAYS 1: at rest, where a frame shows a surface that those which share their rays have
// none of; ENVIRONMENT_KIND (see lib/environment.glsl); BRIGHT_PIECES, OPENINGS (see rays/arriving.glsl);
// as in rays/surface_data.glsl.
#include "rays/surface_cache.glsl"
#include "lib/environment.glsl"
#include "lib/random.glsl"
#include "lib/sampling.glsl"
#include "lib/pixel_centre.glsl"
#include "lib/gbuffer.glsl"
#include "lib/ray_blocks.glsl"
#include "rays/arriving.glsl"
#include "rays/shared_rays.glsl"

uniform float u_sky;             // its mean radiance
uniform int u_receiver_stride;  // pixels from one that light is gathered at to the next

// As rays/shared_rays.glsl says.
layout(location = 0) out vec4 o_far;
layout(location = 1) out vec4 o_near;
#if SHARES_RAYS
uniform int u_ray_count;  // of pixels that share none
#else
layout(location = 2) out vec2 o_light;  // as t_own_light of effects/moving_guide.frag
#endif

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    o_far = vec4(0.0);
    o_near = vec4(0.0);
#if !SHARES_RAYS
    o_light = vec2(0.0);
#endif
    if (gbuffer_z_vs(texel) <= 0.0 || texel % u_receiver_stride != ivec2(0))
        return;
    vec3 p_vs = gbuffer_position_vs(texel);
    vec3 geometric_vs = gbuffer_geometric_normal_vs(texel);
#if SHARES_RAYS
    ivec2 known = texel_of_rays(texel, u_receiver_stride, p_vs, geometric_vs);
    if (known.x >= 0) {
        o_far = texelFetch(t_own_far, known, 0);
        o_near = texelFetch(t_own_near, known, 0);
        return;
    }
    const bool is_edge = false;
    int ray_count = u_ray_count;
#else
    bool is_edge = texelFetch(t_numbers, texel, 0).x < 0;
    int ray_count = number_of_rays(texel);
#endif
    vec3 n_vs = gbuffer_shading_normal_vs(texel);
    mat3 frame = frame_from_z(n_vs);
    LitPoint at = lit_point(ray_start_vs(p_vs, geometric_vs), u_ns_from_vs * n_vs);
    uint first = first_point(texel / u_receiver_stride, ray_count);
    Arriving sums = nothing_yet(n_vs);
    int i = 0;
    do {
        vec2 u = random_2d_in_step(first, uint(i), uint(ray_count), u_stream, 0u);
        add_ray(sums, at, frame * cosine_hemisphere(u), geometric_vs, 1.0, ray_count);
    } while (++i < ray_count);
#if SKY_RAYS
    uint first_sky = first_point(texel / u_receiver_stride, u_sky_rays);
    for (int j = 0; j < u_sky_rays; ++j) {
        SkyRay ray = sky_ray(at, first_sky + uint(j));
        float found = float(ray_count) * max(dot(ray.w, at.normal), 0.0) * INV_PI;
        add_sky_ray(sums, at, ray, u_ns_from_vs * geometric_vs, found, ray_count);
    }
#endif
    float inverse = 1.0 / float(ray_count);
    vec3 far = inverse * sums.far;
    vec3 near = inverse * sums.near;
#if BRIGHT_PIECES
    Arriving aimed = nothing_yet(n_vs);
    uint first_aimed = first_point(texel / u_receiver_stride, u_aimed_rays);
    for (int j = 0; j < u_aimed_rays; ++j) {
        AimedRay ray = aimed_ray(at, first_aimed + uint(j), 1u);
        float found = float(ray_count) * max(dot(ray.w, at.normal), 0.0) * INV_PI;
        add_aimed_ray(aimed, at, ray, u_ns_from_vs * geometric_vs, found);
    }
    far += aimed.far / float(u_aimed_rays);
    near += aimed.near / float(u_aimed_rays);
#endif
    // A ratio, which is exact where all of the sky is open.
    float open = sums.open_sky / max(sums.open_sky + sums.blocked_sky, 1e-37);
#if OPENINGS
    // But biased where little is, and a ray or two are aimed at it.
    float arrived = sums.open_sky / max(sums.all_sky * float(ray_count), 1e-37);
    open = mix(min(arrived, 1.0), open, open * open * open * open);
#endif
    o_far = vec4(far, open);
    float z = centre_z_vs(texel, p_vs, geometric_vs);
    o_near = vec4(near, is_edge ? -z : z);
#if !SHARES_RAYS
    o_light = vec2(dot(far + near, vec3(1.0 / 3.0)) + u_sky * open, is_edge ? -1.0 : 1.0);
#endif
}

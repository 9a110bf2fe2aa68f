#version 330 core
// All that arrives at pixels that a neighbour in front may shade, by rays of their own: a texel
// for each such pixel.
//
// Defines: ENVIRONMENT_KIND (see lib/environment.glsl); as in rays/surface_data.glsl.
#include "rays/surface_cache.glsl"
#include "lib/environment.glsl"
#include "lib/random.glsl"

uniform sampler2D t_edge_pixels;  // column and row of the pixel in the frame; -1: none
uniform float u_radius_ns;
uniform int u_ray_count;

// As lib/edge_rays.glsl says.
layout(location = 0) out vec4 o_far;
layout(location = 1) out vec4 o_near;

struct Arriving {
    vec3 far;
    vec3 near;
    float open_sky;
    float whole_sky;
};

void add_ray(inout Arriving sums, vec3 start, vec3 w_vs)
{
    vec3 w = u_ns_from_vs * w_vs;
    float sky = dot(environment_radiance(direction_ws_of(w_vs)), vec3(1.0));
    sums.whole_sky += sky;
    BvhHit hit = bvh_nearest(start, w, RAY_FAR);
    if (hit.record < 0) {
        sums.open_sky += sky;
        return;
    }
    Surface met = surface_at_hit(hit, start, w);
    bool is_lamp = (met.flags & LIGHT_BODY_FLAG) != 0u;
    vec3 sent = cached_reflection(hit, met, w) + (is_lamp ? vec3(0.0) : met.emission);
    bool is_near = hit.t < u_radius_ns;
    sums.near += is_near ? sent : vec3(0.0);
    sums.far += is_near ? vec3(0.0) : sent;
}

void main()
{
    ivec2 texel = ivec2(texelFetch(t_edge_pixels, ivec2(gl_FragCoord.xy), 0).xy);
    o_far = vec4(0.0);
    o_near = vec4(0.0);
    if (texel.x < 0)
        return;
    vec3 p_vs = gbuffer_position_vs(texel);
    vec3 geometric_vs = gbuffer_geometric_normal_vs(texel);
    mat3 frame = frame_from_z(gbuffer_shading_normal_vs(texel));
    vec3 to_point = u_ns_from_vs * (p_vs * u_ns_per_unit);
    vec3 start = ray_start(u_eye_ns + to_point, u_ns_from_vs * geometric_vs,
                           viewing_direction(to_point, u_ns_from_vs * AHEAD_VS),
                           GBUFFER_ERROR * length(to_point) + RAY_OFFSET);
    uint seed = pixel_seed(texel);
    Arriving sums = Arriving(vec3(0.0), vec3(0.0), 0.0, 0.0);
    for (int i = 0; i < u_ray_count; ++i) {
        vec3 w_vs = frame * cosine_hemisphere(random_2d(uint(i), seed, 0u, false));
        // As SSDO does, below the facet of a smooth shape.
        w_vs -= 2.0 * min(dot(w_vs, geometric_vs), 0.0) * geometric_vs;
        add_ray(sums, start, w_vs);
    }
    float open = sums.whole_sky > 0.0 ? sums.open_sky / sums.whole_sky : 0.0;
    o_far = vec4(sums.far / float(u_ray_count), open);
    o_near = vec4(sums.near / float(u_ray_count), -p_vs.z);
}

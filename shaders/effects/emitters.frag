#version 330 core
// Irradiance from glowing bodies that no light of the scene stands for: shadow rays to points of
// them, each chosen among all by how much of its light can arrive.
//
// Close to a body light changes within what the filter takes together. There rays agree, too, and
// all that comes from so near is kept apart from what is filtered.
//
// Defines: as in rays/surface_data.glsl.
#include "rays/emitter_tree.glsl"
#include "lib/random.glsl"
#include "lib/z_curve.glsl"

uniform int u_ray_count;
uniform ivec2 u_frame_number;  // number of the frame among those of its picture, and their count
uniform float u_near_reach;    // half of the light of a body so many pixels away is kept apart

layout(location = 0) out vec4 o_irradiance;
layout(location = 1) out vec4 o_near;

// How far apart on the surface neighbouring pixels lie, normalised frame.
float pixel_spacing(ivec2 texel, RaySurface surface)
{
    float z = gbuffer_z_vs(texel);
    return pixel_height_at(z) * u_ns_per_unit / max(dot(surface.geometric, surface.w_out), 0.05);
}

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    o_irradiance = o_near = vec4(0.0, 0.0, 0.0, 1.0);
    if (gbuffer_z_vs(texel) <= 0.0)
        return;
    RaySurface surface = ray_surface_at(texel);
    uint first = first_point(texel, u_ray_count * u_frame_number.y)
               + uint(u_ray_count * u_frame_number.x);
    float reach_of_near = u_near_reach * pixel_spacing(texel, surface);
    vec3 sum = vec3(0.0);
    vec3 near = vec3(0.0);
    int i = 0;
    do {
        vec2 choice = random_2d(first + uint(i), u_stream, 0u, false);
        vec2 u = random_2d(first + uint(i), u_stream, 1u, false);
        LightSample light = sample_tree(surface.start, surface.normal, choice, u);
        vec3 arriving = unblocked_irradiance(surface, light);
        float reach = is_dark(arriving) ? -1.0 : reach_toward_light(light.distance);
        arriving = light_is_blocked(surface, light.w, reach) ? vec3(0.0) : arriving;
        float far = light.distance / max(reach_of_near, 1e-30);
        float share = 1.0 / (1.0 + far * far * far * far);
        near += share * arriving;
        sum += (1.0 - share) * arriving;
    } while (++i < u_ray_count);
    o_irradiance.rgb = sum / float(u_ray_count);
    o_near.rgb = near / float(u_ray_count);
}

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
layout(location = 2) out vec2 o_light;  // of o_irradiance, all colours together, and its variance

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
    o_light = vec2(0.0);
    if (gbuffer_z_vs(texel) <= 0.0)
        return;
    RaySurface surface = ray_surface_at(texel);
    uint first = first_point(texel, u_ray_count * u_frame_number.y)
               + uint(u_ray_count * u_frame_number.x);
    float reach_of_near = u_near_reach * pixel_spacing(texel, surface);
    vec3 sum = vec3(0.0);
    vec3 near = vec3(0.0);
    float squares = 0.0;
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
        arriving *= 1.0 - share;
        float found = dot(arriving, vec3(1.0));
        squares += found * found;
        sum += arriving;
    } while (++i < u_ray_count);
    float n = float(u_ray_count);
    o_irradiance.rgb = sum / n;
    o_near.rgb = near / n;
    float all = dot(sum, vec3(1.0));
    // Of one ray nothing is known.
    float variance = max(squares - all * all / n, 0.0) / (n * (n - 1.0));
    o_light = vec2(all / n, u_ray_count > 1 ? variance : 1e30);
}

#version 330 core
// Irradiance from glowing bodies that no light of the scene stands for: shadow rays to points of
// them, each chosen among all by how much of its light can arrive.
//
// Defines: as in rays/surface_data.glsl.
#include "rays/emitter_tree.glsl"
#include "lib/random.glsl"
#include "lib/z_curve.glsl"

uniform int u_ray_count;
uniform ivec2 u_frame_number;  // number of the frame among those of its picture, and their count

layout(location = 0) out vec4 o_irradiance;

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    o_irradiance = vec4(0.0, 0.0, 0.0, 1.0);
    if (gbuffer_z_vs(texel) <= 0.0)
        return;
    RaySurface surface = ray_surface_at(texel);
    uint first = first_point(texel, u_ray_count * u_frame_number.y)
               + uint(u_ray_count * u_frame_number.x);
    vec3 sum = vec3(0.0);
    int i = 0;
    do {
        vec2 choice = random_2d(first + uint(i), u_stream, 0u, false);
        vec2 u = random_2d(first + uint(i), u_stream, 1u, false);
        LightSample light = sample_tree(surface.start, surface.normal, choice, u);
        vec3 arriving = unblocked_irradiance(surface, light);
        float reach = is_dark(arriving) ? -1.0 : reach_toward_light(light.distance);
        sum += light_is_blocked(surface, light.w, reach) ? vec3(0.0) : arriving;
    } while (++i < u_ray_count);
    o_irradiance.rgb = sum / float(u_ray_count);
}

#version 330 core
// Ray-traced visibility, (1 / pi) * integral of V_R(w) cos(theta): the share of cosine-
// distributed rays about the shading normal that meet nothing within R. Kept naive on
// purpose: the reference that screen-space estimators are measured against.
//
// Adds this draw's samples to the sum; defines as in rays/bvh.glsl.
#include "rays/ray.glsl"
#include "lib/random.glsl"

uniform float u_radius_ns;

layout(location = 0) out vec4 o_sum;

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float open = float(u_sample_count);  // what shows no surface sees the open sky
    if (gbuffer_z_vs(pixel) > 0.0) {
        RaySurface surface = ray_surface_at(pixel);
        mat3 frame = frame_from_z(surface.normal);
        uint seed = pixel_seed(pixel);
        int i = 0;
        do {
            vec2 u = random_2d(u_first_sample + uint(i), seed, 0u, true);
            vec3 w = ray_direction(surface, frame, u);
            open -= ray_is_blocked(surface, w, u_radius_ns) ? 1.0 : 0.0;
        } while (++i < u_sample_count);
    }
    o_sum = vec4(open, 0.0, 0.0, 0.0);
}

#version 330 core
// What each surfel sees: the triangle that one ray from each of its points meets.
//
// A tile of the image for each point. Words: 2 p + s for triangle s of primitive p, all bits set
// for none; bits of the distance, negative if it is met from behind. Defines as in rays/surface_data.glsl.
#include "rays/ray.glsl"
#include "lib/octahedral.glsl"
#include "lib/random.glsl"
#include "lib/sampling.glsl"

uniform usampler2D t_surfel_points;  // as in rays/surfel_points.glsl
uniform int u_surfel_rows;

layout(location = 0) out uvec2 o_met;

void main()
{
    ivec2 surfel = ivec2(gl_FragCoord.xy);
    int point = surfel.y / u_surfel_rows;
    surfel.y -= point * u_surfel_rows;
    uvec4 words = texelFetch(t_surfel_points, surfel + ivec2(0, point * u_surfel_rows), 0);
    vec3 normal = oct_unproject(vec2(words.w & 0xffffu, words.w >> 16) * (1.0 / 32767.0) - 1.0);
    vec2 u = random_2d(uint(point), pixel_seed(surfel), 0u, true);
    vec3 w = frame_from_z(normal) * cosine_hemisphere(u);
    BvhHit hit = bvh_nearest(uintBitsToFloat(words.xyz), w, RAY_FAR);
    o_met = uvec2(0xffffffffu, 0u);
    if (hit.record >= 0) {
        vec3 a, b, c;
        bvh_triangle(hit, a, b, c);
        bool is_behind = dot(triangle_normal(a, b, c), w) > 0.0;
        o_met = uvec2(bvh_texel(hit.record, 3).x * 2u + (hit.is_second ? 1u : 0u),
                      floatBitsToUint(is_behind ? -hit.t : hit.t));
    }
}

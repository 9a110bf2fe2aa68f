#version 330 core
// What rays from surfels meet that look for what stands around them: the triangle, and how far away.
//
// Words: 2 p + s for triangle s of primitive p, all bits set for none; bits of the distance, negative
// where it is met from behind. Defines as in rays/surface_data.glsl.
#include "rays/ray.glsl"

uniform sampler2D t_starts;
uniform sampler2D t_ways;  // xyz: unit; w: how far, negative: there is no ray

layout(location = 0) out uvec2 o_met;

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    vec4 way = texelFetch(t_ways, texel, 0);
    BvhHit hit = bvh_nearest(texelFetch(t_starts, texel, 0).xyz, way.xyz, way.w);
    o_met = uvec2(0xffffffffu, 0u);
    if (hit.record >= 0) {
        vec3 a, b, c;
        bvh_triangle(hit, a, b, c);
        bool is_behind = dot(triangle_normal(a, b, c), way.xyz) > 0.0;
        o_met = uvec2(bvh_texel(hit.record, 3).x * 2u + (hit.is_second ? 1u : 0u),
                      floatBitsToUint(is_behind ? -hit.t : hit.t));
    }
}

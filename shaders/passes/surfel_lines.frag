#version 330 core
// What stands on each surfel: the triangle that each line across it meets first, and where.
//
// A tile of the image for each line, first all forwards, then all backwards. Words: 2 p + s
// for triangle s of primitive p, all bits set for none; bits of the distance.
// Defines as in rays/surface_data.glsl.
#include "rays/ray.glsl"

uniform sampler2D t_surfel_ends;
uniform int u_surfel_rows;

layout(location = 0) out uvec2 o_met;

const int SURFEL_LINES = 8;

void main()
{
    ivec2 surfel = ivec2(gl_FragCoord.xy);
    int number = surfel.y / u_surfel_rows;
    surfel.y -= number * u_surfel_rows;
    int line = number % SURFEL_LINES;
    int from = 2 * line + number / SURFEL_LINES;
    int to = 2 * line + 1 - number / SURFEL_LINES;
    vec3 start = texelFetch(t_surfel_ends, surfel + ivec2(0, from * u_surfel_rows), 0).xyz;
    vec3 way = texelFetch(t_surfel_ends, surfel + ivec2(0, to * u_surfel_rows), 0).xyz - start;
    float reach = length(way);
    BvhHit hit = bvh_nearest(start, way / max(reach, 1e-30), reach > 0.0 ? reach : -1.0);
    uint slot = hit.record < 0 ? 0xffffffffu
        : bvh_texel(hit.record, 3).x * 2u + (hit.is_second ? 1u : 0u);
    o_met = uvec2(slot, floatBitsToUint(max(hit.t, 0.0)));
}

#version 330 core
// Which points of each surfel lie behind something flat, close before them or around them: a bit
// each. Pictures on a wall, panes of windows, rugs. Defines as in rays/surface_data.glsl.
#include "rays/ray.glsl"
#include "lib/octahedral.glsl"

uniform usampler2D t_surfel_points;  // as in rays/surfel_points.glsl
uniform int u_surfel_rows;

layout(location = 0) out uint o_covered;

const int SURFEL_POINTS = 16;
// Of the surfel's size. At .1 narrow gaps between walls, which also are flat, are as bright as
// what is open: docs/far-field-experiments.md.
const float CLOSE = 0.05;
// Within 8 degrees. What is round, as a ball on a floor, shows the floor under it.
const float PARALLEL_COSINE = 0.99;

uvec4 words_of(ivec2 surfel, int point)
{
    return texelFetch(t_surfel_points, surfel + ivec2(0, u_surfel_rows * point), 0);
}

void main()
{
    ivec2 surfel = ivec2(gl_FragCoord.xy);
    vec3 low = vec3(1e30);
    vec3 high = vec3(-1e30);
    for (int i = 0; i < SURFEL_POINTS; ++i) {
        vec3 p = uintBitsToFloat(words_of(surfel, i).xyz);
        low = min(low, p);
        high = max(high, p);
    }
    float reach = CLOSE * length(high - low);
    uint covered = 0u;
    for (int i = 0; i < SURFEL_POINTS; ++i) {
        uvec4 words = words_of(surfel, i);
        vec3 normal = oct_unproject(vec2(words.w & 0xffffu, words.w >> 16) * (1.0 / 32767.0) - 1.0);
        BvhHit hit = bvh_nearest(uintBitsToFloat(words.xyz), normal, reach);
        if (hit.record >= 0) {
            vec3 a, b, c;
            bvh_triangle(hit, a, b, c);
            float cosine = dot(triangle_normal(a, b, c), normal);
            covered |= abs(cosine) > PARALLEL_COSINE ? 1u << i : 0u;
        }
    }
    o_covered = covered;
}

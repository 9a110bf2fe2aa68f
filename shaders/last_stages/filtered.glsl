// Light whose filter ends where the terms are added up.
#include "lib/edge_aware_filter.glsl"

// What arrives at the surface at `texel`, whose depth is z.
vec3 light_filtered_here(ivec2 texel, float z)
{
    vec4 results[SIGNAL_COUNT];
    results[0] = neutral(0);
    filter_surface(texel, texel, z, results);
    return results[0].rgb;
}

// How much of evenly spread light the glossy layer reflects.
#include "lib/brdf.glsl"

#if GLOSSY
uniform sampler2D t_reflectance;   // x: cosine of the view, y: roughness; shares of f0, f90

const float TABLE_SIZE = 32.0;

// Where in tables over cosine and roughness, whose nodes go from 0 to 1, a point lies.
vec2 node_of_table(float cos_out, float roughness)
{
    return (vec2(cos_out, roughness) * (TABLE_SIZE - 1.0) + 0.5) / TABLE_SIZE;
}

vec3 layer_reflectance(Brdf brdf, float cos_out)
{
    vec2 share = textureLod(t_reflectance, node_of_table(cos_out, brdf.roughness), 0.0).xy;
    return brdf.f0 * share.x + brdf.f90 * share.y;
}
#endif

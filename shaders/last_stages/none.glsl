// All light was filtered before the terms are added up.

vec3 light_filtered_here(ivec2 texel, float z)
{
    return vec3(0.0);
}

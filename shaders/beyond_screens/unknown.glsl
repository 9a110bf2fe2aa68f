// Nothing is known of what the picture does not show.
const bool TRACES_SMOOTH = false;

bool meets_by_ray(vec3 p_vs, vec3 geometric_vs, vec3 w_vs, float density, float roughness,
                  uint index, out vec3 radiance)
{
    radiance = vec3(0.0);
    return false;
}

vec3 glow_in_lobe(ivec2 texel, Brdf brdf, bool is_met)
{
    return vec3(0.0);
}

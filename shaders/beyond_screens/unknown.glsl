// Nothing is known of what the picture does not show.

bool meets_beyond_screen(vec3 p_vs, vec3 geometric_vs, vec3 w_vs, out vec3 radiance)
{
    radiance = vec3(0.0);
    return false;
}

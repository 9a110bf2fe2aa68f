// Where texels of a shadow map disagree: what they say together.
vec2 shadow_edge(Light light, ivec2 pixel, bool is_edge, vec2 visibility)
{
    return visibility;
}

// Where texels of a shadow map disagree: what they say together.
#define TRACES_PENUMBRAE 0

vec2 shadow_edge(Light light, ivec2 pixel, bool is_edge, vec2 visibility)
{
    return visibility;
}

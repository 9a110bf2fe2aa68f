// Light from one direction.

float directional_falloff(Light light, vec3 to_light)
{
    return 1.0;
}

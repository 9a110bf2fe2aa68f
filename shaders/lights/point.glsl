// Light from a point, the same in all directions.

float point_falloff(Light light, vec3 to_light)
{
    return 1.0;
}

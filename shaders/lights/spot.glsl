// A point light in a cone. Its axis: the unit direction in which it shines; its numbers:
// cosine of the outer angle, 1 / (cosine of the inner angle - that).

// KHR_lights_punctual: squared linear ramp in the cosine between the two angles.
float spot_falloff(Light light, vec3 to_light)
{
    float c = dot(-to_light, light.axis_vs);
    float ramp = clamp((c - light.numbers.x) * light.numbers.y, 0.0, 1.0);
    return ramp * ramp;
}

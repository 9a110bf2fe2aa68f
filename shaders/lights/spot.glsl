// A point light in a cone. Its axis: the unit direction in which it shines; its numbers:
// 1 - cosine of the outer angle, 1 / (cosine of the inner angle - that of the outer).

// KHR_lights_punctual: squared linear ramp in the cosine between the two angles.
float spot_falloff(Light light, vec3 to_light)
{
    // 1 - cosine, without the cancellation that would make cones of .02 degrees all dark.
    vec3 off_axis = to_light + light.axis_vs;
    float ramp = clamp((light.numbers.x - 0.5 * dot(off_axis, off_axis)) * light.numbers.y, 0.0, 1.0);
    return ramp * ramp;
}

// How many channels light has.
//
// IS_GREY: 1 if red, green and blue are equal wherever light comes from and goes to, so
// that red stands for all of them and whatever rides along follows in green.

#if IS_GREY
#define LIGHT float
#else
#define LIGHT vec3
#endif

LIGHT light_in(vec4 texel)
{
#if IS_GREY
    return texel.r;
#else
    return texel.rgb;
#endif
}

// What to write: light, and one more number.
vec4 texel_of_light(LIGHT light, float companion)
{
#if IS_GREY
    return vec4(light, companion, 0.0, 1.0);
#else
    return vec4(light, companion);
#endif
}

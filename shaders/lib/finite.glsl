// Is this a number? Asked of the bits, because comparisons do not tell: compilers may turn
// `a >= 0 && b >= 0` into `min(a, b) >= 0`, whose min() passes over a NaN. Mesa's does, also
// for all(greaterThanEqual(v, vec3(0))), where one NaN among three numbers then counts
// as sound.

const uint EXPONENT_BITS = 0x7f800000u;   // all of them set: infinity or NaN

bool is_finite(float x)
{
    return (floatBitsToUint(x) & EXPONENT_BITS) != EXPONENT_BITS;
}

bool is_finite(vec3 v)
{
    return all(notEqual(floatBitsToUint(v) & EXPONENT_BITS, uvec3(EXPONENT_BITS)));
}

bool is_finite(vec4 v)
{
    return all(notEqual(floatBitsToUint(v) & EXPONENT_BITS, uvec4(EXPONENT_BITS)));
}

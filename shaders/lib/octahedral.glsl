// Unit vectors as two numbers: project onto the octahedron |x| + |y| + |z| = 1, fold
// the lower half (z < 0) over the upper (Meyer et al. 2010, "On Floating-Point Normal
// Vectors"; survey: Cigolle et al. 2014). With 16 bits each: 0.0037 degrees at worst.

// The sign of each component, +1 for zero: sign() would send the fold lines to 0.
vec2 sign_not_zero(vec2 v)
{
    return vec2(v.x < 0.0 ? -1.0 : 1.0, v.y < 0.0 ? -1.0 : 1.0);
}

// Any non-zero vector -> the square [-1, 1]^2.
vec2 oct_project(vec3 n)
{
    vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    return n.z < 0.0 ? (1.0 - abs(p.yx)) * sign_not_zero(p) : p;
}

// The square [-1, 1]^2 -> a vector on the octahedron, which is as long as it happens to be.
vec3 oct_unfold(vec2 p)
{
    vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    // Below the fold z is negative; t undoes the fold and is 0 above it.
    float t = max(-n.z, 0.0);
    n.xy -= t * sign_not_zero(n.xy);
    return n;
}

// The same as a unit vector.
vec3 oct_unproject(vec2 p)
{
    return normalize(oct_unfold(p));
}

// For storage in 16-bit unorm channels. 0 must be one of the 65536 steps, or no
// axis-aligned normal is exact: [-1, 1] maps to the steps 0..65534, 0 to 32767.
const float OCT_HALF_RANGE = 32767.0 / 65535.0;

vec2 oct_encode(vec3 n)
{
    return (oct_project(n) + 1.0) * OCT_HALF_RANGE;
}

vec2 oct_place(vec2 e)
{
    return e * (1.0 / OCT_HALF_RANGE) - 1.0;
}

vec3 oct_decode(vec2 e)
{
    return oct_unproject(oct_place(e));
}

// Directions on the hemisphere from points of the unit square.
#include "lib/constants.glsl"

// An orthonormal frame whose third column is the unit vector `n`: Duff et al. 2017,
// "Building an Orthonormal Basis, Revisited". The sign keeps the denominator at 1 or
// above in magnitude, so no direction is degenerate; there is no branch.
mat3 frame_from_z(vec3 n)
{
    float s = n.z >= 0.0 ? 1.0 : -1.0;
    float a = -1.0 / (s + n.z);
    float b = n.x * n.y * a;
    return mat3(
        vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x),
        vec3(b, s + n.y * n.y * a, -n.y),
        n);
}

// Density cos(theta) / pi: a uniform point of the unit disk, lifted (Malley's method).
vec3 cosine_hemisphere(vec2 u)
{
    float r = sqrt(u.x);
    float phi = 2.0 * PI * u.y;
    return vec3(r * cos(phi), r * sin(phi), sqrt(1.0 - u.x));
}

// Density 1 / (2 pi): heights are uniform on the sphere (Archimedes).
vec3 uniform_hemisphere(vec2 u)
{
    // 1 - u, because u may be 0 but never 1: a height of exactly 0 would lie in the plane.
    float z = 1.0 - u.x;
    float r = sqrt(u.x * (2.0 - u.x));  // sqrt(1 - z^2) without cancellation near the pole
    float phi = 2.0 * PI * u.y;
    return vec3(r * cos(phi), r * sin(phi), z);
}

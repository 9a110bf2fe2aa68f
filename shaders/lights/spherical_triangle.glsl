// Points of a triangle, uniform over the solid angle that it subtends.
//
// Arvo, "Stratified Sampling of Spherical Triangles" (1995); the solid angle after Van Oosterom,
// Strackee, "The Solid Angle of a Plane Triangle" (1983). Why: lights/spherical_rectangle.glsl.
#include "lib/angle.glsl"

// A triangle seen from the origin: unit vectors to its corners.
struct SphericalTriangle {
    vec3 a;
    vec3 b;
    vec3 c;
    float cosine_ab;
    vec2 at_a;          // cosine and sine of its inner angle there
    float angle_at_a;
    float solid_angle;
};

SphericalTriangle spherical_triangle(vec3 a, vec3 b, vec3 c)
{
    SphericalTriangle t;
    t.a = normalize(a);
    t.b = normalize(b);
    t.c = normalize(c);
    t.cosine_ab = dot(t.a, t.b);
    float cosine_bc = dot(t.b, t.c);
    float cosine_ca = dot(t.c, t.a);
    float volume = abs(dot(t.a, cross(t.b, t.c)));
    vec2 at_a = vec2(cosine_bc - t.cosine_ab * cosine_ca, volume);
    t.at_a = at_a * inversesqrt(max(dot(at_a, at_a), 1e-30));
    t.angle_at_a = angle_of(at_a.y, at_a.x);
    t.solid_angle = 2.0 * angle_of(volume, 1.0 + t.cosine_ab + cosine_bc + cosine_ca);
    return t;
}

// A unit vector at right angles to the unit vector `axis`, towards v.
vec3 aside_of(vec3 axis, vec3 v)
{
    vec3 aside = v - dot(v, axis) * axis;
    return aside * inversesqrt(max(dot(aside, aside), 1e-30));
}

// The unit vector to a point of the triangle for u in [0, 1)^2.
vec3 spherical_triangle_direction(SphericalTriangle t, vec2 u)
{
    // The part of the triangle up to an edge from b to a point on its edge from a to c has u.x of it.
    float turned = u.x * t.solid_angle - t.angle_at_a;
    float s = sin(turned);
    float k = cos(turned);
    float x = k - t.at_a.x;
    float y = s + t.at_a.y * t.cosine_ab;
    float below = (y * s + x * k) * t.at_a.y;
    float q = ((y * k - x * s) * t.at_a.x - y) / (abs(below) > 1e-15 ? below : 1e-15);
    q = clamp(q, -1.0, 1.0);
    vec3 on_ac = q * t.a + sqrt(1.0 - q * q) * aside_of(t.a, t.c);
    float z = 1.0 - u.y * (1.0 - dot(on_ac, t.b));
    return z * t.b + sqrt(max(1.0 - z * z, 0.0)) * aside_of(t.b, on_ac);
}

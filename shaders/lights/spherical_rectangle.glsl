// Points of a rectangle, uniform over the solid angle that it subtends.
//
// Urena, Fajardo, King, "An Area-Preserving Parametrization for Spherical Rectangles"
// (2013). Points drawn uniformly by area make the light of a near rectangle arbitrarily
// noisy (1 / distance^2); drawn by solid angle, only the receiver's cosine varies.
#include "lib/angle.glsl"

// A rectangle seen from the origin, in axes along its edges; z <= 0.
struct SphericalRectangle {
    vec3 low;       // nearest x and y, and z of its plane
    vec2 high;      // farthest x and y
    float angle_2;  // two of the inner angles of its outline on the sphere
    float angle_3;
    float solid_angle;
};

// Inner angle of the outline at a corner: the edges' planes pass through the origin.
float corner_angle(float x, float y, float z, float turn)
{
    return angle_of(abs(z) * sqrt(x * x + y * y + z * z), turn * x * y);
}

SphericalRectangle spherical_rectangle(vec3 corner, float length_x, float length_y)
{
    SphericalRectangle r;
    r.low = vec3(corner.xy, -abs(corner.z));
    r.high = corner.xy + vec2(length_x, length_y);
    float angle_0 = corner_angle(r.high.x, r.low.y, r.low.z, 1.0);
    float angle_1 = corner_angle(r.high.x, r.high.y, r.low.z, -1.0);
    r.angle_2 = corner_angle(r.low.x, r.high.y, r.low.z, 1.0);
    r.angle_3 = corner_angle(r.low.x, r.low.y, r.low.z, -1.0);
    r.solid_angle = angle_0 + angle_1 + r.angle_2 + r.angle_3 - TWO_PI;
    return r;
}

// The point of the rectangle for u in [0, 1)^2, in its axes.
vec3 spherical_rectangle_point(SphericalRectangle r, vec2 u)
{
    float z = r.low.z;
    float z_2 = z * z;
    float b_0 = -r.low.y * inversesqrt(max(r.low.y * r.low.y + z_2, 1e-30));
    float b_1 = r.high.y * inversesqrt(max(r.high.y * r.high.y + z_2, 1e-30));
    float a = u.x * r.solid_angle + TWO_PI - r.angle_2 - r.angle_3;
    float sine = sin(a);
    float f = (cos(a) * b_0 - b_1) / (abs(sine) > 1e-15 ? sine : 1e-15);
    float c = clamp((f > 0.0 ? 1.0 : -1.0) * inversesqrt(f * f + b_0 * b_0), -1.0, 1.0);
    float x = -c * z * inversesqrt(max(1.0 - c * c, 1e-15));
    x = clamp(x, r.low.x, r.high.x);
    float d_2 = x * x + z_2;
    float h_0 = r.low.y * inversesqrt(max(d_2 + r.low.y * r.low.y, 1e-30));
    float h_1 = r.high.y * inversesqrt(max(d_2 + r.high.y * r.high.y, 1e-30));
    float h = h_0 + u.y * (h_1 - h_0);
    float y = h * sqrt(d_2) * inversesqrt(max(1.0 - h * h, 1e-12));
    return vec3(x, clamp(y, r.low.y, r.high.y), z);
}

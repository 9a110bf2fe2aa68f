// Angles, exactly.
#include "lib/constants.glsl"

// Angle between two directions, from its sine times a positive factor and its cosine
// times the same factor; sine >= 0. Range-reduced polynomial after Cephes' atanf: 2e-7
// relative, where drivers' atan() and acos() are good to 2e-5 and worse.
float angle_of(float sine, float cosine)
{
    float c = abs(cosine);
    float x = min(sine, c) / max(max(sine, c), 1e-37);
    // tan(pi/8) splits [0, 1]; above it atan(x) = pi/4 + atan((x - 1) / (x + 1)).
    bool is_upper = x > 0.41421356;
    float y = is_upper ? (x - 1.0) / (x + 1.0) : x;
    float z = y * y;
    float a = (((8.05374449538e-2 * z - 1.38776856032e-1) * z + 1.99777106478e-1) * z
               - 3.33329491539e-1) * z * y + y + (is_upper ? 0.25 * PI : 0.0);
    a = sine > c ? HALF_PI - a : a;
    return cosine < 0.0 ? PI - a : a;
}

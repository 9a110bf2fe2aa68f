// How far above a tangent plane a surface must rise to block.
uniform float u_radius;            // R, may be infinite
uniform float u_bias;              // height above the tangent plane to block, relative to R

// What float32 depth and its interpolation may raise a coplanar surface by, relative to
// depth: some 80 ulp. Measured on planes at up to 89.9 degrees; 1e-5 z is also what a
// pixel covers in 100k columns.
const float DEPTH_ERROR = 1.0e-5;

// A radius beyond the distance to the camera says nothing about the size of things.
float length_scale_at(float z)
{
    return min(u_radius, z);
}

float min_blocking_height(float z)
{
    return DEPTH_ERROR * z + u_bias * length_scale_at(z);
}

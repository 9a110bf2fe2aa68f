// What the 24-bit depth buffer compares. Only visibility comes from it, never a position.
//
// The usual hyperbolic depth resolves z^2 / (near 2^24): enough while far / near is
// small. Beyond that (WIDE_DEPTH_RANGE, the eye inside or right at the geometry) the
// fragment writes log(z / near) / log(far / near), whose resolution is the same
// fraction of z everywhere: ln(far / near) 2^-24, 1.2e-6 at far / near = 1e9.

#if WIDE_DEPTH_RANGE
uniform vec2 u_log_depth;  // 1 / log2(far / near), -log2(near) times that

void write_depth(float z)
{
    gl_FragDepth = log2(z) * u_log_depth.x + u_log_depth.y;
}
#else
void write_depth(float z)
{
}
#endif

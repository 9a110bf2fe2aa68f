// Where the centre of a pixel is, which all frames of a view share: each shows a place beside it.
#include "lib/space.glsl"

vec2 centre_uv(ivec2 texel)
{
    return uv_of_texel(texel) - 0.5 * u_jitter_ndc;
}

// Depth at which the plane through `p_vs` stands behind the pixel's centre.
float centre_z_vs(ivec2 texel, vec3 p_vs, vec3 n_vs)
{
    vec2 uv = centre_uv(texel);
    float at_0 = dot(position_vs_at(uv, 0.0), n_vs);
    float at_1 = dot(position_vs_at(uv, 1.0), n_vs);
    return (dot(p_vs, n_vs) - at_0) / (at_1 - at_0);
}

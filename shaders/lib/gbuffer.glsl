// Reading the G-buffer. Texels are those of the full frame; the caller keeps them inside.
#include "lib/space.glsl"
#include "lib/octahedral.glsl"

uniform sampler2D t_z_vs;        // distance along the view axis, 0 = background
uniform sampler2D t_normals_vs;  // octahedral: xy shading normal, zw geometric normal

// Distance of octahedral codes (2 across the square) from which on normals are those of different
// surfaces: 25 degrees.
const float NORMAL_TOLERANCE = 0.43;

float gbuffer_z_vs(ivec2 texel)
{
    return texelFetch(t_z_vs, texel, 0).x;
}

vec3 gbuffer_position_vs(ivec2 texel)
{
    return position_vs_at(uv_of_texel(texel), gbuffer_z_vs(texel));
}

// The normal that lighting uses; on the side of the geometric one.
vec3 gbuffer_shading_normal_vs(ivec2 texel)
{
    return oct_decode(texelFetch(t_normals_vs, texel, 0).xy);
}

// Whether the triangle stands for a smooth surface: its shading normal is not its own.
bool gbuffer_is_smooth(ivec2 texel)
{
    vec4 codes = texelFetch(t_normals_vs, texel, 0);
    return codes.xy != codes.zw;
}

// The normal of the triangle itself, turned towards the camera: occlusion and ray
// offsets need it, because an interpolated normal makes facets shadow themselves.
vec3 gbuffer_geometric_normal_vs(ivec2 texel)
{
    return oct_decode(texelFetch(t_normals_vs, texel, 0).zw);
}

// Whether the camera sees the same side of the triangle as one sees from along `w`.
bool gbuffer_faces(ivec2 texel, vec3 w)
{
    return dot(oct_unfold(oct_place(texelFetch(t_normals_vs, texel, 0).zw)), w) > 0.0;
}

// Pixels that a neighbour in front may shade have rays of their own: what these found.
//
// HAS_EDGE_RAYS: 0 leaves it out.
#include "lib/receiver.glsl"

#if HAS_EDGE_RAYS
uniform sampler2D t_edge_places;  // 0: the pixel has none, else one more than their number
uniform sampler2D t_edge_far;     // rgb: radiance of surfaces beyond R, a: open share of the sky
uniform sampler2D t_edge_near;    // rgb: radiance of surfaces within R, a: z_vs of the pixel
uniform bool u_has_edge_rays;

// In footprints of a pixel. Frames of one view share their rays, and are moved a little
// against each other: what was another surface then has none now.
const float SAME_EDGE_PLANE = 0.25;

ivec2 edge_texel(int number)
{
    int columns = textureSize(t_edge_near, 0).x;
    return ivec2(number % columns, number / columns);
}

int edge_number(ivec2 texel)
{
    return u_has_edge_rays ? int(texelFetch(t_edge_places, texel, 0).x) - 1 : -1;
}

bool has_edge_rays(ivec2 texel)
{
    return edge_number(texel) >= 0;
}

// Where a receiver's rays are, or -1.
ivec2 edge_rays_at(Receiver r, ivec2 texel)
{
    int number = edge_number(texel);
    if (number < 0)
        return ivec2(-1);
    ivec2 place = edge_texel(number);
    vec3 p_vs = position_vs_at(uv_of_texel(texel), texelFetch(t_edge_near, place, 0).a);
    float height = abs(dot(p_vs - r.position_vs, r.geometric_vs));
    return height < SAME_EDGE_PLANE * pixel_height_at(r.z_vs) ? place : ivec2(-1);
}
#endif

// Looks up the light that per-pixel rays have gathered.
//
// HAS_OWN_RAYS: 0 leaves it out.
#include "screen_space/receiver.glsl"
#include "lib/pixel_centre.glsl"

#if HAS_OWN_RAYS
// One more than the number of the pixel's rays, 0: it has none; negative where they are many,
// as a neighbour in front may shade it.
uniform isampler2D t_own_places;
uniform sampler2D t_own_far;     // rgb: radiance of surfaces beyond R, a: open share of the sky
uniform sampler2D t_own_near;    // rgb: radiance of surfaces within R, a: z_vs as centre_z_vs says
uniform bool u_has_own_rays;
uniform bool u_has_all_own_rays;  // every pixel, of this very frame

// In footprints of a pixel. Frames of one view share their rays, and are moved a little
// against each other: what was another surface then has none now. Both surfaces are taken where
// they, or their planes, stand at the pixel's centre, from which each frame shows another place.
const float SAME_PLANE = 0.25;

int own_place(ivec2 texel)
{
    return u_has_own_rays ? texelFetch(t_own_places, texel, 0).x : 0;
}

// Where a receiver's rays are, or -1.
ivec2 own_rays_at(Receiver r, ivec2 texel)
{
    int number = abs(own_place(texel)) - 1;
    if (number < 0)
        return ivec2(-1);
    int columns = textureSize(t_own_near, 0).x;
    ivec2 place = ivec2(number % columns, number / columns);
    if (u_has_all_own_rays)
        return place;
    vec3 p_vs = position_vs_at(centre_uv(texel), texelFetch(t_own_near, place, 0).a);
    float height = abs(dot(p_vs - r.position_vs, r.geometric_vs));
    return height < SAME_PLANE * pixel_height_at(r.z_vs) ? place : ivec2(-1);
}
#endif

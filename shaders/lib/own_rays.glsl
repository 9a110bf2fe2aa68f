// Looks up the light that per-pixel rays have gathered.
//
// HAS_OWN_RAYS: 0 leaves it out; 2: every pixel has some, of this very frame.
#include "screen_space/receiver.glsl"
#include "lib/pixel_centre.glsl"

#if HAS_OWN_RAYS
// r: one more than the number of the pixel's rays, 0: it has none; negative where they are many, as a
// neighbour in front may shade it. g: code of the geometric normal that they started from.
uniform isampler2D t_own_places;
uniform sampler2D t_own_far;     // rgb: radiance of surfaces beyond R, a: open share of the sky
uniform sampler2D t_own_near;    // rgb: radiance of surfaces within R, a: z_vs as centre_z_vs says
uniform bool u_has_own_rays;

// In footprints of a pixel. Frames of one view share their rays, and are moved a little
// against each other: what was another surface then has none now. Both surfaces are taken where
// they, or their planes, stand at the pixel's centre, from which each frame shows another place.
const float SAME_PLANE = 0.25;

// The least cosine of their normals: what arrives at a wall is not what its floor receives.
const float SAME_FACING = 0.8;

const ivec2 BESIDE[4] = ivec2[4](ivec2(1, 0), ivec2(-1, 0), ivec2(0, 1), ivec2(0, -1));

// As effects/own_pixels.frag writes it.
vec3 own_normal_vs(int code)
{
    return oct_unproject(vec2(code & 255, code >> 8) * (1.0 / 127.0) - 1.0);
}

int own_place(ivec2 texel)
{
    return u_has_own_rays ? texelFetch(t_own_places, texel, 0).x : 0;
}

// Where the rays of a pixel are, if they are a receiver's; or -1.
ivec2 own_rays_of(Receiver r, ivec2 texel)
{
    ivec2 own = u_has_own_rays ? texelFetch(t_own_places, texel, 0).xy : ivec2(0);
    int number = abs(own.x) - 1;
    if (number < 0)
        return ivec2(-1);
    int columns = textureSize(t_own_near, 0).x;
    ivec2 place = ivec2(number % columns, number / columns);
#if HAS_OWN_RAYS == 2
    return place;
#endif
    vec3 p_vs = position_vs_at(centre_uv(texel), texelFetch(t_own_near, place, 0).a);
    float height = abs(dot(p_vs - r.position_vs, r.geometric_vs));
    bool faces = dot(own_normal_vs(own.y), r.geometric_vs) > SAME_FACING;
    return faces && height < SAME_PLANE * pixel_height_at(r.z_vs) ? place : ivec2(-1);
}

// Where a receiver's rays are, those of its pixel or of one beside it; or -1.
ivec2 own_rays_at(Receiver r, ivec2 texel)
{
    ivec2 place = own_rays_of(r, texel);
#if HAS_OWN_RAYS == 1
    ivec2 last = textureSize(t_own_places, 0) - 1;
    for (int i = 0; i < 4 && place.x < 0 && u_has_own_rays; ++i) {
        ivec2 beside = texel + BESIDE[i] * u_receiver_stride;
        if (clamp(beside, ivec2(0), last) == beside)
            place = own_rays_of(r, beside);
    }
#endif
    return place;
}
#endif

// Per-pixel rays that the frames of a view share: they are moved a little against each other, so that a
// pixel may show another surface than the one that its rays started from.
#include "lib/gbuffer.glsl"
#include "lib/octahedral.glsl"
#include "lib/pixel_centre.glsl"

// r: one more than the number of the pixel's rays, 0: it has none; negative where they are many, as a
// neighbour in front may shade it. g: code of the geometric normal that they started from.
uniform isampler2D t_own_places;
uniform sampler2D t_own_far;     // rgb: radiance of surfaces beyond R, a: open share of the sky
uniform sampler2D t_own_near;    // rgb: radiance of surfaces within R, a: z_vs as centre_z_vs says, negative where r is

// In footprints of a pixel. Both surfaces are taken where they, or their planes, stand at the pixel's
// centre, from which each frame shows another place.
const float SAME_PLANE = 0.25;

// The least cosine of their normals: what arrives at a wall is not what its floor receives.
const float SAME_FACING = 0.8;

const ivec2 BESIDE[5] = ivec2[5](ivec2(0), ivec2(1, 0), ivec2(-1, 0), ivec2(0, 1), ivec2(0, -1));

// As effects/own_pixels.frag writes it.
vec3 own_normal_vs(int code)
{
    return oct_unproject(vec2(code & 255, code >> 8) * (1.0 / 127.0) - 1.0);
}

// Whether the rays of the pixel at `texel` started from the surface at p_vs.
bool has_rays_of(ivec2 texel, vec3 p_vs, vec3 geometric_vs)
{
    ivec2 own = texelFetch(t_own_places, texel, 0).xy;
    vec3 start_vs = position_vs_at(centre_uv(texel), abs(texelFetch(t_own_near, texel, 0).a));
    float height = abs(dot(start_vs - p_vs, geometric_vs));
    bool faces = dot(own_normal_vs(own.y), geometric_vs) > SAME_FACING;
    return own.x != 0 && faces && height < SAME_PLANE * pixel_height_at(-p_vs.z);
}

// The pixel, or one beside it, whose rays started from its surface; or -1.
ivec2 texel_of_rays(ivec2 texel, int stride, vec3 p_vs, vec3 geometric_vs)
{
    ivec2 last = textureSize(t_own_places, 0) - 1;
    for (int i = 0; i < 5; ++i) {
        ivec2 other = texel + BESIDE[i] * stride;
        if (clamp(other, ivec2(0), last) == other && has_rays_of(other, p_vs, geometric_vs))
            return other;
    }
    return ivec2(-1);
}

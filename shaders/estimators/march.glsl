// Several depth reads along each direction: see lib/march.glsl.
#include "lib/march.glsl"
#include "lib/sampling.glsl"

#define FINDS_BLOCKERS 1

vec3 estimator_direction(vec2 u)
{
    return cosine_hemisphere(u);
}

float estimator_share(vec3 local)
{
    return 1.0 / float(DIRECTION_COUNT);
}

Blocker estimator_blocker(Tangent t, Direction d, int steps, int refinements)
{
    return march(t, d.w_vs, u_radius, d.jitter, steps, refinements);
}

#if GATHERS_SENDERS
// Each blocked direction stands for the solid angle it was drawn with, pi / N of the
// cosine-weighted hemisphere: no area, no distance, no singularity, no scale.
vec3 estimator_sent(Receiver r, Tangent t, Direction d, vec3 radiance, ivec2 texel)
{
    vec3 to_receiver = r.position_vs - gbuffer_position_vs(texel);
    // What is seen of a surface is its front. If that turns away from the receiver, the
    // ray met a side of the solid that the camera does not see. All that is known of what
    // this side sends is that the other side of the same thing is near.
    bool faces = dot(gbuffer_geometric_normal_vs(texel), to_receiver) > 0.0;
    return radiance * (PI * d.share * (faces ? 1.0 : u_hidden_senders));
}
#endif

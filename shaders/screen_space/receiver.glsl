// The surface point that a fragment of an estimator stands for, and its directions.
#include "lib/gbuffer.glsl"
#include "lib/hash.glsl"
#include "lib/sampling.glsl"

uniform int u_receiver_stride;    // 1, or 2 for estimators at half resolution
uniform uvec3 u_pattern_offset;   // from the frame's seed

struct Receiver {
    vec3 position_vs;
    vec3 normal_vs;        // shading normal: axis of the hemisphere
    vec3 geometric_vs;     // normal of the tangent plane that decides occlusion
    float z_vs;            // 0: background
    mat3 vs_from_tangent;
    uint first_point;      // of this pixel's set
};

// At half resolution the receiver is the lower left texel of each 2 x 2 group: an actual
// texel with its own depth and normal, never an average across an edge.
ivec2 receiver_texel(ivec2 pixel)
{
    return pixel * u_receiver_stride;
}

Receiver receiver_at(ivec2 pixel, int point_count)
{
    ivec2 texel = receiver_texel(pixel);
    Receiver r;
    r.z_vs = gbuffer_z_vs(texel);
    r.position_vs = position_vs_at(uv_of_texel(texel), r.z_vs);
    r.normal_vs = gbuffer_shading_normal_vs(texel);
    r.geometric_vs = gbuffer_geometric_normal_vs(texel);
    r.vs_from_tangent = frame_from_z(r.normal_vs);
    r.first_point = set_of_pixel(pixel) * uint(point_count);
    return r;
}

// Sample point `i` of the receiver: xy choose the direction, z the distance along it.
vec3 sample_point(Receiver r, int i)
{
    return kronecker_point(r.first_point + uint(i), u_pattern_offset);
}

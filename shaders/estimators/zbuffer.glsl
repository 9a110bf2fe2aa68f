// The image-space variant of the method's first report: random texels of a square around
// the pixel, blocked where they are nearer to the camera. It knows no radius in scene
// units, no hemisphere and no tangent plane: tilted planes darken themselves and the
// result changes with the resolution. Kept for comparison. Departure: the report's bias
// of 0.01 scene units is taken relative to z, so that at least scale does not matter.
#include "screen_space/receiver.glsl"

#define FINDS_BLOCKERS 0

const float ZBUFFER_BIAS = 0.01;

float estimator_visibility(Receiver r, ivec2 centre)
{
    int open_count = 0;
    int i = 0;
    do {
        vec2 offset = (sample_point(r, i).xy * 2.0 - 1.0) * u_box_px;
        ivec2 texel = centre + ivec2(floor(offset + 0.5));
        ivec2 inside = clamp(texel, ivec2(0), ivec2(u_frame_size_px) - 1);
        float z = gbuffer_z_vs(inside);
        bool blocked = texel == inside && z > 0.0 && z < r.z_vs * (1.0 - ZBUFFER_BIAS);
        open_count += blocked ? 0 : 1;
    } while (++i < DIRECTION_COUNT);
    return float(open_count) / float(DIRECTION_COUNT);
}

// From texels and depths to view-space positions and back.
//
// View space is OpenGL's: camera at the origin, looking along -z. Depth `z` is the
// POSITIVE distance along the view axis (= -position_vs.z); 0 means background.
// Texture coordinates `uv` run over the frame, (0, 0) at the bottom left; texels are
// counted at the frame's full resolution.
//
// The jitter moves the sample away from the pixel centre, so the ray through the
// pixel at `ndc` leaves the camera through `ndc + u_jitter_ndc`.
#include "lib/constants.glsl"

uniform vec2 u_jitter_ndc;     // sub-pixel shift, 2 across the frame
uniform vec2 u_frame_size_px;  // full resolution

const vec3 AHEAD_VS = vec3(0.0, 0.0, -1.0);

#include <projection>

vec3 toward_camera(vec3 p_vs)
{
    return -viewing_direction(p_vs, AHEAD_VS);
}

ivec2 texel_of_uv(vec2 uv)
{
    // floor, not truncation: uv left of or below the frame must give negative texels.
    return ivec2(floor(uv * u_frame_size_px));
}

// Centre of texel `t`. Positions are always rebuilt from texel centres: from any
// other uv the stored depth belongs to a different point (grazing surfaces band).
vec2 uv_of_texel(ivec2 t)
{
    return (vec2(t) + 0.5) * (1.0 / u_frame_size_px);
}

// From texels and depths to view-space positions and back.
//
// View space is OpenGL's: camera at the origin, looking along -z. Depth `z` is the
// POSITIVE distance along the view axis (= -position_vs.z); 0 means background.
// Texture coordinates `uv` run over the frame, (0, 0) at the bottom left; texels are
// counted at the frame's full resolution.
//
// The jitter moves the sample away from the pixel centre, so the ray through the
// pixel at `ndc` leaves the camera through `ndc + u_jitter_ndc`.

uniform vec2 u_tan_half_fov;   // tangents of half the (horizontal, vertical) field of view
uniform vec2 u_jitter_ndc;     // sub-pixel shift, 2 across the frame
uniform vec2 u_frame_size_px;  // full resolution

// Direction through `uv`, scaled to reach depth 1: (x, y, -1), not unit length.
vec3 view_ray_at(vec2 uv)
{
    return vec3((2.0 * uv - 1.0 + u_jitter_ndc) * u_tan_half_fov, -1.0);
}

vec3 position_vs_at(vec2 uv, float z)
{
    return view_ray_at(uv) * z;
}

// Inverse of position_vs_at. Only points in front of the camera (p_vs.z < 0) have a
// place in the frame; the caller rules out the others.
vec2 uv_of_position_vs(vec3 p_vs)
{
    return (p_vs.xy / (-p_vs.z * u_tan_half_fov) - u_jitter_ndc) * 0.5 + 0.5;
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
    return (vec2(t) + 0.5) / u_frame_size_px;
}

// Rays that all come from one point, the eye: the usual `#include <projection>`.
// projections/orthographic.glsl defines the same for parallel rays.

uniform vec2 u_tan_half_fov;   // tangents of half the (horizontal, vertical) field of view

// Direction through `uv`, scaled to reach depth 1: (x, y, -1), not unit length.
vec3 view_ray_at(vec2 uv)
{
    return vec3((2.0 * uv - 1.0 + u_jitter_ndc) * u_tan_half_fov, -1.0);
}

vec3 position_vs_at(vec2 uv, float z)
{
    return view_ray_at(uv) * z;
}

// dot(position_vs_at(uv, z), n) is plane_height(plane_rate(near_uv, n), texels, z), where `uv`
// is so many texels from `near_uv`.
vec3 plane_rate(vec2 near_uv, vec3 n)
{
    vec2 ray_step = 2.0 * u_tan_half_fov / u_frame_size_px;
    return vec3(ray_step * n.xy, dot(view_ray_at(near_uv), n));
}

float plane_height(vec3 rate, vec2 texels, float z)
{
    return z * dot(rate, vec3(texels, 1.0));
}

// Inverse of position_vs_at. Only points in front of the camera (p_vs.z < 0) have a
// place in the frame; the caller rules out the others.
vec2 uv_of_position_vs(vec3 p_vs)
{
    return (p_vs.xy / (-p_vs.z * u_tan_half_fov) - u_jitter_ndc) * 0.5 + 0.5;
}

// Depth of the fragment: clip.w is z, and the rasterizer interpolates 1 / w linearly.
float fragment_z_vs()
{
    return 1.0 / gl_FragCoord.w;
}

// What one pixel of the full resolution covers at depth z.
float pixel_height_at(float z)
{
    return z * (2.0 * u_tan_half_fov.y / u_frame_size_px.y);
}

// Unit direction in which the camera sees what lies `from_eye` of it; `ahead` is its axis.
// Both in the same frame, whichever that is.
vec3 viewing_direction(vec3 from_eye, vec3 ahead)
{
    return from_eye / max(length(from_eye), 1e-30);
}

// How far beside what lies at `distance` a sphere of `radius` about it is seen to reach.
float silhouette_radius(float distance, float radius)
{
    float sine = radius / distance;
    return sine < 1.0 ? radius * inversesqrt(1.0 - sine * sine) : FLOAT_MAX;
}

// The ray through p, by depth, is so long; the one through `uv` ...
float ray_slant(vec3 p_vs)
{
    return length(p_vs) / -p_vs.z;
}

// ... differs by this times the first number of the next, and lies beside p by this times
// the second.
vec3 ray_change(vec3 p_vs, vec2 uv)
{
    return view_ray_at(uv) - p_vs / -p_vs.z;
}

vec2 ray_taper_width(float z)
{
    return vec2(1.0, z);
}

// What `frame_gaps` takes for borders so many pixels inside the frame's.
vec4 frame_slopes(float border_px)
{
    vec2 e = 1.0 - 2.0 * border_px / u_frame_size_px;
    return vec4(e + u_jitter_ndc, e - u_jitter_ndc) * u_tan_half_fov.xyxy;
}

// How far p is from the right, upper, left and lower border: linear in p, in any unit.
vec4 frame_gaps(vec4 slopes, vec3 p_vs)
{
    return slopes * -p_vs.z + vec4(-p_vs.xy, p_vs.xy);
}

// Their change along w.
vec4 frame_gap_rates(vec4 slopes, vec3 w)
{
    return frame_gaps(slopes, w);
}

// Where p is seen beside the camera's axis; `nearness` is that of p, and px_scale how many
// pixels that is.
vec2 picture_place(vec3 p_vs, float nearness)
{
    return p_vs.xy * nearness;
}

vec2 px_scale()
{
    return 0.5 * u_frame_size_px / u_tan_half_fov;
}

// A number that falls with depth and is linear along the picture of a straight line.
float nearness(float z)
{
    return 1.0 / z;
}

bool is_nearer(float z, float than)
{
    return z * than < 1.0;
}

bool is_farther(float z, float than)
{
    return z * than > 1.0;
}

// How much of a line of `length_vs` lies before the share s of its picture, along which its
// nearness goes from `start` to `start` + `change`.
float length_before(float length_vs, float s, float start, float change)
{
    return length_vs * s * (start + change) / (start + s * change);
}

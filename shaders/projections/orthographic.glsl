// Parallel rays along the view axis: the other `#include <projection>`. What each function
// means is written in projections/perspective.glsl.
//
// Here the eye is a point that the program chooses, a frame's height in front of what is
// nearest: so z grows with neither the distance of the camera nor less than the frame shows.

uniform vec2 u_half_frame_vs;   // half of what the frame shows, scene units
uniform vec2 u_near_depth_vs;   // distance of the near plane, and from there to the far one

vec3 view_ray_at(vec2 uv)
{
    return vec3(0.0, 0.0, -1.0);
}

vec3 position_vs_at(vec2 uv, float z)
{
    return vec3((2.0 * uv - 1.0 + u_jitter_ndc) * u_half_frame_vs, -z);
}

// But for a constant, which the difference of two heights has not.
vec3 plane_rate(vec2 near_uv, vec3 n)
{
    return vec3(2.0 * u_half_frame_vs / u_frame_size_px * n.xy, -n.z);
}

float plane_height(vec3 rate, vec2 texels, float z)
{
    return dot(rate.xy, texels) + z * rate.z;
}

vec2 uv_of_position_vs(vec3 p_vs)
{
    return (p_vs.xy / u_half_frame_vs - u_jitter_ndc) * 0.5 + 0.5;
}

float fragment_z_vs()
{
    return u_near_depth_vs.x + gl_FragCoord.z * u_near_depth_vs.y;
}

float pixel_height_at(float z)
{
    return 2.0 * u_half_frame_vs.y / u_frame_size_px.y;
}

vec3 viewing_direction(vec3 from_eye, vec3 ahead)
{
    return ahead;
}

float silhouette_radius(float distance, float radius)
{
    return radius;
}

float ray_slant(vec3 p_vs)
{
    return 1.0;
}

vec3 ray_change(vec3 p_vs, vec2 uv)
{
    return position_vs_at(uv, -p_vs.z) - p_vs;
}

vec2 ray_taper_width(float z)
{
    return vec2(0.0, 1.0);
}

vec4 frame_slopes(float border_px)
{
    vec2 e = 1.0 - 2.0 * border_px / u_frame_size_px;
    return vec4(e + u_jitter_ndc, e - u_jitter_ndc) * u_half_frame_vs.xyxy;
}

vec4 frame_gaps(vec4 slopes, vec3 p_vs)
{
    return slopes + vec4(-p_vs.xy, p_vs.xy);
}

vec4 frame_gap_rates(vec4 slopes, vec3 w)
{
    return vec4(-w.xy, w.xy);
}

vec2 picture_place(vec3 p_vs, float nearness)
{
    return p_vs.xy;
}

vec2 px_scale()
{
    return 0.5 * u_frame_size_px / u_half_frame_vs;
}

float nearness(float z)
{
    return -z;
}

bool is_nearer(float z, float than)
{
    return z < -than;
}

bool is_farther(float z, float than)
{
    return z > -than;
}

float length_before(float length_vs, float s, float start, float change)
{
    return length_vs * s;
}

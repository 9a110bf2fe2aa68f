#version 330 core
// The last picture as a camera that has moved sees what is in it. Where the ray of a pixel meets
// that is found by fixed-point iteration (Bowles et al. 2012); what was hidden or out of the
// frame is made of what is beside it, on the same side of a line between two methods.
#include "lib/space.glsl"

uniform sampler2D t_picture;
uniform sampler2D t_z_vs;             // of the picture
uniform mat3 u_seen_from_now;         // from view space of now to that of the picture
uniform vec3 u_camera_seen_vs;        // where the camera is now, in that of the picture
uniform vec2 u_tan_half_fov_now;      // 0 if rays are parallel
uniform vec2 u_half_frame_now;        // 0 if they are not
uniform vec2 u_left_right;            // where the left side ends and the right one begins

in vec2 v_uv;

layout(location = 0) out vec4 o_color;

const int TURNS = 3;

void main()
{
    vec2 ndc = 2.0 * v_uv - 1.0;
    bool is_parallel = u_half_frame_now.x > 0.0;
    // By depth, not unit length.
    vec3 ray = u_seen_from_now * vec3(ndc * u_tan_half_fov_now, -1.0);
    vec3 start = u_camera_seen_vs + u_seen_from_now * vec3(ndc * u_half_frame_now, 0.0);
    // At first as if the pixel showed what it did: a camera that turns about a point keeps that.
    vec2 uv = v_uv;
    float z = texture(t_z_vs, uv).x;
    float z_now = z;
    for (int turn = 0; turn < TURNS; ++turn) {
        vec3 p = z > 0.0 || is_parallel ? start + z_now * ray : ray;
        uv = p.z < 0.0 || is_parallel ? uv_of_position_vs(p) : uv;
        z = texture(t_z_vs, uv).x;
        if (z == 0.0)
            break;
        z_now = -dot(u_seen_from_now[2], position_vs_at(uv, z) - u_camera_seen_vs);
        z_now = is_parallel ? z_now : max(z_now, 0.0);
    }
    bool is_left = 2.0 * v_uv.x < u_left_right.x + u_left_right.y;
    uv.x = is_left ? min(uv.x, u_left_right.x) : max(uv.x, u_left_right.y);
    o_color = vec4(texture(t_picture, uv).rgb, 1.0);
}

#version 330 core
// The last picture as a camera that has moved sees what is in it. Where the ray of a pixel meets
// that is found by fixed-point iteration (Bowles et al. 2012); what was hidden or out of the
// frame is made of what is beside it.
#include "lib/space.glsl"

uniform sampler2D t_picture;
uniform sampler2D t_z_vs;             // of the picture
uniform mat3 u_seen_from_now;         // from view space of now to that of the picture
uniform vec3 u_camera_seen_vs;        // where the camera is now, in that of the picture
uniform vec2 u_tan_half_fov_now;

in vec2 v_uv;

layout(location = 0) out vec4 o_color;

const int TURNS = 3;

void main()
{
    // By depth, not unit length.
    vec3 ray = u_seen_from_now * vec3((2.0 * v_uv - 1.0) * u_tan_half_fov_now, -1.0);
    // At first as if the pixel showed what it did: a camera that turns about a point keeps that.
    vec2 uv = v_uv;
    float z = texture(t_z_vs, uv).x;
    float z_now = z;
    for (int turn = 0; turn < TURNS; ++turn) {
        vec3 p = z > 0.0 ? u_camera_seen_vs + z_now * ray : ray;
        uv = p.z < 0.0 ? uv_of_position_vs(p) : uv;
        z = texture(t_z_vs, uv).x;
        if (z == 0.0)
            break;
        z_now = max(-dot(u_seen_from_now[2], position_vs_at(uv, z) - u_camera_seen_vs), 0.0);
    }
    o_color = vec4(texture(t_picture, uv).rgb, 1.0);
}
